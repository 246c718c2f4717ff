"""What the elements of `rod_elements` do between their nodes: strains, and centre lines.

Of rods that bend alike in every direction.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from analytic.modes import STATIONS
from analytic.rod_elements import BENDING, Properties, deflection

Floats = NDArray[np.float64]


def strains(rods: Properties, lengths: Floats, nodes: Floats) -> Floats:
    """Return e of every element with e^T e twice its strain energy, shape (6 n s, m).

    `nodes` (n, s + 1, 6, m): m motions of the limbs' nodes in limb axes; `lengths` h (n,) [m] of
    their elements. Of K_e the same in other words: EA / h stretch^2 + GJ / h twist^2 + EI / h
    bend^2 + 12 EI / (1 + Phi) h (lean - mean rotation)^2 in either plane. Differences come before
    products, so that rigid motion, nearly all of a short element's, leaves no rounding.
    """
    h = lengths[:, None, None]
    change = np.diff(nodes, axis=1)
    e = np.empty_like(change)
    EI, flexibility = rods.EI[:, 0], 12 * rods.shear[:, 0]
    bending = np.sqrt(EI / lengths)[:, None, None]
    e[:, :, 0] = np.sqrt(rods.EA / lengths)[:, None, None] * change[:, :, 2]
    e[:, :, 1] = np.sqrt(rods.GJ / lengths)[:, None, None] * change[:, :, 5]
    e[:, :, 2:4] = bending[..., None] * change[:, :, 3:5]
    mean = (nodes[:, 1:, 3:5] + nodes[:, :-1, 3:5]) / 2
    leaning = bending * np.sqrt(12 / (1 + flexibility / lengths**2))[:, None, None]
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
    for direction, (dofs, sign) in enumerate(BENDING):
        for j, dof in enumerate(dofs):
            maps[:, k, direction, cell + dof // 6, dof % 6] = parts[:, :, j] * sign[j]
    maps[:, k, 2, cell, 2], maps[:, k, 2, cell + 1, 2] = 1 - xi, xi
    return maps.reshape(2 * 3 * len(xi), -1)


def centre_lines(rods: Properties, lengths: Floats, nodes: Floats) -> Floats:
    """Return displacement at `STATIONS` in limb axes, shape (n, k, 3, m).

    By the elements' own interpolation, from `nodes` (n, s + 1, 6, m) and the elements' `lengths`
    (n,) [m].
    """
    n, ends, _, m = nodes.shape
    scaled = nodes.copy()
    scaled[:, :, 3:] *= lengths[:, None, None, None]
    both = (_interpolation(ends - 1) @ scaled.reshape(n, -1, m)).reshape(n, 2, -1, 3, m)
    phi = (12 * rods.shear[:, 0] / lengths**2)[:, None, None, None]
    return np.asarray((both[:, 0] + phi * both[:, 1]) / (1 + phi))
