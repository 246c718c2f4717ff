"""Time against error: what an element costs and what it buys, for every model of the bench."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import count, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic import Modes
from analytic.pairing import pair
from analytic.theory import BEAMS
from harness.cases import Case
from harness.models import Spec, parse
from harness.precision.cost import Job, Warm, sample, warm_up
from harness.precision.solved import Solved
from harness.precision.ways import COUNT, Way, every_way, theory_of
from harness.run import SPARE, Study, run
from reference_models.protocol import find
from reference_models.richardson import Richardson

Array = NDArray[np.float64]
GROUPS = {"f1-f3": 3, "f1-f6": 6}
"""The modes that an error is the worst of."""
OWN, SOLID = "own theory", "3-D"
"""The kinds of error: against the limit of the model's own theory, and against solids."""
STEPS = (1, 2, 3, 4, 8, 16, 32)
"""Elements of analytic models and simulators' beams."""
TIMED = "work-precision"
"""What the history calls this way of timing."""
SHIFT = 1e-12
"""How far apart [m] the heights of two timed runs are: nothing kept from one serves the next."""


@dataclass(frozen=True)
class Truth:
    """What errors are taken against: the `modes` of `spec`, by case name."""

    spec: Spec
    modes: dict[str, Modes]

    def uncertainty(self, modes: int) -> float:
        """Return the largest numerical uncertainty of the lowest `modes` at any case [%]."""
        found = [
            0.0 if m.uncertainty is None else float((m.uncertainty / m.frequencies)[:modes].max())
            for m in self.modes.values()
        ]
        return 100 * max(found)


@dataclass(frozen=True)
class Point:
    """One way to solve a pose, with one number of elements.

    Attributes: `method`, its name; `spec`, whose theory and elements it has; its `kind`, as in
    `Way`; `seconds` a pose, shape (rounds,); `dofs`, if any are assembled; `own` and `solid`:
    relative errors against the limit of its own theory and against the 3-D truth, shape
    (cases, COUNT) [%], None where there is no such truth.
    """

    method: str
    spec: Spec
    kind: str
    seconds: Array
    dofs: int | None
    own: Array | None
    solid: Array | None

    @property
    def elements(self) -> str:
        """The elements as text: "3", "8+16" or "exact"."""
        return self.spec.label.partition("@")[2]

    def errors(self, kind: str) -> Array | None:
        """Return the errors of one kind, `OWN` or `SOLID`."""
        return self.own if kind == OWN else self.solid


def worst(errors: Array | None, modes: int) -> float:
    """Return the largest error of the lowest `modes` over all cases [%]; NaN without a truth."""
    return float("nan") if errors is None else float(np.abs(errors[:, :modes]).max())


def milliseconds(point: Point) -> float:
    """Return the median time of a pose [ms]."""
    return 1e3 * float(np.median(point.seconds))


@dataclass(frozen=True)
class WorkPrecision:
    """All points of one run.

    Attributes: `limits` by theory; `floors`, the 3-D errors of these limits, by theory, shape
    (cases, COUNT) [%]; `solid`, the 3-D truth, if there is one; what was `left_out`; `failures` by
    (case, label); `study`, of the truths; `rows` of the points, for the history.
    """

    cases: tuple[Case, ...]
    points: tuple[Point, ...]
    limits: dict[str, Truth]
    floors: dict[str, Array]
    solid: Truth | None
    repeats: int
    left_out: dict[str, str]
    failures: dict[tuple[str, str], str]
    study: Study
    rows: list[dict[str, Any]]


def work_precision(
    cases: Sequence[Case],
    steps: Sequence[int],
    references: Sequence[str],
    truth: Spec | None,
    repeats: int,
    done: Callable[[str], None] = lambda _: None,
) -> WorkPrecision:
    """Time every way to solve `cases` and set its errors beside it.

    `steps`: elements of beams. `truth`: the solid model that 3-D errors are taken against. `done`
    hears of every truth and case, of the warm-up and of each of `repeats` rounds.
    """
    ways, left_out = every_way(steps, references)
    specs = truths(references, truth)
    study = run(cases, specs.values(), COUNT, done)
    limits = {}
    for theory, spec in specs.items():
        known = {c.name: m.first(COUNT) for c in cases if (m := study.get(c, spec)) is not None}
        if len(known) == len(cases):
            limits[theory] = Truth(spec, known)
    solid = None if truth is None else limits.get(theory_of(truth))

    by_job = {(way.method, way.spec.elements): way for way in ways}
    failures = dict(study.failures)
    warm = warm_up([_job(way, cases) for way in ways], {}, failures)
    done("warm-up")
    sample(warm, repeats, done)
    solved = [(by_job[w.job.model, w.job.size], w.answer, _seconds(w)) for w in warm]
    solved += _extrapolated(solved, cases)
    points = [
        _point(way, answers, seconds, cases, limits, solid) for way, answers, seconds in solved
    ]
    place = {method: k for k, method in enumerate(dict.fromkeys(way.method for way in ways))}
    points.sort(key=lambda point: place[point.method])
    floors = {}
    if solid is not None:
        for theory, limit in limits.items():
            answers = [limit.modes[case.name] for case in cases]
            floors[theory] = _errors(limit.spec, answers, cases, solid)
    rows = [row for one in solved for row in _rows(*one, cases)]
    return WorkPrecision(
        tuple(cases), tuple(points), limits, floors, solid, repeats, left_out, failures, study, rows
    )


