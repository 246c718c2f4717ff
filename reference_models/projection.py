"""Linearised dynamics under joint constraints: project, exactly, on what they leave free."""

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

Array = NDArray[np.float64]


def constrained_modes(K: Array, M: Array, J: Array, count: int) -> tuple[Array, Array, int]:
    """Return frequencies [Hz] (count,), mass-normalised shapes (N, count), coordinates left free.

    K, M are (N, N) over all coordinates q; the joints demand J dq = 0, J (c, N) of any rank.
    With N_0 an orthonormal basis of J's null space: (N_0^T K N_0 - omega^2 N_0^T M N_0) x = 0.
    """
    free = null_space(J)
    reduced_K, reduced_M = (free.T @ (A + A.T) @ free / 2 for A in (K, M))
    count = min(count, free.shape[1])
    values, x = scipy.linalg.eigh(reduced_K, reduced_M, subset_by_index=(0, count - 1))
    return np.sqrt(np.maximum(values, 0.0)) / (2 * np.pi), free @ x, free.shape[1]


def null_space(J: Array) -> Array:
    """Return an orthonormal basis of J's null space, shape (N, N - rank), by pivoted QR.

    Rows are scaled first, so that the rank does not depend on a joint's units.
    """
    scale = np.linalg.norm(J, axis=1, keepdims=True)
    rows = J[scale[:, 0] > 0] / scale[scale[:, 0] > 0]
    q, r, _ = scipy.linalg.qr(rows.T, pivoting=True)
    pivots = np.abs(np.diag(r))
    rank = int((pivots > 1e-9 * pivots[0]).sum()) if pivots.size else 0
    return np.asarray(q[:, rank:])
