"""Two-node beam elements: Euler-Bernoulli, Rayleigh and Timoshenko, one set of formulas for all.

A node has [u_x, u_y, u_z, phi_x, phi_y, phi_z] in limb axes, z along the beam. The interpolation
is the exact static one (Przemieniecki 1968; Friedman and Kosmatka 1993), with
Phi = 12 EI / (kappa G A h^2); Phi = 0 gives Hermite's cubics.
"""

import numpy as np
from numpy.typing import NDArray

from analytic.dynamic_stiffness import Sections, chain_element

Floats = NDArray[np.float64]

# An element's dofs are those of its nodes in turn. Bending in the plane z-x moves (u_x, phi_y) with
# phi_y = u_x'; in the plane z-y (u_y, phi_x) with phi_x = -u_y', hence the signs.
_AXIAL, _TORSION = (2, 8), (5, 11)
_BENDING = (((0, 4, 6, 10), np.array([1.0, 1, 1, 1])), ((1, 3, 7, 9), np.array([1.0, -1, 1, -1])))


def _patterns() -> Floats:
    """Return where the ten numbers of an element stand in its matrix, shape (10, 144).

    Of bending p, q, t, v, r, y of `chain_element`; then the diagonal and the other entry of the
    bar, and of the shaft.
    """
    pattern = np.zeros((10, 12, 12))
    places = {0: [(0, 0), (2, 2)], 1: [(0, 1)], 2: [(0, 2)], 3: [(0, 3)], 4: [(1, 1), (3, 3)]}
    for dofs, sign in _BENDING:
        for number, where in {**places, 5: [(1, 3)]}.items():
            for a, b in where:
                pattern[number, dofs[a], dofs[b]] = pattern[number, dofs[b], dofs[a]] = (
                    sign[a] * sign[b]
                )
        # By symmetry of the element: its far end sees what its near end does, turned around.
        for number, a, b in ((1, 2, 3), (3, 1, 2)):
            pattern[number, dofs[a], dofs[b]] = pattern[number, dofs[b], dofs[a]] = (
                -sign[a] * sign[b]
            )
    for number, (a, b) in ((6, _AXIAL), (8, _TORSION)):
        pattern[number, [a, b], [a, b]] = 1.0
        pattern[number + 1, [a, b], [b, a]] = 1.0
    return pattern.reshape(10, 144)


_PATTERNS = _patterns()


def element_matrices(rods: Sections, lengths: Floats) -> Floats:
    """Return K_e and M_e, Eq. (4), of an element of each rod, shape (2, n, 12, 12).

    `lengths` h (n,) [m]. K = int EI theta' theta' + kappa G A (w' - theta)^2, M = int rho A w^2 +
    rho I theta^2 (the last with rotary inertia only), besides a linear bar (EA, rho A) and shaft
    (GJ, rho J).
    """
    h = lengths
    shaft = 2 * rods.EI / rods.axial_speed2  # rho J of a round rod
    numbers = np.empty((2, 10, len(h)))
    numbers[:, :6] = chain_element(rods, h)
    power = np.stack([np.ones_like(h), h, np.ones_like(h), h, h * h, h * h])
    numbers[0, :6] *= rods.EI / h**3 * power
    numbers[1, :6] *= rods.line_mass * h * power
    numbers[0, 6], numbers[0, 8] = rods.EA / h, rods.torsion_speed2 * shaft / h
    numbers[0, 7::2] = -numbers[0, 6::2][:2]
    numbers[1, 6], numbers[1, 8] = rods.line_mass * h / 3, shaft * h / 3
    numbers[1, 7::2] = numbers[1, 6::2][:2] / 2
    return (numbers.swapaxes(1, 2) @ _PATTERNS).reshape(2, len(h), 12, 12)


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


def deflection(xi: Floats, length: Floats, phi: Floats) -> Floats:
    """Return w at `xi` in 0..1 for unit (w, theta) of both nodes, shape (*xi.shape, 4)."""
    square, cube, half = xi**2, xi**3, phi / 2
    step = 3 * square - 2 * cube + phi * xi
    bow = cube - (2 + half) * square + (1 + half) * xi
    turned = bow + (1 + phi) * (square - xi)
    w = np.stack([1 + phi - step, length * bow, step, length * turned], axis=-1)
    return w / (1 + phi)[..., None]


def centre_lines(rods: Sections, lengths: Floats, nodes: Floats, stations: Floats) -> Floats:
    """Return displacement at `stations` (k,), 0..1 of a limb, in limb axes, shape (n, k, 3, m).

    By the elements' own interpolation, from `nodes` (n, s + 1, 6, m) and the elements' `lengths`
    (n,) [m].
    """
    s = nodes.shape[1] - 1
    cell = np.minimum((stations * s).astype(int), s - 1)
    xi = stations * s - cell
    h = lengths[:, None]
    w = deflection(xi, h, rods.flexibility[:, None] / h**2)
    near, far = nodes[:, cell], nodes[:, cell + 1]
    w = w[:, :, None, :, None]  # limb, station, direction, term, motion
    rotation, sign = [4, 3], np.array([[1.0], [-1.0]])
    result = np.empty((*near.shape[:2], 3, near.shape[3]))
    result[:, :, :2] = (
        w[..., 0, :] * near[:, :, :2]
        + w[..., 1, :] * sign * near[:, :, rotation]
        + w[..., 2, :] * far[:, :, :2]
        + w[..., 3, :] * sign * far[:, :, rotation]
    )
    along = xi[:, None]
    result[:, :, 2] = (1 - along) * near[:, :, 2] + along * far[:, :, 2]
    return result
