"""Linearised dynamics under joint constraints: project, exactly, on what they leave free."""

from __future__ import annotations  # scipy loads its parts when they are first used

import numpy as np
import scipy
from numpy.typing import NDArray

from analytic.modes import check_count

Array = NDArray[np.float64]
RANK = 1e-9
"""Singular values below this, relative to the largest of the same joints, are zero."""
FREE = 1e-10
"""A ratio of eigenvalues at which the lower one is a free motion rather than a vibration."""
NOISE = 1e-14
"""Constraints smaller than this, relative to the largest, constrain nothing (a free axis)."""


def constrained_modes(K: Array, M: Array, J: Array, count: int) -> tuple[Array, Array, int]:
    """Return frequencies [Hz] (count,), mass-normalised shapes (N, count), coordinates left free.

    K, M are (N, N) over all coordinates q; the joints demand J dq = 0, J (c, N) of any rank.
    With N_0 an orthonormal basis of J's null space: (N_0^T K N_0 - omega^2 N_0^T M N_0) x = 0.
    Raises `InputError` for more modes than coordinates left free.
    """
    free = null_space(J)
    check_count(count, free.shape[1])
    reduced = (free.T @ (A @ free) for A in (K, M))
    K_free, M_free = ((A + A.T) / 2 for A in reduced)
    values, x = _lowest(K_free, M_free, count)
    return np.sqrt(np.maximum(values, 0.0)) / (2 * np.pi), free @ x, free.shape[1]


def _lowest(K: Array, M: Array, count: int) -> tuple[Array, Array]:
    """Return the lowest eigenvalues and mass-normalised vectors of a symmetric pair.

    LAPACK's error is relative to the largest eigenvalue: that of (M, K) belongs to the lowest mode.
    Where K is singular (a free motion) only (K, M) can be solved.
    """
    size = len(K)
    try:
        mu, x = scipy.linalg.eigh(M, K, subset_by_index=(size - count, size - 1))
    except np.linalg.LinAlgError:
        mu = np.zeros(1)
    if mu[0] <= FREE * mu[-1]:
        values, x = scipy.linalg.eigh(K, M, subset_by_index=(0, count - 1))
        return values, x
    return 1 / mu[::-1], (x / np.sqrt(mu))[:, ::-1]


def null_space(J: Array) -> scipy.sparse.csr_array:
    """Return an orthonormal basis of J's null space, (N, N - rank), by singular values.

    A constraint couples few coordinates, so J falls into small blocks (a joint with the bodies it
    holds; the norm of one node's Euler parameters): each has its own decomposition, equal ones
    share a call, and the basis is sparse. Rows are scaled to unit length, so that the rank does
    not depend on a joint's units.
    """
    size = np.linalg.norm(J, axis=1)
    real = size > NOISE * size.max(initial=0.0)
    rows = J[real] / size[real, None]
    coupled = scipy.sparse.csr_array(rows != 0, dtype=float)
    _, block_of = scipy.sparse.csgraph.connected_components(coupled.T @ coupled, directed=False)
    columns, first_column, width = _grouped(block_of, block_of.max() + 1)
    chosen, first_row, height = _grouped(block_of[(rows != 0).argmax(axis=1)], len(width))

    where, entries, found = [], [], 0
    for r, k in np.unique(np.stack([height, width], axis=1), axis=0).tolist():
        alike = np.flatnonzero((height == r) & (width == k))
        on = columns[first_column[alike, None] + np.arange(k)]
        of = chosen[first_row[alike, None] + np.arange(r)]
        _, singular, V = np.linalg.svd(rows[of[:, :, None], on[:, None, :]])
        null = np.ones((len(alike), k), dtype=bool)
        null[:, : singular.shape[1]] = singular <= RANK * singular[:, :1]
        block, _ = np.nonzero(null)
        number = found + np.arange(len(block))
        where.append((on[block].ravel(), np.repeat(number, k)))
        entries.append(V[null].ravel())
        found += len(block)
    at = tuple(np.concatenate(index) for index in zip(*where, strict=True))
    return scipy.sparse.csr_array(
        scipy.sparse.coo_array((np.concatenate(entries), at), shape=(J.shape[1], found))
    )


def _grouped(
    label: NDArray[np.integer], groups: int
) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
    """Return indices ordered by label, where each group starts among them, and its size."""
    size = np.bincount(label, minlength=groups)
    return np.argsort(label, kind="stable"), np.cumsum(size) - size, size
