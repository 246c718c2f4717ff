"""Linearised dynamics under joint constraints: project, exactly, on what they leave free."""

from __future__ import annotations  # scipy loads its parts when they are first used

from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from analytic.modes import check_count
from reference_models.protocol import ModelError, hertz
from reference_models.spent import phase

Array = NDArray[np.float64]
RANK = 1e-9
"""Singular values below this, relative to the largest of the same joints, are zero."""
FULL = 0.1
"""A basis with more entries than this part of all is multiplied as a full matrix."""
SMALL = 128
"""Up to so many coordinates one decomposition of all costs less than finding its blocks."""
NOISE = 1e-14
"""Constraints smaller than this, relative to the largest, constrain nothing (a free axis)."""

LAPACK = 1e-9
"""Largest relative error of an omega^2 by LAPACK that is taken without a second, shifted, try."""
SPREAD = 1e-4
"""The least shift of a singular K, relative to the largest omega^2 asked for."""
STILL = 1e-4
"""A frequency below this part of the highest found belongs to a free motion."""
ROUNDING = 1e-12
"""Of an entry of K, relative, with what projection adds."""


def constrained_modes(
    model: str, K: Array, M: Array, J: Array, count: int, rounding: float = ROUNDING
) -> tuple[Array, Array, int]:
    """Return frequencies [Hz] (count,), mass-normalised shapes (N, count), coordinates left free.

    K, M are (N, N) over all coordinates q; the joints demand J dq = 0, J (c, N) of any rank.
    With N_0 an orthonormal basis of J's null space: (N_0^T K N_0 - omega^2 N_0^T M N_0) x = 0.
    K's entries are known to `rounding`, relative. Raises `InputError` for more modes than
    coordinates left free, and `ModelError` naming the `model` where an omega^2 is below zero.
    """
    with phase("projection"):
        free = null_space(J)
        check_count(count, free.shape[1])
        full = free.nnz > FULL * free.shape[0] * free.shape[1]
        basis: Any = free.toarray() if full else free
        reduced = (basis.T @ (A @ basis) for A in (K, M))
        K_free, M_free = ((A + A.T) / 2 for A in reduced)
    with phase("eigen-solution"):
        values, x, noise = _lowest(K_free, M_free, count, rounding)
    return hertz(model, values, noise), free @ x, free.shape[1]


def _lowest(K: Array, M: Array, count: int, rounding: float) -> tuple[Array, Array, Array]:
    """Return the lowest eigenvalues, mass-normalised vectors, and how far the former are known.

    LAPACK's error is relative to the largest eigenvalue: that of (M, K) belongs to the lowest mode.
    Where K is singular (a free motion), K + sigma M is not: sigma is about one of the lowest.
    """
    last = (len(K) - count, len(K) - 1)
    rounded = len(K) * np.finfo(float).eps
    try:
        mu, x = scipy.linalg.eigh(M, K, subset_by_index=last)
        found = 1 / mu[::-1], (x / np.sqrt(mu))[:, ::-1]
        noise = _noise(K, found[1], rounding)
        # LAPACK's error of any mu is that of the largest: one of a free motion spoils the others.
        if (found[0] > noise).all() and rounded * mu[-1] <= LAPACK * mu[0]:
            return *found, noise
    except np.linalg.LinAlgError:
        pass  # K is singular, or not even that
    values = scipy.linalg.eigh(K, M, eigvals_only=True)
    scale = max(values[count - 1], rounded * values[-1])
    shift = float(values[values >= SPREAD * scale][0]) or 1.0
    try:
        mu, x = scipy.linalg.eigh(M, K + shift * M, subset_by_index=last)
    except np.linalg.LinAlgError:  # far below zero
        values, x = scipy.linalg.eigh(K, M)
        noise = _noise(K, x, rounding) + rounded * values[-1]
        return values[:count], x[:, :count], noise[:count]
    x = (x / np.sqrt(mu))[:, ::-1]
    return 1 / mu[::-1] - shift, x, _noise(K, x, rounding) + rounding * shift


def _noise(K: Array, x: Array, rounding: float) -> Array:
    """Return how far x^T K x is known for every column of x where K's entries are rounded."""
    return np.asarray(rounding * np.einsum("im,im->m", np.abs(x), np.abs(K) @ np.abs(x)))


def vibrations(model: str, frequencies: Array, spins: int, count: int) -> NDArray[np.intp]:
    """Return which `count` of ascending `frequencies` are vibrations.

    `spins` limbs may turn about themselves, which moves nothing else. Raises `ModelError` naming
    the `model` where more motions need no energy: the platform's.
    """
    still = frequencies < STILL * frequencies[-1]
    if still.sum() > spins:
        raise ModelError(
            f"{model}: {int(still.sum())} motions need no energy, where {spins} limbs may spin: "
            "the platform can move with the drives locked"
        )
    return np.flatnonzero(~still)[:count]


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
    if not len(rows):
        return scipy.sparse.eye_array(J.shape[1], format="csr")
    if J.shape[1] <= SMALL:
        _, singular, V = np.linalg.svd(rows)
        return scipy.sparse.csr_array(V[np.sum(singular > RANK * singular[0]) :].T)
    coupled = scipy.sparse.csr_array(rows != 0, dtype=float)
    _, block_of = scipy.sparse.csgraph.connected_components(coupled.T @ coupled, directed=False)
    columns, first_column, width = _grouped(block_of, block_of.max() + 1)
    chosen, first_row, height = _grouped(block_of[(rows != 0).argmax(axis=1)], len(width))

    where, entries, found = [], [], 0
    for r, k in np.unique(np.stack([height, width], axis=1), axis=0).tolist():
        alike = np.flatnonzero((height == r) & (width == k))
        on = columns[first_column[alike, None] + np.arange(k)]
        of = chosen[first_row[alike, None] + np.arange(r)]
        _, singular, held = np.linalg.svd(rows[of[:, :, None], on[:, None, :]], full_matrices=False)
        null = np.ones((len(alike), k), dtype=bool)
        null[:, : singular.shape[1]] = nothing = singular <= RANK * singular[:, :1]
        # What completes an orthonormal basis of the rows; theirs that are zero come last.
        held = np.where(nothing[..., None], 0.0, held)
        V = np.linalg.qr(held.swapaxes(1, 2), mode="complete")[0].swapaxes(1, 2)
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
