"""How beam theory fares as rods grow stout: Euler-Bernoulli and Timoshenko against a reference."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, product
from typing import Any

import numpy as np

from analytic import InputError, Mechanism, Rod, Section, limbs_at
from analytic.mechanism import Item
from harness.bench import Bench, Study
from harness.case import Case
from harness.causes import THEORIES, exact
from harness.compare import at, cells, errors, failure_notes
from harness.figures import look, panels
from harness.presets import SOLIDS, quick
from harness.request import Plan, Request
from harness.result import Result
from harness.signatures import Array, Figure
from harness.tables import Number, Row, Table
from reference_models import Named

TAKES = ("cases", "case_file", "references", "modes", "shear")
DEFAULTS = {"references": SOLIDS[0]}
RATIOS = (0.05, 0.1, 0.15, 0.2)
"""Diameters over the mean limb length; the paper's rods are at 0.2."""


@dataclass(frozen=True)
class Slenderness(Result):
    """Exact beam `theories` against `reference` as d/L grows: `cases` with rods of all `ratios`.

    `study` behind the numbers; `shown`: mode numbers from 1; `errors` by case and theory and the
    reference's own `uncertainty` by case, (len(ratios), count) [%], NaN without an answer or at
    0 Hz.
    """

    cases: Sequence[Case]
    ratios: Sequence[float]
    theories: Sequence[Named]
    reference: Named
    study: Study
    shown: Sequence[int]
    errors: Mapping[tuple[Case, Named], Array]
    uncertainty: Mapping[Case, Array]

    def records(self) -> Iterator[dict[str, Any]]:
        """Return one row a case, theory, d/L and mode."""
        for (case, theory), found in self.errors.items():
            for (k, ratio), i in product(enumerate(self.ratios), self.shown):
                yield {
                    "case": case.name, "theory": theory.name, "reference": self.reference.label,
                    "diameter_over_length": ratio, "mode": i, "error_percent": found[k, i - 1],
                    "reference_uncertainty_percent": self.uncertainty[case][k, i - 1],
                }  # fmt: skip

    def tables(self) -> dict[str, Table]:
        """Return the errors [%] of the theories and the reference's own uncertainty at each d/L."""
        rows: list[Row] = []
        for case in self.cases:
            for k, ratio in enumerate(self.ratios):
                for theory in self.theories:
                    found = cells(at(self.errors[case, theory][k], self.shown), 3, signed=True)
                    rows.append((case.name, Number(ratio), theory.name, *found))
                own = cells(at(self.uncertainty[case][k], self.shown), 3, none="not known")
                rows.append((case.name, Number(ratio), "reference's own, +-", *own))
        about = "d is set for all limbs from their mean length; the theories are without elements"
        title = f"Beam theory against {self.reference.label} as d/L grows [%]"
        columns = ("Case", "d/L", "", *(f"e{i}" for i in self.shown))
        return {"": Table(title, columns, rows, [about, *failure_notes(self.study)])}

    def figures(self) -> dict[str, Figure]:
        """Return error against d/L: a row of panels a theory, a column a case."""
        title = f"Beam theory without elements against {self.reference.label}"
        size = len(self.theories), len(self.cases)
        figure, grid = panels(title, *size, (4.6, 3.4), sharex=True)
        for axes, (theory, case) in zip(grid.flat, product(self.theories, self.cases), strict=True):
            error, own = self.errors[case, theory], np.nan_to_num(self.uncertainty[case])
            for i in self.shown:
                axes.errorbar(self.ratios, error[:, i - 1], own[:, i - 1], capsize=2, **look(i))
            axes.axhline(0, color="0.4", lw=0.8)
            axes.grid(alpha=0.25)
            axes.set_title(f"{theory.name}, {case.heading}", fontsize=10)
            axes.set_xticks(self.ratios)
            if case == self.cases[0]:
                axes.set_ylabel("error [%]")
            if theory == self.theories[-1]:
                axes.set_xlabel("$d / L$")
        grid[0][0].legend(fontsize=8)
        return {"": figure}

    def sentences(self) -> list[str]:
        """Return every theory's largest error for the most slender and the stoutest rods."""
        lines = []
        for theory in reversed(self.theories):
            for k in dict.fromkeys((0, len(self.ratios) - 1)):
                error = np.abs([at(self.errors[c, theory][k], self.shown) for c in self.cases])
                own = np.array([at(self.uncertainty[c][k], self.shown) for c in self.cases])
                if np.isfinite(error).any():
                    worst = np.unravel_index(np.nanargmax(error), error.shape)
                    bar = f" +-{own[worst]:.1g}" if np.isfinite(own[worst]) else ""
                    lines.append(
                        f"At d/L = {self.ratios[k]:g} exact {theory.name} lies within "
                        f"{error[worst]:.2g}{bar} % of {self.reference.label}."
                    )
        return lines


def with_rods(case: Case, ratio: float) -> Case:
    """Return `case` with every rod's diameter `ratio` times the mean limb length, and named so.

    Bores grow in proportion. Raises `InputError` for a rod that is not round.
    """
    diameter = ratio * float(limbs_at(case.mechanism, case.pose).lengths.mean())

    def thick(item: Item) -> Item:
        if not isinstance(item, Rod):
            return item
        own = item.section.diameter
        if own is None:
            expected = "round rods to make as thick as d/L"
            raise InputError("cases", "a rod that is not round", expected)
        return replace(item, section=Section.round(diameter, diameter * item.section.bore / own))

    limbs = (replace(limb, chain=tuple(map(thick, limb.chain))) for limb in case.mechanism.limbs)
    stout = Mechanism(tuple(limbs), case.mechanism.platform)
    return replace(case, name=f"{case.name} d/L={ratio:.3g}", mechanism=stout)


def slenderness(
    cases: Sequence[Case],
    ratios: Sequence[float],
    theories: Sequence[Named],
    reference: Named,
    shown: Sequence[int],
    bench: Bench,
) -> Slenderness:
    """Return how far `theories` are from `reference` at each d/L, modes paired by shape."""
    stout = {case: [with_rods(case, ratio) for ratio in ratios] for case in cases}
    study = bench.run(chain(*stout.values()), [*theories, reference], max(shown))
    off = {(c, t): errors(study, t, reference, stout[c]) for c, t in product(cases, theories)}
    own = {c: errors(study, theories[-1], reference, stout[c], "own") for c in cases}
    return Slenderness(cases, ratios, theories, reference, study, shown, off, own)


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
