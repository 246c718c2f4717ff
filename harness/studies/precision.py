"""Time against error: what an element costs and what it buys, for every model."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, pairwise
from typing import Any

import numpy as np

from analytic import Modes
from analytic.model import Model
from analytic.pairing import pair
from harness.bench import SPARE, Bench, Study, label
from harness.case import Case
from harness.causes import THEORIES
from harness.columns import laid_out
from harness.compare import failure_notes, percent, relative_error
from harness.figures import COLOURS, panels
from harness.presets import PAPER_ELEMENTS, solid_truth
from harness.request import Option, Plan, Request, whole
from harness.result import Result
from harness.rows import mode_rows, settings
from harness.signatures import Array, Figure
from harness.tables import Table
from harness.timing import Spent, Timed, Timings, Way, time_ways
from harness.unbeaten import Mark, draw, unbeaten
from reference_models import Named
from reference_models.richardson import extrapolated

COUNT = 6
GROUPS = {"f1-f3": 3, "f1-f6": 6}
"""The modes that an error is the worst of."""
OWN, SOLID = "own theory", "solids"
"""The kinds of error: against the limit of the model's own theory, and against solids."""
TARGETS = (1.0, 0.1, 0.01)
"""Errors [%] that a user may be content with."""
STEPS = (1, 2, 3, 4, 8, 16, 32)
"""Elements of beams."""
LEAST = 1e-9
"""Errors are drawn no smaller than this [%]: below it is rounding."""
BATCH = 100
"""Poses a call of models that take many at once."""
SOLVERS = ("null-space", "saddle-point")
DEFAULTS = {"references": "all"}
OPTIONS = (
    Option("rounds", "N", "How often everything is timed; default 3.", "3",
           whole("rounds", 1, 1000)),
)  # fmt: skip
EXTRA = 2 * SPARE
"""Modes solved for beyond COUNT, as extrapolation needs them."""


@dataclass(frozen=True)
class Point:
    """One way to solve a pose, with what it costs and how far off it is.

    Attributes: `method` and `size` in words; `model`; `seconds` a pose; `dofs`; `poses` a call, 0
    for one pose with its modes; `errors` by kind, (cases, COUNT) [%]: None, or no kind, where there
    is no such truth.
    """

    method: str
    size: str
    model: Model
    seconds: float
    dofs: int | None
    poses: int
    errors: Mapping[str, Array | None]

    def worst(self, kind: str, modes: int) -> float:
        """Return the largest error of the lowest `modes` at any case [%]; NaN without a truth."""
        errors = self.errors.get(kind)
        return float("nan") if errors is None else float(np.abs(errors[:, :modes]).max())

    @property
    def name(self) -> str:
        """The way in words, with its time."""
        ms = 1e3 * self.seconds
        time = f"{ms:.3g} ms" if ms < 1000 else f"{ms / 1000:.3g} s"
        return f"{Way(self.model).method}@{self.size}: {time}"


