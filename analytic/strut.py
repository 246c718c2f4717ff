"""Limbs without rods: springs between the base and the platform, and what bodies they carry."""

import numpy as np
from numpy.typing import NDArray

from analytic.errors import InputError
from analytic.motion import PLATFORM, Map
from analytic.placed import Placed

Floats = NDArray[np.float64]

DEPENDENT = 1e-9
"""Freedoms between two masses, in units of length 1, that all but depend on each other."""


def strut_blocks(placed: Placed, unit: float) -> list[tuple[int, Floats]]:
    """Return K and M over the platform's coordinates of n limbs of links, joints and bodies.

    A list of (which item of the chain, (2, n, 6, 6)). The limb's free twists F let the platform
    go; across them, W^T F = 0, its springs give way by W^T E k^-1 E^T W, the inverse of a
    stiffness, and every joint's springs have a part of it. Where there are bodies the limb has six
    independent freedoms, so that the platform says where they are: r = E^-1 u. `unit` is a length
    [m]. Raises `InputError` for limbs that do not give way, or let a body move by itself.
    """
    kinds = [kind[0] for kind in placed.alike.kind]
    n = len(placed.alike.limbs)
    where = placed.starts[:, -1]
    E, stiffness, items = [], [], []
    for k, kind in enumerate(kinds):
        if kind == "joint":
            twists = Map((), placed.twists(k)).carried(where - placed.starts[:, k])
            E.append(twists.matrix)
            stiffness.append(placed.alike.freedoms[k].stiffness)
            items += [k] * twists.matrix.shape[-1]
    if not E:
        raise _refused(placed, "no rod that is rigid in every direction", "a spring in it")
    scale = np.array([1.0] * 3 + [1 / unit] * 3)
    T = np.concatenate(E, axis=-1) / scale[:, None]
    own = np.concatenate(stiffness, axis=1)
    J = Map(PLATFORM, np.broadcast_to(np.eye(6), (n, 6, 6))).carried(placed.arms)
    tip = J.matrix / scale[:, None]
    stretch = _stretches(placed, T, own, tip)
    of = np.array(items)
    sprung = (own > 0).any(axis=0)
    blocks = []
    for k in dict.fromkeys(of[sprung].tolist()):
        r, mine = stretch[:, of[sprung] == k], own[:, sprung & (of == k)]
        block = np.zeros((2, n, 6, 6))
        block[0] = r.swapaxes(1, 2) @ (mine[..., None] * r)
        blocks.append((k, block))
    if "body" in kinds:
        blocks += _bodies(placed, kinds, T, of, tip)
    return blocks


def _stretches(placed: Placed, T: Floats, own: Floats, tip: Floats) -> Floats:
    """Return how far each spring gives way by a unit of the platform's motions, (n, k, 6)."""
    sprung = (own > 0).any(axis=0)
    stretch = np.zeros((len(T), int(sprung.sum()), 6))
    for i in range(len(T)):
        U, sigma, _ = np.linalg.svd(T[i][:, ~sprung])
        W = U[:, int((sigma > DEPENDENT).sum()) :]
        held = W.T @ T[i][:, sprung]
        if np.linalg.matrix_rank(held, tol=DEPENDENT) < W.shape[1]:
            raise _refused(placed, "no rod that is rigid in some direction", "a spring in it")
        soft = held / own[i, sprung]
        stretch[i] = soft.T @ np.linalg.solve(soft @ held.T, W.T @ tip[i])
    return stretch


def _bodies(
    placed: Placed, kinds: list[str], T: Floats, of: NDArray[np.int64], tip: Floats
) -> list[tuple[int, Floats]]:
    """Return the masses of bodies that the platform moves by the limb's six freedoms."""
    f = T.shape[-1]
    if f != 6 or np.linalg.matrix_rank(T, tol=DEPENDENT).min() < 6:
        raise _refused(
            placed,
            f"a body, no rod and {f} freedoms",
            "six that are independent, or an elastic rod",
        )
    r = np.linalg.solve(T, tip)
    blocks = []
    for k in (k for k, kind in enumerate(kinds) if kind == "body"):
        moved = np.zeros((len(T), 6, 6))
        for j in dict.fromkeys(of[of < k].tolist()):
            arm = placed.starts[:, k] - placed.starts[:, j]
            moved += Map((), placed.twists(j)).carried(arm).matrix @ r[:, of == j]
        block = np.zeros((2, len(T), 6, 6))
        block[1] = moved.swapaxes(1, 2) @ placed.masses(k) @ moved
        blocks.append((k, block))
    return blocks


def _refused(placed: Placed, what: str, expected: str) -> InputError:
    limb = int(placed.alike.limbs[0]) + 1
    return InputError("mechanism", f"limb {limb} with {what}", expected)
