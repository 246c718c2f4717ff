"""One model against another at every pose of a sweep; where they differ most, by shape."""

import shlex
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from analytic import Mechanism, Modes, Pose
from analytic.model import Model
from analytic.pairing import pair
from harness.answer import solved
from harness.bench import label
from harness.compare import cell, cells, relative_error
from harness.history.duck import constant, one_of
from harness.poses import cells as pose_cells
from harness.poses import columns, headings
from harness.sweep.engine import run
from harness.sweep.jobs import BATCH, Sweep
from harness.sweep.long_table import TABLE, LongTable
from harness.sweep.mode_check import Floats, beams_of, check_modes, frequencies
from harness.sweep.pose_sets import written
from harness.tables import Cell, Table
from harness.workers import Failure

STILL = 1e-6
"""A centre line that moves less than this part of the most that any does is one of torsion."""
NAMED = 5
"""Poses named whose modes are miscounted."""
_BY_MODE = f"""
SELECT which, mode, ifnull(arg_max(e, abs(e)), 'nan'), ifnull(sqrt(favg(e * e)), 'nan'),
  ifnull(favg(e), 'nan'), ifnull(arg_max(pose, abs(e)), 0)
FROM (SELECT which, mode, pose, error_percent AS e FROM {TABLE})
GROUP BY which, mode ORDER BY which, mode
"""
"""Of each model and mode the largest error with its sign, rms, mean, and the worst pose, or 0."""


