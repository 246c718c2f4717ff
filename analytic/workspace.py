"""Where the platform can go: the limits of Eq. (25) and the region they leave."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.errors import InputError, count, number
from analytic.kinematics import closes, limbs_at
from analytic.mechanism import Joint, Link, Mechanism, Rod
from analytic.placed import placed_where
from analytic.pose import Pose, check_poses

Floats = NDArray[np.float64]

CONSTRAINTS = ("shortest limb", "longest limb", "spherical joint", "revolute joint")
"""The last axis of `margins`."""
OF_CHAINS = ("shortest stroke", "longest stroke", "joint at the platform", "joint at the base")
"""The same of limbs of any chain."""
STEP = math.radians(1)
"""Tilts are tried this far apart: a gap in the reachable tilts narrower than this is not seen."""
SMALLEST = 1e-10
"""How closely a boundary is found [rad, m]."""
NEAREST = 1e-4
"""The azimuth where a circle touches is closed in on to this [rad]; its tilt errs by the square."""
GOLDEN = (math.sqrt(5) - 1) / 2
BATCH = 400
"""As many poses at once as cost little more than one."""
FARTHEST = math.pi / 2
"""No tilt beyond this is looked for."""


@dataclass(frozen=True)
class Limits:
    """The limits of Eq. (25): length_min <= L_i <= length_max, |alpha_i| <= spherical_max and
    |beta_i| <= revolute_max, in m and rad.

    alpha_i is the angle of the limb B_i A_i from the platform's normal: zero for a limb
    perpendicular to the platform. beta_i is its angle from the global z about the revolute axis:
    zero for a vertical limb. The paper prints the lengths and neither angle; 45 degrees stands
    for both: a wide-angle ball joint, and a hinge that clears its bracket.
    A mechanism that is `limited` says its own, and these are not asked. `torsion` [rad], `x` and
    `y` [m] are those of every pose; None: the hinges say x and y.
    Raises `InputError` for lengths out of order or angles not between 0 and pi.
    """

    length_min: float = 0.2
    length_max: float = 1.0
    spherical_max: float = math.pi / 4
    revolute_max: float = math.pi / 4
    torsion: float = 0.0
    x: float | None = None
    y: float | None = None

    def held(self, poses: Pose) -> Pose:
        """Return `poses` with the torsion, x and y of every pose."""
        if poses.x is not None or (self.x is None and not self.torsion):
            return poses
        return Pose(poses.z, poses.azimuth, poses.tilt, self.torsion, self.x, self.y)

    def __post_init__(self) -> None:
        low = number("Limits.length_min", self.length_min, "a finite number of metres")
        if low < 0:
            raise InputError("Limits.length_min", low, "no less than 0 m")
        high = number("Limits.length_max", self.length_max, "a finite number of metres")
        if high <= low:
            raise InputError("Limits.length_max", high, f"more than length_min = {low}")
        for name in ("spherical_max", "revolute_max"):
            expected = "an angle above 0 and at most pi"
            angle = number(f"Limits.{name}", getattr(self, name), expected, positive=True)
            if angle > math.pi:
                raise InputError(f"Limits.{name}", angle, expected)


def margins(mechanism: Mechanism, poses: Pose, limits: Limits) -> Floats:
    """Return how far each limb is inside each limit, shape (*poses.shape, n, 4) [m, m, rad, rad].

    In the order of `CONSTRAINTS`, negative outside; NaN where a joint cannot close.
    """
    check_poses(mechanism, poses)
    if not isinstance(limits, Limits):
        raise InputError("limits", limits, "Limits")
    flat = limits.held(poses).ravel()
    if mechanism.limited or not mechanism.simple:
        inside = _of_chains(mechanism, flat, limits)
        return inside.reshape(*poses.shape, *inside.shape[1:])
    result = np.full((len(flat), len(mechanism.limbs), len(CONSTRAINTS)), np.nan)
    closed: Any = slice(None)
    try:
        limbs = limbs_at(mechanism, flat)
    except InputError:
        closed = closes(mechanism, flat)
        limbs = limbs_at(mechanism, flat[closed])
    inside_all = (
        limbs.lengths - limits.length_min,
        limits.length_max - limbs.lengths,
        limits.spherical_max - np.abs(limbs.spherical),
        limits.revolute_max - np.abs(limbs.revolute),
    )
    result[closed] = np.stack(inside_all, axis=-1)
    return result.reshape(*poses.shape, *result.shape[1:])


def _of_chains(mechanism: Mechanism, poses: Pose, limits: Limits) -> Floats:
    """Return `margins` of limbs of any chain, at N poses in a row: its own limits, or `limits`."""
    own, z = mechanism.limited, np.array([0.0, 0.0, 1.0])
    groups, good = placed_where(mechanism, poses)
    result = np.full((len(poses), len(mechanism.limbs), len(OF_CHAINS)), np.inf)
    for group in groups:
        links = [k for k, kind in enumerate(group.alike.kind) if kind[0] == "link"]
        rods = group.alike.rods or links
        for j, i in enumerate(group.alike.limbs.tolist()):
            limb, along = mechanism.limbs[i], group.frames[:, j, :, 2]
            size, least, most = group.lengths[:, j].sum(axis=-1), limits.length_min, np.inf
            if not own:
                most = limits.length_max
            elif limb.stroke is not None:
                least, most = limb.stroke
                free = np.flatnonzero(np.isnan(group.alike.lengths[j]))
                size = (
                    group.lengths[:, j, free[0]]
                    if free.size
                    else (group.starts[:, j, 0] - limb.base) @ group.alike.slides[j]
                )
            else:
                least = -np.inf
            result[:, i, 0], result[:, i, 1] = size - least, most - size
            for k, item in enumerate(limb.chain):
                if not isinstance(item, Joint) or rods[0] < k < rods[-1]:
                    continue
                tip = k > rods[-1]
                bound = limits.spherical_max if tip else limits.revolute_max
                largest, rest = (item.largest, np.array(item.rest)) if own else (bound, z)
                if largest is None:
                    continue
                away = group.turned @ rest if tip else np.broadcast_to(rest, along.shape)
                across = np.linalg.norm(np.cross(away, along), axis=-1)
                angle = np.arctan2(across, (away * along).sum(axis=-1))
                place = 2 if tip else 3
                result[:, i, place] = np.minimum(result[:, i, place], largest - angle)
    result[~good] = np.nan
    return result


def reachable(mechanism: Mechanism, poses: Pose, limits: Limits) -> NDArray[np.bool_]:
    """Return where all joints close and all limits of Eq. (25) hold, shape poses.shape."""
    return np.asarray((margins(mechanism, poses, limits) >= 0).all(axis=(-2, -1)))


def boundary(mechanism: Mechanism, z: Any, azimuth: Any, limits: Limits) -> Floats:
    """Return the largest tilt to which every smaller one is reachable, by the polar method [rad].

    `z` and `azimuth` are broadcast. At most `FARTHEST`, and NaN where tilt 0 is not reachable.
    """
    rays = Pose(z, azimuth)
    z, azimuth = np.ravel(rays.z)[:, None], np.ravel(rays.azimuth)[:, None]

    def inside(ray: NDArray[np.intp], tilts: Floats) -> NDArray[np.bool_]:
        return reachable(mechanism, Pose(z[ray], azimuth[ray], tilts), limits)

    return _polar(inside, len(z), STEP, FARTHEST).reshape(rays.shape)


def rim(
    mechanism: Mechanism, pose: Pose, plane: tuple[str, str], direction: Floats, limits: Limits
) -> Floats:
    """Return how far o may go from one pose in a plane, by the polar method, (n,) [m].

    `plane` and `direction` (n,) [rad] as of `in_plane`. NaN where the pose itself is not reachable;
    a gap narrower than a thousandth of the longest reach is not seen.
    """
    size = _size(mechanism, limits, float(pose.z))
    across = direction[:, None]

    def inside(ray: NDArray[np.intp], far: Floats) -> NDArray[np.bool_]:
        return reachable(mechanism, in_plane(pose, plane, far, across[ray]), limits)

    return _polar(inside, len(direction), size / 1000, 2 * size)


def in_plane(pose: Pose, plane: tuple[str, str], far: Any, direction: Any) -> Pose:
    """Return one pose with o moved `far` [m] towards `direction` [rad], turned as it was.

    `plane`: two of x, y and z, which o moves along by far times cos and sin of the direction.
    Raises `InputError` where hinges say x and y.
    """
    if pose.x is None:
        raise InputError("plane", ",".join(plane), "a pose that says x and y, which hinges do here")
    first, second = plane
    moved = {
        first: getattr(pose, first) + far * np.cos(direction),
        second: getattr(pose, second) + far * np.sin(direction),
    }
    return replace(pose, **moved)


def _polar(
    inside: Callable[[NDArray[np.intp], Floats], NDArray[np.bool_]],
    rays: int,
    step: float,
    farthest: float,
) -> Floats:
    """Return how far along every ray all is inside, (rays,); NaN where its start is not.

    `inside(which, far)` answers for some rays (n,) at steps along them, (n, m), or (1, m) alike.
    From 0 outwards by `step`; the step that fails is divided again and again, down to `SMALLEST`,
    and its inner end returned.
    """
    every = np.arange(rays)
    result = np.where(inside(every, np.zeros((1, 1)))[:, 0], 0.0, np.nan)
    level = np.flatnonzero(~np.isnan(result))
    low, going = np.zeros(len(level)), np.arange(len(level))
    block = max(1, BATCH // max(1, len(level)))
    stops = np.linspace(0, farthest, 1 + math.ceil(farthest / step))
    for first in range(1, len(stops), block):
        steps = stops[first : first + block]
        passed = _passed(inside(level[going], steps[None]))
        low[going] = stops[first - 1 + passed]
        going = going[passed == len(steps)]
        if not going.size:
            break
    high = np.minimum(low + step, farthest)
    parts = max(2, block)
    while level.size and (high - low).max() > SMALLEST:
        steps = low[:, None] + (high - low)[:, None] * np.linspace(0, 1, parts + 1)
        passed = _passed(inside(level, steps[:, 1:]))
        ray = np.arange(len(low))
        low, high = steps[ray, passed], steps[ray, np.minimum(passed + 1, parts)]
    result[level] = low
    return result


def _passed(inside: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return how many of each row (N, steps) are true before the first that is not."""
    return np.asarray(np.logical_and.accumulate(inside, axis=1).sum(axis=1))


