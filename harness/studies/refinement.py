"""Grid convergence done properly: observed order, Richardson limit and GCI from three meshes.

Roache's grid convergence index as Celik et al. report it (J. Fluids Eng. 130, 078001, 2008).
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from analytic import InputError
from harness.bench import Bench, Study, label
from harness.case import Case
from harness.causes import THEORIES, exact
from harness.compare import cell, cells, failure_notes, largest, match, percent, relative_error
from harness.request import Plan, Request
from harness.result import Result
from harness.tables import Number, Table
from reference_models import Named

MESHES = 3
"""Meshes that an order, a limit and a band are read from."""
SAFETY, WARY = 1.25, 3.0
"""Roache's factors: on three meshes in the asymptotic range, and anywhere else."""
ASYMPTOTIC = 0.25
"""Largest relative difference of observed and formal order in the asymptotic range."""
FREE = 1e-5
"""Frequencies below this part of the largest may be the rounding of a free motion, of 0 Hz."""
ROUNDING = 1e-10
"""Relative steps below this are rounding; nothing can be read from them."""


class Verification(NamedTuple):
    """What three meshes say of one frequency.

    Attributes: `frequencies` on every mesh [Hz]; observed `order` p (NaN if it cannot be read);
    Richardson `limit` [Hz]; `gci`, the half-width of the band around the finest value that should
    hold the limit [Hz]; `monotone`: both steps have one sign; `asymptotic`: p is within 25 % of the
    formal order; `converged`: the last step is rounding.
    """

    frequencies: tuple[float, ...]
    order: float
    limit: float
    gci: float
    monotone: bool
    asymptotic: bool
    converged: bool

    @property
    def remark(self) -> str:
        """What a reader must know before believing the limit."""
        if self.converged:
            return "converged to rounding"
        if not self.monotone:
            return "not monotone: no limit"
        return "" if self.asymptotic else "not in the asymptotic range"

    @property
    def band(self) -> float:
        """The GCI, relative to the finest value [%]; NaN at 0 Hz."""
        return 100 * self.gci / self.frequencies[-1] if self.frequencies[-1] else math.nan


def verify(elements: Sequence[int], frequencies: Sequence[float], formal: float) -> Verification:
    """Return order, limit and GCI from the last three of ascending `elements`.

    p solves (f_1 - f_2) / (f_2 - f_3) = r_21^p (r_32^p - 1) / (r_21^p - 1), with f_3 the finest;
    limit = f_3 + (f_3 - f_2) / (r_32^p - 1), never below zero; GCI = F_s |f_3 - f_2| / (r_32^p -
    1), with F_s = 1.25, or 3 and the lower of observed and formal order outside the asymptotic
    range.
    """
    (n1, n2, n3), (f1, f2, f3) = elements[-MESHES:], frequencies[-MESHES:]
    first, last, fine = f2 - f1, f3 - f2, n3 / n2
    if abs(last) <= ROUNDING * abs(f3):
        return Verification(tuple(frequencies), math.nan, f3, abs(last), True, False, True)
    monotone = first * last > 0
    order = _order(first / last, fine, n2 / n1) if monotone else math.nan
    asymptotic = bool(abs(order - formal) <= ASYMPTOTIC * formal)
    # Outside the asymptotic range the lower order is the careful one.
    trusted = order if asymptotic else float(np.nanmin([order, formal]))
    step = last / (fine**trusted - 1)
    gci = (SAFETY if asymptotic else WARY) * abs(step)
    limit = max(f3 + step, 0.0) if monotone else f3
    return Verification(tuple(frequencies), order, limit, gci, monotone, asymptotic, False)


def _order(ratio: float, fine: float, coarse: float) -> float:
    """Return p for a `ratio` of steps; NaN if none between 0.05 and 20 gives it."""
    from scipy.optimize import brentq

    def excess(p: float) -> float:
        return math.log(ratio) - math.log(fine**p * (coarse**p - 1) / (fine**p - 1))

    low, high = 0.05, 20.0
    if excess(low) * excess(high) > 0:
        return math.nan
    return float(brentq(excess, low, high))


Ladder = tuple[Named, ...]
"""One model on ascending meshes."""