def truths(references: Sequence[str], truth: Spec | None) -> dict[str, Spec]:
    """Return what stands for the limit of each theory: exact beams, solids extrapolated."""
    found = {name: Spec(name, None) for name in BEAMS}
    solids = [] if truth is None else [truth]
    for spec in (*solids, *(parse(name, "references") for name in references)):
        found.setdefault(theory_of(spec), spec)
    return found


def _job(way: Way, cases: Sequence[Case]) -> Job:
    """Return the job of solving every case, at heights a little different at each run."""
    runs = count()

    def solve() -> list[Modes | Array]:
        shift = SHIFT * next(runs)
        return [way.solve(case, replace(case.pose, z=case.pose.z + shift)) for case in cases]

    elements = way.spec.elements
    assert not isinstance(elements, tuple), "pairs are put together from their meshes"
    return Job(way.method, elements, solve, poses=way.poses * len(cases))


def _seconds(warm: Warm) -> Array:
    return np.array(list(warm.samples.values()))


@dataclass(frozen=True)
class _Mesh:
    """A mesh that has been solved, as `Richardson` asks for it."""

    elements: int
    answer: Modes

    def modes(self, mechanism: Any, pose: Any, count: int = 6) -> Modes:
        return self.answer.first(count)


Answered = tuple[Way, Sequence[Any], Array]


def _extrapolated(solved: Sequence[Answered], cases: Sequence[Case]) -> list[Answered]:
    """Return neighbouring meshes of each simulator, extrapolated: their times add up."""
    found: list[Answered] = []
    simulators = [one for one in solved if one[0].kind == "simulator"]
    for (coarse, first, short), (fine, second, long) in pairwise(simulators):
        a, b = coarse.spec.elements, fine.spec.elements
        if coarse.method != fine.method or not (isinstance(a, int) and isinstance(b, int)):
            continue
        order = find(fine.spec.name).info().order
        answers = [
            Richardson(_Mesh(a, x), _Mesh(b, y), order).modes(case.mechanism, case.pose, COUNT)  # type: ignore[arg-type]
            for case, x, y in zip(cases, first, second, strict=True)
        ]
        rounds = min(len(short), len(long))
        way = replace(fine, spec=replace(fine.spec, elements=(a, b)))
        found.append((way, answers, short[:rounds] + long[:rounds]))
    return found


def _point(
    way: Way,
    answers: Sequence[Modes | Array],
    seconds: Array,
    cases: Sequence[Case],
    limits: dict[str, Truth],
    solid: Truth | None,
) -> Point:
    limit, first = limits.get(theory_of(way.spec)), answers[0]
    return Point(
        method=way.method,
        spec=way.spec,
        kind=way.kind,
        seconds=seconds,
        dofs=first.dofs if isinstance(first, Modes) else None,
        own=None if limit is None else _errors(way.spec, answers, cases, limit),
        solid=None if solid is None else _errors(way.spec, answers, cases, solid),
    )


def _rows(
    way: Way, answers: Sequence[Modes | Array], seconds: Array, cases: Sequence[Case]
) -> list[dict[str, Any]]:
    many = way.poses if way.kind == "batch" else None
    return [
        row
        for case, answer in zip(cases, answers, strict=True)
        for row in Solved(way.spec, case, way.method, TIMED, many).rows(
            answer, float(np.median(seconds))
        )
    ]


def _errors(
    spec: Spec, answers: Sequence[Modes | Array], cases: Sequence[Case], truth: Truth
) -> Array:
    """Return 100 (f / f_truth - 1) [%] for each mode of the truth, partners found by shape."""
    rows = []
    for case, answer in zip(cases, answers, strict=True):
        exact, shaped = truth.modes[case.name], answer
        if not isinstance(shaped, Modes):
            # Frequencies alone have the shapes of the same model, assembled.
            shaped = spec.build().modes(case.mechanism, case.pose, COUNT + SPARE)
        frequencies = answer.frequencies if isinstance(answer, Modes) else answer
        partner = pair(exact, shaped, case.mechanism, case.pose).partner
        rows.append(100 * (frequencies[partner] / exact.frequencies - 1))
    return np.array(rows)
