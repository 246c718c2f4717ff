"""Eqs. (23)-(24): the lowest natural frequencies and modes of (K, M)."""

import numpy as np
import scipy.linalg
import scipy.sparse
import scipy.sparse.linalg
from numpy.typing import NDArray

Array = NDArray[np.float64]
FREE = 1e-10
"""A ratio of eigenvalues at which the lower one is a free motion rather than a vibration."""


def lowest_modes(
    K: scipy.sparse.csr_array, M: scipy.sparse.csr_array, count: int, solver: str
) -> tuple[Array, Array]:
    """Return frequencies [Hz], shape (count,), and mass-normalised vectors, (dofs, count).

    (K - omega_i^2 M) Phi_i = 0. `solver`: "dense" (LAPACK) or "sparse" (shift-invert Lanczos).
    """
    if solver == "sparse" and count < K.shape[0] - 1:
        # A fixed start vector: the same input gives the same bits.
        start = np.sin(np.arange(1.0, K.shape[0] + 1))
        values, vectors = scipy.sparse.linalg.eigsh(
            K.tocsc(), k=count, M=M.tocsc(), sigma=0.0, v0=start, tol=0.0
        )
        order = np.argsort(values)
        values, vectors = values[order], vectors[:, order]
    else:
        values, vectors = _dense(K.toarray(), M.toarray(), count)
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
