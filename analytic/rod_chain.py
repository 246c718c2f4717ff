"""Pieces of a rod that are chains of equal elements, condensed onto their ends.

y as in `rod_exact`: an element's T carries it from node to node, and a piece of m elements has T^m.
T is written as at rest, plus Lambda times what inertia does: nothing cancels at low frequency or in
short elements. Powers are taken of T - 1, so that many elements lose no digits.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.rod_elements import bending_numbers

Array = NDArray[Any]
Floats = NDArray[np.float64]

MIRROR = np.array([[1.0, -1.0], [-1.0, 1.0]])
"""What changes sign of (w, theta) by (w, theta) as seen from the other end."""
RIGID = np.array([[1.0, 1.0], [0.0, 1.0]])


def transition(mu: Array, rotary: Floats, phi: Floats, elements: int) -> Array:
    """Return T^m over a piece of m `elements`, shape (..., 4, 4); see `rod_exact.transition`.

    `mu` and `phi` as there, `rotary` rho I / (m L^2), of the piece.
    """
    m = elements
    # Of one element, in its own units.
    Lambda, phi, rotary = (mu / m**4)[..., None, None], phi * m**2, rotary * m**2
    shear = 12 * phi
    (p, q, *_, r, _), (pm, qm, tm, vm, rm, ym) = bending_numbers(shear, rotary)
    C = matrix([[p, -q], [-q, r]]) - Lambda * matrix([[pm, -qm], [-qm, rm]])
    B = matrix([[tm, vm], [-vm, ym]])
    # What the inertia of rigid motions does at the first node.
    by_turn = 1 / (1 + shear)
    o = np.zeros_like(shear)
    E = matrix([
        [o + 1 / 2, by_turn * ((9 + 10 * shear) / 60 - rotary)],
        [o + 1 / 12, by_turn * ((4 + 5 * shear) / 120 + rotary * shear / 2)],
    ])  # fmt: skip
    # The elements' D_01 is (Lambda bent B + 1) / -bent: d1 = T d0 + bent f0 at rest.
    bent = matrix([[phi - 1 / 6, o + 1 / 2], [o - 1 / 2, o + 1]])
    left = -Lambda * np.linalg.solve(np.eye(2) + Lambda * (bent @ B), bent + 0 * C)
    N = np.empty((*C.shape[:-2], 4, 4), dtype=left.dtype)
    moved = left @ E
    N[..., :2, :2] = moved + (RIGID - np.eye(2))
    N[..., :2, 2:] = left @ B @ bent + bent
    N[..., 2:, :2] = C @ moved - Lambda * ((MIRROR * E) @ RIGID)
    # T is symplectic, and the element the same from either end.
    N[..., 2:, 2:] = N[..., :2, :2].swapaxes(-1, -2) * MIRROR
    unit = np.array([1 / m, 1, m**2, m])
    return np.eye(4) + _power(N * (unit[:, None] / unit), m)


def bar(x: Array, elements: int) -> tuple[Array, Array]:
    """Return what `rod_exact.bar` does, of linear elements."""
    m = elements
    x = x / m**2
    N = matrix([[-x / 2, 1 / m + 0 * x], [-m * x * (1 - x / 12), -x / 2]])
    N = _power(N / (1 + x / 6)[..., None, None], m)
    return (1 + N[..., 0, 0]) / N[..., 0, 1], -1 / N[..., 0, 1]


def matrix(rows: list[list[Array]]) -> Array:
    """Return the matrices (..., a, b) of entries (...)."""
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _power(N: Array, m: int) -> Array:
    """Return (1 + N)^m - 1."""
    result = np.zeros_like(N)
    while True:
        if m % 2:
            result = result + N + result @ N
        m //= 2
        if not m:
            return result
        N = 2 * N + N @ N
