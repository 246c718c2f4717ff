"""Two-node beam elements of rods with any section: Euler-Bernoulli, Rayleigh and Timoshenko in one.

A node has [u_x, u_y, u_z, phi_x, phi_y, phi_z] in limb axes, z along the rod. The interpolation is
the exact static one (Przemieniecki 1968; Friedman and Kosmatka 1993), with
Phi = 12 EI / (kappa G A h^2); Phi = 0 gives Hermite's cubics.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.errors import InputError
from analytic.mechanism import Rod
from analytic.theory import Theory

Floats = NDArray[np.float64]

# An element's dofs are those of its nodes in turn. Bending in the plane z-x moves (u_x, phi_y) with
# phi_y = u_x'; in the plane z-y (u_y, phi_x) with phi_x = -u_y', hence the signs.
BENDING = (((0, 4, 6, 10), (1.0, 1, 1, 1)), ((1, 3, 7, 9), (1.0, -1, 1, -1)))
"""An element's dofs (w, theta, w, theta) and their signs, of either plane."""
AXIAL, TORSION = (2, 8), (5, 11)


@dataclass(frozen=True)
class Properties:
    """What rods resist and weigh; every entry has shape (n,), of bending in two planes (n, 2).

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

    def alike(self) -> "Properties":
        """Return those of rods that bend alike in both planes, said once: (n, 1)."""
        own = {name: getattr(self, name)[:, :1] for name in ("EI", "rotary", "shear")}
        return replace(self, **own)


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


def bending_numbers(
    phi: NDArray[Any], rotary: NDArray[Any]
) -> tuple[tuple[NDArray[Any], ...], tuple[NDArray[Any], ...]]:
    """Return (p, q, t, v, r, y) of an element's bending stiffness and of its mass.

    [[p, q, t, v], [q, r, -v, y], [t, -v, p, -q], [v, y, -q, r]] in units of EI / h^3 and rho A h
    over (w, h theta), in closed form (Friedman and Kosmatka 1993): `phi` 12 EI / (kappa G A h^2),
    `rotary` rho I / (rho A h^2).
    """
    one = 1 / (1 + phi)
    stiff = (12 * one, 6 * one, -12 * one, 6 * one, (4 + phi) * one, (2 - phi) * one)
    mass = (
        13 / 35 + 7 * phi / 10 + phi**2 / 3 + rotary * 6 / 5,
        11 / 210 + 11 * phi / 120 + phi**2 / 24 + rotary * (1 / 10 - phi / 2),
        9 / 70 + 3 * phi / 10 + phi**2 / 6 - rotary * 6 / 5,
        -(13 / 420 + 3 * phi / 40 + phi**2 / 24) + rotary * (1 / 10 - phi / 2),
        1 / 105 + phi / 60 + phi**2 / 120 + rotary * (2 / 15 + phi / 6 + phi**2 / 3),
        -(1 / 140 + phi / 60 + phi**2 / 120) - rotary * (1 / 30 + phi / 6 - phi**2 / 6),
    )
    return stiff, tuple(entry * one**2 for entry in mass)


@lru_cache(maxsize=2)
def _patterns(planes: int) -> Floats:
    """Return K_e and M_e side by side without what depends on the rod, (27 `planes` + 4, 288).

    Of bending in a plane (of both alike, where `planes` is 1) one row for every power of h that
    rotations bring (0 to 2) times every one of Phi (0 to 2): of the strain energy, of rho A w^2 and
    of rho I theta^2. Then K_e's bar and shaft, and M_e's. Gauss's four points integrate exactly.
    """
    points, weights = np.polynomial.legendre.leggauss(4)
    x, weights = (points + 1) / 2, weights / 2
    one = np.ones_like(x)

    def parts(a: Floats) -> Floats:
        """Return int (a_0 + Phi a_1)(a_0 + Phi a_1)^T dxi by powers of Phi, (3, 4, 4)."""
        square = np.einsum("g,pgi,qgj->pqij", weights, a, a)
        return np.stack([square[0, 0], square[0, 1] + square[1, 0], square[1, 1]])

    rotation = np.array([
        [6 * (x**2 - x), 3 * x**2 - 4 * x + 1, 6 * (x - x**2), 3 * x**2 - 2 * x],
        [0 * x, 1 - x, 0 * x, x],
    ]).swapaxes(1, 2)  # fmt: skip
    curvature = np.array(
        [[12 * x - 6, 6 * x - 4, 6 - 12 * x, 6 * x - 2], [0 * x, -one, 0 * x, one]]
    ).swapaxes(1, 2)
    # w' - theta = -Phi / (1 + Phi) strain, the same along an element: its shear force is constant.
    strain = np.array([1, 0.5, -1, 0.5])
    stiffness = parts(curvature)
    stiffness[1] += 12 * np.outer(strain, strain)
    turns = np.add.outer([0, 1, 0, 1], [0, 1, 0, 1])
    rows = np.zeros((27 * planes + 4, 2, 12, 12))
    for plane, (dofs, sign) in enumerate(BENDING):
        first = 27 * (plane % planes)
        own = rows[first : first + 27].reshape(3, 3, 3, 2, 12, 12)  # energy, turn, Phi
        for kind, of in enumerate((stiffness, parts(deflection(x)), parts(rotation))):
            for turn in range(3):
                where = np.where(turns == turn, of * np.outer(sign, sign), 0.0)
                own[kind, turn, :, min(kind, 1)][np.ix_(range(3), dofs, dofs)] = where
    for matrix, line in ((0, [[1, -1], [-1, 1]]), (1, [[1 / 3, 1 / 6], [1 / 6, 1 / 3]])):
        for k, own_dofs in enumerate((AXIAL, TORSION)):
            rows[27 * planes + 2 * matrix + k, matrix][np.ix_(own_dofs, own_dofs)] = line
    return rows.reshape(-1, 288)


# Of every pattern of bending the power of h, then that of Phi, which is flexibility / h^2.
_OF_H = np.repeat([0.0, 1.0, 2.0], 3)
_OF_PHI = np.tile([0.0, 1.0, 2.0], 3)


@dataclass(frozen=True)
class Coefficients:
    """What elements of the same rods share, whatever their length.

    Attributes: `factors` (n, k) and `powers` (k,): every pattern of K_e and M_e is multiplied by
    factor h^power, those of bending by 1 / (1 + Phi)^2 besides; `flexibility` 12 EI / (kappa G A)
    of these (n, k - 4), or (n, 1) of all; `patterns` (k, 288).
    """

    factors: Floats
    powers: Floats
    flexibility: Floats
    patterns: Floats

    def matrices(self, lengths: Floats) -> Floats:
        """Return what `element_matrices` does."""
        h = lengths[:, None]
        values = self.factors * h**self.powers
        values[:, :-4] /= (1 + self.flexibility / (h * h)) ** 2
        return np.asarray((values @ self.patterns).reshape(-1, 2, 12, 12).swapaxes(0, 1))


def coefficients(rods: Properties) -> Coefficients:
    """Return what elements of these `rods` share."""
    n, planes = rods.EI.shape
    flexibility = 12 * rods.shear[..., None]
    phi = flexibility**_OF_PHI
    mass = np.broadcast_to(rods.mass[:, None], (n, planes))
    bending = np.stack([rods.EI, mass, rods.rotary], axis=2)[..., None] * phi[:, :, None]
    line = np.stack([rods.EA, rods.GJ, rods.mass, rods.polar], axis=1)
    own = _OF_H - 2 * _OF_PHI
    powers = np.tile(np.concatenate([own - 3, own + 1, own - 1]), planes)
    return Coefficients(
        np.hstack([bending.reshape(n, -1), line]),
        np.concatenate([powers, [-1.0, -1.0, 1.0, 1.0]]),
        np.repeat(flexibility[..., 0], 27, axis=1) if planes > 1 else flexibility[..., 0],
        _patterns(planes),
    )


def element_matrices(rods: Properties, lengths: Floats) -> Floats:
    """Return K_e and M_e, Eq. (4), of an element of each rod, shape (2, n, 12, 12).

    `lengths` h (n,) [m]. K = int EI theta' theta' + kappa G A (w' - theta)^2, M = int rho A w^2 +
    rho I theta^2, besides a linear bar (EA, rho A) and shaft (GJ, rho (Ix + Iy)).
    """
    return coefficients(rods).matrices(lengths)
