"""What is mapped: poses in the regular workspace or over a plane, and what a model finds there."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from analytic import InputError, Joint, Limits, Mechanism, Modes, Pose, RegularWorkspace
from analytic.model import Model
from analytic.workspace import CONSTRAINTS, OF_CHAINS, heights, in_plane, inscribed, margins, rim
from harness.answer import Batch, BatchTask
from harness.bench import Bench, label
from harness.case import Case
from harness.poses import columns, named
from harness.rows import MAP, mode_rows, settings
from harness.signatures import Array
from harness.workers import Failure

Flags = NDArray[np.bool_]
TILTS, MOVES = 1e-3, 1e-6
"""A platform that tilts [rad], or moves in a plane [m], by less than this anywhere does not."""
PROFILE = 41
"""Heights at which the inscribed circles are found, from the lowest to the highest."""


@dataclass(frozen=True)
class Region:
    """The regular workspace of a mechanism within limits.

    Attributes: `mechanism`; `limits`; `circles`, the largest inscribed circle at `PROFILE`
    heights; `cone`, the largest truncated cone in them.
    """

    mechanism: Mechanism
    limits: Limits
    circles: RegularWorkspace
    cone: RegularWorkspace

    @classmethod
    def of(cls, mechanism: Mechanism, limits: Limits, near: float | None = None) -> "Region":
        """Return it, of several stretches of heights the one next to `near` (see `heights`).

        Raises `InputError` where a level platform is nowhere within `limits`, or does not tilt.
        """
        for limb in mechanism.limbs:
            last = limb.chain[-1]
            if not (isinstance(last, Joint) and any(f.kind == "rotation" for f in last.freedoms)):
                expected = "limbs with joints at the platform; `sweep --poses` takes other poses"
                raise InputError("mechanism", limb.described, expected)
        z = np.linspace(*heights(mechanism, limits, near), PROFILE)
        circles = RegularWorkspace(z, inscribed(mechanism, z, limits, azimuths=36)[0])
        if circles.radii.max() < TILTS:
            expected = "limbs whose platform tilts any way; `sweep --poses` takes other poses"
            raise InputError("mechanism", mechanism.limbs[0].described, expected)
        return cls(mechanism, limits, circles, circles.cone())

    def layers(self, number: int) -> Array:
        """Return `number` heights over the cone, evenly, to whole millimetres inside it [m]."""
        low, high = 1000 * self.cone.z
        return np.round(np.linspace(np.ceil(low), np.floor(high), number)) / 1000


@dataclass(frozen=True)
class Rays:
    """Poses on rays from a middle outwards, (..., A, R): all rays of a layer begin at one pose.

    Attributes: `mechanism`; `limits`, which hold what the `poses` leave out; `there`, whether there
    is a pose at all.
    """

    mechanism: Mechanism
    limits: Limits
    poses: Pose
    there: Flags

    def held(self, which: Flags) -> Pose:
        """Return some poses as a row, with the torsion, x and y that the limits hold."""
        return self.limits.held(self.poses[which])

    @property
    def rim(self) -> Flags:
        """Whether a pose is the last of its ray."""
        rim = self.there.copy()
        rim[..., :-1] &= ~self.there[..., 1:]
        return rim

    @property
    def wanted(self) -> Flags:
        """Which poses to solve: a middle once."""
        wanted = self.there.copy()
        wanted[..., 1:, 0] = False
        return wanted

    def spread(self, values: Array) -> Array:
        """Return the `values` (n, ...) at the `wanted` poses as those of all, (..., A, R, ...)."""
        found = np.full((*self.there.shape, *values.shape[1:]), np.nan)
        found[self.wanted] = values
        every = found.reshape(*self.there.shape, -1)
        every[..., 1:, 0, :] = every[..., :1, 0, :]
        return found


@dataclass(frozen=True)
class Grid(Rays):
    """The poses of a map, layer by layer inside the largest circles: (n, A, T).

    Attributes:
        region: where.
        z: heights of the layers, shape (n,) [m].
        radii, touch: the circle's tilt, and the azimuth where it meets a limit, shape (n,) [rad].
        azimuth: shape (A,), from the first limb's azimuth, evenly round [rad].
        tilt: shape (n, T) [rad], from 0 to the rim of each layer; NaN after it.
        shared: whether a tilt is one that the layers have in common, shape (n, T): not a rim.
    """

    region: Region
    z: Array
    radii: Array
    touch: Array
    azimuth: Array
    tilt: Array
    shared: Flags

    @classmethod
    def of(cls, region: Region, z: Array, azimuths: int, tilts: int) -> "Grid":
        """Return `tilts` from 0 to the widest rim that the layers share, and each layer's rim."""
        mechanism, limits = region.mechanism, region.limits
        x, y, _ = mechanism.limbs[0].base
        azimuth = np.arctan2(y, x) + 2 * np.pi * np.arange(azimuths) / azimuths
        radii, touch = inscribed(mechanism, z, limits, azimuths=36)
        common = np.linspace(0, radii.max(), tilts)
        # A common tilt next to the rim would make a sliver of a ring.
        inner = common < radii[:, None] - 1e-3 * common[1]
        inner[:, 0] = True
        tilt = np.where(inner, common, np.nan)
        for row, radius, last in zip(tilt, radii, inner.sum(axis=1), strict=True):
            if radius > 0:
                row[last] = radius
        poses = Pose(z[:, None, None], azimuth[:, None], np.nan_to_num(tilt)[:, None])
        there = np.isfinite(tilt)[:, None] & np.ones((azimuths, 1), dtype=bool)
        return cls(mechanism, limits, poses, there, region, z, radii, touch, azimuth, tilt, inner)


