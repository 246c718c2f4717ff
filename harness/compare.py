"""What studies that set models beside each other share: errors, notes, and cells."""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from analytic.model import Model
from analytic.pairing import Pairing
from harness.bench import Bench, Study, label
from harness.case import Case
from harness.request import Request
from harness.result import Result
from harness.signatures import Array
from harness.tables import Number
from reference_models import Named

PERCENT = 2
"""Decimals of an error in percent, as in Table I."""


def relative_error(theory: ArrayLike, reference: ArrayLike) -> Array:
    """Return 100 (theory / reference - 1) [%], the paper's "Error (%)"; NaN against 0 Hz."""
    ours, against = np.broadcast_arrays(np.asarray(theory, dtype=float), reference)
    ratio = np.full(ours.shape, np.nan)
    np.divide(ours, against, out=ratio, where=against != 0)
    return np.asarray(100 * (ratio - 1))


class Match(NamedTuple):
    """The modes of a theory beside their partners, by shape, in a reference, each (count,).

    Attributes: `ours`, `against` and its `uncertainty` [Hz]; the theory's `error` and the
    reference's `own` uncertainty [%], NaN where it states none; `odd`: which modes have a partner
    that their order does not suggest, or none; `pairing` of the two.
    """

    ours: Array
    against: Array
    uncertainty: Array
    error: Array
    own: Array
    odd: NDArray[np.bool_]
    pairing: Pairing


def match(study: Study, case: Case, theory: Model, reference: Model) -> Match | None:
    """Return the modes of `theory` asked for beside those of `reference`; None if either failed."""
    pairing = study.pairing(case, theory, reference)
    if pairing is None:
        return None
    ours, modes = (study.answers[case, model] for model in (theory, reference))
    f, place = ours.frequencies[: study.count], pairing.partner
    against, uncertainty = modes.frequencies[place], np.full(len(place), np.nan)
    if modes.uncertainty is not None:
        uncertainty = modes.uncertainty[place]
    own = relative_error(against + uncertainty, against)
    odd = pairing.reordered | pairing.doubtful
    return Match(f, against, uncertainty, relative_error(f, against), own, odd, pairing)


def errors(
    study: Study, theory: Model, reference: Model, cases: Sequence[Case] = (), what: str = "error"
) -> Array:
    """Return the errors of `theory` [%], (cases, count), by default of all; NaN where one failed.

    `what`: another attribute of `Match`.
    """
    found = [match(study, case, theory, reference) for case in cases or study.cases]
    return np.array([getattr(one, what) if one else np.full(study.count, np.nan) for one in found])


@dataclass(frozen=True)
class AgainstElements(Result):
    """`theory` against `reference` as its `elements` s grow; `shown`: mode numbers from 1."""

    study: Study
    theory: Named
    reference: Named
    elements: tuple[int, ...]
    shown: tuple[int, ...]

    @cached_property
    def meshes(self) -> tuple[Named, ...]:
        """The theory with each number of elements."""
        return tuple(replace(self.theory, elements=s) for s in self.elements)

    @classmethod
    def of(cls, request: Request, bench: Bench, models: Sequence[Named], **more: Any) -> Self:
        """Return it against the first reference, `models` solved beside the two; `more` fields."""
        theory, reference = request.theory, request.references[0]
        meshes = [replace(theory, elements=s) for s in request.steps]
        study = bench.run(request.cases, [reference, *meshes, *models], request.count)
        return cls(study, theory, reference, request.steps, request.shown, **more)


def cell(
    value: float, digits: int = PERCENT, *, signed: bool = False, none: str = "-"
) -> Number | str:
    """Return a number as a cell; `none` for what is none, such as 0 Hz against 0 Hz."""
    return Number(float(value), digits, signed) if np.isfinite(value) else none


def cells(
    values: Iterable[float], digits: int = PERCENT, *, signed: bool = False, none: str = "-"
) -> list[Number | str]:
    """Return numbers as cells, `none` for what is none."""
    return [cell(value, digits, signed=signed, none=none) for value in values]


def at(values: Array, shown: Sequence[int]) -> Array:
    """Return what belongs to the mode numbers `shown` from 1, of values (..., count)."""
    return np.asarray(values[..., np.array(shown) - 1])


def case_notes(cases: Sequence[Case]) -> list[str]:
    """Return what was read or fitted in each case, and the errata that explain it."""
    notes = [f"{case.name}: {case.note}" for case in cases]
    wanted = {key for case in cases for key in case.errata}
    for paper in dict.fromkeys(case.paper for case in cases if case.paper is not None):
        if wanted:
            notes += [f"erratum {one.id} ({one.where}): {one.evidence}"
                      for one in paper.errata if one.id in wanted]  # fmt: skip
            continue
        notes += [paper.citation, paper.note] if paper.note else [paper.citation]
        notes += [f"{one.statement} is printed, read as: {one.reading}" for one in paper.errata]
    return notes


def pairing_notes(
    study: Study, case: Case, theory: Model, reference: Model, shown: Iterable[int]
) -> list[str]:
    """Return a sentence for every mode whose partner is not the one its order suggests."""
    pairing, notes = study.pairing(case, theory, reference), list[str]()
    if pairing is None:
        return []
    for k in (i - 1 for i in shown):
        if pairing.reordered[k]:
            other, end = f"mode {pairing.partner[k] + 1}", "paired by shape"
        elif pairing.doubtful[k]:
            other, end = "no mode", "its error is doubtful"
        else:
            continue
        notes.append(
            f"{case.name}: mode {k + 1} of {label(theory)} looks like {other} of "
            f"{label(reference)} (assurance {pairing.assurance[k]:.3f}): {end}"
        )
    return notes


def failure_notes(*studies: Study, of: Collection[Model] | None = None) -> list[str]:
    """Return what failed (`of` these models, by default any), a sentence a case and reason."""
    found: dict[tuple[str, str, str], dict[str, None]] = {}
    for study in studies:
        for (case, model), why in study.failures.items():
            if of is None or model in of:
                what = "cannot take" if (case, model) in study.refused else "failed at"
                found.setdefault((what, case.name, why), {})[label(model)] = None
    return [f"{', '.join(who)} {what} {case}: {why}" for (what, case, why), who in found.items()]


def percent(value: float, bound: str = "") -> str:
    """Return a size [%] in words, two digits of it; `bound`: "at most " or "up to " before it."""
    return f"{bound}{value:.2g} %" if value >= 1e-3 else "less than 0.001 %"


def largest(values: ArrayLike) -> float:
    """Return the largest of `values` without its sign; NaN where none is known."""
    known = np.abs(np.asarray(values, dtype=float))
    return float(np.fmax.reduce(known, axis=None, initial=np.nan))


def span(values: ArrayLike) -> str:
    """Return the range of some errors [%] in words; "not known" where there is none."""
    known = np.asarray(values, dtype=float)
    known = known[np.isfinite(known)]
    if not known.size:
        return "not known"
    low, high = (f"{value:+.2f}" for value in (known.min(), known.max()))
    return f"{low} %" if low == high else f"{low} to {high} %"
