"""Limbs of any chain at many poses: their cores, and what joins these to the mechanism.

A freedom belongs to its limb's core where its axis keeps still in the limb's axes, or where three
of a joint leave no direction out. All others are coordinates of the mechanism beside the platform's
six; they move ports of the core, or the tip with the platform.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.limb_core import AXES, TIP, Core, in_limb_axes
from analytic.mechanism import Body, Item, Joint, Vector
from analytic.placed import Freedoms, Placed, cross
from analytic.platform import body_mass
from analytic.theory import Theory

Floats = NDArray[np.float64]

KEPT = 1e-10
"""How far an axis may turn in the limb's axes and yet keep still there [rad]."""
NONE = 1e-14
"""A smaller component of a motion is none."""


@dataclass(frozen=True)
class Joined:
    """The limbs of one core at N poses.

    Attributes: `core`; `adapting` lengths (N, n) [m]; `moved` (N, n, e), how the mechanism's e
    coordinates, the platform's first, move every `Core.given`.
    """

    core: Core
    adapting: Floats
    moved: list[Floats]


@dataclass(frozen=True)
class Beside:
    """The mechanism apart from cores, over its e coordinates: `springs` (e,), `mass` (N, e, e)."""

    springs: Floats
    mass: Floats


@dataclass(frozen=True)
class _Sorted:
    """What a group's joints are: `fixed` freedoms of every limb (kind, axis, stiffness) by item,
    those that turn by item, and the first item of the core.
    """

    fixed: list[dict[int, list[tuple[str, Vector, float]]]]
    turning: dict[int, list[int]]
    begin: int


def cores(
    groups: list[Placed], platform_mass: Floats, elements: int | None, theory: Theory
) -> tuple[list[Joined], Beside] | None:
    """Return the cores of all limbs, and what is beside them, `platform_mass` (N, 6, 6).

    None where a body that turns against its limb stands behind a rod, or a limb has no rod: no
    table holds it.
    """
    known = [_sorted(group) for group in groups]
    sorts = [one for one in known if one is not None]
    if len(sorts) < len(known):
        return None
    own = [sum(map(len, one.turning.values())) for one in sorts]
    e = TIP + sum(c * len(g.alike.limbs) for c, g in zip(own, groups, strict=True))
    springs, mass = np.zeros(e), np.zeros((len(platform_mass), e, e))
    mass[:, :TIP, :TIP] = platform_mass
    joined, first = [], TIP
    for group, one, c in zip(groups, sorts, own, strict=True):
        n = len(group.alike.limbs)
        columns = first + np.arange(n * c).reshape(n, c)
        first += n * c
        joined += _joined(group, one, columns, springs, mass, elements, theory)
    return joined, Beside(springs, mass)


def _sorted(group: Placed) -> _Sorted | None:
    alike = group.alike
    begin = 0
    if not alike.rods:
        return None
    for k, kind in enumerate(alike.kind):
        if kind == ("body", "base") or kind == ("body", "global"):
            if any(name == "rod" for name, *_ in alike.kind[:k]):
                return None
            begin = k + 1
    fixed: list[dict[int, list[tuple[str, Vector, float]]]] = [{} for _ in alike.limbs]
    turning: dict[int, list[int]] = {}
    for k, of in alike.freedoms.items():
        still = [] if k < begin else _still(group, k, of)
        for i, own in enumerate(fixed):
            own[k] = [(of.kinds[f], axes[i], float(of.stiffness[i, f])) for f, axes in still]
        left = set(range(len(of.kinds))) - {f for f, _ in still}
        turning[k] = sorted(left)
    return _Sorted(fixed, turning, begin)


def _still(group: Placed, k: int, of: Freedoms) -> list[tuple[int, list[Vector]]]:
    """Return the freedoms that keep still in limb axes, with the axis of every limb."""
    n = len(group.alike.limbs)
    found: list[tuple[int, list[Vector]]] = []
    local = in_limb(group, group.twists(k))
    for kind in ("translation", "rotation"):
        own = [f for f, name in enumerate(of.kinds) if name == kind]
        if len(own) == 3 and _round(of, own):
            found += [(f, [AXES[axis]] * n) for axis, f in enumerate(own)]
            continue
        for f in own:
            if of.frames[f] == "limb" and not of.across[f]:
                found.append((f, [(float(x), float(y), float(z)) for x, y, z in of.axes[:, f]]))
                continue
            half = local[..., 3:, f] if kind == "rotation" else local[..., :3, f]
            size = np.abs(half).max(axis=(0, 1))
            if np.sort(size)[-2] < KEPT:
                found.append((f, [AXES[int(size.argmax())]] * n))
    return found


def _round(of: Freedoms, three: list[int]) -> bool:
    """Return whether three freedoms of a kind leave no direction out, and are all alike."""
    axes, stiffness = of.axes[:, three], of.stiffness[:, three]
    if any(of.across[f] for f in three) or len({of.frames[f] for f in three}) > 1:
        return False
    if not stiffness.any():
        return bool((np.abs(np.linalg.det(axes)) > KEPT).all())
    square = axes @ axes.swapaxes(1, 2)
    alike = bool((stiffness == stiffness[:, :1]).all())
    return alike and bool(np.abs(square - np.eye(3)).max() < KEPT)


def in_limb(group: Placed, motion: Floats) -> Floats:
    """Return motions (N, n, 6, f) in limb axes."""
    R = group.frames.swapaxes(-1, -2)
    return np.concatenate([R @ motion[..., :3, :], R @ motion[..., 3:, :]], axis=-2)


