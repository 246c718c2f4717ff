"""One model against another at every pose of a sweep, and where they differ most."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import polars as pl
from numpy.typing import NDArray

from analytic import Mechanism, Pose
from analytic.pairing import pair
from harness.engine import Engine, run
from harness.frames import write_frames
from harness.jobs import Failure, built
from harness.journal import Journal
from harness.mode_check import ModeCheck, check_modes
from harness.models import Spec
from harness.pose_sets import written
from harness.sweep import Sweep, answers
from harness.tables import Cell, Number, Table

Floats = NDArray[np.float64]
NAMED = 5
"""Poses named whose modes are miscounted."""

ERRORS = {
    "pose": pl.Int64,
    "z_m": pl.Float64,
    "azimuth_rad": pl.Float64,
    "tilt_rad": pl.Float64,
    "model": pl.String,
    "against": pl.String,
    "mode": pl.Int64,
    "error_percent": pl.Float64,
}


@dataclass
class Errors:
    """Errors of `spec` against another [%], a column a mode, gathered block by block.

    Modes are paired by order: a sweep keeps no shapes. Sorted lists differ least when paired by
    order, so where modes cross between the models an error here may be too small, by no more than
    the gap of the modes that cross; `ShapeCheck` tells where that matters.
    """

    spec: Spec
    modes: NDArray[np.int64]
    poses: int = 0
    total: Floats = field(init=False)
    squares: Floats = field(init=False)
    worst: Floats = field(init=False)
    where: NDArray[np.int64] = field(init=False)
    counted: NDArray[np.int64] = field(init=False)
    miscounted: NDArray[np.int64] = field(init=False)
    wrong: list[int] = field(default_factory=list)
    twist: int = 0

    def __post_init__(self) -> None:
        self.total, self.squares, self.worst = np.zeros((3, len(self.modes)))
        self.where, self.counted, self.miscounted = np.zeros((3, len(self.modes)), dtype=np.int64)

    def add(self, numbers: NDArray[np.int64], error: Floats) -> None:
        """Take in the errors (n, m) at poses of these `numbers` (n,)."""
        self.poses += len(numbers)
        self.total += error.sum(axis=0)
        self.squares += (error**2).sum(axis=0)
        k = np.abs(error).argmax(axis=0)
        largest = error[k, np.arange(len(k))]
        # The first of equals stays, and a worst pose is named even where no error is.
        worse = (np.abs(largest) > np.abs(self.worst)) | (self.where == 0)
        self.worst = np.where(worse, largest, self.worst)
        self.where = np.where(worse, numbers[k], self.where)

    def count(self, numbers: NDArray[np.int64], check: ModeCheck) -> None:
        """Take in at how many poses, and of which `numbers`, there are too many or few modes."""
        self.counted += check.counted.sum(axis=0)[self.modes - 1]
        self.miscounted += check.wrong.sum(axis=0)[self.modes - 1]
        self.wrong += numbers[check.wrong.any(axis=1)].tolist()
        self.twist += int(check.twist.sum())


@dataclass(frozen=True)
class ShapeCheck:
    """Two models at one pose again, shapes and all, to pair their modes by shape."""

    mechanism: Mechanism
    pose: Pose
    spec: Spec
    against: Spec
    count: int

    @property
    def safe(self) -> bool:
        """Whether it can neither crash nor hang."""
        return self.spec.analytic and self.against.analytic

    def solve(self) -> tuple[Floats, Floats]:
        """Return errors [%] by shape and the pairs' assurance, each (count,)."""
        first = built(self.spec).modes(self.mechanism, self.pose, self.count)
        second = built(self.against).modes(self.mechanism, self.pose, self.count + 2)
        pairs = pair(first, second, self.mechanism, self.pose)
        reference = second.frequencies[pairs.partner]
        return 100 * (first.frequencies / reference - 1), pairs.assurance


