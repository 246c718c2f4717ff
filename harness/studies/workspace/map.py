"""Frequencies over the regular workspace, layer by layer: the data of Fig. 6."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic import InputError, Joint, Limits, Mechanism, Modes, Pose, RegularWorkspace
from analytic.model import Model
from analytic.workspace import CONSTRAINTS, OF_CHAINS, heights, inscribed, margins
from harness.answer import Batch, BatchTask
from harness.bench import Bench, label
from harness.case import Case
from harness.poses import named
from harness.rows import MAP, mode_rows, settings
from harness.signatures import Array
from harness.workers import Failure

LEAST = 1e-3
"""A platform that tilts by less than this everywhere does not tilt [rad]."""
ORDER = "modes are numbered by order, from the lowest: where two cross, they change places"
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
        if circles.radii.max() < LEAST:
            chain = mechanism.limbs[0].described
            expected = "limbs whose platform tilts any way; `sweep --poses` takes other poses"
            raise InputError("mechanism", chain, expected)
        return cls(mechanism, limits, circles, circles.cone())

    def layers(self, number: int) -> Array:
        """Return `number` heights over the cone, evenly, to whole millimetres inside it [m]."""
        low, high = 1000 * self.cone.z
        return np.round(np.linspace(np.ceil(low), np.floor(high), number)) / 1000


def limits_met(mechanism: Mechanism, limits: Limits, pose: Pose) -> str:
    """Return the limit, or limits, met at a pose on the boundary, in words."""
    met = np.unique(np.nonzero(np.abs(margins(mechanism, pose, limits)) < 1e-8)[1])
    plain = mechanism.simple and not mechanism.limited
    names = CONSTRAINTS if plain else OF_CHAINS
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
class Grid:
    """The poses of a map, layer by layer inside the largest circles.

    Attributes:
        z: heights of the layers, shape (n,) [m].
        radii, touch: the circle's tilt, and the azimuth where it meets a limit, shape (n,) [rad].
        azimuth: shape (A,), from the first limb's azimuth, evenly round [rad].
        tilt: shape (n, T) [rad], from 0 to the rim of each layer; NaN after it.
        shared: whether a tilt is one that the layers have in common, shape (n, T): not a rim.
    """

    z: Array
    radii: Array
    touch: Array
    azimuth: Array
    tilt: Array
    shared: NDArray[np.bool_]

    @classmethod
    def of(cls, region: Region, z: Array, azimuths: int, tilts: int) -> "Grid":
        """Return `tilts` from 0 to the widest rim that the layers share, and each layer's rim."""
        x, y, _ = region.mechanism.limbs[0].base
        azimuth = np.arctan2(y, x) + 2 * np.pi * np.arange(azimuths) / azimuths
        radii, touch = inscribed(region.mechanism, z, region.limits, azimuths=36)
        common = np.linspace(0, radii.max(), tilts)
        # A common tilt next to the rim would make a sliver of a ring.
        inner = common < radii[:, None] - 1e-3 * common[1]
        inner[:, 0] = True
        tilt = np.where(inner, common, np.nan)
        for row, radius, last in zip(tilt, radii, inner.sum(axis=1), strict=True):
            if radius > 0:
                row[last] = radius
        return cls(z, radii, touch, azimuth, tilt, inner)

    @property
    def rim(self) -> NDArray[np.intp]:
        """The index of each layer's last tilt, shape (n,)."""
        return np.asarray(np.isfinite(self.tilt).sum(axis=1) - 1)

    @property
    def wanted(self) -> NDArray[np.bool_]:
        """Which (n, A, T) to solve: a level platform once, for it has no azimuth."""
        shape = (len(self.z), len(self.azimuth), self.tilt.shape[1])
        wanted = np.broadcast_to(np.isfinite(self.tilt)[:, None, :], shape).copy()
        wanted[:, 1:, 0] = False
        return wanted

    def pose(self, layer: Any, azimuth: Any, tilt: Any) -> Pose:
        """Return the pose, or poses, of these indices."""
        return Pose(self.z[layer], self.azimuth[azimuth], self.tilt[layer, tilt])


