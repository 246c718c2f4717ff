"""What studies that set models beside each other share: errors, notes, and cells."""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from analytic.model import Model
from analytic.pairing import Pairing
from harness import published
from harness.bench import Study, label
from harness.cases import Case
from harness.tables import Number

PERCENT = 2
"""Decimals of an error in percent, as in Table I."""


def relative_error(
    theory: NDArray[np.float64], reference: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return 100 (theory / reference - 1) [%], the paper's "Error (%)"; NaN against 0 Hz."""
    ours, against = np.asarray(theory, dtype=float), np.asarray(reference, dtype=float)
    ratio = np.full(np.broadcast_shapes(ours.shape, against.shape), np.nan)
    np.divide(ours, against, out=ratio, where=against != 0)
    return np.asarray(100 * (ratio - 1))


def cell(value: float, digits: int = PERCENT, *, signed: bool = False) -> Number | str:
    """Return a number as a cell; a dash for what is none, such as 0 Hz against 0 Hz."""
    return Number(float(value), digits, signed) if np.isfinite(value) else "-"


def cells(
    values: Iterable[float], digits: int = PERCENT, *, signed: bool = False
) -> list[Number | str]:
    """Return numbers as cells, dashes for what is none."""
    return [cell(value, digits, signed=signed) for value in values]


def case_notes(cases: Sequence[Case]) -> list[str]:
    """Return what was read or fitted in each case, and the errata that explain it."""
    notes = [f"{case.name}: {case.note}" for case in cases]
    for paper in dict.fromkeys(case.paper for case in cases if case.paper is not None):
        notes += [paper.citation, paper.note] if paper.note else [paper.citation]
        notes += [f"{what} is printed, read as: {reading}" for _, what, reading in paper.errata]
    wanted = {key for case in cases for key in case.errata}
    return notes + [
        f"erratum {erratum.id} ({erratum.where}): {erratum.evidence}"
        for erratum in published.errata()
        if erratum.id in wanted
    ]


def pairing_notes(
    case: Case, theory: Model, reference: Model, pairing: Pairing, pick: Sequence[int]
) -> list[str]:
    """Return a sentence for every mode whose partner is not the one its order suggests."""
    notes = []
    for i in pick:
        where = f"{case.name}: mode {i + 1} of {label(theory)}"
        seen = f"(assurance {pairing.assurance[i]:.3f})"
        if pairing.reordered[i]:
            other = int(pairing.partner[i]) + 1
            notes.append(
                f"{where} looks like mode {other} of {label(reference)} {seen}: paired by shape"
            )
        elif pairing.doubtful[i]:
            notes.append(
                f"{where} looks like no mode of {label(reference)} {seen}: its error is doubtful"
            )
    return notes


def failure_notes(*studies: Study) -> list[str]:
    """Return a sentence for every model that failed at a case."""
    return list(dict.fromkeys(
        f"{label(model)} failed at {case.name}: {why}"
        for study in studies
        for (case, model), why in study.failures.items()
    ))  # fmt: skip


def kind(model: Model) -> str:
    """Return what a table calls a reference: "Exact" without elements, else "FEA"."""
    return "Exact" if model.elements is None else "FEA"


def percent(value: float) -> str:
    """Return a size [%] in words, two digits of it."""
    return f"{value:.2g} %" if value >= 1e-3 else "less than 0.001 %"


def at_most(value: float) -> str:
    """Return a bound [%] in words."""
    return f"at most {value:.2g} %" if value >= 1e-3 else percent(value)


def span(values: NDArray[np.float64], *, signed: bool = False) -> str:
    """Return the range of some errors [%] in words; "not known" where there is none."""
    known = np.asarray(values)[np.isfinite(values)]
    if not known.size:
        return "not known"
    low, high = (f"{value:{'+' if signed else ''}.2f}" for value in (known.min(), known.max()))
    return f"{low} %" if low == high else f"{low} to {high} %"