@dataclass(frozen=True)
class WorkPrecision(Result):
    """All points of one run: `study` of the truths, `timings` of the ways, `truth` of solids."""

    cases: tuple[Case, ...]
    points: tuple[Point, ...]
    study: Study
    timings: Timings
    truth: Named | None

    @property
    def kinds(self) -> dict[str, str]:
        """The kinds of error, and what each is taken against in words."""
        found = {OWN: "the exact limit of its own theory"}
        return found if self.truth is None else found | {SOLID: self.truth.label}

    @property
    def asked(self) -> list[tuple[str, str, str, int]]:
        """Every kind of error, what it is against, and every group with its number of modes."""
        return [
            (kind, against, group, modes)
            for kind, against in self.kinds.items()
            for group, modes in GROUPS.items()
        ]

    def known_to(self, kind: str, modes: int) -> float:
        """Return the truth's own uncertainty of the lowest `modes` at any case [%]."""
        if kind == OWN or self.truth is None:
            return 0.0
        found = (self.study.first(case, self.truth) for case in self.cases)
        return max(
            (100 * float((m.uncertainty / m.frequencies)[:modes].max())
             for m in found if m is not None and m.uncertainty is not None), default=0.0,
        )  # fmt: skip

    def front(self, kind: str, modes: int) -> list[Point]:
        """Return the points that nothing beats in both time and error, by ascending time."""
        known = (p for p in self.points if np.isfinite(p.worst(kind, modes)))
        return unbeaten(known, lambda p: (p.seconds, p.worst(kind, modes)))

    def cheapest(self, kind: str, modes: int, target: float, many: bool) -> Point | None:
        """Return the fastest way that is surely within `target` [%], or None."""
        unsure = self.known_to(kind, modes)
        good = (
            p
            for p in self.points
            if (p.poses > 1) == many and p.worst(kind, modes) + unsure <= target
        )
        return min(good, key=lambda p: p.seconds, default=None)

    def records(self) -> list[dict[str, Any]]:
        """Return one row a way: seconds, coordinates and its largest errors."""
        return [
            {
                "method": p.method, "elements": p.size, "poses_a_call": max(1, p.poses),
                "seconds_a_pose": p.seconds, "dofs": p.dofs,
                **{f"{group}_{kind.replace(' ', '_')}_percent": p.worst(kind, modes)
                   for kind, _, group, modes in self.asked},
            }
            for p in self.points
        ]  # fmt: skip

    def tables(self) -> dict[str, Table]:
        """Return the cheapest ways to a precision, and the front."""
        best = (
            (against, group, target,
             *("none" if p is None else p.name
               for many in (False, True) for p in [self.cheapest(kind, modes, target, many)]))
            for kind, against, group, modes in self.asked for target in TARGETS
        )  # fmt: skip
        notes = (
            "the fastest way whose error, with the truth's own uncertainty, stays below the target",
            f"time of a pose, matrices included; {self.timings.rounds} rounds, one BLAS thread",
            *(f"{method}: {why}" for method, why in self.timings.left_out.items()),
            *failure_notes(self.study),
        )
        front = (
            (against, group, p.method, p.size, 1e3 * p.seconds, p.worst(kind, modes))
            for kind, against, group, modes in self.asked for p in self.front(kind, modes)
        )  # fmt: skip
        about = dict.fromkeys(("Against", "Modes"))
        ways = {"Target [%]": 2, "One pose": None, f"{BATCH} poses a call": None}
        shown = {"Way": None, "Elements": None, "ms a pose": 4, "Largest error [%]": 6}
        return {
            "": laid_out("The cheapest way to a precision", about | ways, best, notes),
            "-front": laid_out("What nothing beats in time and error", about | shown, front),
        }

    def figures(self) -> dict[str, Figure]:
        """Return error against time, log-log: a column a group of modes, a row a truth.

        What nothing beats is drawn in colour and named; what is beaten is faint behind it.
        """
        title = (
            "Ways that nothing beats, for one pose (blue) and many poses a call (orange); "
            "grey: all others"
        )
        figure, grid = panels(title, len(self.kinds), len(GROUPS), (6, 5.2))
        for axes, (kind, against, group, modes) in zip(grid.flat, self.asked, strict=True):
            axes.set_title(f"{group}, against {against}", fontsize=10)
            axes.set_xlabel("time of a pose [ms]")
            found = [(p, p.worst(kind, modes)) for p in self.points]
            placed = [(Mark(1e3 * p.seconds, max(LEAST, error), label(p.model)), p.poses > 1)
                      for p, error in found if np.isfinite(error)]  # fmt: skip
            fronts = {
                colour: unbeaten((m for m, batch in placed if batch == many), lambda m: (m.x, m.y))
                for many, colour in ((False, COLOURS[0]), (True, COLOURS[3]))
            }
            draw(axes, [mark for mark, _ in placed], fronts, thin=True)
            axes.margins(x=0.5, y=0.1)  # names stand on either side of what is drawn
            if unsure := self.known_to(kind, modes):
                axes.axhspan(LEAST / 2, unsure, color="0.92", zorder=0)
                said = f"grey band: the truth is known to {percent(unsure)}"
                corner = {"ha": "right", "va": "bottom", "transform": axes.transAxes}
                axes.text(0.99, 0.01, said, fontsize=7, **corner)
                axes.set_ylim(bottom=unsure / 3)
        for axes in grid[:, 0]:
            axes.set_ylabel("largest error [%]")
        return {"": figure}

    def sentences(self) -> list[str]:
        """Return the cheapest way to 0.1 % of one pose, for each truth and all modes."""
        return [
            f"The cheapest way to 0.1 % of {against} on f1-f6: {best.name} a pose."
            for kind, against in self.kinds.items()
            if (best := self.cheapest(kind, COUNT, 0.1, many=False)) is not None
        ]

    def rows(self) -> list[dict[str, Any]]:
        """Return the truths' rows and one a timed way and mode; `solve_s` is its whole time."""
        timed = (timed_rows(one, self.cases, "work-precision") for one in self.timings.timed)
        return [*self.study.rows(), *chain.from_iterable(timed)]

    def failures(self) -> dict[str, str]:
        """Return what has no answer, and why."""
        return super().failures() | self.timings.failures


def timed_rows(one: Timed, cases: Sequence[Case], timed: str) -> list[dict[str, Any]]:
    """Return the rows of one timed way for the history: `build_s` is 0, `solve_s` all of it."""
    rows = []
    for answer, case in zip(one.answers, cases, strict=True):
        if isinstance(answer, Modes):
            count = len(answer.frequencies)
            chosen = settings(one.way.model, count, way=one.way.method, timed=timed)
            found = mode_rows(case, label(one.way.model), chosen, answer, min(COUNT, count))
            rows += [row | {"build_s": 0.0, "solve_s": one.median()} for row in found]
    return rows


