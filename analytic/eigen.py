"""Eqs. (23)-(24): the lowest natural frequencies and modes of (K, M).

LAPACK's error is relative to the largest eigenvalue, and that of (K, M) grows with s^4: solved is
M x = mu K x, whose largest mu = 1 / omega^2 are wanted. Two things this leaves: K of short elements
is rounded by more than the last digits of its lowest modes, and where the mechanism moves freely K
is singular. Both are mended by `refined`, from the strains of the modes found.
"""

from __future__ import annotations  # scipy loads its parts when they are first used

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from analytic.lanczos import is_sparse, lowest_sparse

Array = NDArray[np.float64]


def lowest_modes(K: Any, M: Any, count: int, shift: float = 0.0) -> tuple[Array, Array]:
    """Return the `count` lowest omega^2, ascending, and mass-normalised vectors, (dofs, count).

    (K - omega^2 M) Phi = 0 for arrays (by LAPACK) or sparse arrays (by block Lanczos), through the
    inverse of K + `shift` M. Raises `LinAlgError` where that is not positive definite.
    """
    if is_sparse(K):
        return lowest_sparse(K, M, count, shift)
    root, A = _standard(K + shift * M if shift else K, M)
    mu, z = largest(A, count)
    x, _ = scipy.linalg.lapack.dtrtrs(root, z, lower=1, trans=1)
    return 1 / mu[::-1] - shift, (x / np.sqrt(mu))[:, ::-1]


def lowest_values(K: Array, M: Array, count: int) -> Array:
    """Return what `lowest_modes` returns of a dense pair, but for the vectors."""
    _, d, e, _, _ = scipy.linalg.lapack.dsytrd(_standard(K, M)[1], lower=1)
    return np.asarray(1 / _last(d, e, count)[::-1])


def largest(A: Array, count: int) -> tuple[Array, Array]:
    """Return the `count` largest eigenvalues of a dense A, ascending, all positive, and vectors.

    Of symmetric A the lower triangle is read. All eigenvalues of the tridiagonal form cost less
    than a few by bisection (`dsyevx`); vectors are found of those wanted. Raises `LinAlgError`.
    """
    lapack, size = scipy.linalg.lapack, len(A)
    reflectors, d, e, scales, _ = lapack.dsytrd(A, lower=1)
    mu = _last(d, e, count)
    one_block = np.ones(size, dtype=np.int32)
    z, info = lapack.dstein(d, e, mu, one_block, size * one_block)
    _check(info, mu)
    if size > 1:  # Householder's vectors of the lower triangle leave the first row alone
        z[1:] = lapack.dormqr("L", "N", reflectors[1:, :-1], scales, z[1:], 64 * count)[0]
    return mu, z


def _standard(K: Array, M: Array) -> tuple[Array, Array]:
    """Return L of K = L L^T, and L^-1 M L^-T.

    A symmetric matrix seen by columns is the same one: nothing is copied but what is overwritten.
    """
    root, info = scipy.linalg.lapack.dpotrf(K.T, lower=1)
    if info:
        raise np.linalg.LinAlgError(f"K is not positive definite ({info})")
    solve = scipy.linalg.blas.dtrsm
    half = solve(1.0, root, M.T, lower=1)
    return root, solve(1.0, root, half, side=1, lower=1, trans_a=1, overwrite_b=1)


def _last(d: Array, e: Array, count: int) -> Array:
    """Return the `count` largest eigenvalues of a tridiagonal matrix, ascending."""
    every, info = scipy.linalg.lapack.dsterf(d, e)
    mu = every[-count:]
    _check(info, mu)
    return np.asarray(mu)


def _check(info: int, mu: Array) -> None:
    if info or not mu[0] > 0:
        raise np.linalg.LinAlgError(f"K is not positive definite, or no convergence ({info})")


def refined(
    M: Any, u: Array, strains: Callable[[Array], Array], free: int, shift: float
) -> tuple[Array, Array]:
    """Return omega^2 and mass-normalised vectors in the space of `u`, from their strains.

    `strains(u)` = e with e^T e = u^T K u (see `beam.strains`). By Rayleigh and Ritz: an error of u
    enters squared. The first `free` have omega^2 = 0: the mechanism's free motions.
    """
    size = 1 / np.sqrt((u * (M @ u)).sum(axis=0))
    u = u * size
    e = strains(u)
    mass, stiffness = u.T @ (M @ u), e.T @ e
    y = scipy.linalg.eigh(mass, stiffness + shift * mass)[1][:, ::-1]
    y /= np.sqrt((y * (mass @ y)).sum(axis=0))
    # Each by its own strains: a sum of squares, small where the mode is slow.
    values = ((e @ y) ** 2).sum(axis=0)
    values[:free] = 0.0
    order = np.argsort(values, kind="stable")
    return values[order], u @ y[:, order]


def hertz(eigenvalues: Array) -> Array:
    """Return f = omega / 2 pi of omega^2; raises `ArithmeticError` for a negative one."""
    if not (eigenvalues >= 0).all():
        raise ArithmeticError(f"omega^2 = {eigenvalues.min():.3g} 1/s^2 is below zero")
    return np.sqrt(eigenvalues) / (2 * np.pi)