@dataclass(frozen=True)
class Plane(Rays):
    """Poses of one case in a plane: from its own outwards, to where the limits end: (A, R).

    Attributes: `case`; `names` of two coordinates; `direction` (A,), evenly round from the first
    coordinate's axis [rad]; `far` (A, R), from 0 to the rim by equal steps [m].
    """

    case: Case
    names: tuple[str, str]
    direction: Array
    far: Array

    @classmethod
    def of(
        cls, case: Case, names: tuple[str, str], limits: Limits, directions: int, steps: int
    ) -> "Plane":
        """Return `steps` from 0 to the rim in so many directions.

        Raises `InputError` for a case outside its limits, or one that cannot move in the plane.
        """
        direction = 2 * np.pi * np.arange(directions) / directions
        ends = rim(case.mechanism, case.pose, names, direction, limits)
        asked = ",".join(names)
        if np.isnan(ends).any():
            raise InputError("plane", asked, f"a case within its limits, which {case.name} is not")
        if ends.max() < MOVES:
            raise InputError("plane", asked, f"one in which the platform of {case.name} can move")
        far = np.outer(ends, np.linspace(0, 1, steps))
        poses = in_plane(case.pose, names, far, direction[:, None])
        there = np.ones(far.shape, dtype=bool)
        return cls(case.mechanism, limits, poses, there, case, names, direction, far)


def limits_met(mechanism: Mechanism, limits: Limits, pose: Pose) -> str:
    """Return the limit, or limits, met at a pose on the boundary, in words."""
    met = np.unique(np.nonzero(np.abs(margins(mechanism, pose, limits)) < 1e-8)[1])
    names = CONSTRAINTS if mechanism.simple and not mechanism.limited else OF_CHAINS
    return " and ".join(names[kind] for kind in met) or "closure of the joints"


def limits_said(mechanism: Mechanism, limits: Limits) -> str:
    """Return the limits of a map in words."""
    if mechanism.limited:
        return "limits: strokes and joint angles as the mechanism states them"
    angles = np.degrees([limits.spherical_max, limits.revolute_max])
    words = ("spherical joints", "revolute joints") if mechanism.simple else (
        "joints at the platform", "joints at the base")  # fmt: skip
    return (
        f"limits: limbs {1000 * limits.length_min:g} to {1000 * limits.length_max:g} mm; "
        f"{words[0]} {angles[0]:g} deg from limbs normal to the platform; "
        f"{words[1]} {angles[1]:g} deg from vertical limbs"
    )


