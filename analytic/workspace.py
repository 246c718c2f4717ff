"""Where the platform can go: the limits of Eq. (25) and the region they leave."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.errors import InputError, count, number
from analytic.kinematics import limbs_at
from analytic.mechanism import Mechanism
from analytic.pose import Pose, check_poses, closes

Floats = NDArray[np.float64]

CONSTRAINTS = ("shortest limb", "longest limb", "spherical joint", "revolute joint")
"""The last axis of `margins`."""
STEP = math.radians(1)
"""Tilts are tried this far apart: a gap in the reachable tilts narrower than this is not seen."""
SMALLEST = 1e-10
"""How closely a boundary is found [rad]."""
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
    Raises `InputError` for lengths out of order or angles not between 0 and pi.
    """

    length_min: float = 0.2
    length_max: float = 1.0
    spherical_max: float = math.pi / 4
    revolute_max: float = math.pi / 4

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
    flat = poses.ravel()
    result = np.full((len(flat), len(mechanism.limbs), len(CONSTRAINTS)), np.nan)
    closed: Any = slice(None)
    try:
        limbs = limbs_at(mechanism, flat)
    except InputError:
        closed = closes(mechanism, flat)
        limbs = limbs_at(mechanism, flat[closed])
    inside = (
        limbs.lengths - limits.length_min,
        limits.length_max - limbs.lengths,
        limits.spherical_max - np.abs(limbs.spherical),
        limits.revolute_max - np.abs(limbs.revolute),
    )
    result[closed] = np.stack(inside, axis=-1)
    return result.reshape(*poses.shape, *result.shape[1:])


def reachable(mechanism: Mechanism, poses: Pose, limits: Limits) -> NDArray[np.bool_]:
    """Return where all joints close and all limits of Eq. (25) hold, shape poses.shape."""
    return np.asarray((margins(mechanism, poses, limits) >= 0).all(axis=(-2, -1)))


def boundary(mechanism: Mechanism, z: Any, azimuth: Any, limits: Limits) -> Floats:
    """Return the largest tilt to which every smaller one is reachable, by the polar method [rad].

    `z` and `azimuth` are broadcast. From tilt 0 outwards in steps of `STEP`; the step that fails is
    divided again and again, down to `SMALLEST`, and its inner end returned. At most `FARTHEST`, and
    NaN where tilt 0 is not reachable.
    """
    rays = Pose(z, azimuth)
    shape, z, azimuth = rays.shape, np.ravel(rays.z), np.ravel(rays.azimuth)
    result = np.where(reachable(mechanism, Pose(z, azimuth), limits), 0.0, np.nan)
    level = np.flatnonzero(~np.isnan(result))
    z, azimuth = z[level, None], azimuth[level, None]
    low, going = np.zeros(len(level)), np.arange(len(level))
    block = max(1, BATCH // max(1, len(level)))
    tilts = np.linspace(0, FARTHEST, 1 + math.ceil(FARTHEST / STEP))
    for first in range(1, len(tilts), block):
        steps = tilts[first : first + block]
        passed = _passed(mechanism, Pose(z[going], azimuth[going], steps), limits)
        low[going] = tilts[first - 1 + passed]
        going = going[passed == len(steps)]
        if not going.size:
            break
    high = np.minimum(low + STEP, FARTHEST)
    parts = max(2, block)
    while level.size and (high - low).max() > SMALLEST:
        steps = low[:, None] + (high - low)[:, None] * np.linspace(0, 1, parts + 1)
        passed = _passed(mechanism, Pose(z, azimuth, steps[:, 1:]), limits)
        ray = np.arange(len(low))
        low, high = steps[ray, passed], steps[ray, np.minimum(passed + 1, parts)]
    result[level] = low
    return result.reshape(shape)


def _passed(mechanism: Mechanism, poses: Pose, limits: Limits) -> NDArray[np.int64]:
    """Return how many poses of each row (N, steps) are reachable before the first that is not."""
    inside = reachable(mechanism, poses, limits)
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


def heights(mechanism: Mechanism, limits: Limits) -> tuple[float, float]:
    """Return the lowest and highest z of the level platform above the base, to 1e-12 m.

    Of several stretches, the lowest. Raises `InputError` where there is none.
    """
    reach = limits.length_max + np.abs(mechanism.platform_points).sum(axis=1).max()
    z = np.linspace(0, np.abs(mechanism.bases[:, 2]).max() + reach, 1001)[1:]
    inside = np.flatnonzero(reachable(mechanism, Pose(z), limits))
    if not inside.size:
        raise InputError("limits", limits, "limits that a level platform above the base can meet")
    first = inside[0]
    last = first + np.flatnonzero(~np.isin(np.arange(first, len(z) + 1), inside))[0] - 1
    ends = []
    for within, outside in ((z[first], z[first] - z[0]), (z[last], z[last] + z[0])):
        a, b = within, outside
        while abs(b - a) > 1e-12:
            middle = (a + b) / 2
            if middle > 0 and reachable(mechanism, Pose(middle), limits):
                a = middle
            else:
                b = middle
        ends.append(float(a))
    return ends[0], ends[1]