def carried(motion: Floats, arm: Floats) -> Floats:
    """Return motions (N, n, 6, f) of a rigid body at the point that is `arm` (N, n, 3) away."""
    moved = motion.copy()
    turned = cross(motion[..., 3:, :].swapaxes(-1, -2), arm[..., None, :])
    moved[..., :3, :] += turned.swapaxes(-1, -2)
    return moved


def _joined(
    group: Placed,
    one: _Sorted,
    columns: NDArray[np.intp],
    springs: Floats,
    mass: Floats,
    elements: int | None,
    theory: Theory,
) -> list[Joined]:
    alike, starts = group.alike, group.starts
    N, n, e = len(mass), len(alike.limbs), len(springs)
    held = [k for k, kind in enumerate(alike.kind) if kind[0] in ("rod", "body")]
    given: dict[tuple[int, int], Floats] = {}

    def move(item: int, motion: Floats, where: list[int]) -> None:
        """Add motions (N, n, 6, f) in limb axes to what moves `item`, -1 being the tip."""
        for axis in range(TIP):
            size = motion[..., axis, :]
            if item < 0 or np.abs(size).max(initial=0) > NONE:
                row = given.setdefault((item, axis), np.zeros((N, n, e)))
                for i in range(n):
                    row[:, i, columns[i, where]] += size[:, i]

    used = 0
    start = np.zeros((N, n, 6, columns.shape[1]))
    for k, kind in enumerate(alike.kind):
        if k < one.begin and k:
            start = carried(start, starts[..., k, :] - starts[..., k - 1, :])
        if kind[0] == "joint" and one.turning[k]:
            turning = one.turning[k]
            where = list(range(used, used + len(turning)))
            used += len(turning)
            springs[columns[:, where]] = alike.freedoms[k].stiffness[:, turning]
            twists = group.twists(k)[..., turning]
            if k < one.begin:
                start[..., where] += twists
            elif k > held[-1]:
                end = carried(twists, starts[..., -1, :] - starts[..., k, :])
                move(-1, in_limb(group, end), where)
            else:
                move(k, in_limb(group, twists), where)
        elif kind[0] == "body" and k < one.begin:
            _weigh(group, k, start, columns, mass)
    if one.begin:
        last = one.begin - 1
        begin = carried(start, starts[..., one.begin, :] - starts[..., last, :])
        move(last, in_limb(group, begin), list(range(columns.shape[1])))
    for k in range(3):
        # e . (u + w x a) = e . u + (a x e) . w
        e_k = group.frames[..., k]
        along, turn = (given.setdefault((-1, row), np.zeros((N, n, e))) for row in (k, 3 + k))
        along[..., :3] += e_k
        along[..., 3:TIP] += cross(group.arms, e_k)
        turn[..., 3:TIP] += e_k

    result = []
    # The core's items count from where it begins; a leading joint stands for what is before.
    before = one.begin - 1 if one.begin else 0
    for some in _alike(group, one):
        core = _core(group, one, some[0], given, elements, theory)
        which: slice | list[int] = slice(None) if len(some) == n else some
        moved = [
            given[item + before if item >= 0 else -1, axis][:, which] for item, axis in core.given
        ]
        adapting = np.ones((N, len(some)))
        if core.adapts is not None:
            adapting = group.lengths[:, which, core.adapts + before]
        result.append(Joined(core, adapting, moved))
    return result


def _alike(group: Placed, one: _Sorted) -> list[list[int]]:
    """Return the limbs of a group whose cores are equal, together."""
    found: list[tuple[Any, list[int]]] = []
    for i, chain in enumerate(group.alike.chains):
        key = [item for item in chain[one.begin :] if not isinstance(item, Joint)], one.fixed[i]
        for other, some in found:
            if key == other:
                some.append(i)
                break
        else:
            found.append((key, [i]))
    return [some for _, some in found]


def _core(
    group: Placed,
    one: _Sorted,
    i: int,
    given: dict[tuple[int, int], Floats],
    elements: int | None,
    theory: Theory,
) -> Core:
    chain: list[Item] = []
    ports: list[tuple[int, ...]] = []

    def moved(k: int) -> tuple[int, ...]:
        return tuple(sorted(axis for item, axis in given if item == k))

    if one.begin:
        chain.append(Joint((), name="start"))
        ports.append(moved(one.begin - 1))
    for k, item in enumerate(group.alike.chains[i]):
        if k < one.begin:
            continue
        if isinstance(item, Joint):
            chain.append(in_limb_axes(item, one.fixed[i][k]))
            ports.append(moved(k))
        else:
            chain.append(item)
            ports.append(())
    return _same(Core(tuple(chain), tuple(ports), elements, theory))


@lru_cache(maxsize=256)
def _same(core: Core) -> Core:
    """Return the core that was made first of all equal ones: it knows its rods already."""
    return core


def _weigh(group: Placed, k: int, motion: Floats, columns: NDArray[np.intp], mass: Floats) -> None:
    """Add the mass of bodies before the cores, which `motion` (N, n, 6, c) moves, to `mass`."""
    for i, chain in enumerate(group.alike.chains):
        body = chain[k]
        assert isinstance(body, Body)
        if body.frame == "limb":
            R = group.frames[:, i]
            about = np.array([
                body_mass(body.mass, r @ np.array(body.inertia) @ r.T, r @ np.array(body.centre))
                for r in R
            ])  # fmt: skip
        else:
            about = body_mass(body.mass, np.array(body.inertia), np.array(body.centre))
        own = motion[:, i].swapaxes(1, 2) @ about @ motion[:, i]
        mass[:, columns[i][:, None], columns[i]] += own
