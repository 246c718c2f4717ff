"""The worst poses of an error map again, where modes are paired by shape."""

import shlex
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analytic import Mechanism, Modes, Pose
from analytic.model import Model
from analytic.pairing import pair
from harness.answer import solved
from harness.bench import label
from harness.compare import cell, relative_error
from harness.poses import cells, columns, headings, used
from harness.sweep.engine import Engine, run
from harness.sweep.error_map import Errors
from harness.sweep.mode_check import beams_of
from harness.sweep.pose_sets import written
from harness.sweep.sweep import Sweep
from harness.tables import Cell, Table
from harness.workers import Failure

Floats = NDArray[np.float64]
STILL = 1e-6
"""A centre line that moves less than this part of the most that any does is one of torsion."""


@dataclass(frozen=True)
class ShapeCheck:
    """Two models at one pose again, shapes and all, to pair their modes by shape."""

    mechanism: Mechanism
    pose: Pose
    model: Model
    against: Model
    count: int
    torsion: bool

    @property
    def isolated(self) -> bool:
        """Whether it must run in a process of its own."""
        return self.model.info().isolated or self.against.info().isolated

    def solve(self) -> tuple[Floats, Floats]:
        """Return errors [%] by shape and the pairs' assurance, each (count,)."""
        first = self._modes(self.model, self.count)
        second = self._modes(self.against, self.count + 2)
        pairs = pair(first, second, self.mechanism, self.pose)
        reference = second.frequencies[pairs.partner]
        return relative_error(first.frequencies, reference), pairs.assurance

    def _modes(self, model: Model, count: int) -> Modes:
        wanted = count
        while True:
            if model.info().isolated:
                modes, _ = solved(model, self.mechanism, self.pose, wanted)
            else:
                modes = model.modes(self.mechanism, self.pose, wanted)
            if self.torsion or not beams_of(model):
                return modes
            amplitude = np.abs(modes.limbs).max(axis=(1, 2, 3))
            bends = np.flatnonzero(amplitude > STILL * amplitude.max())
            if len(bends) >= count:
                names = ("frequencies", "platform", "limbs")
                return replace(modes, **{n: getattr(modes, n)[bends] for n in names}).first(count)
            wanted += count - len(bends)


def worst_table(
    sweep: Sweep, gathered: list[Errors], against: Model, engine: Engine, command: str
) -> Table:
    """The worst pose of each mode, its error paired by shape, and how to see it again."""
    checks = [
        ShapeCheck(
            sweep.mechanism, sweep.poses[n - 1], errors.model, against, sweep.count, errors.torsion
        )
        for errors in gathered
        for n in sorted({mode.where for mode in errors.modes if mode.where})
    ]
    shown = used([sweep.poses])
    by_shape = {(task.model, task.pose): result for task, result in run(engine, checks)}
    rows: list[tuple[Cell, ...]] = []
    for errors in gathered:
        for mode in errors.modes:
            if not mode.where:
                continue
            pose = sweep.poses[mode.where - 1]
            result = by_shape[errors.model, pose]
            pairs: tuple[Cell, ...] = ("-", "-")
            if not isinstance(result, Failure):
                shape, assurance = (values[mode.mode - 1] for values in result)
                pairs = (cell(shape, 6, signed=True), cell(assurance, 3))
            error = cell(mode.worst, 6, signed=True)
            where: tuple[Cell, ...] = (mode.where, *cells(columns(pose), shown, 3))
            rows.append((label(errors.model), f"f{mode.mode}", error, *pairs, *where))
    labels = shlex.quote(",".join(label(errors.model) for errors in gathered))
    notes = tuple(
        f"pose {n}: rps-bench sweep --poses {written(sweep.poses[n - 1])} --models {labels} "
        f"--against {shlex.quote(label(against))}{command}"
        for n in sorted({mode.where for errors in gathered for mode in errors.modes if mode.where})
    )
    names = ("Model", "Mode", "Error (%)", "By shape (%)", "Assurance", "Pose", *headings(shown))
    return Table(f"Worst poses against {label(against)}", names, tuple(rows), notes)
