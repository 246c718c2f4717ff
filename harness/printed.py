"""Models beside what a paper prints that is data: mode by mode, as far as its digits go."""

from collections.abc import Sequence

from analytic.model import Model
from harness.bench import Study, label
from harness.case import Case
from harness.paper import Printed
from harness.tables import Cell, Number, Table

AGREES = 0.1
"""Agreement beyond the last digit [%]: what parameters rounded to three digits leave."""


def ours(study: Study, case: Case, model: Model, one: Printed) -> float | None:
    """Return the model's frequency of a printed mode [Hz]; None where it was not solved for."""
    modes = study.get(case, model)
    if modes is None or one.mode > study.count:
        return None
    return float(modes.frequencies[one.mode - 1])


def agrees(found: float, one: Printed) -> bool:
    """Return whether a frequency is the printed one: by its last digit, or to `AGREES`."""
    return abs(found - one.frequency) <= one.half + AGREES / 100 * one.frequency


def printed_table(study: Study, theories: Sequence[Model]) -> Table:
    """Return one row a case, theory and printed value."""
    rows: list[tuple[Cell, ...]] = []
    for case in study.cases:
        for theory in theories:
            for one in () if case.prints_errors else case.printed:
                found = ours(study, case, theory, one)
                if found is not None:
                    off = Number(100 * (found / one.frequency - 1), 3, signed=True)
                    rows.append((case.name, one.method, f"f{one.mode}", Number(one.frequency, 3),
                                 label(theory), Number(found), off, one.where))  # fmt: skip
    columns = ("Case", "Printed by", "Mode", "Printed [Hz]", "Model", "Ours [Hz]",
               "Difference [%]", "Where")  # fmt: skip
    return Table("Beside what is printed", columns, tuple(rows))


def against_paper(study: Study, theory: Model) -> list[str]:
    """Return for every paper and method how many of its values a theory gives, and the worst."""
    seen: dict[tuple[str, str], list[tuple[bool, float]]] = {}
    for case in study.cases:
        for one in () if case.prints_errors else case.printed:
            found = ours(study, case, theory, one)
            if found is not None and case.paper is not None:
                off = 100 * (found / one.frequency - 1)
                key = case.paper.name, one.method
                seen.setdefault(key, []).append((agrees(found, one), off))
    return [
        f"{sum(good for good, _ in some)} of the {len(some)} values that {paper} prints "
        f"({method}) agree with {label(theory)} to their last digit or {AGREES} %; the largest "
        f"difference is {max((off for _, off in some), key=abs):+.2f} %."
        for (paper, method), some in seen.items()
    ]
