"""Work-precision as tables and a figure: what each model costs, and the cheapest way to a target.

A target counts as met only where the error and the truth's own uncertainty together stay below it,
and where the limit of the model's theory meets it too: coarse meshes whose error happens to cancel
their theory's are not precise.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analytic.theory import BEAMS
from harness.figures import figure_files
from harness.precision.cost import ENDLESS, FEW, SLOW
from harness.precision.figure import precision_figure
from harness.precision.ways import BATCH, theory_of
from harness.precision.work_precision import (
    GROUPS,
    OWN,
    SOLID,
    Point,
    Truth,
    WorkPrecision,
    milliseconds,
    worst,
)
from harness.tables import Cell, Number, Table, table_files

TARGETS = (1.0, 0.1, 0.01)
"""What the cheapest way is sought to [%]."""
KINDS = {"batch": f"{BATCH} poses a call", "single": "one pose", "simulator": "simulator"}


def cheapest(points: Sequence[Point]) -> Point | None:
    """Return the point of least time; of those no slower by their quartiles, the plainest.

    That is one without elements, else with the fewest, of the same method.
    """
    best = min(points, key=milliseconds, default=None)
    if best is None:
        return None
    limit = np.percentile(best.seconds, 75)
    equal = [p for p in points if p.method == best.method
             and np.percentile(p.seconds, 25) <= limit]  # fmt: skip
    return min(equal, key=lambda point: int(np.sum(point.spec.elements or 0)))


def precision_tables(result: WorkPrecision) -> dict[str, Table]:
    """Return all tables by the stem of their files."""
    return {
        "work-precision": points_table(result),
        "cheapest": cheapest_table(result),
        "cheapest-models": models_table(result),
    }


def precision_files(result: WorkPrecision) -> dict[str, bytes]:
    """Return all tables and the figure as files to write."""
    figure = figure_files(precision_figure(result), "work-precision")
    return figure | table_files(precision_tables(result))


def precision_sentences(result: WorkPrecision) -> list[str]:
    """Return the floors that no mesh lowers, and what the cheapest ways take."""
    lines = []
    if result.solid is not None:
        floors = [
            f"{theory} {worst(floor, 3):.2g} % on f1-f3 and {worst(floor, 6):.2g} % on f1-f6"
            for theory, floor in result.floors.items()
            if theory in BEAMS
        ]
        lines.append(
            f"Against solids ({result.solid.spec.label}, known to "
            f"{result.solid.uncertainty(6):.2g} %) the theories without elements are off by up to: "
            f"{'; '.join(floors)}. No number of elements removes that."
        )
    for method in ("substructure, euler-bernoulli", "exudyn-cable", "exudyn-beam"):
        points = [point for point in result.points if point.method == method]
        if points:
            needs = [
                f"{target:g} % with {verdict(result, points, OWN, 6, target)}" for target in TARGETS
            ]
            lines.append(f"{method} meets its own theory's limit on f1-f6 to {', '.join(needs)}.")
    return lines


def points_table(result: WorkPrecision) -> Table:
    """Return every model with every number of elements: errors, time and dofs."""
    both = " and ".join(case.name for case in result.cases)
    rows: list[tuple[Cell, ...]] = []
    for point in result.points:
        times = [Number(float(q), 4) for q in 1e3 * np.percentile(point.seconds, [50, 25, 75])]
        for group, modes in GROUPS.items():
            unsure = 0.0 if result.solid is None else result.solid.uncertainty(modes)
            rows.append(
                (both, point.method, theory_of(point.spec), point.elements, group,
                 _error(point, result.limits.get(theory_of(point.spec)), point.own, modes),
                 _error(point, result.solid, point.solid, modes), Number(unsure, 4), *times,
                 len(point.seconds), "-" if point.dofs is None else point.dofs)
            )  # fmt: skip
    columns = (
        "Case", "Model", "Theory", "Elements", "Modes", "Error own theory [%]", "Error 3-D [%]",
        "3-D uncertainty [%]", "ms a pose", "q1 [ms]", "q3 [ms]", "rounds", "dofs",
    )  # fmt: skip
    return Table("Work and precision of every model", columns, tuple(rows), _notes(result))


def _error(
    point: Point, truth: Truth | None, errors: NDArray[np.float64] | None, modes: int
) -> Cell:
    if truth is None:
        return "not known"
    return (
        "is the truth"
        if point.spec == truth.spec and point.kind == "simulator"
        else Number(worst(errors, modes), 4)
    )


def _notes(result: WorkPrecision) -> tuple[str, ...]:
    solid = "none can run here"
    if result.solid is not None:
        solid = f"{result.solid.spec.label} ({_version(result.solid)})"
    limits = "; ".join(
        f"{theory}: {truth.spec.label}, known to {truth.uncertainty(max(GROUPS.values())):.2g} %"
        for theory, truth in result.limits.items()
        if theory not in BEAMS
    )
    floors = "; ".join(
        f"{theory} {worst(floor, GROUPS['f1-f3']):.2g} %, {worst(floor, GROUPS['f1-f6']):.2g} %"
        for theory, floor in result.floors.items()
    )
    return (
        "errors: largest of the modes over all cases; 'own theory': against the exact limit of the "
        "model's own beam theory (discretisation alone), or for solids " + (limits or "none"),
        f"3-D truth: {solid}; from it, on f1-f3 and f1-f6, lie the limits of: {floors or 'none'}",
        f"times: a pose's share of solving all cases, {result.repeats} rounds of everything ({FEW} "
        f"of what takes over {SLOW:g} s, 1 over {ENDLESS:g} s), one BLAS thread, each run at poses "
        "not met before; extrapolated meshes: the sum of both",
        *(f"{model}: {why}" for model, why in result.left_out.items()),
        *(f"{label} failed at {case}: {why}" for (case, label), why in result.failures.items()),
    )


def _version(truth: Truth) -> str:
    return next(iter(truth.modes.values())).version


def cheapest_table(result: WorkPrecision) -> Table:
    """Return the cheapest way to each target: of all, of one pose a call, of the simulators."""
    rows: list[tuple[Cell, ...]] = []
    for kind, theory in _truths(result):
        truth = result.limits[theory] if kind == OWN else result.solid
        for group, modes in GROUPS.items():
            for target in TARGETS:
                cells: list[Cell] = []
                for way in KINDS:
                    points = [
                        p for p in result.points
                        if p.kind == way and (kind == SOLID or theory_of(p.spec) == theory)
                    ]  # fmt: skip
                    good = [p for p in points if meets(result, p, kind, modes, target)]
                    best = cheapest(good)
                    cells.append("none" if best is None else _named(best))
                unsure = 0.0 if truth is None else truth.uncertainty(modes)
                name = f"{SOLID} ({theory})" if kind == SOLID else theory
                rows.append((name, Number(unsure, 3), group, Number(target, 2), *cells))
    columns = ("Truth", "known to [%]", "Modes", "Target [%]", *KINDS.values())
    notes = (
        "a theory's name: errors are against its own limit, by models of that theory; 3-D: against "
        "solids, by any model",
        "none: see cheapest-models for the reason: a theory's floor, or a truth not known so well",
        *_notes(result)[2:3],
    )
    return Table("The cheapest way to 1, 0.1 and 0.01 %", columns, tuple(rows), notes)


def models_table(result: WorkPrecision) -> Table:
    """Return what each model needs for each target, or why it cannot meet it."""
    rows: list[tuple[Cell, ...]] = []
    for kind in (OWN, SOLID) if result.solid is not None else (OWN,):
        for group, modes in GROUPS.items():
            for method in dict.fromkeys(point.method for point in result.points):
                points = [point for point in result.points if point.method == method]
                cells = [verdict(result, points, kind, modes, target) for target in TARGETS]
                rows.append((kind, group, method, *cells))
    columns = ("Truth", "Modes", "Model", *(f"to {target:g} %" for target in TARGETS))
    notes = (
        "elements and ms a pose; floor: error of the theory without elements, which no mesh lowers",
        *_notes(result),
    )
    return Table("What each model needs for 1, 0.1 and 0.01 %", columns, tuple(rows), notes)


def verdict(
    result: WorkPrecision, points: Sequence[Point], kind: str, modes: int, target: float
) -> str:
    """Return the cheapest of one model's `points` that meets `target`, or why none does."""
    theory = theory_of(points[0].spec)
    truth = result.limits.get(theory) if kind == OWN else result.solid
    if truth is None:
        return "no truth"
    unsure, floor = truth.uncertainty(modes), _floor(result, theory, kind, modes)
    best = cheapest([point for point in points if meets(result, point, kind, modes, target)])
    if best is not None:
        return f"{best.elements}: {_time(best)}"
    if floor - unsure > target:
        return f"not reachable: floor {floor:.2g} %"
    closest = min(points, key=lambda point: worst(point.errors(kind), modes))
    error = worst(closest.errors(kind), modes)
    if min(floor, error) - unsure <= target < max(floor, error) + unsure and unsure > 0:
        return f"undecided: {closest.elements} is off by {error:.2g} +- {unsure:.2g} %"
    return f"no: {closest.elements} is off by {error:.2g} %"