def compare(
    sweep: Sweep, journal: Journal, against: Spec, modes: list[int], folder: Path, suffix: str
) -> list[Errors]:
    """Write the error of every other model at every pose; return what was gathered of them."""
    gathered = [Errors(spec, np.array(modes)) for spec in sweep.specs if spec != against]

    def frames() -> Iterator[pl.DataFrame]:
        for errors in gathered:
            for start, stop in sweep.blocks():
                ours, assumed = _block(sweep, journal, errors.spec, start, stop)
                theirs, theory = _block(sweep, journal, against, start, stop)
                here = np.flatnonzero(~np.isnan(ours[:, 0] + theirs[:, 0]))
                if not len(here):
                    continue
                numbers, shown = start + here + 1, errors.modes - 1
                if against.analytic and not errors.spec.analytic and assumed == theory:
                    poses = sweep.poses[start + here]
                    errors.count(numbers, check_modes(ours[here], sweep.mechanism, poses, against))
                error = 100 * (ours[here] / theirs[here] - 1)[:, shown]
                errors.add(numbers, error)
                yield _frame(errors, against, start + here, sweep.poses, error)

    write_frames(folder, f"errors.{suffix}", frames(), ERRORS)
    return gathered


def _block(
    sweep: Sweep, journal: Journal, spec: Spec, start: int, stop: int
) -> tuple[Floats, set[str]]:
    """Return frequencies (stop - start, count), NaN where a job is not finished; the theory."""
    values, theory = np.full((stop - start, sweep.count), np.nan), set()
    for job, answer in answers(sweep, journal, spec, start, stop):
        values[job.start - start :][: len(job.poses)] = answer.frequencies
        theory.add(answer.theory)
    return values, theory


def _frame(
    errors: Errors, against: Spec, index: NDArray[np.int64], poses: Pose, error: Floats
) -> pl.DataFrame:
    m = len(errors.modes)
    return (
        pl.DataFrame(
            {
                "pose": np.repeat(index + 1, m),
                "z_m": np.repeat(poses.z[index], m),
                "azimuth_rad": np.repeat(poses.azimuth[index], m),
                "tilt_rad": np.repeat(poses.tilt[index], m),
                "mode": np.tile(errors.modes, len(index)),
                "error_percent": error.ravel(),
            }
        )
        .with_columns(model=pl.lit(errors.spec.label), against=pl.lit(against.label))
        .select(list(ERRORS))
    )


def error_table(gathered: list[Errors], against: Spec) -> Table:
    """Largest, rms and mean error of each model and mode over all poses."""
    rows: list[tuple[Cell, ...]] = []
    for errors in gathered:
        for k, mode in enumerate(errors.modes.tolist() if errors.poses else []):
            values = (
                abs(errors.worst[k]),
                np.sqrt(errors.squares[k] / errors.poses),
                errors.total[k] / errors.poses,
            )
            numbers = (Number(float(v), 6, signed=i == 2) for i, v in enumerate(values))
            wrong = (
                f"{errors.miscounted[k]} of {errors.counted[k]}" if errors.counted.any() else "-"
            )
            rows.append((errors.spec.label, f"f{mode}", errors.poses, *numbers, wrong))
    columns = ("Model", "Mode", "Poses", "Largest (%)", "rms (%)", "Mean (%)", "Miscounted")
    notes = [
        "modes paired by order; shapes are looked at for the worst poses",
        "Miscounted: poses where the number of modes up to halfway to the next is not Wittrick and "
        "Williams' count; for simulators of the same theory, where the gap is clear of the error",
    ]
    for errors in gathered:
        if errors.counted.any():
            named = ", ".join(map(str, errors.wrong[:NAMED]))
            more = f": {named}{' ...' if len(errors.wrong) > NAMED else ''}" if named else ""
            if errors.twist:
                more += (
                    f"; at {errors.twist} of them torsion of limbs, and nothing else, is missing"
                )
            notes.append(
                f"{errors.spec.label}: poses with a wrong mode count: "
                f"{len(errors.wrong)} of {errors.poses}{more}"
            )
    return Table(f"Error against {against.label}", columns, tuple(rows), tuple(notes))


def worst_table(
    sweep: Sweep, gathered: list[Errors], against: Spec, engine: Engine, command: str
) -> Table:
    """The worst pose of each mode, its error paired by shape, and how to see it again."""
    checks = [
        ShapeCheck(sweep.mechanism, sweep.poses[n - 1], errors.spec, against, sweep.count)
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