def every_way(theory: Named, references: Sequence[Named], steps: Sequence[int]) -> list[Way]:
    """Return all ways: the paper's model and its rivals, exact limbs, condensed, simulators."""
    ways: list[Way] = []
    shear = tuple(pair for pair in theory.settings if pair[0] == "shear")
    for name in THEORIES:
        own = shear if name == THEORIES[-1] else ()
        ways += [Way(Named(name, s, own)) for s in (*steps, None)]
        one = tuple(sorted((("beam", name), *own)))
        ways += [Way(Named("condensed", s, one), 1) for s in (*steps, None)]
        ways += [Way(Named("condensed", s, one), BATCH) for s in (PAPER_ELEMENTS, None)]
    for solver in SOLVERS:
        ways += [Way(Named("multipliers", s, (("solver", solver),))) for s in steps]
    for reference in references:
        info = reference.info()
        meshes = steps if info.limit else info.ladder
        ways += [Way(replace(reference, elements=n)) for n in meshes]
        if not info.isolated:
            ways.append(Way(reference, BATCH))
    return list(dict.fromkeys(ways))


def work_precision(
    cases: Sequence[Case], ways: Sequence[Way], truth: Named | None, rounds: int, bench: Bench
) -> WorkPrecision:
    """Time every way at `cases` and set its errors beside it; `truth`: what stands for solids."""
    limits = [limit for way in ways if (limit := way.model.limit()) is not None]
    study = bench.run(cases, [*limits, *([] if truth is None else [truth])], COUNT)
    cases = study.complete(*study.models) or study.cases
    timings = time_ways(bench, ways, cases, rounds, COUNT + EXTRA)
    points = []
    for one in (*timings.timed, *_extrapolated(timings, cases)):
        way, errors = one.way, dict[str, Array | None]()
        for kind, against in ((OWN, way.model.limit()), (SOLID, truth)):
            errors[kind] = None if against is None else _errors(one, cases, study, against, bench)
        seconds, dofs = one.median(), one.dofs
        points.append(Point(way.method, way.size, way.model, seconds, dofs, way.poses, errors))
    place = [*dict.fromkeys(way.method for way in ways)]
    points.sort(key=lambda point: place.index(point.method))
    return WorkPrecision(tuple(cases), tuple(points), study, timings, truth)


def run(request: Request, bench: Bench) -> WorkPrecision:
    """Return time against error of every way at the cases."""
    ways = every_way(request.theory, request.references, request.elements or STEPS)
    return work_precision(request.cases, ways, solid_truth(), request.options["rounds"], bench)


def jobs(plan: Plan) -> dict[str, Request]:
    """Return what the main job asks."""
    return {"work-precision": plan.request()}


def _extrapolated(timings: Timings, cases: Sequence[Case]) -> list[Timed]:
    """Return neighbouring meshes of each simulator, extrapolated: their times add up."""
    found = []
    for coarse, fine in pairwise(timings.timed):
        a, b = coarse.way.model.elements, fine.way.model.elements
        info = fine.way.model.info()
        same = coarse.way.method == fine.way.method and info.refinements is not None
        if not (same and isinstance(a, int) and isinstance(b, int)):
            continue
        answers = tuple(
            extrapolated(x, y.first(COUNT + SPARE), (a, b), info.order, c.mechanism, c.pose, COUNT)
            for c, x, y in zip(cases, coarse.answers, fine.answers, strict=True)
            if isinstance(x, Modes) and isinstance(y, Modes)
        )
        rounds = tuple(
            Spent(x.seconds + y.seconds, np.nan, np.nan, answers)
            for x, y in zip(coarse.rounds, fine.rounds, strict=False)
        )
        model = replace(fine.way.model, elements=(a, b))  # type: ignore[type-var]
        found.append(Timed(Way(model), rounds[0], rounds))
    return found


def _errors(
    one: Timed, cases: Sequence[Case], study: Study, truth: Model, bench: Bench
) -> Array | None:
    """Return 100 (f / f_truth - 1) [%] for each mode of the truth, partners found by shape."""
    rows = []
    for case, answer in zip(cases, one.answers, strict=True):
        exact = study.first(case, truth)
        shaped: object = answer
        found: Any = getattr(answer, "frequencies", answer)
        if not isinstance(answer, Modes):
            # Frequencies alone have the shapes of the same model, asked for its modes.
            shaped = bench.solve(one.way.model, case.mechanism, case.pose, COUNT + SPARE)
        if exact is None or not isinstance(shaped, Modes):
            return None
        partner = pair(exact, shaped, case.mechanism, case.pose).partner
        rows.append(relative_error(found[partner], exact.frequencies))
    return np.array(rows)
