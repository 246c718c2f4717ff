"""One model against another at every pose of a sweep, and where they differ most."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import polars as pl
from numpy.typing import NDArray

from analytic import Pose
from harness.models import Spec
from harness.sweep.frames import write_frames
from harness.sweep.jobs import analytic_frequencies, info_of
from harness.sweep.journal import Journal
from harness.sweep.mode_check import ModeCheck, check_modes
from harness.sweep.sweep import Sweep, answers
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
    Without `torsion`, which one of the two does not have, modes are numbered without it.
    """

    spec: Spec
    modes: NDArray[np.int64]
    torsion: bool = True
    poses: int = 0
    total: Floats = field(init=False)
    squares: Floats = field(init=False)
    worst: Floats = field(init=False)
    where: NDArray[np.int64] = field(init=False)
    counted: NDArray[np.int64] = field(init=False)
    miscounted: NDArray[np.int64] = field(init=False)
    wrong: list[int] = field(default_factory=list)

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


def compare(
    sweep: Sweep, journal: Journal, against: Spec, modes: list[int], folder: Path, suffix: str
) -> list[Errors]:
    """Write the error of every other model at every pose; return what was gathered of them.

    Where a simulator has no torsion of limbs, the theory is taken without it.
    """
    gathered = [
        Errors(spec, np.array(modes), _twists(spec) and _twists(against))
        for spec in sweep.specs
        if spec != against
    ]

    def frames() -> Iterator[pl.DataFrame]:
        for errors in gathered:
            for start, stop in sweep.blocks():
                ours, assumed = _block(sweep, journal, errors.spec, start, stop, errors.torsion)
                theirs, theory = _block(sweep, journal, against, start, stop, errors.torsion)
                here = np.flatnonzero(~np.isnan(ours[:, 0] + theirs[:, 0]))
                if not len(here):
                    continue
                numbers, shown = start + here + 1, errors.modes - 1
                if against.analytic and not errors.spec.analytic and assumed == theory:
                    poses = sweep.poses[start + here]
                    check = check_modes(ours[here], sweep.mechanism, poses, against, errors.torsion)
                    errors.count(numbers, check)
                error = 100 * (ours[here] / theirs[here] - 1)[:, shown]
                errors.add(numbers, error)
                yield _frame(errors, against, start + here, sweep.poses, error)

    write_frames(folder, f"errors.{suffix}", frames(), ERRORS)
    return gathered


def _twists(spec: Spec) -> bool:
    return spec.analytic or info_of(spec).torsion


def _block(
    sweep: Sweep, journal: Journal, spec: Spec, start: int, stop: int, torsion: bool
) -> tuple[Floats, set[str]]:
    """Return frequencies (stop - start, count), NaN where a job is not finished; the theory."""
    values, theory = np.full((stop - start, sweep.count), np.nan), set()
    for job, answer in answers(sweep, journal, spec, start, stop):
        found = answer.frequencies
        if spec.analytic and not torsion:
            found = analytic_frequencies(job, torsion=False)
        values[job.start - start :][: len(job.poses)] = found
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
        notes += _torsion_note(errors, against)
        if errors.counted.any():
            named = ", ".join(map(str, errors.wrong[:NAMED]))
            more = f": {named}{' ...' if len(errors.wrong) > NAMED else ''}" if named else ""
            notes.append(
                f"{errors.spec.label}: poses with a wrong mode count: "
                f"{len(errors.wrong)} of {errors.poses}{more}"
            )
    return Table(f"Error against {against.label}", columns, tuple(rows), tuple(notes))


def _torsion_note(errors: Errors, against: Spec) -> list[str]:
    """Say which modes were compared, where one of the two has no torsion of limbs."""
    both = errors.spec, against
    lacking = " and ".join(spec.label for spec in both if not _twists(spec))
    twisting = [spec for spec in both if _twists(spec)]
    if not lacking:
        return []
    if all(spec.analytic for spec in twisting):
        with_it = "".join(f"; {spec.label} is taken without it" for spec in twisting)
        return [f"torsion of limbs, coupled to nothing, is not in {lacking}{with_it}"]
    return [
        f"torsion of limbs is not in {lacking}, but in {twisting[0].label}: modes paired by order "
        "need not be the same ones where it is among the lowest"
    ]
