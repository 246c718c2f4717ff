"""How cost grows with the elements: counted work, which no language and no machine changes, and
seconds as measured."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import lru_cache

import numpy as np

from analytic import InputError, work
from analytic.chain_work import chain_work
from analytic.substructure import DENSE
from analytic.work import Work
from harness.case import Case
from harness.columns import laid_out
from harness.compare import cell
from harness.studies.precision import COUNT
from harness.tables import Table
from harness.timing import Timed

FORMULATIONS = {
    "paper": "the paper's independent coordinates",
    "null-space": "multipliers, null-space",
    "saddle-point": "multipliers, saddle-point",
}
LARGE = 8
"""From this s on, growth is fitted a second time: below it, what does not grow dominates."""


@lru_cache(maxsize=512)
def counted(formulation: str, s: int, case: Case, *, sparse: bool | None = None) -> Work:
    """Return the counted work of one of `FORMULATIONS` with `s` elements at a case.

    Solved as it is here, or `sparse`, or not. Raises `InputError` for more coordinates than are
    solved.
    """
    if not case.mechanism.simple:
        return chain_work(formulation, case.mechanism, case.pose, s, COUNT, sparse=sparse)
    limbs = len(case.mechanism.limbs)
    if sparse is None:
        sparse = limbs * (6 * s - 2) + 6 > DENSE
    count = {"paper": work.substructure, "null-space": work.null_space,
             "saddle-point": work.saddle_point}[formulation]  # fmt: skip
    return count(s, limbs, COUNT, sparse=sparse)


def work_table(steps: Sequence[int], case: Case) -> Table:
    """Return what a solution takes on any machine: counted operations and memory."""
    rows = []
    for s in steps:
        for name, method in FORMULATIONS.items():
            with suppress(InputError):  # more coordinates than multipliers are solved for
                one, own = counted(name, s, case), counted("paper", s, case)
                rows.append((method, s, one.dofs, one.nonzeros, one.bytes / 1e3, one.flops / 1e6,
                             one.flops / own.flops))  # fmt: skip
    columns = dict.fromkeys(("Formulation", "s", "dofs", "non-zeros of K"))
    columns |= {"kB": 1, "Mflop": 3, "paper's = 1": 2}
    alike = "" if case.mechanism.simple else ", multipliers by LAPACK always"
    note = (
        f"by LAPACK up to {DENSE} coordinates of the paper's, sparse elimination and block "
        f"Lanczos above{alike}; no language or machine changes these"
    )
    return laid_out("Counted work of one solution", columns, rows, [note])


def grown(
    timed: Sequence[Timed], steps: Sequence[int], case: Case
) -> dict[tuple[str, str], dict[int, float]]:
    """Return times and counted operations by number of elements, by method and what it is."""
    found: dict[tuple[str, str], dict[int, float]] = defaultdict(dict)
    for t in timed:
        for what, spent in (("time", "seconds"), ("solve time", "solve")):
            if isinstance(s := t.way.model.elements, int):
                found[t.way.method, what][s] = t.median(spent)
    for name, method in FORMULATIONS.items():
        for what, sparse in (("operations, dense", False), ("operations, sparse", True)):
            for s in steps:
                with suppress(InputError):  # more coordinates than multipliers are solved for
                    found[method, what][s] = counted(name, s, case, sparse=sparse).flops
    return found


def exponent(series: Mapping[int, float], least: int = 1) -> tuple[str, float, float]:
    """Return the sizes, the p of t ~ s^p by least squares on logarithms and its standard error.

    Of sizes from `least` on; "-" and NaN where there are fewer than three.
    """
    from scipy.stats import linregress

    known = {s: value for s, value in series.items() if s >= least and value > 0}
    if len(known) < 3:
        return "-", np.nan, np.nan
    fit = linregress(np.log(list(known)), np.log(list(known.values())))
    return f"{min(known)}-{max(known)}", float(fit.slope), float(fit.stderr)


def growth_table(timed: Sequence[Timed], steps: Sequence[int], case: Case) -> Table:
    """Return every exponent, over all sizes and over large ones."""
    fits = {
        key: (exponent(series), exponent(series, LARGE))
        for key, series in grown(timed, steps, case).items()
    }
    rows = [
        (*key, *(c for sizes, *fit in both for c in (sizes, *map(cell, fit))))
        for key, both in fits.items() if both[0][0] != "-"
    ]  # fmt: skip
    columns = ("Model", "Of", "s", "exponent", "std. error", "large s", "exponent", "std. error")
    notes = (
        "cost ~ s^exponent, least squares on logarithms of medians; three sizes at least",
        "a compiled language would change neither solve times, which are LAPACK's and SuperLU's, "
        "nor counted operations: no verdict on an element's cost rests on anything else",
    )
    return Table("Growth of cost with the number of elements", columns, rows, notes)
