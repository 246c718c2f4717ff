"""Eqs. (23)-(24): the lowest natural frequencies and modes of (K, M)."""

import numpy as np
import scipy.linalg
import scipy.sparse
import scipy.sparse.linalg
from numpy.typing import NDArray


def lowest_modes(
    K: scipy.sparse.csr_array, M: scipy.sparse.csr_array, count: int, solver: str
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
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
        values, vectors = scipy.linalg.eigh(
            K.toarray(), M.toarray(), subset_by_index=(0, count - 1), check_finite=False
        )
    # A mechanism that can move freely has omega = 0, up to rounding of either sign.
    return np.sqrt(np.maximum(values, 0.0)) / (2 * np.pi), vectors
