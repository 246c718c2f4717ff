"""Grid convergence done properly: observed order, Richardson limit and GCI from three meshes.

Roache's grid convergence index as Celik et al. report it (J. Fluids Eng. 130, 078001, 2008).
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from analytic import InputError
from analytic.pairing import pair
from harness.answer import FREE
from harness.bench import Bench, Study, label
from harness.cases import Case
from harness.causes import THEORIES, exact
from harness.compare import at_most, cell, failure_notes, relative_error
from harness.plan import Plan
from harness.request import Request
from harness.result import Result
from harness.tables import Cell, Number, Table
from reference_models import Named

if TYPE_CHECKING:
    import pandas as pd

MESHES = 3
"""Meshes that an order, a limit and a band are read from."""
SAFETY, WARY = 1.25, 3.0
"""Roache's factors: on three meshes in the asymptotic range, and anywhere else."""
ASYMPTOTIC = 0.25
"""Largest relative difference of observed and formal order in the asymptotic range."""
ROUNDING = 1e-10
"""Relative steps below this are rounding; nothing can be read from them."""


@dataclass(frozen=True)
class Verification:
    """What three meshes say of one frequency.

    Attributes: observed `order` p (NaN if it cannot be read); Richardson `limit` [Hz]; `gci`, the
    half-width of the band around the finest value that should hold the limit [Hz]; `monotone`:
    both steps have one sign; `asymptotic`: p is within 25 % of the formal order; `converged`: the
    last step is rounding.
    """

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