def ladder(model: Named, elements: Sequence[int] | None = None) -> Ladder:
    """Return `model` on at least three meshes: those given, or those it is watched on.

    A model that is asked for extrapolated from two meshes of one's own stands on these and on half
    the coarser. Raises `InputError` for fewer than three.
    """
    if elements is None:
        own, info = model.elements, model.info()
        elements = info.ladder
        if isinstance(own, tuple) and (own != info.refinements or len(elements) < MESHES):
            elements = (own[0] // 2, *own)
    if len(elements) < MESHES or min(elements) < 1:
        given = ",".join(map(str, elements))
        raise InputError("elements", given, "three numbers at least, to read an order from")
    return tuple(replace(model, elements=n) for n in elements)


def verified(study: Study, steps: Ladder) -> dict[tuple[Case, int], Verification]:
    """Return what each mode's frequencies on the ladder say, by case and mode from 1.

    Modes are numbered by the finest mesh and followed by their shape; a case at which any mesh
    failed is left out.
    """
    elements = [model.elements for model in steps if isinstance(model.elements, int)]
    formal, found = steps[-1].info().order, {}
    for case in study.complete(*steps):
        known = [one for model in steps[:-1] if (one := match(study, case, steps[-1], model))]
        rows = [*(one.against for one in known), known[0].ours]
        for i, values in enumerate(np.array(rows).T.tolist(), 1):
            found[case, i] = verify(elements, values, formal)
    return found


@dataclass(frozen=True)
class Family:
    """One model on its ladder `steps`: what its frequencies say, `seen` by case and mode from 1.

    `exact`: the frequency [Hz] of the same mode in the exact limit of the theory that the model
    declares; a mode that looks like none of the limit's is left out.
    """

    steps: Ladder
    seen: Mapping[tuple[Case, int], Verification]
    exact: Mapping[tuple[Case, int], float]

    @classmethod
    def of(cls, study: Study, steps: Ladder) -> "Family":
        """Return it."""
        limit, exact = steps[-1].limit(), dict[tuple[Case, int], float]()
        for case in study.complete(*steps):
            if limit is not None and (found := match(study, case, steps[-1], limit)):
                for i in np.flatnonzero(~found.pairing.doubtful).tolist():
                    exact[case, i + 1] = float(found.against[i])
        return cls(steps, verified(study, steps), exact)

    @property
    def name(self) -> str:
        """What the models of the ladder are called together."""
        return self.steps[-1].label if self.steps[-1].settings else self.steps[-1].name

    @property
    def meshes(self) -> str:
        """The numbers of elements in words."""
        return ", ".join(str(model.elements) for model in self.steps)

    @property
    def formal(self) -> float:
        """The order in theory."""
        return self.steps[-1].info().order

    @property
    def summary(self) -> tuple[float, float, float, float, str]:
        """The least and the largest observed order, the widest band of a mode [%], how far limits
        lie from exact ones at most [%], NaN where not known; how many frequencies have a warning.
        """
        orders = [one.order for one in self.seen.values()]
        low, high = (float(end.reduce(orders, initial=np.nan)) for end in (np.fmin, np.fmax))
        limits = [self.seen[key].limit for key in self.exact]
        off = largest(relative_error(limits, [*self.exact.values()]))
        warned = sum(bool(one.remark) and not one.converged for one in self.seen.values())
        band = largest([one.band for one in self.seen.values()])
        return low, high, band, off, f"{warned} of {len(self.seen)}"

    def misses(self) -> dict[Case, list[str]]:
        """Return the modes whose limit lies further from the exact one than its band, by case."""
        most, wrong = max(self.exact.values(), default=0.0), dict[Case, list[str]]()
        for (case, i), truth in self.exact.items():
            say = self.seen[case, i]
            if abs(say.limit - truth) > say.gci + (ROUNDING * truth if truth else FREE * most):
                wrong.setdefault(case, []).append(
                    f"f{i} = {say.limit:.6g} Hz for {truth:.6g} Hz, with a GCI of {say.gci:.2g} Hz"
                )
        return wrong

    def table(self, study: Study, shown: Sequence[int]) -> Table:
        """Return the ladder's frequencies with their observed order, limit, GCI and warnings."""
        rows = [
            (case.name, f"f{i}", *map(Number, one.frequencies), cell(one.order),
             Number(one.limit), cell(one.band, 4), one.remark)
            for (case, i), one in self.seen.items() if i in shown
        ]  # fmt: skip
        columns = ("Case", "Mode", *(f"{model.elements} [Hz]" for model in self.steps), "order",
                   "limit [Hz]", "GCI [%]", "Remark")  # fmt: skip
        notes = [f"formal order of {self.name}: {self.formal:g}", *failure_notes(study)]
        title = f"{self.name}: frequencies against elements a limb, and their limit"
        return Table(title, columns, rows, notes)


@dataclass(frozen=True)
class Refinement(Result):
    """Models on their meshes at the cases of `study`; `shown`: mode numbers from 1."""

    study: Study
    families: tuple[Family, ...]
    shown: tuple[int, ...]

    def failures(self) -> dict[str, str]:
        """Return what has no answer, and what converges to another theory than it says."""
        said = "it does not converge to the theory it declares"
        return super().failures() | {
            f"{label(one.steps[-1])} at {case.name}": f"{said}: {'; '.join(wrong)}"
            for one in self.families for case, wrong in one.misses().items()
        }  # fmt: skip

    def records(self) -> Iterator[dict[str, Any]]:
        """Return one row a case, model and mode: order, limit, GCI and the exact limit."""
        for family in self.families:
            for (case, i), one in family.seen.items():
                if i in self.shown:
                    yield {
                        "case": case.name, "model": family.name,
                        "elements": family.steps[-1].elements, "mode": i,
                        "frequency_hz": one.frequencies[-1], "formal_order": family.formal,
                        "order": one.order, "limit_hz": one.limit, "gci_hz": one.gci,
                        "exact_hz": family.exact.get((case, i), math.nan), "remark": one.remark,
                    }  # fmt: skip

    def tables(self) -> dict[str, Table]:
        """Return one table of all models, and one a model: mode by mode."""
        rows = []
        for one in self.families:
            *orders, band, off, warned = one.summary
            rows.append(
                (
                    one.name,
                    one.meshes,
                    f"{one.formal:g}",
                    *cells(orders),
                    cell(band, 4),
                    cell(off, 4),
                    warned,
                )
            )
        columns = ("Model", "Elements", "formal order", "least", "largest order", "GCI [%]",
                   "from its exact limit [%]", "Warnings")  # fmt: skip
        notes = (
            "GCI: the largest of all modes and cases, of the finest mesh",
            "from its exact limit: how far the limit read from the meshes lies from that of the "
            "theory that the model declares",
            *failure_notes(self.study),
        )
        every = {f"-{one.name}": one.table(self.study, self.shown) for one in self.families}
        return {"": Table("Models on their ladders", columns, rows, notes)} | every

    def sentences(self) -> list[str]:
        """Return each model's observed orders, widest band, and how often there is a warning."""
        lines = []
        for one in self.families:
            if not one.seen:
                continue
            low, high, band, off, warned = one.summary
            known = "not to be read" if math.isnan(low) else f"{low:.2f} to {high:.2f}"
            meets = f"; its limit lies {percent(off, 'at most ')} from the exact one"
            lines.append(
                f"{one.name}, {one.meshes} elements: order {known} (in theory {one.formal:g}), GCI "
                f"{percent(band, 'at most ')} of the finest, {warned} frequencies with a "
                f"warning{'' if math.isnan(off) else meets}."
            )
        return lines


def run(request: Request, bench: Bench) -> Refinement:
    """Return the theory and every reference on three meshes or more, beside their exact limits.

    Without elements each model has its own; NAME@N1+N2 stands on these two and half the coarser.
    """
    models = dict.fromkeys((request.theory, *request.references))
    ladders = dict.fromkeys(ladder(model, request.elements) for model in models)
    every = [model for steps in ladders for model in steps]
    limits = [limit for steps in ladders if (limit := steps[-1].limit()) is not None]
    study = bench.run(request.cases, [*every, *limits], request.count)
    families = tuple(Family.of(study, steps) for steps in ladders)
    return Refinement(study, families, request.shown)


def jobs(plan: Plan) -> dict[str, Request]:
    """Return what the main job asks: every beam theory and every reference on its ladder."""
    theories = [exact(name, plan.theory) for name in THEORIES]
    return {"refinement": plan.request(references=(*theories, *plan.references))}
