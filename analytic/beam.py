"""Two-node beam elements: Euler-Bernoulli, Rayleigh and Timoshenko, one derivation for all.

A node has [u_x, u_y, u_z, phi_x, phi_y, phi_z] in limb axes, z along the beam. The interpolation
is the exact static one (Przemieniecki 1968; Friedman and Kosmatka 1993), with
Phi = 12 EI / (kappa G A h^2); Phi = 0 gives Hermite's cubics. Gauss's four points integrate every
product exactly, once and for all rods.
"""

from dataclasses import dataclass
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


def _patterns() -> Floats:
    """Return the entries of K_e and M_e side by side without what depends on the rod, (31, 288).

    Of bending one row for every power of h that rotations bring (0 to 2) times every one of Phi (0
    to 2): of the strain energy, of rho A w^2 and of rho I theta^2. Then K_e's bar and shaft, and
    M_e's.
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

    K = [bending(stiffness), np.zeros((18, 144)), line([[1, -1], [-1, 1]]), np.zeros((2, 144))]
    M = [
        np.zeros((9, 144)),
        bending(_parts(deflection(_XI))),
        bending(_parts(rotation)),
        np.zeros((2, 144)),
        line([[1 / 3, 1 / 6], [1 / 6, 1 / 3]]),
    ]
    return np.hstack([np.concatenate(K), np.concatenate(M)])


_PATTERNS = _patterns()
# Of every pattern the power of h, then that of Phi / flexibility = 1 / h^2; bending first.
_OF_H = np.repeat([0.0, 1.0, 2.0], 3)
_OF_PHI = np.tile([0.0, 1.0, 2.0], 3)


@dataclass(frozen=True)
class Coefficients:
    """What elements of the same rods share, whatever their length.

    Attributes: `factors` (n, 31) and `powers` (31,): every pattern of K_e and M_e is multiplied by
    factor h^power, those of bending by 1 / (1 + Phi)^2 besides; `flexibility` (n,) as of the rods.
    """

    factors: Floats
    powers: Floats
    flexibility: Floats

    def matrices(self, lengths: Floats) -> Floats:
        """Return what `element_matrices` does."""
        values = self.factors * lengths[:, None] ** self.powers
        soft = 1 + self.flexibility / (lengths * lengths)
        values[:, :-4] /= (soft * soft)[:, None]
        return np.asarray((values @ _PATTERNS).reshape(-1, 2, 12, 12).swapaxes(0, 1))


def coefficients(rods: Sections) -> Coefficients:
    """Return what elements of these `rods` share."""
    phi = rods.flexibility[:, None] ** _OF_PHI
    shaft = 2 * rods.EI / rods.axial_speed2  # rho J of a round rod
    bending = [
        rods.EI[:, None] * phi,
        rods.line_mass[:, None] * phi,
        rods.line_inertia[:, None] * phi,
    ]
    line = np.stack([rods.EA, rods.torsion_speed2 * shaft, rods.line_mass, shaft], axis=1)
    own = _OF_H - 2 * _OF_PHI
    powers = np.concatenate([own - 3, own + 1, own - 1, [-1.0, -1.0, 1.0, 1.0]])
    return Coefficients(np.hstack([*bending, line]), powers, rods.flexibility)


def element_matrices(rods: Sections, lengths: Floats) -> Floats:
    """Return K_e and M_e, Eq. (4), of an element of each rod, shape (2, n, 12, 12).

    `lengths` h (n,) [m]. K = int EI theta' theta' + kappa G A (w' - theta)^2, M = int rho A w^2 +
    rho I theta^2 (the last with rotary inertia only), besides a linear bar (EA, rho A) and shaft
    (GJ, rho J).
    """
    return coefficients(rods).matrices(lengths)


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
def _interpolation(s: int) -> Floats:
    """Return the maps from a limb's nodes to `STATIONS` in limb axes, (2 * 33, 6 (s + 1)).

    Those of rotations times h. The sum of both halves, the second times Phi, over 1 + Phi.
    """
    cell = np.minimum((STATIONS * s).astype(int), s - 1)
    xi = STATIONS * s - cell
    parts = deflection(xi)
    maps = np.zeros((2, len(xi), 3, s + 1, 6))
    k = np.arange(len(xi))
    for direction, (dofs, sign) in enumerate(_BENDING):
        for j, dof in enumerate(dofs):
            maps[:, k, direction, cell + dof // 6, dof % 6] = parts[:, :, j] * sign[j]
    maps[:, k, 2, cell, 2], maps[:, k, 2, cell + 1, 2] = 1 - xi, xi
    return maps.reshape(2 * 3 * len(xi), -1)


def centre_lines(rods: Sections, lengths: Floats, nodes: Floats) -> Floats:
    """Return displacement at `STATIONS` in limb axes, shape (n, k, 3, m).

    By the elements' own interpolation, from `nodes` (n, s + 1, 6, m) and the elements' `lengths`
    (n,) [m].
    """
    n, ends, _, m = nodes.shape
    scaled = nodes.copy()
    scaled[:, :, 3:] *= lengths[:, None, None, None]
    both = (_interpolation(ends - 1) @ scaled.reshape(n, -1, m)).reshape(n, 2, -1, 3, m)
    phi = (rods.flexibility / lengths**2)[:, None, None, None]
    return np.asarray((both[:, 0] + phi * both[:, 1]) / (1 + phi))
