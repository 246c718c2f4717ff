"""Chains at poses: where their items are, how long, and how their joints can move.

Limbs alike in structure are placed together, at one pose or many: `...` below is the shape of the
poses, n the number of limbs alike.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.errors import InputError
from analytic.mechanism import Body, Freedom, Item, Joint, Limb, Link, Mechanism, Rod, Vector
from analytic.platform import body_mass
from analytic.pose import CLOSURE, Pose, check_poses

Floats = NDArray[np.float64]
Refuse = Callable[..., None]

ALONG = 1e-6
"""A universal joint whose axis leans from its limb by less than this [rad] turns about one only."""
SQUARE = 1e-9
"""A hinge is square to its limb, and two universal joints in line, to this angle [rad]."""


@dataclass(frozen=True)
class Freedoms:
    """The freedoms of one joint of n limbs: `axes` (n, f, 3), `stiffness` (n, f), each one's
    `kinds`, `frames` and `across`, equal for all.
    """

    axes: Floats
    stiffness: Floats
    kinds: tuple[str, ...]
    frames: tuple[str, ...]
    across: tuple[bool, ...]


@dataclass(frozen=True)
class Alike:
    """n limbs whose chains have the same structure.

    Attributes: `limbs`, their numbers (n,); `chains`, their items; `kind` of every item, what the
    structure is; `bases`, `points` B_i and A_i and `towards` (n, 3); `lengths` (n, items), nan for
    what adapts, 0 for joints and bodies; `freedoms` of the items that are joints; `slider`, and the
    directions `slides` of sliders (n, 3).
    """

    limbs: NDArray[np.intp]
    chains: tuple[tuple[Item, ...], ...]
    kind: tuple[Any, ...]
    bases: Floats
    points: Floats
    towards: Floats
    lengths: Floats
    freedoms: dict[int, Freedoms]
    slider: str
    slides: Floats

    @property
    def rods(self) -> list[int]:
        """Which items are rods."""
        return [k for k, kind in enumerate(self.kind) if kind[0] == "rod"]


@dataclass(frozen=True)
class Placed:
    """n limbs alike at poses.

    Attributes: `alike`; `frames` from limb to global axes (..., n, 3, 3); `arms` o to A_i
    (..., n, 3) [m]; `lengths` of the items (..., n, items) [m]; `starts` where each item starts,
    and where the last one ends (..., n, items + 1, 3) [m]; `turned` R of the platform
    (..., 3, 3).
    """

    alike: Alike
    frames: Floats
    arms: Floats
    lengths: Floats
    starts: Floats
    turned: Floats

    def twists(self, item: int) -> Floats:
        """Return E of a joint: how the limb after it moves a unit of each freedom, (..., n, 6, f).

        Displacement at the joint, then rotation, in global axes.
        """
        of = self.alike.freedoms[item]
        E = np.zeros((*self.frames.shape[:-2], 6, len(of.kinds)))
        for f, (kind, frame, across) in enumerate(zip(of.kinds, of.frames, of.across, strict=True)):
            axis = self._global(of.axes[:, f], frame)
            if across:
                axis = cross(axis, self.frames[..., 2])
                axis = axis / np.linalg.norm(axis, axis=-1, keepdims=True)
            E[..., 3 * (kind == "rotation") : 3 + 3 * (kind == "rotation"), f] = axis
        return E

    def masses(self, item: int) -> Floats:
        """Return the mass matrices of a body at where it stands in the chain, (n, 6, 6)."""
        found = []
        for i, chain in enumerate(self.alike.chains):
            body = chain[item]
            assert isinstance(body, Body)
            axes = np.eye(3) if body.frame != "limb" else self.frames[i]
            inertia = axes @ np.array(body.inertia) @ axes.T
            found.append(body_mass(body.mass, inertia, axes @ np.array(body.centre)))
        return np.array(found)

    def _global(self, axes: Floats, frame: str) -> Floats:
        if frame == "limb":
            return np.asarray((self.frames @ axes[..., None])[..., 0])
        if frame == "platform":
            return np.asarray(axes @ self.turned.swapaxes(-1, -2))
        return axes


@lru_cache(maxsize=64)
def alike(mechanism: Mechanism) -> tuple[Alike, ...]:
    """Return the limbs of `mechanism` in groups of equal structure."""
    groups: dict[Any, list[int]] = {}
    for i, limb in enumerate(mechanism.limbs):
        groups.setdefault(tuple(map(_kind, limb.chain)), []).append(i)
    return tuple(
        _alike(kind, [mechanism.limbs[i] for i in some], some) for kind, some in groups.items()
    )


def _kind(item: Item) -> tuple[Any, ...]:
    if isinstance(item, Joint):
        each = ((f.kind, f.frame, f.across, f.stiffness > 0) for f in _loose(item))
        return ("joint", item.slider, *each)
    if isinstance(item, Body):
        return ("body", item.frame)
    return ("rod" if isinstance(item, Rod) else "link", item.length is None)


def _alike(kind: tuple[Any, ...], limbs: list[Limb], which: list[int]) -> Alike:
    chains = tuple(limb.chain for limb in limbs)
    lengths = np.array([[_length(item) for item in chain] for chain in chains])
    freedoms = {}
    for k, (name, *more) in enumerate(kind):
        if name == "joint":
            each = [_loose(chain[k]) for chain in chains]
            freedoms[k] = Freedoms(
                np.array([[f.axis for f in own] for own in each]).reshape(len(each), -1, 3),
                np.array([[f.stiffness for f in own] for own in each]).reshape(len(each), -1),
                *(tuple(f[at] for f in more[1:]) for at in range(3)),
            )
    first = chains[0][0]
    return Alike(
        np.array(which),
        chains,
        kind,
        np.array([limb.base for limb in limbs]),
        np.array([limb.platform_point for limb in limbs]),
        np.array([limb.towards for limb in limbs]),
        lengths,
        freedoms,
        first.slider if isinstance(first, Joint) else "",
        np.array([_slides(chain[0]) for chain in chains]),
    )


def _loose(item: Item) -> list[Freedom]:
    """Return the freedoms of a joint that are not locked."""
    return [f for f in item.freedoms if f.stiffness < math.inf] if isinstance(item, Joint) else []


def _slides(item: Item) -> Vector:
    return item.freedoms[0].axis if isinstance(item, Joint) and item.slider else (0.0, 0.0, 0.0)


def _length(item: Item) -> float:
    if isinstance(item, (Rod, Link)):
        return np.nan if item.length is None else item.length
    return 0.0


@lru_cache(maxsize=64)
def _planes(mechanism: Mechanism) -> tuple[Floats, Floats, Floats, Floats]:
    """Return the planes that hinges at bases keep an A_i in, and what solves them for o's x and y.

    Normals (p, 3), points of the platform and of the base (p, 3), pseudo-inverse (2, p).
    """
    rows = [
        (item.hinge.axis, limb.platform_point, limb.base)
        for limb in mechanism.limbs
        for item in limb.chain
        if isinstance(item, Joint) and item.hinge and item.hinge.frame == "base"
    ]
    normals, points, bases = np.array(rows).reshape(-1, 3, 3).swapaxes(0, 1)
    return normals, points, bases, np.asarray(np.linalg.pinv(normals[:, :2], rcond=1e-9))


def position(mechanism: Mechanism, pose: Pose) -> Floats:
    """Return o, shape (*pose.shape, 3) [m]: as the pose says, or else as hinges at the base do.

    Each hinge keeps its limb in a plane, e_i . (o + R A_i - B_i) = 0: least squares for x and y,
    Eq. (2). Raises `InputError` where the hinges do not say both.
    """
    check_poses(mechanism, pose)
    if pose.x is not None:
        return np.stack([pose.x, pose.y, pose.z], axis=-1)
    normals, points, bases, across = _planes(mechanism)
    z = np.asarray(pose.z)[..., None]
    if np.linalg.matrix_rank(normals[:, :2], tol=1e-9) < 2 and not mechanism.simple:
        raise InputError("pose", "z alone", "x and y too: no hinges at the base set them")
    arms = points @ pose.rotation.swapaxes(-1, -2)
    gap = ((arms - bases) * normals).sum(axis=-1) + normals[:, 2] * z
    return np.concatenate([-gap @ across.T, z], axis=-1)


def station_masses(mechanism: Mechanism, pose: Pose, weights: Floats) -> Floats:
    """Return the mass of every limb at one pose by stations equally far apart, (n, k) [kg].

    `weights` (k,), of sum 1, divide that of its rods; a body belongs to the station next to it.
    """
    result = np.zeros((len(mechanism.limbs), len(weights)))
    for group in place(mechanism, pose):
        ends = np.cumsum(group.lengths, axis=-1)
        for i, chain, lengths, end in zip(
            group.alike.limbs, group.alike.chains, group.lengths, ends, strict=True
        ):
            for item, length, at in zip(chain, lengths, end, strict=True):
                if isinstance(item, Rod):
                    result[i] += item.material.density * item.area * length * weights
                elif isinstance(item, Body):
                    result[i, round(at / end[-1] * (len(weights) - 1))] += item.mass
    return result


def place(mechanism: Mechanism, pose: Pose) -> list[Placed]:
    """Return all limbs at `pose`, in groups of equal structure.

    Raises `InputError` naming the limb and the amount where a joint does not close, a rod does not
    reach, or a joint's axes fall together.
    """
    o, R = position(mechanism, pose), pose.rotation
    return [_placed(group, pose, o, R, refuse) for group in alike(mechanism)]


def placed_where(mechanism: Mechanism, pose: Pose) -> tuple[list[Placed], NDArray[np.bool_]]:
    """Return all limbs at `pose`, and where they can be so, pose.shape: elsewhere, nothing is said.

    Raises `InputError` where hinges do not say x and y.
    """
    good = np.ones((*pose.shape, 1), dtype=bool)

    def tell(_: Pose, __: Alike, bad: NDArray[Any], *___: Any) -> None:
        good[...] &= ~np.broadcast_to(bad, (*pose.shape, np.shape(bad)[-1])).any(-1, keepdims=True)

    o, R = position(mechanism, pose), pose.rotation
    with np.errstate(invalid="ignore", divide="ignore"):
        groups = [_placed(group, pose, o, R, tell) for group in alike(mechanism)]
    return groups, good[..., 0]


def _placed(group: Alike, pose: Pose, o: Floats, R: Floats, tell: Refuse) -> Placed:
    arms = group.points @ R.swapaxes(-1, -2)
    start, tips = np.broadcast_to(group.bases, arms.shape), o[..., None, :] + arms
    given = np.nansum(group.lengths, axis=1)
    if group.slider:
        axis = group.slides
        span = tips - start
        far = (span * axis).sum(axis=-1)
        left = given**2 - ((span * span).sum(axis=-1) - far**2)
        beside = np.sqrt(np.maximum(-left, 0.0))
        tell(pose, group, left <= 0, beside, "rods that reach from slider to A_{}, too short by"
               " the leg of a right triangle of {:.3e} m")  # fmt: skip
        root = np.sqrt(np.maximum(left, 0.0))
        start = start + (far + (root if group.slider == "above" else -root))[..., None] * axis
    span = tips - start
    total = np.sqrt((span * span).sum(axis=-1))
    left = total - given
    if not group.slider:
        tell(pose, group, left <= CLOSURE, left,
               "something left to what adapts, not {1:.3e} m in limb {0}")  # fmt: skip
    z = span / np.where(total > 0, total, 1.0)[..., None]
    x = cross(group.towards, z)
    size = np.linalg.norm(x, axis=-1)
    tell(
        pose, group, size < ALONG, size, "a reference across limb {}, not {:.1e} rad from along it"
    )
    x = x / size[..., None]
    frames = np.stack([x, cross(z, x), z], axis=-1)
    lengths = np.where(np.isnan(group.lengths), left[..., None], group.lengths)
    so_far = np.concatenate([np.zeros((*total.shape, 1)), np.cumsum(lengths, axis=-1)], axis=-1)
    starts = start[..., None, :] + so_far[..., None] * z[..., None, :]
    found = Placed(group, frames, arms, lengths, starts, R)
    _closed(found, pose, total, tell)
    return found


def _closed(found: Placed, pose: Pose, total: Floats, tell: Refuse) -> None:
    """Refuse hinges not square to their limb, and universal joints along it or out of line."""
    group, z = found.alike, found.frames[..., 2]
    ends: list[Floats] = []
    for of in group.freedoms.values():
        turns = [f for f, kind in enumerate(of.kinds) if kind == "rotation"]
        axes = [found._global(of.axes[:, f], of.frames[f]) for f in turns]
        ideal = [f for f in turns if not of.stiffness[:, f].any()]
        if len(ideal) == 1 and not of.across[ideal[0]]:
            lean = np.abs((axes[turns.index(ideal[0])] * z).sum(axis=-1))
            tell(pose, group, (lean > SQUARE) & (lean * total > CLOSURE), lean * total,
                   "A_i in its revolute joint's plane, not A_{} {:.1e} m beside it")  # fmt: skip
        for f in turns:
            if not of.across[f]:
                continue
            across = cross(axes[turns.index(f)], z)
            size = np.linalg.norm(across, axis=-1)
            expected = "universal joints across, not that of limb {} {:.1e} rad from along"
            tell(pose, group, size < ALONG, size, expected)
            if f in ideal and len(turns) == 2:
                ends.append(across / size[..., None])
    if len(ends) == 2:
        lean = np.linalg.norm(np.cross(ends[0], ends[1]), axis=-1)
        tell(pose, group, lean > SQUARE, lean,
               "universal joints in line, not those of limb {} {:.1e} rad out of it")  # fmt: skip


def cross(a: Floats, b: Floats) -> Floats:
    """Return a x b over the last axis, quicker than numpy's."""
    x, y, z = a[..., 0], a[..., 1], a[..., 2]
    u, v, w = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=-1)


def refuse(pose: Pose, group: Alike, bad: NDArray[Any], amount: Floats, expected: str) -> None:
    """Raise `InputError` for the first pose and limb that is `bad` (..., n)."""
    if not np.any(bad):
        return
    *where, k = (int(i) for i in np.argwhere(bad)[0])
    one = pose[tuple(where)] if where else pose
    value = f"z={one.z!r}, azimuth={one.azimuth!r}, tilt={one.tilt!r}"
    if one.x is not None:
        value += f", torsion={one.torsion!r}, x={one.x!r}, y={one.y!r}"
    amount = np.broadcast_to(amount, np.shape(bad))
    raise InputError(
        "pose", value, expected.format(int(group.limbs[k]) + 1, float(amount[(*where, k)]))
    )
