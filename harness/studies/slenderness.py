"""How beam theory fares as rods grow stout: Euler-Bernoulli and Timoshenko against a reference."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from analytic import Mechanism, Rod, limbs_at
from harness.bench import Bench, Study
from harness.cases import Case
from harness.causes import THEORIES, exact
from harness.compare import cells, failure_notes, percent, relative_error
from harness.figures import COLOURS, MARKERS
from harness.plan import Plan
from harness.presets import SOLIDS, quick
from harness.request import Request
from harness.result import Result
from harness.tables import Cell, Number, Table
from reference_models import Named

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
TAKES = ("cases", "case_file", "references", "modes", "shear")
DEFAULTS = {"references": SOLIDS[0]}
RATIOS = (0.05, 0.1, 0.15, 0.2)
"""Diameters over the mean limb length; the paper's rods are at 0.2."""


@dataclass(frozen=True)
class Slenderness(Result):
    """Errors of exact beam `theories` against `reference` as d/L grows.

    `errors` by case and theory, shape (len(ratios), count) [%], NaN where the reference failed or
    stands at 0 Hz; `uncertainty` of the reference by case, the same shape [%]; `study` behind
    them; `shown`: mode numbers from 1.
    """

    ratios: tuple[float, ...]
    theories: tuple[Named, ...]
    reference: Named
    errors: Mapping[tuple[Case, Named], Array]
    uncertainty: Mapping[Case, Array]
    study: Study
    shown: tuple[int, ...]

    @property
    def studies(self) -> tuple[Study, ...]:
        """What was solved for it."""
        return (self.study,)

    def to_frame(self) -> "pd.DataFrame":
        """Return one row a case, theory, d/L and mode."""
        import pandas as pd

        return pd.DataFrame([
            {
                "case": case.name,
                "theory": theory.name,
                "reference": self.reference.label,
                "diameter_over_length": ratio,
                "mode": i,
                "error_percent": errors[k, i - 1],
                "reference_uncertainty_percent": self.uncertainty[case][k, i - 1],
            }
            for (case, theory), errors in self.errors.items()
            for k, ratio in enumerate(self.ratios)
            for i in self.shown
        ])  # fmt: skip

    def tables(self) -> dict[str, Table]:
        """Return the errors [%] of the theories and the reference's own uncertainty at each d/L."""
        pick = [i - 1 for i in self.shown]
        rows: list[tuple[Cell, ...]] = []
        for case, uncertainty in self.uncertainty.items():
            for k, ratio in enumerate(self.ratios):
                for theory in self.theories:
                    found = cells(self.errors[case, theory][k][pick], 3, signed=True)
                    rows.append((case.name, Number(ratio, 3), theory.name, *found))
                own = ["not known" if np.isnan(x) else Number(x, 3) for x in uncertainty[k][pick]]
                rows.append((case.name, Number(ratio, 3), "reference's own, +-", *own))
        notes = [
            "d is set for all limbs from their mean length; the theories are without elements",
            *failure_notes(self.study),
        ]
        title = f"Beam theory against {self.reference.label} as d/L grows [%]"
        columns = ("Case", "d/L", "", *(f"e{i}" for i in self.shown))
        return {"": Table(title, columns, tuple(rows), tuple(notes))}

    def figures(self) -> "dict[str, Figure]":
        """Return error against d/L: a row of panels a theory, a column a case."""
        return {"": slenderness_figure(self)}

    def sentences(self) -> list[str]:
        """Return the largest errors of the theories for the most slender and the stoutest rods."""
        pick, lines = [i - 1 for i in self.shown], []
        for k in dict.fromkeys((0, len(self.ratios) - 1)):
            worst = []
            for theory in self.theories:
                found = np.array([self.errors[case, theory][k][pick] for case in self.uncertainty])
                if np.isfinite(found).any():
                    most = percent(float(np.nanmax(np.abs(found))))
                    worst.append(f"{most} (exact {theory.name})")
            if worst:
                lines.append(
                    f"At d/L = {self.ratios[k]:g} beam theory is up to {' and '.join(worst)} from "
                    f"{self.reference.label}."
                )
        return lines


