"""What a mechanism can do with its drives locked: nothing, or it is refused.

A motion without energy leaves every rod as it is: limbs are then serial chains of ideal freedoms.
The platform moves freely as far as all limbs let it, the common part of the spaces that their
freedoms' twists span; freedoms of one limb that depend on each other are motions of its own, as
the spin of a rod between two spherical joints, and harm nothing.
"""

import numpy as np
from numpy.typing import NDArray

from analytic.errors import InputError
from analytic.placed import Placed

Floats = NDArray[np.float64]

RIGID = 1e-9
"""A motion of the platform that the limbs resist by less than this part of the most is free."""
DEPENDENT = 1e-9
"""A combination of unit twists smaller than this is none."""


def limb_twists(placed: Placed, centre: Floats, unit: float) -> Floats:
    """Return the ideal freedoms of n limbs as twists at o, (n, 6, f), rotations times `unit` [m].

    At one pose; every column has unit length.
    """
    columns = []
    for k, of in placed.alike.freedoms.items():
        E = placed.twists(k)[..., [not any(row) for row in of.stiffness.T]]
        arm = centre - placed.starts[:, k]
        moved = E.copy()
        moved[:, :3] += np.cross(E[:, 3:], arm[:, :, None], axis=1)
        columns.append(moved)
    T = np.concatenate(columns, axis=-1) if columns else np.zeros((len(placed.arms), 6, 0))
    T[:, 3:] *= unit
    return np.asarray(T / np.linalg.norm(T, axis=1, keepdims=True))


def spins(groups: list[Placed], centre: Floats, unit: float) -> int:
    """Return how many motions of limbs' own there are that need no energy."""
    return sum(int(sum(_dependent(limb_twists(group, centre, unit)))) for group in groups)


def _dependent(T: Floats) -> list[int]:
    return [t.shape[1] - int((np.linalg.svd(t, compute_uv=False) > DEPENDENT).sum()) for t in T]


def free(groups: list[Placed], centre: Floats, unit: float) -> tuple[int, float]:
    """Return how many motions of the platform no limb resists, and how weakly the others are.

    The latter is the least resistance that is none, over the greatest.
    """
    held = []
    for group in groups:
        for T in limb_twists(group, centre, unit):
            U, sigma, _ = np.linalg.svd(T)
            rank = int((sigma > DEPENDENT).sum())
            held.append(U[:, rank:].T)
    stack = np.concatenate([*held, np.zeros((6, 6))])
    resisted = np.linalg.svd(stack, compute_uv=False)
    firm = resisted > RIGID * max(resisted[0], RIGID)
    return 6 - int(firm.sum()), float(resisted[firm].min(initial=1.0) / max(resisted[0], RIGID))


def check_held(groups: list[Placed], centre: Floats, unit: float) -> None:
    """Raise `InputError` where the platform can move with the drives locked."""
    loose, _ = free(groups, centre, unit)
    if loose:
        ways = "one way" if loose == 1 else f"{loose} ways"
        raise InputError(
            "mechanism",
            f"a platform that can move {ways} with its drives locked",
            "one that its limbs hold",
        )
