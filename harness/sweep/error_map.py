"""One model against another at every pose of a sweep, and where they differ most."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.model import Model
from harness.bench import label
from harness.compare import cell, relative_error
from harness.sweep.journal import Journal
from harness.sweep.long_table import LongTable
from harness.sweep.mode_check import ModeCheck, beams_of, check_modes
from harness.sweep.sweep import Sweep, answers
from harness.tables import Cell, Table

Floats = NDArray[np.float64]
NAMED = 5
"""Poses named whose modes are miscounted."""

ERRORS = {
    "pose": "BIGINT",
    "z_m": "DOUBLE",
    "azimuth_rad": "DOUBLE",
    "tilt_rad": "DOUBLE",
    "model": "VARCHAR",
    "against": "VARCHAR",
    "mode": "BIGINT",
    "error_percent": "DOUBLE",
}


@dataclass
class Errors:
    """Errors of `model` against another [%], a column a mode, gathered block by block.

    Modes are paired by order: a sweep keeps no shapes. Sorted lists differ least when paired by
    order, so where modes cross between the models an error here may be too small, by no more than
    the gap of the modes that cross; `ShapeCheck` tells where that matters.
    Without `torsion`, which one of the two does not have, modes are numbered without it.
    An error against 0 Hz is none: `known` is how many there are.
    """

    model: Model
    modes: NDArray[np.int64]
    torsion: bool = True
    poses: int = 0
    known: NDArray[np.int64] = field(init=False)
    total: Floats = field(init=False)
    squares: Floats = field(init=False)
    worst: Floats = field(init=False)
    where: NDArray[np.int64] = field(init=False)
    counted: NDArray[np.int64] = field(init=False)
    miscounted: NDArray[np.int64] = field(init=False)
    wrong: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        n = len(self.modes)
        self.total, self.squares, self.worst = np.zeros((3, n))
        self.known, self.where, self.counted, self.miscounted = np.zeros((4, n), dtype=np.int64)

    def add(self, numbers: NDArray[np.int64], error: Floats) -> None:
        """Take in the errors (n, m) at poses of these `numbers` (n,)."""
        self.poses += len(numbers)
        self.known += np.isfinite(error).sum(axis=0)
        self.total += np.nansum(error, axis=0)
        self.squares += np.nansum(error**2, axis=0)
        size = np.where(np.isfinite(error), np.abs(error), -1.0)
        k = size.argmax(axis=0)
        column = np.arange(len(k))
        # The first of equals stays, and a worst pose is named even where no error is.
        first = (self.where == 0) & (size[k, column] >= 0)
        worse = (size[k, column] > np.abs(self.worst)) | first
        self.worst = np.where(worse, error[k, column], self.worst)
        self.where = np.where(worse, numbers[k], self.where)

    def count(self, numbers: NDArray[np.int64], check: ModeCheck) -> None:
        """Take in at how many poses, and of which `numbers`, there are too many or few modes."""
        self.counted += check.counted.sum(axis=0)[self.modes - 1]
        self.miscounted += check.wrong.sum(axis=0)[self.modes - 1]
        self.wrong += numbers[check.wrong.any(axis=1)].tolist()


def compare(
    sweep: Sweep, journal: Journal, against: Model, modes: Sequence[int], file: Path
) -> list[Errors]:
    """Write the error of every other model at every pose; return what was gathered of them.

    Where one of two models has no torsion of limbs, the other is taken without it if it can be.
    """
    gathered = [
        Errors(model, np.array(modes), model.info().torsion and against.info().torsion)
        for model in sweep.models
        if model != against
    ]
    theory = beams_of(against)
    with LongTable(file, ERRORS, ["error_percent"], modes) as table:
        for errors in gathered:
            for start, stop in sweep.blocks():
                ours, assumed = _block(sweep, journal, errors.model, start, stop, errors.torsion)
                theirs, theirs_in = _block(sweep, journal, against, start, stop, errors.torsion)
                here = np.flatnonzero(~np.isnan(ours[:, 0] + theirs[:, 0]))
                if not len(here):
                    continue
                poses, numbers = sweep.poses[start + here], start + here + 1
                isolated = errors.model.info().isolated
                if theory is not None and isolated and assumed == theirs_in:
                    found = ours[here]
                    check = check_modes(found, sweep.mechanism, poses, theory, errors.torsion)
                    errors.count(numbers, check)
                error = relative_error(ours[here], theirs[here])[:, errors.modes - 1]
                errors.add(numbers, error)
                block: dict[str, Any] = {
                    "pose": numbers, "z_m": poses.z, "azimuth_rad": poses.azimuth,
                    "tilt_rad": poses.tilt, "model": label(errors.model),
                    "against": label(against), "error_percent": error,
                }  # fmt: skip
                table.add(block)
        table.write()
    return gathered


def _block(
    sweep: Sweep, journal: Journal, model: Model, start: int, stop: int, torsion: bool
) -> tuple[Floats, set[str]]:
    """Return frequencies (stop - start, count), NaN where a job is not finished; the theory."""
    values, theory = np.full((stop - start, sweep.count), np.nan), set()
    beams = None if torsion else beams_of(model)
    for job, answer in answers(sweep, journal, model, start, stop):
        found = answer.frequencies
        if beams is not None:
            found = beams.without_torsion(job.mechanism, job.poses, job.count)
        values[job.start - start :][: len(job.poses)] = found
        theory.add(answer.theory)
    return values, theory


def error_table(gathered: list[Errors], against: Model) -> Table:
    """Largest, rms and mean error of each model and mode over all poses."""
    rows: list[tuple[Cell, ...]] = []
    for errors in gathered:
        for k, mode in enumerate(errors.modes.tolist() if errors.poses else []):
            known = int(errors.known[k]) or np.nan
            values = (
                abs(errors.worst[k]) if errors.known[k] else np.nan,
                np.sqrt(errors.squares[k] / known),
                errors.total[k] / known,
            )
            numbers = (cell(float(v), 6, signed=i == 2) for i, v in enumerate(values))
            wrong = (
                f"{errors.miscounted[k]} of {errors.counted[k]}" if errors.counted.any() else "-"
            )
            rows.append((label(errors.model), f"f{mode}", errors.poses, *numbers, wrong))
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
                f"{label(errors.model)}: poses with a wrong mode count: "
                f"{len(errors.wrong)} of {errors.poses}{more}"
            )
    return Table(f"Error against {label(against)}", columns, tuple(rows), tuple(notes))


def _torsion_note(errors: Errors, against: Model) -> list[str]:
    """Say which modes were compared, where one of the two has no torsion of limbs."""
    both = errors.model, against
    lacking = " and ".join(label(model) for model in both if not model.info().torsion)
    twisting = [model for model in both if model.info().torsion]
    if not lacking:
        return []
    if all(beams_of(model) for model in twisting):
        with_it = "".join(f"; {label(model)} is taken without it" for model in twisting)
        return [f"torsion of limbs, coupled to nothing, is not in {lacking}{with_it}"]
    return [
        f"torsion of limbs is not in {lacking}, but in {label(twisting[0])}: modes paired by order "
        "need not be the same ones where it is among the lowest"
    ]
