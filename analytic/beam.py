"""Two-node beam elements: Euler-Bernoulli, Rayleigh and Timoshenko, one derivation for all.

A node has [u_x, u_y, u_z, phi_x, phi_y, phi_z] in limb axes, z along the beam. The interpolation
is the exact static one (Przemieniecki 1968; Friedman and Kosmatka 1993), with
Phi = 12 EI / (kappa G A h^2); Phi = 0 gives Hermite's cubics. Gauss's four points integrate every
product exactly, once and for all rods.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from analytic.modes import STATIONS
from analytic.waves import Sections

Floats = NDArray[np.float64]

# An element's dofs are those of its nodes in turn. Bending in the plane z-x moves (u_x, phi_y) with
# phi_y = u_x'; in the plane z-y (u_y, phi_x) with phi_x = -u_y', hence the signs.
_BENDING = (((0, 4, 6, 10), (1.0, 1, 1, 1)), ((1, 3, 7, 9), (1.0, -1, 1, -1)))
_AXIAL, _TORSION = (2, 8), (5, 11)
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(4)
_XI, _WEIGHTS = (_POINTS + 1) / 2, _WEIGHTS / 2


def deflection(xi: Floats) -> Floats:
    """Return w at `xi` (k,) in 0..1 for unit (w, h theta) of both nodes, shape (2, k, 4).

    The sum of both parts, the second times Phi, over 1 + Phi.
    """
    x = xi
    return np.array(
        [
            [2 * x**3 - 3 * x**2 + 1, x**3 - 2 * x**2 + x, 3 * x**2 - 2 * x**3, x**3 - x**2],
            [1 - x, (x - x**2) / 2, x, (x**2 - x) / 2],
        ]
    ).swapaxes(1, 2)


def _parts(a: Floats) -> Floats:
    """Return int (a_0 + Phi a_1)(a_0 + Phi a_1)^T dxi by powers of Phi, (3, 4, 4); a (2, k, 4)."""
    square = np.einsum("g,pgi,qgj->pqij", _WEIGHTS, a, a)
    return np.stack([square[0, 0], square[0, 1] + square[1, 0], square[1, 1]])


def _patterns() -> tuple[Floats, Floats]:
    """Return the entries of K_e and M_e without what depends on the rod, (11, 144) and (20, 144).

    Of bending one row for every power of h that rotations bring (0 to 2) times every one of Phi (0
    to 2); then the bar and the shaft. M has those of rho A w^2, of rho I theta^2, then these two.
    """
    x, one = _XI, np.ones_like(_XI)
    rotation = np.array(
        [
            [6 * (x**2 - x), 3 * x**2 - 4 * x + 1, 6 * (x - x**2), 3 * x**2 - 2 * x],
            [0 * x, 1 - x, 0 * x, x],
        ]
    ).swapaxes(1, 2)
    curvature = np.array(
        [[12 * x - 6, 6 * x - 4, 6 - 12 * x, 6 * x - 2], [0 * x, -one, 0 * x, one]]
    ).swapaxes(1, 2)
    # w' - theta = -Phi / (1 + Phi) strain, the same along an element: its shear force is constant.
    strain = np.array([1, 0.5, -1, 0.5])
    stiffness = _parts(curvature)
    stiffness[1] += 12 * np.outer(strain, strain)
    turns = np.add.outer([0, 1, 0, 1], [0, 1, 0, 1])

    def bending(parts: Floats) -> Floats:
        placed = np.zeros((3, 3, 12, 12))
        for dofs, sign in _BENDING:
            for turn in range(3):
                where = np.where(turns == turn, parts * np.outer(sign, sign), 0.0)
                placed[turn][np.ix_(range(3), dofs, dofs)] = where
        return placed.reshape(9, 144)

    def line(matrix: list[list[float]]) -> Floats:
        placed = np.zeros((2, 12, 12))
        placed[0][np.ix_(_AXIAL, _AXIAL)] = placed[1][np.ix_(_TORSION, _TORSION)] = matrix
        return placed.reshape(2, 144)

    K = [bending(stiffness), line([[1, -1], [-1, 1]])]
    M = [
        bending(_parts(deflection(_XI))),
        bending(_parts(rotation)),
        line([[1 / 3, 1 / 6], [1 / 6, 1 / 3]]),
    ]
    return np.concatenate(K), np.concatenate(M)


_K, _M = _patterns()


def element_matrices(rods: Sections, lengths: Floats) -> Floats:
    """Return K_e and M_e, Eq. (4), of an element of each rod, shape (2, n, 12, 12).

    `lengths` h (n,) [m]. K = int EI theta' theta' + kappa G A (w' - theta)^2, M = int rho A w^2 +
    rho I theta^2 (the last with rotary inertia only), besides a linear bar (EA, rho A) and shaft
    (GJ, rho J).
    """
    h = lengths
    n = len(h)
    square = h * h
    phi = rods.flexibility / square
    grid = np.empty((n, 3, 3))
    grid[:, 0, 0] = scale = 1 / (1 + phi) ** 2
    grid[:, 0, 1], grid[:, 0, 2] = scale * phi, scale * phi * phi
    grid[:, 1], grid[:, 2] = grid[:, 0] * h[:, None], grid[:, 0] * square[:, None]
    powers = grid.reshape(n, 9)
    shaft = 2 * rods.EI / rods.axial_speed2  # rho J of a round rod
    stiff, heavy = np.empty((n, 11)), np.empty((n, 20))
    stiff[:, :9] = powers * (rods.EI / (square * h))[:, None]
    stiff[:, 9], stiff[:, 10] = rods.EA / h, rods.torsion_speed2 * shaft / h
    heavy[:, :9] = powers * (rods.line_mass * h)[:, None]
    heavy[:, 9:18] = powers * (rods.line_inertia / h)[:, None]
    heavy[:, 18], heavy[:, 19] = rods.line_mass * h, shaft * h
    both = np.empty((2, n, 144))
    np.matmul(stiff, _K, out=both[0])
    np.matmul(heavy, _M, out=both[1])
    return both.reshape(2, n, 12, 12)


def strains(rods: Sections, lengths: Floats, nodes: Floats) -> Floats:
    """Return e of every element with e^T e twice its strain energy, shape (6 n s, m).

    `nodes` (n, s + 1, 6, m): m motions of the limbs' nodes in limb axes; `lengths` h (n,) [m] of
    their elements. Of K_e the same in other words: EA / h stretch^2 + GJ / h twist^2 + EI / h
    bend^2 + 12 EI / (1 + Phi) h (lean - mean rotation)^2 in either plane. Differences come before
    products, so that rigid motion, nearly all of a short element's, leaves no rounding.
    """
    h = lengths[:, None, None]
    change = np.diff(nodes, axis=1)
    e = np.empty_like(change)
    bending = np.sqrt(rods.EI / lengths)[:, None, None]
    e[:, :, 0] = np.sqrt(rods.EA / lengths)[:, None, None] * change[:, :, 2]
    twisting = 2 * rods.EI * rods.torsion_speed2 / rods.axial_speed2
    e[:, :, 1] = np.sqrt(twisting / lengths)[:, None, None] * change[:, :, 5]
    e[:, :, 2:4] = bending[..., None] * change[:, :, 3:5]
    mean = (nodes[:, 1:, 3:5] + nodes[:, :-1, 3:5]) / 2
    leaning = bending * np.sqrt(12 / (1 + rods.flexibility / lengths**2))[:, None, None]
    e[:, :, 4] = leaning * (mean[:, :, 1] - change[:, :, 0] / h)
    e[:, :, 5] = leaning * (mean[:, :, 0] + change[:, :, 1] / h)
    return e.reshape(-1, nodes.shape[-1])


@lru_cache(maxsize=32)
def _cells(s: int) -> tuple[NDArray[np.int64], Floats, Floats]:
    """Return for `STATIONS` the nodes beside each (k, 2), where it is between, and `deflection`."""
    cell = np.minimum((STATIONS * s).astype(int), s - 1)
    xi = STATIONS * s - cell
    return cell[:, None] + [0, 1], xi, deflection(xi)


def centre_lines(rods: Sections, lengths: Floats, nodes: Floats) -> Floats:
    """Return displacement at `STATIONS` in limb axes, shape (n, k, 3, m).

    By the elements' own interpolation, from `nodes` (n, s + 1, 6, m) and the elements' `lengths`
    (n,) [m].
    """
    n = len(nodes)
    beside, xi, parts = _cells(nodes.shape[1] - 1)
    phi = (rods.flexibility / lengths**2)[:, None, None]
    w = (parts[0] + phi * parts[1]) / (1 + phi)
    w[..., 1::2] *= lengths[:, None, None]
    weights = np.zeros((n, len(xi), 3, 12))
    for direction, (dofs, sign) in enumerate(_BENDING):
        weights[:, :, direction, dofs] = w * sign
    weights[:, :, 2, 2], weights[:, :, 2, 8] = 1 - xi, xi
    ends = nodes[:, beside].reshape(n, len(xi), 12, -1)
    return np.asarray(weights @ ends)
