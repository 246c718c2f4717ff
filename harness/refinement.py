"""Grid convergence done properly: observed order, Richardson limit and GCI from three meshes.

Roache's grid convergence index as Celik et al. report it (J. Fluids Eng. 130, 078001, 2008).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from analytic import InputError
from analytic.pairing import pair
from harness.cases import Case
from harness.compare import failure_notes
from harness.models import Spec, formal_order
from harness.run import Study, run
from harness.tables import Cell, Number, Table

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
    limit = f_3 + (f_3 - f_2) / (r_32^p - 1); GCI = F_s |f_3 - f_2| / (r_32^p - 1), with F_s = 1.25,
    or 3 and the lower of observed and formal order outside the asymptotic range.
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
    limit = f3 + step if monotone else f3
    return Verification(order, limit, factor * abs(step), monotone, asymptotic, False)


def _order(ratio: float, fine: float, coarse: float) -> float:
    """Return p for a `ratio` of steps; NaN if none between 0.05 and 20 gives it."""

    def excess(p: float) -> float:
        return math.log(ratio) - math.log(fine**p * (coarse**p - 1) / (fine**p - 1))

    low, high = 0.05, 20.0
    if excess(low) * excess(high) > 0:
        return math.nan
    return float(brentq(excess, low, high))


def ladder(spec: Spec, elements: Sequence[int] | None) -> list[Spec]:
    """Return `spec` on at least three meshes: those given, or its own two and half the coarser."""
    if elements is None:
        coarse, fine = spec.elements if isinstance(spec.elements, tuple) else (8, 16)
        elements = (coarse // 2, coarse, fine)
    if len(elements) < MESHES:
        text = ",".join(map(str, elements))
        raise InputError("--elements", text, "three numbers at least, to read an order from")
    return [replace(spec, elements=n) for n in elements]


Seen = tuple[list[float], Verification]
"""The frequencies of one mode on every mesh [Hz], and what they say."""


@dataclass(frozen=True)
class Refinement:
    """Models on ladders of meshes: the `study` behind them, and what they say in `found`.

    `found` holds what was `Seen` by (case, model, mode from 0).
    """

    study: Study
    ladders: tuple[tuple[Spec, ...], ...]
    found: dict[tuple[str, str, int], Seen]


def refine(
    cases: Sequence[Case],
    ladders: Sequence[Sequence[Spec]],
    count: int,
    done: Callable[[str], None] = lambda _: None,
) -> Refinement:
    """Return every ladder's frequencies at every case, each mode followed by its shape."""
    study = run(cases, [spec for ladder in ladders for spec in ladder], count, done)
    found = {
        (case, ladder[0].name, i): seen
        for ladder in ladders
        for (case, i), seen in verified(study, ladder).items()
    }
    return Refinement(study, tuple(map(tuple, ladders)), found)


def verified(study: Study, ladder: Sequence[Spec]) -> dict[tuple[str, int], Seen]:
    """Return what each mode's frequencies on the ladder say, by (case, mode from 0).

    Modes are numbered by the finest mesh and followed by their shape; a case at which any mesh
    failed is left out.
    """
    found = {}
    for case in study.cases:
        meshes = [study.get(case, spec) for spec in ladder]
        if any(modes is None for modes in meshes):
            continue
        *coarser, finest = [modes for modes in meshes if modes is not None]
        finest = finest.first(study.count)
        rows = [
            modes.frequencies[pair(finest, modes, case.mechanism, case.pose).partner]
            for modes in coarser
        ]
        table = np.array([*rows, finest.frequencies])
        elements = [spec.elements for spec in ladder if isinstance(spec.elements, int)]
        for i in range(study.count):
            values = table[:, i].tolist()
            found[case.name, i] = values, verify(elements, values, formal_order(ladder[0]))
    return found


def refinement_tables(result: Refinement, shown: Sequence[int]) -> list[Table]:
    """Return one table a model: frequencies, observed order, limit and GCI, mode by mode."""
    return [verification_table(result.study, ladder, shown) for ladder in result.ladders]


def verification_table(study: Study, ladder: Sequence[Spec], shown: Sequence[int]) -> Table:
    """Return the ladder's frequencies with their observed order, limit, GCI and warnings."""
    found = verified(study, ladder)
    rows: list[tuple[Cell, ...]] = []
    for case in study.cases:
        for i in shown:
            if (case.name, i - 1) not in found:
                continue
            values, seen = found[case.name, i - 1]
            band = 100 * seen.gci / values[-1]
            order: Cell = Number(seen.order, 2) if math.isfinite(seen.order) else "-"
            rows.append(
                (case.name, f"f{i}", *(Number(v) for v in values), order,
                 Number(seen.limit), Number(band, 4), seen.remark)
            )  # fmt: skip
    columns = ("Case", "Mode", *(str(spec.elements) for spec in ladder), "order",
               "limit [Hz]", "GCI [%]", "Remark")  # fmt: skip
    name = ladder[0].name
    notes = (f"formal order of {name}: {formal_order(ladder[0])}", *failure_notes(study))
    title = f"{name}: frequencies [Hz] against elements a limb, and their limit"
    return Table(title, columns, tuple(rows), notes)
