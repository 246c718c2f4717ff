"""One model against another at every pose of a sweep; where they differ most, by shape.

Modes are paired by order: a sweep keeps no shapes. Sorted lists differ least when paired by order,
so where modes cross between the models an error here may be too small, by no more than the gap of
the modes that cross; `ShapeCheck` tells where that matters.

They are counted as well. The theory's number is Wittrick and Williams' count, halfway between
neighbouring frequencies of the theory: a mode that a simulator misses, has twice or makes up shifts
its own number there.
"""

import shlex
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from analytic import Mechanism, Modes, Pose, condensed_frequencies
from analytic.mode_counts import mode_counts
from analytic.model import Model
from analytic.pairing import pair
from analytic.theory import Theory
from harness.answer import solved
from harness.bench import label
from harness.compare import cell, cells, relative_error
from harness.history.duck import constant, one_of
from harness.poses import cells as pose_cells
from harness.poses import columns, headings
from harness.sweep.engine import run
from harness.sweep.jobs import BATCH, Sweep
from harness.sweep.long_table import TABLE, LongTable
from harness.sweep.pose_sets import written
from harness.tables import Cell, Table
from harness.workers import Failure

STILL = 1e-6
"""A centre line that moves less than this part of the most that any does is one of torsion."""
NAMED = 5
"""Poses named whose modes are miscounted."""
CLEAR = 4
"""Neighbours further apart than this many deviations are told apart."""
REPEATED = 1e-6
"""Relative distance below which neighbours are one repeated mode."""
SPARE = 4
"""Further modes of the theory, for what a simulator has in the place of those it misses."""
_BY_MODE = f"""
SELECT which, mode, count(*), ifnull(arg_max(e, abs(e)), 'nan'),
  ifnull(sqrt(favg(e * e)), 'nan'), ifnull(favg(e), 'nan'), arg_max(pose, abs(e))
FROM (SELECT which, mode, pose, error_percent AS e FROM {TABLE})
GROUP BY which, mode ORDER BY which, mode
"""
"""Of a model and mode: poses, the largest error with its sign, rms, mean, and the worst pose."""
Floats = NDArray[np.float64]
Beams = Mapping[str, Any]
"""Limbs whose modes can be counted, as functions of `analytic` take them: `elements` each, None for
exact ones, `beam` and `shear`."""


def compare(sweep: Sweep, against: Model, file: Path, command: str) -> dict[str, Table]:
    """Write the error of every other model at every pose; return "errors", what they come to by
    mode, and "worst", the worst poses, their errors paired by shape, and how to see them again.

    Where one of two models has no torsion of limbs, the other is taken without it if it can be, and
    modes are numbered without it. `command`: further options of the command that shows a pose.
    """
    where, pick, theory = sweep.where, np.array(sweep.modes) - 1, beams_of(against)
    others = [model for model in sweep.models if model != against]
    labels, name = [label(model) for model in others], label(against)
    torsion = [model.info().torsion and against.info().torsion for model in others]
    counted, miscounted = np.zeros((2, len(others), len(pick)), dtype=int)
    wrong: list[list[int]] = [[] for _ in others]
    columns_of = ("pose", "which"), where, ("error_percent",)
    with closing(LongTable(file, *columns_of, sweep.modes)) as table:
        for which, model in enumerate(others):
            for start in sweep.blocks:
                ours, assumed = _block(sweep, model, start, torsion[which])
                theirs, theirs_in = _block(sweep, against, start, torsion[which])
                here = np.flatnonzero(~np.isnan(ours[:, 0] + theirs[:, 0]))
                if not len(here):
                    continue
                ours, theirs, numbers = ours[here], theirs[here], start + here + 1
                poses = sweep.poses[numbers - 1]
                if theory is not None and model.info().isolated and assumed == theirs_in:
                    check = check_modes(ours, sweep.mechanism, poses, theory, torsion[which])
                    counted[which] += check.counted.sum(axis=0)[pick]
                    miscounted[which] += check.wrong.sum(axis=0)[pick]
                    wrong[which] += numbers[check.wrong.any(axis=1)].tolist()
                error = relative_error(ours, theirs)[:, pick]
                own = {"pose": numbers, "which": which, "error_percent": error}
                table.add(columns(poses) | own)
        found = table.base.execute(_BY_MODE).fetchall()
        table.write(
            ("pose", *where, "model", "against", "mode", "error_percent"),
            {"model": one_of(labels, "which"), "against": constant(name)},
        )

    def again(which: int, number: int) -> ShapeCheck:
        pose, models = sweep.poses[number - 1], (others[which], against)
        return ShapeCheck(sweep.mechanism, pose, *models, sweep.count, torsion[which])

    bad = {(which, number) for which, *_, number in found if number}
    by_shape = dict(run(sweep.engine, [again(*each) for each in sorted(bad)]))
    errors: list[tuple[Cell, ...]] = []
    worst: list[tuple[Cell, ...]] = []
    for which, mode, number_of, largest, rms, mean, number in found:
        first, k = (labels[which], f"f{mode}"), sweep.modes.index(mode)
        counts = f"{miscounted[which, k]} of {counted[which, k]}" if counted[which].any() else "-"
        sizes = cells([abs(largest), rms], 6)
        errors.append((*first, number_of, *sizes, cell(mean, 6, signed=True), counts))
        if number:
            result = by_shape[again(which, number)]
            pairs: tuple[Cell, ...] = ("-", "-")
            if not isinstance(result, Failure):
                shape, assurance = (values[mode - 1] for values in result)
                pairs = (cell(shape, 6, signed=True), cell(assurance, 3))
            at = pose_cells(columns(sweep.poses[number - 1]), where, 3)
            worst.append((*first, cell(largest, 6, signed=True), *pairs, number, *at))
    notes = [
        "modes paired by order; shapes are looked at for the worst poses",
        "Miscounted: poses where the number of modes up to halfway to the next is not Wittrick and "
        "Williams' count; for simulators of the same theory, where the gap is clear of the error",
    ]
    total = {which: number_of for which, _, number_of, *_ in found}
    for which, model in enumerate(others):
        notes += _torsion_note(model, against)
        if counted[which].any():
            some = ", ".join(map(str, wrong[which][:NAMED]))
            more = f": {some}{' ...' if len(wrong[which]) > NAMED else ''}" if some else ""
            notes.append(
                f"{labels[which]}: poses with a wrong mode count: "
                f"{len(wrong[which])} of {total[which]}{more}"
            )
    options = f"{shlex.quote(','.join(labels))} --against {shlex.quote(name)}{command}"
    commands = tuple(
        f"pose {n}: rps-bench sweep --poses {written(sweep.poses[n - 1])} --models {options}"
        for n in sorted({number for _, number in bad})
    )
    heads = ("Model", "Mode", "Poses", "Largest (%)", "rms (%)", "Mean (%)", "Miscounted")
    worst_heads = ("Model", "Mode", "Error (%)", "By shape (%)", "Assurance", "Pose")
    return {
        "errors": Table(f"Error against {name}", heads, tuple(errors), tuple(notes)),
        "worst": Table(
            f"Worst poses against {name}", worst_heads + headings(where), tuple(worst), commands
        ),
    }