def verify(elements: Sequence[int], frequencies: Sequence[float], formal: float) -> Verification:
    """Return order, limit and GCI from the last three of ascending `elements`.

    p solves (f_1 - f_2) / (f_2 - f_3) = r_21^p (r_32^p - 1) / (r_21^p - 1), with f_3 the finest;
    limit = f_3 + (f_3 - f_2) / (r_32^p - 1), never below zero; GCI = F_s |f_3 - f_2| / (r_32^p -
    1), with F_s = 1.25, or 3 and the lower of observed and formal order outside the asymptotic
    range.
    """
    (n1, n2, n3), (f1, f2, f3) = elements[-MESHES:], frequencies[-MESHES:]
    first, last = f2 - f1, f3 - f2
    fine, coarse = n3 / n2, n2 / n1
    if abs(last) <= ROUNDING * abs(f3):
        return Verification(math.nan, f3, abs(last), True, False, True)
    monotone = first * last > 0
    order = _order(first / last, fine, coarse) if monotone else math.nan
    asymptotic = bool(abs(order - formal) <= ASYMPTOTIC * formal)
    # Outside the asymptotic range the lower order is the careful one.
    trusted = order if asymptotic else float(np.nanmin([order, formal]))
    step = last / (fine**trusted - 1)
    factor = SAFETY if asymptotic else WARY
    limit = max(f3 + step, 0.0) if monotone else f3
    return Verification(order, limit, factor * abs(step), monotone, asymptotic, False)


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
    own = model.elements
    if elements is None:
        info = model.info()
        elements = info.ladder
        if isinstance(own, tuple) and (own != info.refinements or len(elements) < MESHES):
            elements = (own[0] // 2, *own)
    if len(elements) < MESHES or min(elements) < 1:
        given = ",".join(map(str, elements))
        raise InputError("elements", given, "three numbers at least, to read an order from")
    return tuple(replace(model, elements=n) for n in elements)


@dataclass(frozen=True)
class Seen:
    """One mode on every mesh: its `frequencies` [Hz], and what the last three `say`."""

    frequencies: tuple[float, ...]
    say: Verification

    @property
    def band(self) -> float:
        """The GCI, relative to the finest value [%]; NaN at 0 Hz."""
        return 100 * self.say.gci / self.frequencies[-1] if self.frequencies[-1] else math.nan


def verified(study: Study, steps: Ladder) -> dict[tuple[Case, int], Seen]:
    """Return what each mode's frequencies on the ladder say, by case and mode from 1.

    Modes are numbered by the finest mesh and followed by their shape; a case at which any mesh
    failed is left out.
    """
    elements = [model.elements for model in steps if isinstance(model.elements, int)]
    formal, found = steps[-1].info().order, {}
    for case in study.complete(*steps):
        *coarser, finest = (study.answers[case, model] for model in steps)
        finest = finest.first(study.count)
        rows = [
            modes.frequencies[pair(finest, modes, case.mechanism, case.pose).partner]
            for modes in coarser
        ]
        for i, values in enumerate(np.array([*rows, finest.frequencies]).T.tolist(), 1):
            found[case, i] = Seen(tuple(values), verify(elements, values, formal))
    return found


@dataclass(frozen=True)
class Refinement(Result):
    """Models on `ladders` of meshes at the cases of `study`; `shown`: mode numbers from 1."""

    study: Study
    ladders: tuple[Ladder, ...]
    shown: tuple[int, ...]

    @property
    def studies(self) -> tuple[Study, ...]:
        """What was solved for it."""
        return (self.study,)

    @cached_property
    def found(self) -> Mapping[Ladder, Mapping[tuple[Case, int], Seen]]:
        """What each mode's frequencies say, by ladder, then by case and mode from 1."""
        return {steps: verified(self.study, steps) for steps in self.ladders}

    @cached_property
    def exact(self) -> Mapping[Ladder, Mapping[tuple[Case, int], float]]:
        """The frequency [Hz] of the same mode in the exact limit of the theory that it declares.

        A mode that looks like none of the limit's is left out.
        """
        found: dict[Ladder, dict[tuple[Case, int], float]] = {}
        for steps in self.ladders:
            limit, finest = steps[-1].limit(), steps[-1]
            own = found.setdefault(steps, {})
            if limit is None:
                continue
            for case in self.study.complete(limit, *steps):
                pairing = self.study.pairing(case, finest, limit)
                assert pairing is not None, "both have an answer"
                truth = self.study.answers[case, limit].frequencies[pairing.partner]
                own |= {
                    (case, i): float(f)
                    for i, f in enumerate(truth, 1)
                    if not pairing.doubtful[i - 1]
                }
        return found

    def misses(self) -> dict[tuple[Case, Named], str]:
        """Return which models do not converge to the theory they declare, by case and finest mesh.

        The limit read from their meshes lies further from the theory's exact one than its band.
        """
        wrong: dict[tuple[Case, Named], list[str]] = {}
        for steps, seen in self.found.items():
            largest = max(self.exact[steps].values(), default=0.0)
            for (case, i), truth in self.exact[steps].items():
                say = seen[case, i].say
                off = abs(say.limit - truth)
                if off > say.gci + (ROUNDING * truth if truth else FREE * largest):
                    wrong.setdefault((case, steps[-1]), []).append(
                        f"f{i} = {say.limit:.6g} Hz for {truth:.6g} Hz, with a GCI of "
                        f"{say.gci:.2g} Hz"
                    )
        return {
            key: "it does not converge to the theory it declares: " + "; ".join(found)
            for key, found in wrong.items()
        }

    def failures(self) -> dict[str, str]:
        """Return what has no answer, and what converges to another theory than it says."""
        missed = {
            f"{label(model)} at {case.name}": why for (case, model), why in self.misses().items()
        }
        return super().failures() | missed

    def to_frame(self) -> "pd.DataFrame":
        """Return one row a case, model and mode: order, limit, GCI and the exact limit."""
        import pandas as pd

        return pd.DataFrame([
            {
                "case": case.name,
                "model": family(steps),
                "elements": steps[-1].elements,
                "mode": i,
                "frequency_hz": one.frequencies[-1],
                "formal_order": steps[-1].info().order,
                "order": one.say.order,
                "limit_hz": one.say.limit,
                "gci_hz": one.say.gci,
                "exact_hz": self.exact[steps].get((case, i), math.nan),
                "remark": one.say.remark,
            }
            for steps, seen in self.found.items()
            for (case, i), one in seen.items()
            if i in self.shown
        ])  # fmt: skip

    def tables(self) -> dict[str, Table]:
        """Return one table of all models, and one a model: mode by mode."""
        return {"": self._overview()} | {
            f"-{family(steps)}": verification_table(self.study, steps, self.shown)
            for steps in self.ladders
        }

    def _overview(self) -> Table:
        rows: list[tuple[Cell, ...]] = []
        for steps, seen in self.found.items():
            orders = [one.say.order for one in seen.values() if math.isfinite(one.say.order)]
            span: list[Cell] = [Number(f(orders), 2) if orders else "-" for f in (min, max)]
            rows.append((
                family(steps),
                _meshes(steps),
                f"{steps[-1].info().order:g}",
                *span,
                cell(_largest(one.band for one in seen.values()), 4),
                cell(self._furthest(steps), 4),
                f"{_warned(seen.values())} of {len(seen)}",
            ))  # fmt: skip
        columns = ("Model", "Elements", "formal order", "least", "largest order", "GCI [%]",
                   "from its exact limit [%]", "Warnings")  # fmt: skip
        notes = (
            "GCI: the largest of all modes and cases, of the finest mesh",
            "from its exact limit: how far the limit read from the meshes lies from that of the "
            "theory that the model declares",
            *failure_notes(self.study),
        )  # fmt: skip
        return Table("Models on their ladders", columns, tuple(rows), notes)

    def _furthest(self, steps: Ladder) -> float:
        """Return how far the limits lie from the exact ones [%], at most; NaN without these."""
        seen = self.found[steps]
        return _largest(
            abs(float(relative_error(np.array(seen[key].say.limit), np.array(truth))))
            for key, truth in self.exact[steps].items()
        )

    def sentences(self) -> list[str]:
        """Return each model's observed orders, widest band, and how often there is a warning."""
        lines = []
        for steps, seen in self.found.items():
            if not seen:
                continue
            known = [one.say.order for one in seen.values() if math.isfinite(one.say.order)]
            span = f"{min(known):.2f} to {max(known):.2f}" if known else "not to be read"
            warned = _warned(seen.values())
            off = self._furthest(steps)
            meets = "" if math.isnan(off) else f"; its limit lies {at_most(off)} from the exact one"
            lines.append(
                f"{family(steps)}, {_meshes(steps)} elements: order {span} (in theory "
                f"{steps[-1].info().order:g}), GCI "
                f"{at_most(_largest(one.band for one in seen.values()))} of the finest, {warned} "
                f"of {len(seen)} frequencies with a warning{meets}."
            )
        return lines


def refine(
    cases: Sequence[Case], ladders: Sequence[Ladder], shown: Sequence[int], bench: Bench
) -> Refinement:
    """Return every ladder's frequencies at every case, beside the exact limits of theories."""
    meshes = [model for steps in ladders for model in steps]
    limits = [limit for steps in ladders if (limit := steps[-1].limit()) is not None]
    study = bench.run(cases, [*meshes, *limits], max(shown))
    return Refinement(study, tuple(ladders), tuple(shown))


def run(request: Request, bench: Bench) -> Refinement:
    """Return the theory and every reference on three meshes or more.

    Without elements each model has its own; NAME@N1+N2 stands on these two and half the coarser.
    """
    models = dict.fromkeys((request.theory, *request.references))
    ladders = dict.fromkeys(ladder(model, request.elements) for model in models)
    return refine(request.cases, list(ladders), request.shown, bench)


def jobs(plan: Plan) -> dict[str, Request]:
    """Return what the main job asks: every beam theory and every reference on its ladder."""
    theories = [exact(name, plan.theory) for name in THEORIES]
    return {"refinement": plan.request(references=(*theories, *plan.references))}


def verification_table(study: Study, steps: Ladder, shown: Sequence[int]) -> Table:
    """Return the ladder's frequencies with their observed order, limit, GCI and warnings."""
    rows: list[tuple[Cell, ...]] = []
    for (case, i), seen in verified(study, steps).items():
        if i not in shown:
            continue
        order: Cell = Number(seen.say.order, 2) if math.isfinite(seen.say.order) else "-"
        rows.append(
            (case.name, f"f{i}", *map(Number, seen.frequencies), order,
             Number(seen.say.limit), cell(seen.band, 4), seen.say.remark)
        )  # fmt: skip
    columns = ("Case", "Mode", *(f"{model.elements} [Hz]" for model in steps), "order",
               "limit [Hz]", "GCI [%]", "Remark")  # fmt: skip
    name = family(steps)
    notes = (f"formal order of {name}: {steps[-1].info().order:g}", *failure_notes(study))
    title = f"{name}: frequencies against elements a limb, and their limit"
    return Table(title, columns, tuple(rows), notes)


def family(steps: Ladder) -> str:
    """Return what the models of a ladder are called together."""
    return steps[-1].label if steps[-1].settings else steps[-1].name


def _meshes(steps: Ladder) -> str:
    return ", ".join(str(model.elements) for model in steps)


def _warned(seen: Iterable[Seen]) -> int:
    return sum(bool(one.say.remark) and not one.say.converged for one in seen)


def _largest(values: Iterable[float]) -> float:
    return max((value for value in values if math.isfinite(value)), default=math.nan)
