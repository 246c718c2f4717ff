"""Beam elements of rods with any section: the statics exact, one derivation for all theories.

As `beam`, with bending in two planes: a node has [u_x, u_y, u_z, phi_x, phi_y, phi_z] in limb axes,
z along the rod; bending that moves u_x turns by phi_y = u_x', and bending that moves u_y by
phi_x = -u_y'.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from analytic.errors import InputError
from analytic.mechanism import Rod
from analytic.theory import Theory

Floats = NDArray[np.float64]

BENDING = (((0, 4, 6, 10), (1.0, 1, 1, 1)), ((1, 3, 7, 9), (1.0, -1, 1, -1)))
"""An element's dofs (w, theta, w, theta) and their signs, of either plane."""
AXIAL, TORSION = (2, 8), (5, 11)


@dataclass(frozen=True)
class Properties:
    """What rods resist and weigh; every entry has shape (n,), those of two planes (n, 2).

    Attributes: `EA` [N], `GJ` and `EI` of motion along x and along y [N m^2], `mass` rho A [kg/m],
    `polar` rho (Ix + Iy), `rotary` rho I of either plane [kg m] (zero without rotary inertia),
    `shear` EI / (kappa G A) [m^2] (zero without shear).
    """

    EA: Floats
    GJ: Floats
    EI: Floats
    mass: Floats
    polar: Floats
    rotary: Floats
    shear: Floats


def properties(rods: list[Rod], theory: Theory) -> Properties:
    """Return the properties of `rods` under `theory`.

    Raises `InputError` for Timoshenko's with a section that is neither round nor says its shear
    coefficients.
    """
    rows = []
    for rod in rods:
        E, G, rho = rod.material.young, rod.material.shear, rod.material.density
        section = rod.section
        # Motion along x turns sections about y.
        about = section.second_moments[1], section.second_moments[0]
        rotary = rho if theory.rotary_inertia else 0.0
        kappas = shear_coefficients(rod, theory)
        rows.append([
            E * section.area,
            G * section.torsion_constant,
            *(E * second for second in about),
            rho * section.area,
            rho * section.polar_moment,
            *(rotary * second for second in about),
            *(
                E * second / (kappa * G * section.area) if kappa else 0.0
                for second, kappa in zip(about, kappas, strict=True)
            ),
        ])  # fmt: skip
    EA, GJ, EI0, EI1, mass, polar, rotary0, rotary1, shear0, shear1 = np.array(rows).T
    two = (np.stack(pair, axis=-1) for pair in ((EI0, EI1), (rotary0, rotary1), (shear0, shear1)))
    EI, rotaries, shears = two
    return Properties(EA, GJ, EI, mass, polar, rotaries, shears)


def shear_coefficients(rod: Rod, theory: Theory) -> tuple[float, float]:
    """Return kappa of shear along x and y; 0 without shear deformation.

    The section's own; or the theory's, by Cowper for hollow round sections too,
    6 (1 + nu) (1 + m^2)^2 / ((7 + 6 nu) (1 + m^2)^2 + (20 + 12 nu) m^2) with m = bore / diameter.
    """
    if theory.beam != "timoshenko":
        return 0.0, 0.0
    section = rod.section
    if section.shear_coefficients is not None:
        return section.shear_coefficients
    if section.diameter is None:
        raise InputError(
            "Section.shear_coefficients",
            None,
            "two shear coefficients, which Timoshenko's theory needs of a section not round",
        )
    if theory.shear == "cowper" and section.bore:
        nu, m2 = rod.material.poisson, (section.bore / section.diameter) ** 2
        round_ = (1 + m2) ** 2
        kappa = 6 * (1 + nu) * round_ / ((7 + 6 * nu) * round_ + (20 + 12 * nu) * m2)
    else:
        kappa = theory.shear_coefficient(rod.material)
    return kappa, kappa