def inscribed(
    mechanism: Mechanism, z: Any, limits: Limits, azimuths: int = 72
) -> tuple[Floats, Floats]:
    """Return the largest reachable circle about tilt 0 at each `z`: its tilt, and where it touches.

    Both have shape (n,) [rad]. The boundary is sampled at `azimuths` (24 or more), and every least
    sample closed in on between its neighbours: a dip between two samples that neither of them
    feels is not seen. NaN where tilt 0 is not reachable.
    """
    z = np.atleast_1d(np.asarray(z, dtype=float))
    width = 2 * np.pi / count("azimuths", azimuths, at_least=24)
    around = width * np.arange(azimuths)
    tilts = boundary(mechanism, z[:, None], around, limits)
    least = (tilts <= np.roll(tilts, 1, axis=1)) & (tilts <= np.roll(tilts, -1, axis=1))
    layer, k = np.nonzero(least)
    centre, best = around[k], tilts[layer, k]
    # Golden section; where limits meet the boundary points outwards, so a minimum is smooth.
    low, high = centre - width, centre + width
    left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_left, at_right = (boundary(mechanism, z[layer], point, limits) for point in (left, right))
    for _ in range(math.ceil(math.log(NEAREST / width, GOLDEN))):
        down = at_left < at_right
        low, high = np.where(down, low, left), np.where(down, right, high)
        new = np.where(down, high - GOLDEN * (high - low), low + GOLDEN * (high - low))
        found = boundary(mechanism, z[layer], new, limits)
        left, right = np.where(down, new, right), np.where(down, left, new)
        at_left, at_right = np.where(down, found, at_right), np.where(down, at_left, found)
        centre, best = np.where(found < best, new, centre), np.fmin(found, best)
    radii, touch = tilts[:, 0].copy(), np.zeros_like(z)
    for i in np.unique(layer):
        own = np.flatnonzero(layer == i)
        lowest = own[best[own].argmin()]
        radii[i], touch[i] = best[lowest], centre[lowest] % (2 * np.pi)
    return radii, touch


