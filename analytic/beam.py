"""Two-node beam elements: Euler-Bernoulli, Rayleigh and Timoshenko, one derivation for all.

A node has [u_x, u_y, u_z, phi_x, phi_y, phi_z] in limb axes, z along the beam. The interpolation
is the exact static one (Przemieniecki 1968; Friedman and Kosmatka 1993), with
Phi = 12 EI / (kappa G A h^2); Phi = 0 gives Hermite's cubics. Gauss's four points integrate every
product exactly.
"""

import numpy as np
from numpy.typing import NDArray

from analytic.mechanism import Rod
from analytic.theory import Theory

_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(4)
_XI, _WEIGHTS = (_POINTS + 1) / 2, _WEIGHTS / 2

# Bending in the plane z-x moves (u_x, phi_y) and phi_y = u_x'; in the plane z-y (u_y, phi_x) and
# phi_x = -u_y', hence the signs. Axial: u_z. Torsion: phi_z.
_BENDING = (((0, 4, 6, 10), np.array([1.0, 1, 1, 1])), ((1, 3, 7, 9), np.array([1.0, -1, 1, -1])))
_AXIAL, _TORSION = (2, 8), (5, 11)
_LINEAR_K = np.array([[1.0, -1.0], [-1.0, 1.0]])
_LINEAR_M = np.array([[2.0, 1.0], [1.0, 2.0]]) / 6


def deflection(xi: NDArray[np.float64], length: float, phi: float) -> NDArray[np.float64]:
    """Return w at `xi` in 0..1 for unit (w, theta) of both nodes, shape (*xi.shape, 4)."""
    return np.stack(
        [
            2 * xi**3 - 3 * xi**2 - phi * xi + 1 + phi,
            length * (xi**3 - (2 + phi / 2) * xi**2 + (1 + phi / 2) * xi),
            -2 * xi**3 + 3 * xi**2 + phi * xi,
            length * (xi**3 - (1 - phi / 2) * xi**2 - phi / 2 * xi),
        ],
        axis=-1,
    ) / (1 + phi)


def section_rotation(xi: NDArray[np.float64], length: float, phi: float) -> NDArray[np.float64]:
    """Return the section's theta at `xi`, as `deflection` returns w."""
    return np.stack(
        [
            6 * (xi**2 - xi) / length,
            3 * xi**2 - (4 + phi) * xi + 1 + phi,
            6 * (xi - xi**2) / length,
            3 * xi**2 - (2 - phi) * xi,
        ],
        axis=-1,
    ) / (1 + phi)


def element_matrices(
    rod: Rod, length: float, theory: Theory
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return K_e, M_e of one element of `length` [m], each (12, 12), for Eq. (4).

    K = int EI theta' theta' + kappa G A (w' - theta)^2, M = int rho A w^2 + rho I theta^2 (the
    last with rotary inertia only), besides a linear bar (EA, rho A) and shaft (GJ, rho J).
    """
    material, h = rod.material, length
    EI, rhoA = material.young * rod.second_moment, material.density * rod.area
    phi = theory.shear_flexibility(rod) / h**2
    w = deflection(_XI, h, phi)
    theta = section_rotation(_XI, h, phi)
    ones = np.ones_like(_XI)
    curvature = np.stack(
        [
            6 * (2 * _XI - 1) / h**2,
            (6 * _XI - 4 - phi) / h,
            6 * (1 - 2 * _XI) / h**2,
            (6 * _XI - 2 + phi) / h,
        ],
        axis=-1,
    ) / (1 + phi)
    # w' - theta is the same along the element: shear force is constant there.
    strain = -phi / (1 + phi) * np.stack([ones / h, ones / 2, -ones / h, ones / 2], axis=-1)
    shear_stiffness = 12 * EI / (phi * h**2) if phi else 0.0

    def integral(a: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(h * np.einsum("g,gi,gj->ij", _WEIGHTS, a, a))

    bending_K = EI * integral(curvature) + shear_stiffness * integral(strain)
    bending_M = rhoA * integral(w)
    if theory.rotary_inertia:
        bending_M = bending_M + material.density * rod.second_moment * integral(theta)

    K, M = np.zeros((12, 12)), np.zeros((12, 12))
    for dofs, sign in _BENDING:
        K[np.ix_(dofs, dofs)] = bending_K * np.outer(sign, sign)
        M[np.ix_(dofs, dofs)] = bending_M * np.outer(sign, sign)
    K[np.ix_(_AXIAL, _AXIAL)] = material.young * rod.area / h * _LINEAR_K
    M[np.ix_(_AXIAL, _AXIAL)] = rhoA * h * _LINEAR_M
    K[np.ix_(_TORSION, _TORSION)] = material.shear * rod.polar_moment / h * _LINEAR_K
    M[np.ix_(_TORSION, _TORSION)] = material.density * rod.polar_moment * h * _LINEAR_M
    return K, M


def centre_line(
    rod: Rod, length: float, elements: int, theory: Theory, stations: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the map from a limb's nodes to its centre line at `stations` in 0..1 of `length`.

    Shape (len(stations), 3, 6 (elements + 1)): displacement in limb axes by the element's own
    interpolation.
    """
    h = length / elements
    phi = theory.shear_flexibility(rod) / h**2
    cell = np.minimum((stations * elements).astype(int), elements - 1)
    xi = stations * elements - cell
    w = deflection(xi, h, phi)
    result = np.zeros((len(stations), 3, 6 * (elements + 1)))
    for k, start in enumerate(6 * cell):
        for direction, (dofs, sign) in enumerate(_BENDING):
            result[k, direction, start + np.array(dofs)] = sign * w[k]
        result[k, 2, start + np.array(_AXIAL)] = 1 - xi[k], xi[k]
    return result