@dataclass(frozen=True)
class Answers:
    """What a `model` found of a `mechanism` at n `poses`.

    Attributes: `frequencies` (n, count) [Hz], NaN where it failed; `modes`, one a pose, None where
    it failed; where all poses were solved at once they are those of the first, with the seconds of
    one; `failures` by "MODEL at POSE", in words.
    """

    model: Model
    mechanism: Mechanism
    poses: Pose
    frequencies: Array
    modes: Sequence[Modes | None]
    failures: dict[str, str]

    def rows(self, kind: str = MAP) -> list[dict[str, Any]]:
        """Return one row a pose and mode for the history, of the poses solved."""
        count, result = self.frequencies.shape[1], list[dict[str, Any]]()
        how, name = settings(self.model, count), label(self.model)
        for pose, f, modes in zip(self.poses, self.frequencies, self.modes, strict=True):
            if modes is not None:
                case, own = Case(kind, self.mechanism, pose, ""), replace(modes, frequencies=f)
                result += mode_rows(case, name, how, own, count)
        return result


def solve(model: Model, mechanism: Mechanism, poses: Pose, count: int, bench: Bench) -> Answers:
    """Return the `count` lowest frequencies of `model` at `poses` (an array of them).

    A model that may crash takes one pose after the other, in a process of its own; others take all
    at once.
    """
    frequencies, failures = np.full((len(poses), count), np.nan), dict[str, str]()
    answers: list[Modes | None] = [None] * len(poses)
    if not model.info().isolated:
        bench.listener.expect(1)
        everywhere = f"{label(model)} at {len(poses)} poses"
        first = bench.solve(model, mechanism, poses[0], count)
        batch = BatchTask(model, mechanism, poses, count)
        found = first if isinstance(first, Failure) else bench.call(batch, isolated=False)
        bench.listener.done(everywhere)
        if isinstance(found, Failure):
            failures[everywhere] = found.reason
        else:
            assert isinstance(first, Modes) and isinstance(found, Batch)
            frequencies = found.table
            alike = replace(first, build_seconds=0.0, solve_seconds=found.seconds / len(poses))
            answers = [replace(alike, uncertainty=None, residual=None)] * len(poses)
        return Answers(model, mechanism, poses, frequencies, answers, failures)
    bench.listener.expect(len(poses))
    for i, pose in enumerate(poses):
        there = f"{label(model)} at {named(pose)}"
        modes = bench.solve(model, mechanism, pose, count)
        if isinstance(modes, Failure):
            failures[there] = modes.reason
        else:
            frequencies[i], answers[i] = modes.frequencies, modes
        bench.listener.done(there)
    return Answers(model, mechanism, poses, frequencies, answers, failures)


Where = TypeVar("Where", bound=Rays)


class Map(Generic[Where]):
    """What a model found over the poses of a grid or a plane.

    Attributes: `grid`; `answers` at its `wanted` poses; `frequencies` (..., A, R, count) [Hz],
    ascending, NaN where there is no pose or the model failed: the i-th is the i-th lowest, so where
    modes cross they change places.
    """

    def __init__(self, grid: Where, answers: Answers) -> None:
        self.grid, self.answers = grid, answers
        self.frequencies = grid.spread(answers.frequencies)

    @classmethod
    def of(cls, grid: Where, model: Model, count: int, bench: Bench) -> "Map[Where]":
        """Return the `count` lowest frequencies of `model` over a grid or a plane."""
        return cls(grid, solve(model, grid.mechanism, grid.held(grid.wanted), count, bench))

    def records(self, shown: Sequence[int], which: Flags) -> Iterator[dict[str, Any]]:
        """Return one row a mode and pose of those `which` have an answer: where, and what."""
        which = which & np.isfinite(self.frequencies[..., 0])
        found, last = self.frequencies[which], self.grid.rim[which].tolist()
        for mode in shown:
            for pose, end, f in zip(self.grid.held(which), last, found[:, mode - 1], strict=True):
                yield {"model": label(self.answers.model), **columns(pose), "rim": end,
                       "mode": mode, "frequency_hz": f}  # fmt: skip