@dataclass
class Compared:
    """`model` beside another at `poses`; how many modes were `counted` there, by mode, how many of
    them wrongly, and the numbers of the `wrong` poses.

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


def compare(sweep: Sweep, against: Model, file: Path, command: str) -> dict[str, Table]:
    """Write the error of every other model at every pose; return "errors", what they come to by
    mode, and "worst", the worst poses, their errors paired by shape, and how to see them again.

    Where one of two models has no torsion of limbs, the other is taken without it if it can be.
    `command`: further options of the command that shows a pose.
    """
    where, pick, theory = sweep.where, np.array(sweep.modes) - 1, beams_of(against)
    others: list[Compared] = []
    with LongTable(file, ("pose", "which"), where, ("error_percent",), sweep.modes) as table:
        for model in sweep.models:
            if model == against:
                continue
            torsion = model.info().torsion and against.info().torsion
            one = Compared(model, torsion, *np.zeros((2, len(pick)), dtype=np.int64))
            for start in sweep.blocks:
                ours, assumed = _block(sweep, model, start, torsion)
                theirs, theirs_in = _block(sweep, against, start, torsion)
                here = np.flatnonzero(~np.isnan(ours[:, 0] + theirs[:, 0]))
                if not len(here):
                    continue
                poses, numbers = sweep.poses[start + here], start + here + 1
                one.poses += len(here)
                if theory is not None and model.info().isolated and assumed == theirs_in:
                    check = check_modes(ours[here], sweep.mechanism, poses, theory, torsion)
                    one.counted += check.counted.sum(axis=0)[pick]
                    one.miscounted += check.wrong.sum(axis=0)[pick]
                    one.wrong += numbers[check.wrong.any(axis=1)].tolist()
                error = relative_error(ours[here], theirs[here])[:, pick]
                block = {"pose": numbers, "which": len(others), "error_percent": error}
                table.add(columns(poses) | block)
            others.append(one)
        found = table.base.execute(_BY_MODE).fetchall()
        names = [label(one.model) for one in others]
        texts = {"model": one_of(names, "which"), "against": constant(label(against))}
        shown = ("pose", *where, *texts, "mode", "error_percent")
        table.write({name: texts.get(name, name) for name in shown})

    def check_of(which: int, number: int) -> ShapeCheck:
        one, pose = others[which], sweep.poses[number - 1]
        return ShapeCheck(sweep.mechanism, pose, one.model, against, sweep.count, one.torsion)

    bad = {(which, number): None for which, *_, number in found if number}
    by_shape = dict(run(sweep.engine, [check_of(*key) for key in bad]))
    rows: list[tuple[Cell, ...]] = []
    worst_rows: list[tuple[Cell, ...]] = []
    for which, mode, worst, rms, mean, number in found:
        one, name = others[which], (names[which], f"f{mode}")
        counts = "-"
        if one.counted.any():
            k = list(sweep.modes).index(mode)
            counts = f"{one.miscounted[k]} of {one.counted[k]}"
        errors = *cells([abs(worst), rms], 6), cell(mean, 6, signed=True)
        rows.append((*name, one.poses, *errors, counts))
        if not number:
            continue
        again = check_of(which, number)
        result = by_shape[again]
        pairs: tuple[Cell, ...] = ("-", "-")
        if not isinstance(result, Failure):
            shape, assurance = (values[mode - 1] for values in result)
            pairs = (cell(shape, 6, signed=True), cell(assurance, 3))
        place = pose_cells(columns(again.pose), where, 3)
        worst_rows.append((*name, cell(worst, 6, signed=True), *pairs, number, *place))
    notes = [
        "modes paired by order; shapes are looked at for the worst poses",
        "Miscounted: poses where the number of modes up to halfway to the next is not Wittrick and "
        "Williams' count; for simulators of the same theory, where the gap is clear of the error",
    ]
    for one in others:
        notes += _notes(one, against)
    heads = ("Model", "Mode", "Poses", "Largest (%)", "rms (%)", "Mean (%)", "Miscounted")
    commands = tuple(
        f"pose {n}: rps-bench sweep --poses {written(sweep.poses[n - 1])} --models "
        f"{shlex.quote(','.join(names))} --against {shlex.quote(label(against))}{command}"
        for n in sorted({number for _, number in bad})
    )
    worst_heads = ("Model", "Mode", "Error (%)", "By shape (%)", "Assurance", "Pose")
    return {
        "errors": Table(f"Error against {label(against)}", heads, tuple(rows), tuple(notes)),
        "worst": Table(
            f"Worst poses against {label(against)}", (*worst_heads, *headings(where)),
            tuple(worst_rows), commands,
        ),
    }  # fmt: skip


def _block(sweep: Sweep, model: Model, start: int, torsion: bool) -> tuple[Floats, set[str]]:
    """Return frequencies (`BATCH`, count), NaN where there is no answer; the theory."""
    values, theory = np.full((BATCH, sweep.count), np.nan), set()
    beams = None if torsion else beams_of(model)
    for job, answer in sweep.answers(model, start):
        found = answer.frequencies
        if beams is not None:
            found = frequencies(job.mechanism, job.poses, job.count, beams, torsion=False)
        values[job.start - start :][: len(job.poses)] = found
        theory.add(answer.theory)
    return values, theory


def _notes(one: Compared, against: Model) -> list[str]:
    """Say which modes were compared, where one of the two has no torsion of limbs, and where the
    number of modes is wrong."""
    both, notes = (one.model, against), []
    lacking = " and ".join(label(model) for model in both if not model.info().torsion)
    twisting = [model for model in both if model.info().torsion]
    if lacking and all(map(beams_of, twisting)):
        with_it = "".join(f"; {label(model)} is taken without it" for model in twisting)
        notes.append(f"torsion of limbs, coupled to nothing, is not in {lacking}{with_it}")
    elif lacking:
        notes.append(
            f"torsion of limbs is not in {lacking}, but in {label(twisting[0])}: modes paired by "
            "order need not be the same ones where it is among the lowest"
        )
    if one.counted.any():
        named = ", ".join(map(str, one.wrong[:NAMED]))
        more = f": {named}{' ...' if len(one.wrong) > NAMED else ''}" if named else ""
        notes.append(
            f"{label(one.model)}: poses with a wrong mode count: "
            f"{len(one.wrong)} of {one.poses}{more}"
        )
    return notes


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
