"""One model against another at every pose of a sweep; where they differ most, by shape."""

import shlex
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic import Mechanism, Modes, Pose
from analytic.model import Model
from analytic.pairing import pair
from harness.answer import solved
from harness.bench import label
from harness.compare import cell, cells, relative_error
from harness.poses import COLUMNS, columns, headings, used
from harness.poses import cells as pose_cells
from harness.sweep.engine import Engine, run
from harness.sweep.journal import Journal
from harness.sweep.long_table import TABLE, LongTable
from harness.sweep.mode_check import beams_of, check_modes
from harness.sweep.pose_sets import written
from harness.sweep.sweep import Sweep
from harness.tables import Cell, Table
from harness.workers import Failure

Floats = NDArray[np.float64]
STILL = 1e-6
"""A centre line that moves less than this part of the most that any does is one of torsion."""
NAMED = 5
"""Poses named whose modes are miscounted."""
_BY_MODE = f"""
SELECT mode, count(e), ifnull(sqrt(favg(e * e)), 'nan'), ifnull(favg(e), 'nan'),
  ifnull(arg_max(e, abs(e)), 'nan'), ifnull(arg_max(pose, abs(e)), 0)
FROM (SELECT mode, pose, error_percent AS e FROM {TABLE} WHERE model = ?)
GROUP BY mode ORDER BY mode
"""

ERRORS = {
    "pose": "BIGINT",
    **dict.fromkeys(COLUMNS, "DOUBLE"),
    "model": "VARCHAR",
    "against": "VARCHAR",
    "mode": "BIGINT",
    "error_percent": "DOUBLE",
}


@dataclass(frozen=True)
class ModeErrors:
    """The errors [%] of one mode over all poses: `known` of them; NaN where there is none.

    `worst`, with its sign, is that of the pose number `where`, 0 where none is known.
    """

    mode: int
    known: int
    rms: float
    mean: float
    worst: float
    where: int


@dataclass
class Errors:
    """Errors of `model` against another: by mode, and where its modes are miscounted.

    Modes are paired by order: a sweep keeps no shapes. Sorted lists differ least when paired by
    order, so where modes cross between the models an error here may be too small, by no more than
    the gap of the modes that cross; `ShapeCheck` tells where that matters.
    Without `torsion`, which one of the two does not have, modes are numbered without it.
    """

    model: Model
    torsion: bool
    counted: NDArray[np.int64]
    miscounted: NDArray[np.int64]
    poses: int = 0
    wrong: list[int] = field(default_factory=list)
    modes: list[ModeErrors] = field(default_factory=list)


def compare(
    sweep: Sweep, journal: Journal, against: Model, modes: Sequence[int], file: Path
) -> list[Errors]:
    """Write the error of every other model at every pose; return what they come to.

    Where one of two models has no torsion of limbs, the other is taken without it if it can be.
    """
    gathered = []
    pick = np.array(modes) - 1
    theory = beams_of(against)
    where = used([sweep.poses])
    kinds = {n: kind for n, kind in ERRORS.items() if n not in COLUMNS or n in where}
    with LongTable(file, kinds, ["error_percent"], modes) as table:
        for model in sweep.models:
            if model == against:
                continue
            torsion = model.info().torsion and against.info().torsion
            errors = Errors(model, torsion, *np.zeros((2, len(pick)), dtype=np.int64))
            gathered.append(errors)
            for start, stop in sweep.blocks():
                ours, assumed = _block(sweep, journal, model, start, stop, torsion)
                theirs, theirs_in = _block(sweep, journal, against, start, stop, torsion)
                here = np.flatnonzero(~np.isnan(ours[:, 0] + theirs[:, 0]))
                if not len(here):
                    continue
                poses, numbers = sweep.poses[start + here], start + here + 1
                errors.poses += len(here)
                if theory is not None and model.info().isolated and assumed == theirs_in:
                    check = check_modes(ours[here], sweep.mechanism, poses, theory, torsion)
                    errors.counted += check.counted.sum(axis=0)[pick]
                    errors.miscounted += check.wrong.sum(axis=0)[pick]
                    errors.wrong += numbers[check.wrong.any(axis=1)].tolist()
                block: dict[str, Any] = {
                    "pose": numbers, **{name: columns(poses)[name] for name in where},
                    "model": label(model), "against": label(against),
                    "error_percent": relative_error(ours[here], theirs[here])[:, pick],
                }  # fmt: skip
                table.add(block)
            found = table.base.execute(_BY_MODE, [label(model)]).fetchall()
            errors.modes = [ModeErrors(*row) for row in found]
        table.write()
    return gathered


def _block(
    sweep: Sweep, journal: Journal, model: Model, start: int, stop: int, torsion: bool
) -> tuple[Floats, set[str]]:
    """Return frequencies (stop - start, count), NaN where a job is not finished; the theory."""
    values, theory = np.full((stop - start, sweep.count), np.nan), set()
    beams = None if torsion else beams_of(model)
    for job, answer in sweep.answers(journal, model, start, stop):
        found = answer.frequencies
        if beams is not None:
            found = beams.frequencies(job.mechanism, job.poses, job.count, torsion=False)
        values[job.start - start :][: len(job.poses)] = found
        theory.add(answer.theory)
    return values, theory


def error_table(gathered: list[Errors], against: Model) -> Table:
    """Largest, rms and mean error of each model and mode over all poses."""
    rows: list[tuple[Cell, ...]] = []
    for errors in gathered:
        for k, mode in enumerate(errors.modes):
            counts = f"{errors.miscounted[k]} of {errors.counted[k]}"
            counts = counts if errors.counted.any() else "-"
            numbers = cells([abs(mode.worst), mode.rms], 6) + cells([mode.mean], 6, signed=True)
            rows.append((label(errors.model), f"f{mode.mode}", errors.poses, *numbers, counts))
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
            where: tuple[Cell, ...] = (mode.where, *pose_cells(columns(pose), shown, 3))
            rows.append((label(errors.model), f"f{mode.mode}", error, *pairs, *where))
    labels = shlex.quote(",".join(label(errors.model) for errors in gathered))
    notes = tuple(
        f"pose {n}: rps-bench sweep --poses {written(sweep.poses[n - 1])} --models {labels} "
        f"--against {shlex.quote(label(against))}{command}"
        for n in sorted({mode.where for errors in gathered for mode in errors.modes if mode.where})
    )
    names = ("Model", "Mode", "Error (%)", "By shape (%)", "Assurance", "Pose", *headings(shown))
    return Table(f"Worst poses against {label(against)}", names, tuple(rows), notes)