@dataclass(frozen=True)
class Answers:
    """What a model found at n poses.

    Attributes: `frequencies` (n, count) [Hz], NaN where it failed; `modes`, one a pose where it
    takes one at a time, None where it failed, and of the first pose alone where it takes all at
    once; `seconds` a pose of the latter, else None; `failures` by "MODEL at POSE", in words.
    """

    frequencies: Array
    modes: tuple[Modes | None, ...]
    seconds: float | None
    failures: dict[str, str]

    def rows(
        self, model: Model, mechanism: Mechanism, poses: Pose, kind: str = MAP
    ) -> list[dict[str, Any]]:
        """Return one row a pose and mode for the history, of the `poses` solved."""
        count = self.frequencies.shape[1]
        how, name = settings(model, count), label(model)
        result: list[dict[str, Any]] = []
        for i, pose in enumerate(poses):
            modes = self.modes[i if self.seconds is None else 0]
            if modes is None or not np.isfinite(self.frequencies[i]).all():
                continue
            if self.seconds is not None:
                modes = replace(
                    modes, frequencies=self.frequencies[i],
                    uncertainty=None, residual=None,
                    build_seconds=0.0, solve_seconds=self.seconds,
                )  # fmt: skip
            result += mode_rows(Case(kind, mechanism, pose, ""), name, how, modes, count)
        return result


@dataclass(frozen=True)
class WorkspaceMap:
    """Frequencies of one model over a grid in the regular workspace.

    Attributes: `region`; `grid`; `model`; `frequencies` (n, A, T, count) [Hz], ascending, NaN where
    there is no pose or the model failed: the i-th is the i-th lowest, so where modes cross they
    change places; `answers` of the model at the poses of `grid.wanted`, in their order there.
    """

    region: Region
    grid: Grid
    model: Model
    frequencies: Array
    answers: Answers

    def rows(self) -> list[dict[str, Any]]:
        """Return one row a pose and mode for the history: a level platform once a layer."""
        poses = self.region.limits.held(self.grid.pose(*np.nonzero(self.grid.wanted)))
        return self.answers.rows(self.model, self.region.mechanism, poses)


def workspace_map(
    region: Region, grid: Grid, model: Model, count: int, bench: Bench
) -> WorkspaceMap:
    """Return the `count` lowest frequencies of `model` over `grid`.

    A model that may crash takes one pose after the other, in a process of its own; others take all
    at once.
    """
    wanted = grid.wanted
    where = np.nonzero(wanted)
    frequencies = np.full((*wanted.shape, count), np.nan)
    poses = region.limits.held(grid.pose(*where))
    answers = solve(model, region.mechanism, poses, count, bench)
    frequencies[where] = answers.frequencies
    frequencies[:, 1:, 0] = frequencies[:, :1, 0]
    return WorkspaceMap(region, grid, model, frequencies, answers)


def solve(model: Model, mechanism: Mechanism, poses: Pose, count: int, bench: Bench) -> Answers:
    """Return what `model` finds at `poses` (an array of them)."""
    frequencies, failures = np.full((len(poses), count), np.nan), dict[str, str]()
    if not model.info().isolated:
        bench.listener.expect(1)
        first = bench.solve(model, mechanism, poses[0], count)
        found: object = first
        if isinstance(first, Modes):
            found = bench.call(BatchTask(model, mechanism, poses, count), isolated=False)
        everywhere = f"{label(model)} at {len(poses)} poses"
        bench.listener.done(everywhere)
        if isinstance(found, Failure):
            return Answers(frequencies, (None,), 0.0, {everywhere: found.reason})
        assert isinstance(first, Modes) and isinstance(found, Batch)
        return Answers(found.table, (first,), found.seconds / len(poses), {})
    bench.listener.expect(len(poses))
    answers: list[Modes | None] = []
    for i, pose in enumerate(poses):
        modes = bench.solve(model, mechanism, pose, count)
        answers.append(None if isinstance(modes, Failure) else modes)
        if isinstance(modes, Failure):
            failures[f"{label(model)} at {named(pose)}"] = modes.reason
        else:
            frequencies[i] = modes.frequencies
        bench.listener.done(f"{label(model)} at {named(pose)}")
    return Answers(frequencies, tuple(answers), None, failures)