def meets(result: WorkPrecision, point: Point, kind: str, modes: int, target: float) -> bool:
    """Return whether `point`, and its theory without elements, are surely within `target` [%]."""
    theory, errors = theory_of(point.spec), point.errors(kind)
    truth = result.limits.get(theory) if kind == OWN else result.solid
    if truth is None or errors is None:
        return False
    larger = max(worst(errors, modes), _floor(result, theory, kind, modes))
    return larger + truth.uncertainty(modes) <= target


def _floor(result: WorkPrecision, theory: str, kind: str, modes: int) -> float:
    return 0.0 if kind == OWN else worst(result.floors.get(theory), modes)


def _truths(result: WorkPrecision) -> list[tuple[str, str]]:
    """Return each truth there is: the kind of error, and the theory whose limit it is."""
    solid = [] if result.solid is None else [theory_of(result.solid.spec)]
    own = [(OWN, theory) for theory in result.limits if theory not in solid]
    return own + [(SOLID, theory) for theory in solid]


def _time(point: Point) -> str:
    ms = milliseconds(point)
    return f"{ms:.3g} ms" if ms < 1000 else f"{ms / 1000:.3g} s"


def _named(point: Point) -> str:
    method = point.method.removesuffix(f", {BATCH} poses a call")
    return f"{method}@{point.elements}: {_time(point)}"