def heights(mechanism: Mechanism, limits: Limits, near: float | None = None) -> tuple[float, float]:
    """Return the lowest and highest z of the level platform above the base, to 1e-12 m.

    Of several stretches, the lowest; of limbs other than R-P-S, above the base or below it, the one
    next to `near` [m], or else the longest, above it if there is one. Raises `InputError` where
    there is none.
    """
    anywhere = mechanism.limited or not mechanism.simple
    top = _size(mechanism, limits, near)
    z = np.linspace(-top if anywhere else 0, top, 2001 if anywhere else 1001)[1:]
    step = z[1] - z[0]
    inside = np.flatnonzero(reachable(mechanism, Pose(z), limits))
    if not inside.size:
        where = "" if anywhere else " above the base"
        raise InputError("limits", limits, f"limits that a level platform{where} can meet")
    stretches = np.split(inside, np.flatnonzero(np.diff(inside) > 1) + 1)
    chosen = stretches[0]
    if anywhere and near is not None:
        chosen = min(stretches, key=lambda some: float(np.abs(z[some] - near).min()))
    elif anywhere:
        chosen = max([some for some in stretches if z[some[0]] > 0] or stretches, key=len)
    first, last = int(chosen[0]), int(chosen[-1])
    ends = []
    for within, outside in ((z[first], z[first] - step), (z[last], z[last] + step)):
        a, b = within, outside
        while abs(b - a) > 1e-12:
            middle = (a + b) / 2
            if (anywhere or middle > 0) and reachable(mechanism, Pose(middle), limits):
                a = middle
            else:
                b = middle
        ends.append(float(a))
    return ends[0], ends[1]


def _size(mechanism: Mechanism, limits: Limits, near: float | None) -> float:
    """Return how far above the base o is at most [m]."""
    reach = np.abs(mechanism.platform_points).sum(axis=1).max() + _longest(mechanism, limits, near)
    return float(np.abs(mechanism.bases[:, 2]).max() + reach)


def _longest(mechanism: Mechanism, limits: Limits, near: float | None) -> float:
    """Return how far limbs reach at most [m]: by their strokes, `limits`, or about `near`."""
    if not mechanism.limited:
        return limits.length_max
    found = []
    for limb in mechanism.limbs:
        given = sum(i.length or 0.0 for i in limb.chain if isinstance(i, (Rod, Link)))
        own = max(map(abs, limb.stroke)) if limb.stroke else 2 * abs(near or 0.0) + 1.0
        found.append(given + own)
    return max(found)
