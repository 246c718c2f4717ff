"""Eqs. (23)-(24): the lowest natural frequencies and modes of (K, M)."""

from __future__ import annotations  # scipy loads its parts when they are first used

from contextlib import suppress

import numpy as np
import scipy
from numpy.typing import NDArray

from analytic.lanczos import SingularError, lowest_sparse

Array = NDArray[np.float64]
FREE = 1e-10
"""A ratio of eigenvalues at which the lower one is a free motion rather than a vibration."""


def lowest_modes(
    K: scipy.sparse.csr_array, M: scipy.sparse.csr_array, count: int, solver: str
) -> tuple[Array, Array]:
    """Return frequencies [Hz], shape (count,), and mass-normalised vectors, (dofs, count).

    (K - omega_i^2 M) Phi_i = 0. `solver`: "dense" (LAPACK) or "sparse" (block
    Lanczos; LAPACK as well where a free motion makes K singular).
    """
    if solver == "sparse":
        with suppress(SingularError):
            return hertz(*lowest_sparse(K, M, count))
    return hertz(*_dense(K.toarray(), M.toarray(), count))


def hertz(values: Array, vectors: Array) -> tuple[Array, Array]:
    """Return frequencies of omega^2, and the vectors as they are."""
    # A mechanism that can move freely has omega = 0, up to rounding of either sign.
    return np.sqrt(np.maximum(values, 0.0)) / (2 * np.pi), vectors


def _dense(K: Array, M: Array, count: int) -> tuple[Array, Array]:
    """Return the lowest eigenvalues and mass-normalised vectors of a dense pair.

    LAPACK's error is relative to the largest eigenvalue, and that of (K, M) grows with s^4: so
    solve M x = mu K x, whose largest mu are wanted, unless K is singular (a free motion).
    """
    size = len(K)
    try:
        mu, x = scipy.linalg.eigh(
            M, K, subset_by_index=(size - count, size - 1), check_finite=False
        )
    except np.linalg.LinAlgError:
        mu = np.zeros(1)
    if mu[0] <= FREE * mu[-1]:
        values, vectors = scipy.linalg.eigh(
            K, M, subset_by_index=(0, count - 1), check_finite=False
        )
        return values, vectors
    return 1 / mu[::-1], (x / np.sqrt(mu))[:, ::-1]
