"""The lowest modes of a sparse pair, none missed: block Lanczos, checked by Sylvester's inertia.

Lanczos from one start vector finds a second copy of a repeated mode by rounding only: of 2,100
solutions at symmetric poses with `scipy.sparse.linalg.eigsh`, 11 missed one. A block finds as many
copies as it has columns, and the inertia of K - omega^2 M says whether any is missing.
"""

from __future__ import annotations  # scipy loads its parts when they are first used

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

Array = NDArray[np.float64]
CONVERGED = 1e-10
"""Residual of a mode, relative to its eigenvalue of the inverse; the eigenvalue's is its square."""
STALLED = 1e-5
"""Residual that is taken if rounding lets it shrink no further, as with hundreds of elements."""
ROUNDING = 1e-2
"""The same, if three blocks have not shrunk it at all: what is left is the inverse's rounding."""
FLAT, STUCK = 1e-2, 8
"""So many blocks that change a residual by less than this part of it will not shrink it."""
DISTINCT = 1e-9
"""omega^2 closer than this, relative, are not told apart by the count; nor is what rounding of K
moves, a few parts in 1e16 of the largest omega^2 of a single coordinate."""
SAME = 1e-3
"""Omega^2 of two solutions closer than this, relative, are those of one set of modes."""
SINGULAR = 1e-12
"""A pivot below this part of its diagonal entry is zero but for rounding."""


class SingularError(np.linalg.LinAlgError):
    """A matrix that cannot be eliminated."""


def lowest_sparse(
    K: scipy.sparse.csr_array, M: scipy.sparse.csr_array, count: int, shift: float = 0.0
) -> tuple[Array, Array]:
    """Return the `count` lowest omega^2 of (K, M), ascending, and mass-normalised vectors.

    By the inverse of K + `shift` M. Coordinates should run along the chains of a structure: they
    are eliminated in the order given. Raises `SingularError` where that matrix is singular.
    """
    inverse = factor(K + shift * M if shift else K)
    if (pivots(inverse) < SINGULAR * K.diagonal()).any():
        raise SingularError("K + shift M is not positive definite")
    return lowest(K, M, count, inverse.solve, (K, M))


def lowest(
    K: scipy.sparse.csr_array,
    M: scipy.sparse.csr_array,
    count: int,
    solve: Callable[[Array], Array],
    counted: tuple[scipy.sparse.csr_array, scipy.sparse.csr_array],
) -> tuple[Array, Array]:
    """Return what `lowest_sparse` returns, with any inverse of K + shift M, by `solve`.

    `counted` is the pair whose inertia counts the modes: (K, M), or what constraints leave of it.
    """
    rounding = 4 * np.finfo(float).eps * (K.diagonal() / M.diagonal()).max()
    block, before = count + 2, np.full(count, np.nan)
    while True:
        u = _block_lanczos(solve, M, count, block)
        # Rayleigh's quotient: free of what a shift rounds off.
        values = (u * (K @ u)).sum(axis=0)
        order = np.argsort(values)
        values, u = values[order], u[:, order]
        below = values[-1] - max(DISTINCT * abs(values[-1]), rounding)
        if _count(*counted, below) == (values < below).sum():
            return values, u
        # Twice the block finds what the first one left out. If that was nothing, rounding of K has
        # moved a mode past where they were counted.
        if np.allclose(values, before, rtol=SAME, atol=rounding) or block >= K.shape[0]:
            return values, u
        block, before = 2 * block, values


def _count(K: scipy.sparse.csr_array, M: scipy.sparse.csr_array, value: float) -> int | None:
    """Return how many omega^2 of (K, M) lie below `value`; None where a pivot vanishes."""
    try:
        return int((pivots(factor(K - value * M)) < 0).sum())
    except SingularError:
        return None


def is_sparse(A: Any) -> bool:
    """Return whether a matrix is stored as a sparse one."""
    return bool(scipy.sparse.issparse(A))


def factor(A: scipy.sparse.csr_array) -> scipy.sparse.linalg.SuperLU:
    """Return A = L U, eliminated down the diagonal: rows and columns are permuted alike."""
    try:
        factors = scipy.sparse.linalg.splu(
            scipy.sparse.csc_array(A),
            permc_spec="NATURAL",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
    except RuntimeError:
        raise SingularError from None
    if (factors.perm_r != factors.perm_c).any():
        raise SingularError
    return factors


def pivots(factors: scipy.sparse.linalg.SuperLU) -> Array:
    """Return D of L D L^T in A's own order; its signs are A's inertia (Sylvester)."""
    return np.asarray(factors.U.diagonal()[factors.perm_c])


def _block_lanczos(
    solve: Callable[[Array], Array], M: scipy.sparse.csr_array, count: int, block: int
) -> Array:
    """Return mass-normalised eigenvectors of S M to its `count` largest eigenvalues, descending.

    `solve` applies S, symmetric and semidefinite. Every block is orthogonalised against
    all before it; the Rayleigh-Ritz values of the whole basis are taken after each. Raises
    `SingularError` where rounding of S leaves no hope of all.
    """
    size = M.shape[0]
    # A fixed start: the same input gives the same bits.
    W = solve(np.random.default_rng(0).standard_normal((size, block)))
    V, Z = np.empty((size, 0)), np.empty((size, 0))
    last, still, flat = np.inf, 0, 0
    while True:
        W = _orthonormal(W, V, M)
        V = np.hstack([V, W])
        # As many columns as the space has leave nothing out, though rounding finds ever more.
        exhausted = not W.shape[1] or V.shape[1] >= size
        W = solve(M @ W)
        Z = np.hstack([Z, W])
        T = (M @ V).T @ Z
        mu, y = np.linalg.eigh((T + T.T) / 2)
        mu, y = mu[: -count - 1 : -1], y[:, : -count - 1 : -1]
        u = V @ y
        gap = Z @ y - u * mu
        residual = (np.sqrt((gap * (M @ gap)).sum(axis=0)) / mu).max()
        still = still + 1 if residual > 0.9 * last else 0
        flat = flat + 1 if abs(residual - last) < FLAT * last else 0
        stalled = residual < STALLED and residual > last / 2
        stalled |= residual < ROUNDING and still == 3
        if len(mu) == count and (exhausted or residual <= CONVERGED or stalled):
            # Once more through the inverse: rounding has left traces of high modes in u, which
            # Rayleigh's quotient would multiply by their omega^2.
            u = Z @ y
            return np.asarray(u / np.sqrt((u * (M @ u)).sum(axis=0)))
        if flat == STUCK:
            raise SingularError("rounding of the inverse hides its smaller eigenvalues")
        last = residual


def _orthonormal(W: Array, V: Array, M: scipy.sparse.csr_array) -> Array:
    """Return a basis of W's columns, orthonormal in M, to each other and to V: twice is enough.

    Directions that V holds but for rounding are dropped.
    """
    W = W / np.sqrt((W * (M @ W)).sum(axis=0))
    for _ in range(2):
        W = W - V @ ((M @ V).T @ W)
        d, Q = np.linalg.eigh(W.T @ (M @ W))
        new = d > max(1e-24, 1e-12 * d.max(initial=0.0))
        W = W @ (Q[:, new] / np.sqrt(d[new]))
    return W