@lru_cache(maxsize=1)
def _patterns() -> tuple[Floats, Floats]:
    """Return entries of K_e and M_e without what depends on the rod, (14, 144) and (38, 144).

    Of either plane, one row for every power of h that rotations bring (0 to 2) times one of Phi (0
    to 2); then the bar and the shaft. M has those of w^2, of theta^2, then these two.
    """
    points, weights = np.polynomial.legendre.leggauss(4)
    x, weights = (points + 1) / 2, weights / 2
    one = np.ones_like(x)

    def parts(a: Floats) -> Floats:
        square = np.einsum("g,pig,qjg->pqij", weights, a, a)
        return np.stack([square[0, 0], square[0, 1] + square[1, 0], square[1, 1]])

    w = np.array([
        [2 * x**3 - 3 * x**2 + 1, x**3 - 2 * x**2 + x, 3 * x**2 - 2 * x**3, x**3 - x**2],
        [1 - x, (x - x**2) / 2, x, (x**2 - x) / 2],
    ])  # fmt: skip
    theta = np.array([
        [6 * (x**2 - x), 3 * x**2 - 4 * x + 1, 6 * (x - x**2), 3 * x**2 - 2 * x],
        [0 * x, 1 - x, 0 * x, x],
    ])  # fmt: skip
    curvature = np.array(
        [[12 * x - 6, 6 * x - 4, 6 - 12 * x, 6 * x - 2], [0 * x, -one, 0 * x, one]]
    )
    # w' - theta = -Phi / (1 + Phi) strain, the same along an element: its shear force is constant.
    strain = np.array([1, 0.5, -1, 0.5])
    stiffness = parts(curvature)
    stiffness[1] += 12 * np.outer(strain, strain)
    turns = np.add.outer([0, 1, 0, 1], [0, 1, 0, 1])

    def bending(of: Floats, plane: int) -> Floats:
        placed = np.zeros((3, 3, 12, 12))
        dofs, sign = BENDING[plane]
        for turn in range(3):
            where = np.where(turns == turn, of * np.outer(sign, sign), 0.0)
            placed[turn][np.ix_(range(3), dofs, dofs)] = where
        return placed.reshape(9, 144)

    def line(matrix: list[list[float]]) -> Floats:
        placed = np.zeros((2, 12, 12))
        placed[0][np.ix_(AXIAL, AXIAL)] = placed[1][np.ix_(TORSION, TORSION)] = matrix
        return placed.reshape(2, 144)

    K = [bending(stiffness, 0), bending(stiffness, 1), line([[1, -1], [-1, 1]])]
    M = [bending(of, plane) for plane in (0, 1) for of in (parts(w), parts(theta))]
    return np.concatenate(K), np.concatenate([*M, line([[1 / 3, 1 / 6], [1 / 6, 1 / 3]])])


def element_matrices(rods: Properties, lengths: Floats) -> Floats:
    """Return K_e and M_e, Eq. (4), of an element of each rod, shape (2, n, 12, 12).

    `lengths` h (n,) [m]. K = int EI theta' theta' + kappa G A (w' - theta)^2, M = int rho A w^2 +
    rho I theta^2, besides a linear bar (EA, rho A) and shaft (GJ, rho (Ix + Iy)).
    """
    K, M = _patterns()
    h = lengths
    n = len(h)
    stiff, heavy = np.empty((n, 20)), np.empty((n, 38))
    turned = np.stack([np.ones_like(h), h, h * h], axis=-1)
    for plane in (0, 1):
        phi = 12 * rods.shear[:, plane] / (h * h)
        grid = np.stack([np.ones_like(phi), phi, phi * phi], axis=-1) / ((1 + phi) ** 2)[:, None]
        powers = (turned[:, :, None] * grid[:, None, :]).reshape(n, 9)
        stiff[:, 9 * plane : 9 * plane + 9] = powers * (rods.EI[:, plane] / h**3)[:, None]
        heavy[:, 18 * plane : 18 * plane + 9] = powers * (rods.mass * h)[:, None]
        rotary = powers * (rods.rotary[:, plane] / h)[:, None]
        heavy[:, 18 * plane + 9 : 18 * plane + 18] = rotary
    stiff[:, 18], stiff[:, 19] = rods.EA / h, rods.GJ / h
    heavy[:, 36], heavy[:, 37] = rods.mass * h, rods.polar * h
    return np.stack([stiff @ K, heavy @ M]).reshape(2, n, 12, 12)