def with_rods(case: Case, ratio: float) -> Case:
    """Return `case` with every rod's diameter `ratio` times the mean limb length, and named so."""
    diameter = ratio * float(limbs_at(case.mechanism, case.pose).lengths.mean())
    limbs = tuple(
        limb.with_rod(Rod.round(limb.rod.material, diameter)) for limb in case.mechanism.limbs
    )
    mechanism = Mechanism(limbs, case.mechanism.platform)
    return replace(case, name=f"{case.name} d/L={ratio:.3g}", mechanism=mechanism)


def slenderness(
    cases: Sequence[Case],
    ratios: Sequence[float],
    theories: Sequence[Named],
    reference: Named,
    shown: Sequence[int],
    bench: Bench,
) -> Slenderness:
    """Return how far `theories` are from `reference` at each d/L, modes paired by shape."""
    shape = (len(ratios), max(shown))
    stout = {(case, k): with_rods(case, ratio) for case in cases for k, ratio in enumerate(ratios)}
    study = bench.run(stout.values(), [*theories, reference], max(shown))
    errors = {(case, theory): np.full(shape, np.nan) for case in cases for theory in theories}
    uncertainty = {case: np.full(shape, np.nan) for case in cases}
    for (own, k), case in stout.items():
        for theory in theories:
            pairing = study.pairing(case, theory, reference)
            if pairing is None:
                continue
            against, ours = study.answers[case, reference], study.answers[case, theory]
            f = against.frequencies[pairing.partner]
            errors[own, theory][k] = relative_error(ours.frequencies[: study.count], f)
            if against.uncertainty is not None:
                width = f + against.uncertainty[pairing.partner]
                uncertainty[own][k] = relative_error(width, f)
    return Slenderness(
        tuple(ratios), tuple(theories), reference, errors, uncertainty, study, tuple(shown)
    )


def run(request: Request, bench: Bench) -> Slenderness:
    """Return how exact beam theories fare at d/L = 0.05, 0.1, 0.15 and 0.2.

    Against the first of --references; the cases' rods are made as thick as that asks for.
    """
    theories = [exact(name, request.theory) for name in (THEORIES[0], THEORIES[-1])]
    return slenderness(request.cases, RATIOS, theories, request.references[0], request.shown, bench)


def jobs(plan: Plan) -> dict[str, Request]:
    """Return what the main job asks: against a solid, by quick meshes of it, if one can run."""
    solid = plan.references[0] if plan.solid is None else quick(plan.solid)
    return {"slenderness": plan.request(references=(solid,))}


def slenderness_figure(result: Slenderness) -> "Figure":
    """Return error against d/L: a row of panels a theory, a column a case."""
    from matplotlib.figure import Figure

    cases = list(result.uncertainty)
    size = (4.6 * len(cases), 3.4 * len(result.theories))
    figure = Figure(figsize=size, layout="constrained")
    panels = figure.subplots(len(result.theories), len(cases), squeeze=False, sharex=True)
    for theory, strip in zip(result.theories, panels, strict=True):
        for case, axes in zip(cases, strip, strict=True):
            for i in result.shown:
                axes.errorbar(
                    result.ratios, result.errors[case, theory][:, i - 1],
                    np.nan_to_num(result.uncertainty[case][:, i - 1]),
                    color=COLOURS[(i - 1) % 6], marker=MARKERS[(i - 1) % 6],
                    markersize=9 - 4 * ((i - 1) % 2), lw=1.2, capsize=2, label=f"$e_{{{i}}}$",
                )  # fmt: skip
            axes.axhline(0, color="0.4", lw=0.8)
            axes.grid(alpha=0.25)
            axes.set_title(f"{theory.name}, {case.name}", fontsize=10)
            axes.set_xticks(result.ratios)
        strip[0].set_ylabel("error [%]")
    for axes in panels[-1]:
        axes.set_xlabel("$d / L$")
    panels[0][0].legend(fontsize=8)
    figure.suptitle(f"Beam theory without elements against {result.reference.label}", fontsize=10)
    return figure
