"""Frequencies over the regular workspace, layer by layer: the data of Fig. 6."""

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic import Limits, Mechanism, Modes, Pose, RegularWorkspace
from analytic.workspace import CONSTRAINTS, heights, inscribed, margins
from harness.models import Spec, batch_solver
from reference_models import ModelError

Floats = NDArray[np.float64]
Done = Callable[[str], None]
Failures = dict[tuple[str, str], str]

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
    def of(cls, mechanism: Mechanism, limits: Limits) -> "Region":
        """Return it; raises `InputError` where a level platform is nowhere within `limits`."""
        z = np.linspace(*heights(mechanism, limits), PROFILE)
        circles = RegularWorkspace(z, inscribed(mechanism, z, limits, azimuths=36)[0])
        return cls(mechanism, limits, circles, circles.cone())

    def layers(self, number: int) -> Floats:
        """Return `number` heights over the cone, evenly, to whole millimetres inside it [m]."""
        low, high = 1000 * self.cone.z
        return np.round(np.linspace(np.ceil(low), np.floor(high), number)) / 1000

    def bound(self, z: float, azimuth: float, tilt: float) -> str:
        """Return the limit, or limits, met at a pose on the boundary."""
        inside = margins(self.mechanism, Pose(z, azimuth, tilt), self.limits)
        met = np.unique(np.nonzero(np.abs(inside) < 1e-8)[1])
        return " and ".join(CONSTRAINTS[kind] for kind in met) or "closure of the joints"


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

    z: Floats
    radii: Floats
    touch: Floats
    azimuth: Floats
    tilt: Floats
    shared: NDArray[np.bool_]

    @classmethod
    def of(cls, region: Region, z: Floats, azimuths: int, tilts: int) -> "Grid":
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

    Attributes: `frequencies` (n, count) [Hz], NaN where it failed; `failures` by (pose, model
    label), in words; `modes` of a model that takes one pose at a time, by the pose's number, those
    that failed left out; `seconds` a pose of a model that takes all at once, else None.
    """

    frequencies: Floats
    failures: Failures
    modes: dict[int, Modes]
    seconds: float | None


@dataclass(frozen=True)
class WorkspaceMap:
    """Frequencies of one model over a grid in the regular workspace.

    Attributes: `region`; `grid`; `spec`, the model; `frequencies` (n, A, T, count) [Hz],
    ascending, NaN where there is no pose or the model failed: the i-th is the i-th lowest, so
    where modes cross they change places; `answers` of the model at the poses of `grid.wanted`, in
    their order there.
    """

    region: Region
    grid: Grid
    spec: Spec
    frequencies: Floats
    answers: Answers

    def rows(self) -> list[dict[str, Any]]:
        """Return one row a pose, in SI units."""
        result, grid = [], self.grid
        for i, k, j in np.argwhere(np.isfinite(self.frequencies[..., 0])).tolist():
            row = {"model": self.spec.label, "z_m": grid.z[i], "azimuth_rad": grid.azimuth[k]}
            row |= {"tilt_rad": grid.tilt[i, j], "rim": bool(j == grid.rim[i])}
            found = enumerate(self.frequencies[i, k, j].tolist(), 1)
            result.append(row | {f"f{mode}_hz": value for mode, value in found})
        return result


def workspace_map(
    region: Region, grid: Grid, spec: Spec, count: int, done: Done = lambda _: None
) -> WorkspaceMap:
    """Return the `count` lowest frequencies of `spec` over `grid`.

    Analytic models take all poses at once, simulators one after another; `done` hears of each.
    """
    wanted = grid.wanted
    where = np.nonzero(wanted)
    frequencies = np.full((*wanted.shape, count), np.nan)
    answers = solve(spec, region.mechanism, grid.pose(*where), count, done)
    frequencies[where] = answers.frequencies
    frequencies[:, 1:, 0] = frequencies[:, :1, 0]
    return WorkspaceMap(region, grid, spec, frequencies, answers)


def solve(
    spec: Spec, mechanism: Mechanism, poses: Pose, count: int, done: Done = lambda _: None
) -> Answers:
    """Return what `spec` finds at `poses` (an array of them)."""
    batch = batch_solver(spec)
    if batch is not None:
        batch(mechanism, poses[[0, -1]], count)  # tables load once, which is no pose's time
        began = perf_counter()
        found = batch(mechanism, poses, count)
        return Answers(found, {}, {}, (perf_counter() - began) / len(poses))
    model, failures, modes = spec.build(), {}, {}
    frequencies = np.full((len(poses), count), np.nan)
    for i, pose in enumerate(poses):
        try:
            modes[i] = model.modes(mechanism, pose, count)
            frequencies[i] = modes[i].frequencies
        except ModelError as error:
            failures[named(pose), spec.label] = str(error)
        done(f"{spec.label} at {named(pose)}")
    return Answers(frequencies, failures, modes, None)


def named(pose: Pose) -> str:
    """Return a pose in words."""
    azimuth, tilt = np.degrees([pose.azimuth, pose.tilt])
    return f"z = {1000 * pose.z:.1f} mm, azimuth {azimuth:.2f} deg, tilt {tilt:.2f} deg"
