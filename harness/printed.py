"""Models beside what a paper prints that is data: mode by mode, as far as its digits go."""

from collections.abc import Iterator, Sequence

from analytic.model import Model
from harness.bench import Study, label
from harness.case import Case
from harness.paper import Printed
from harness.tables import Number, Table

AGREES = 0.1
"""Agreement beyond the last digit [%]: what parameters rounded to three digits leave."""


def beside(study: Study, case: Case, theory: Model) -> Iterator[tuple[Printed, float, float]]:
    """Yield the values printed of a case, the theory's [Hz], and its difference [%]."""
    modes = study.get(case, theory)
    for one in () if modes is None or case.prints_errors else case.printed:
        if one.mode <= study.count:
            found = float(modes.frequencies[one.mode - 1])  # type: ignore[union-attr]
            yield one, found, 100 * (found / one.frequency - 1)


def printed_table(study: Study, theories: Sequence[Model]) -> Table:
    """Return one row a case, theory and printed value."""
    rows = tuple(
        (case.name, one.method, f"f{one.mode}", Number(one.frequency, 3), label(theory),
         Number(found), Number(off, 3, signed=True), one.where)
        for case in study.cases for theory in theories
        for one, found, off in beside(study, case, theory)
    )  # fmt: skip
    columns = ("Case", "Printed by", "Mode", "Printed [Hz]", "Model", "Ours [Hz]",
               "Difference [%]", "Where")  # fmt: skip
    return Table("Beside what is printed", columns, rows)


def against_paper(study: Study, theory: Model) -> list[str]:
    """Return for every paper and method how many of its values a theory gives, and the worst."""
    seen: dict[tuple[str, str], list[tuple[bool, float]]] = {}
    for case in study.cases:
        for one, found, off in beside(study, case, theory):
            # By its last digit, or to `AGREES`.
            good = abs(found - one.frequency) <= one.half + AGREES / 100 * one.frequency
            if case.paper is not None:
                seen.setdefault((case.paper.name, one.method), []).append((good, off))
    return [
        f"{sum(good for good, _ in some)} of the {len(some)} values that {paper} prints "
        f"({method}) agree with {label(theory)} to their last digit or {AGREES} %; the largest "
        f"difference is {max((off for _, off in some), key=abs):+.2f} %."
        for (paper, method), some in seen.items()
    ]
