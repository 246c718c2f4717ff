"""The worst poses of an error map again, where modes are paired by shape."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analytic import Mechanism, Modes, Pose
from analytic.pairing import pair
from harness.models import Spec
from harness.sweep.engine import Engine, run
from harness.sweep.error_map import Errors
from harness.sweep.jobs import built
from harness.sweep.pose_sets import written
from harness.sweep.sweep import Sweep
from harness.sweep.task import Failure
from harness.tables import Cell, Number, Table

Floats = NDArray[np.float64]
STILL = 1e-6
"""A centre line that moves less than this part of the most that any does is one of torsion."""


@dataclass(frozen=True)
class ShapeCheck:
    """Two models at one pose again, shapes and all, to pair their modes by shape."""

    mechanism: Mechanism
    pose: Pose
    spec: Spec
    against: Spec
    count: int
    torsion: bool

    @property
    def safe(self) -> bool:
        """Whether it can neither crash nor hang."""
        return self.spec.analytic and self.against.analytic

    def solve(self) -> tuple[Floats, Floats]:
        """Return errors [%] by shape and the pairs' assurance, each (count,)."""
        first = self._modes(self.spec, self.count)
        second = self._modes(self.against, self.count + 2)
        pairs = pair(first, second, self.mechanism, self.pose)
        reference = second.frequencies[pairs.partner]
        return 100 * (first.frequencies / reference - 1), pairs.assurance

    def _modes(self, spec: Spec, count: int) -> Modes:
        wanted = count
        while True:
            modes = built(spec).modes(self.mechanism, self.pose, wanted)
            if self.torsion or not spec.analytic:
                return modes
            amplitude = np.abs(modes.limbs).max(axis=(1, 2, 3))
            bends = np.flatnonzero(amplitude > STILL * amplitude.max())
            if len(bends) >= count:
                break
            wanted += count - len(bends)
        return replace(
            modes,
            frequencies=modes.frequencies[bends],
            platform=modes.platform[bends],
            limbs=modes.limbs[bends],
        ).first(count)


def worst_table(
    sweep: Sweep, gathered: list[Errors], against: Spec, engine: Engine, command: str
) -> Table:
    """The worst pose of each mode, its error paired by shape, and how to see it again."""
    checks = [
        ShapeCheck(
            sweep.mechanism, sweep.poses[n - 1], errors.spec, against, sweep.count, errors.torsion
        )
        for errors in gathered
        for n in np.unique(errors.where[errors.where > 0]).tolist()
    ]
    by_shape = {(task.spec, task.pose): result for task, result in run(engine, checks)}
    rows: list[tuple[Cell, ...]] = []
    for errors in gathered:
        for k, mode in enumerate(errors.modes.tolist() if errors.poses else []):
            n = int(errors.where[k])
            pose = sweep.poses[n - 1]
            result = by_shape[errors.spec, pose]
            pairs: tuple[Cell, ...] = ("-", "-")
            if not isinstance(result, Failure):
                pairs = (Number(result[0][mode - 1], 6, True), Number(result[1][mode - 1]))
            at = (1000 * pose.z, *np.degrees([pose.azimuth, pose.tilt]).tolist())
            error = Number(float(errors.worst[k]), 6, True)
            where = (Number(float(value)) for value in at)
            rows.append((errors.spec.label, f"f{mode}", error, *pairs, n, *where))
    labels = ",".join(errors.spec.label for errors in gathered)
    notes = tuple(
        f"pose {n}: rps-bench sweep --poses {written(sweep.poses[n - 1])} --models {labels} "
        f"--against {against.label}{command}"
        for n in sorted({n for errors in gathered for n in errors.where.tolist() if n})
    )
    columns = ("Model", "Mode", "Error (%)", "By shape (%)", "Assurance", "Pose",
               "z [mm]", "azimuth [deg]", "tilt [deg]")  # fmt: skip
    return Table(f"Worst poses against {against.label}", columns, tuple(rows), notes)
