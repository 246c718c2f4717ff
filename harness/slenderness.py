"""How beam theory fares as rods grow stout: Euler-Bernoulli and Timoshenko against 3-D solids."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from analytic import Mechanism, Rod, limbs_at
from harness.cases import Case
from harness.compare import failure_notes, relative_error
from harness.figures import COLOURS, MARKERS
from harness.models import Spec
from harness.run import Study, run
from harness.tables import Cell, Number, Table

RATIOS = (0.05, 0.1, 0.15, 0.2)
THEORIES = ("euler-bernoulli", "timoshenko")


@dataclass(frozen=True)
class Slenderness:
    """Errors of exact beam theories against `reference` as d/L grows.

    `errors` by (case name, theory name), shape (len(ratios), count) [%], NaN where the reference
    failed; `uncertainty` of the reference by case name, the same shape [%].
    """

    cases: tuple[Case, ...]
    ratios: tuple[float, ...]
    reference: Spec
    errors: dict[tuple[str, str], NDArray[np.float64]]
    uncertainty: dict[str, NDArray[np.float64]]
    studies: tuple[Study, ...]


def with_rods(case: Case, ratio: float) -> Case:
    """Return `case` with every rod's diameter `ratio` times the mean limb length, and named so."""
    diameter = ratio * float(limbs_at(case.mechanism, case.pose).lengths.mean())
    limbs = tuple(
        replace(limb, rod=Rod(limb.rod.material, diameter)) for limb in case.mechanism.limbs
    )
    mechanism = Mechanism(limbs, case.mechanism.platform)
    return replace(case, name=f"{case.name} d/L={ratio:.3g}", mechanism=mechanism)


def slenderness(
    cases: Sequence[Case],
    ratios: Sequence[float],
    reference: Spec,
    count: int,
    done: Callable[[str], None] = lambda _: None,
) -> Slenderness:
    """Return how far the theories, without elements, are from `reference` at each d/L."""
    theories = [Spec(name, None, reference.shear) for name in THEORIES]
    shape = (len(ratios), count)
    errors = {(c.name, t): np.full(shape, np.nan) for c in cases for t in THEORIES}
    uncertainty = {case.name: np.full(shape, np.nan) for case in cases}
    studies = []
    for k, ratio in enumerate(ratios):
        study = run([with_rods(c, ratio) for c in cases], [*theories, reference], count, done)
        studies.append(study)
        for own, case in zip(cases, study.cases, strict=True):
            solid = study.get(case, reference)
            for theory in theories:
                pairing = study.pairing(case, theory, reference)
                if solid is None or pairing is None:
                    continue
                f = solid.frequencies[pairing.partner]
                ours = study.modes[case.name, theory.label].frequencies[:count]
                errors[own.name, theory.name][k] = relative_error(ours, f)
                if solid.uncertainty is not None:
                    uncertainty[own.name][k] = 100 * solid.uncertainty[pairing.partner] / f
    return Slenderness(tuple(cases), tuple(ratios), reference, errors, uncertainty, tuple(studies))


def slenderness_table(result: Slenderness, shown: Sequence[int]) -> Table:
    """Return the errors [%] of both theories and the reference's own uncertainty at each d/L."""
    rows: list[tuple[Cell, ...]] = []
    for case in result.cases:
        for k, ratio in enumerate(result.ratios):
            for theory in THEORIES:
                error = result.errors[case.name, theory][k]
                cells = [_cell(error[i - 1], signed=True) for i in shown]
                rows.append((case.name, Number(ratio, 3), theory, *cells))
            own = result.uncertainty[case.name][k]
            cells = [_cell(own[i - 1]) for i in shown]
            rows.append((case.name, Number(ratio, 3), "reference's own, +-", *cells))
    notes = ["d is set for all limbs from their mean length; both theories without elements"]
    notes += [note for study in result.studies for note in failure_notes(study)]
    title = f"Beam theory against {result.reference.label} as d/L grows [%]"
    return Table(title, ("Case", "d/L", "", *(f"e{i}" for i in shown)), tuple(rows), tuple(notes))


def _cell(value: float, *, signed: bool = False) -> Cell:
    return Number(float(value), 3, signed) if np.isfinite(value) else "not known"


def slenderness_figure(result: Slenderness, shown: Sequence[int]) -> Figure:
    """Return error against d/L: a row of panels a theory, a column a case."""
    size = (4.6 * len(result.cases), 3.4 * len(THEORIES))
    figure = Figure(figsize=size, layout="constrained")
    panels = figure.subplots(len(THEORIES), len(result.cases), squeeze=False, sharex=True)
    for theory, strip in zip(THEORIES, panels, strict=True):
        for case, axes in zip(result.cases, strip, strict=True):
            for i in shown:
                axes.errorbar(
                    result.ratios, result.errors[case.name, theory][:, i - 1],
                    np.nan_to_num(result.uncertainty[case.name][:, i - 1]),
                    color=COLOURS[(i - 1) % 6], marker=MARKERS[(i - 1) % 6],
                    markersize=9 - 4 * ((i - 1) % 2), lw=1.2, capsize=2, label=f"$e_{i}$",
                )  # fmt: skip
            axes.axhline(0, color="0.4", lw=0.8)
            axes.grid(alpha=0.25)
            axes.set_title(f"{theory}, {case.name}", fontsize=10)
            axes.set_xticks(result.ratios)
        strip[0].set_ylabel("error [%]")
    for axes in panels[-1]:
        axes.set_xlabel("$d / L$")
    panels[0][0].legend(fontsize=8)
    figure.suptitle(f"Beam theory without elements against {result.reference.label}", fontsize=10)
    return figure