def _block(sweep: Sweep, model: Model, start: int, torsion: bool) -> tuple[Floats, set[str]]:
    """Return frequencies (`BATCH`, count), NaN where there is no answer; the theory."""
    values, theory = np.full((BATCH, sweep.count), np.nan), set()
    beams = None if torsion else beams_of(model)
    for job, answer in sweep.answers(model, start):
        found = answer.frequencies
        if beams is not None:
            found = condensed_frequencies(
                job.mechanism, job.poses, count=job.count, torsion=False, fast=False, **beams
            )
        values[job.start - start :][: len(job.poses)] = found
        theory.add(answer.theory)
    return values, theory


def _torsion_note(model: Model, against: Model) -> list[str]:
    """Say which modes were compared, where one of the two has no torsion of limbs."""
    both = (model, against)
    lacking = " and ".join(label(one) for one in both if not one.info().torsion)
    twisting = [one for one in both if one.info().torsion]
    if not lacking:
        return []
    if all(map(beams_of, twisting)):
        with_it = "".join(f"; {label(one)} is taken without it" for one in twisting)
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
            modes, _ = solved(model, self.mechanism, self.pose, wanted)
            if self.torsion or not beams_of(model):
                return modes
            amplitude = np.abs(modes.limbs).max(axis=(1, 2, 3))
            bends = np.flatnonzero(amplitude > STILL * amplitude.max())
            if len(bends) >= count:
                names = ("frequencies", "platform", "limbs")
                return replace(modes, **{n: getattr(modes, n)[bends] for n in names}).first(count)
            wanted += count - len(bends)


class ModeCheck(NamedTuple):
    """At N poses, above each of `count` modes: was it counted there, and wrongly; (N, count)."""

    counted: NDArray[np.bool_]
    wrong: NDArray[np.bool_]


def beams_of(model: Model) -> Beams | None:
    """Return what a model assumes of its limbs where it is one of beams, or None."""
    if model.info().isolated:
        return None
    built: Any = model.build() if hasattr(model, "build") else model
    theory = getattr(built, "theory", None)
    if not isinstance(theory, Theory):
        return None
    return {"elements": built.elements, "beam": theory.beam, "shear": theory.shear}


def check_modes(
    found: Floats, mechanism: Mechanism, poses: Pose, theory: Beams, torsion: bool = True
) -> ModeCheck:
    """Count a simulator's frequencies `found` (N, count) [Hz] against those of `theory`.

    A gap between two modes of the theory is left out where it is not `CLEAR` of how far the
    frequencies next to its ends are from these, or of what is usual at the pose: a mode without a
    partner does not excuse itself. Without `torsion` the theory's limbs do not twist either.
    """
    count = found.shape[1]
    exact = condensed_frequencies(
        mechanism, poses, count=count + 1 + SPARE, torsion=torsion, fast=False, **theory
    )
    away = np.abs(found[:, :, None] - exact[:, None, :])
    partner = away.argmin(axis=2)
    nearest = partner[..., None] == np.arange(exact.shape[1])
    deviation = np.where(nearest, away, 0.0).max(axis=1)[:, : count + 1]
    usual = np.median(away.min(axis=2) / np.take_along_axis(exact, partner, axis=1), axis=1)
    exact = exact[:, : count + 1]
    deviation = np.maximum(deviation, usual[:, None] * exact)
    gap = np.diff(exact)
    counted = gap > CLEAR * np.maximum(deviation[:, 1:], deviation[:, :-1])
    counted &= gap > REPEATED * exact[:, 1:]
    middle = (exact[:, 1:] + exact[:, :-1]) / 2
    right = mode_counts(mechanism, poses, middle, torsion=torsion, **theory)
    below = (found[:, None, :] < middle[:, :, None]).sum(axis=2)
    return ModeCheck(counted, counted & (below != right))
