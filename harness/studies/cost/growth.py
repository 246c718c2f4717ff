"""How cost grows with the number of elements: seconds as measured, operations as counted."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from contextlib import suppress

import numpy as np

from analytic import InputError
from harness.case import Case
from harness.compare import cell
from harness.studies.cost.work import FORMULATIONS, counted
from harness.tables import Cell, Table
from harness.timing import Timed

LARGE = 8
"""From this s on, growth is fitted a second time: below it, what does not grow dominates."""
Series = dict[tuple[str, str], dict[int, float]]


def grown(timed: Sequence[Timed], steps: Sequence[int], case: Case) -> Series:
    """Return times and counted operations by number of elements, by method and what it is."""
    found: Series = defaultdict(dict)
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
    rows: list[tuple[Cell, ...]] = []
    for key, series in grown(timed, steps, case).items():
        fits = (exponent(series), exponent(series, LARGE))
        if fits[0][0] != "-":
            rows.append((*key, *(c for sizes, *fit in fits for c in (sizes, *map(cell, fit)))))
    columns = ("Model", "Of", "s", "exponent", "std. error", "large s", "exponent", "std. error")
    notes = (
        "cost ~ s^exponent, least squares on logarithms of medians; three sizes at least",
        "a compiled language would change neither solve times, which are LAPACK's and SuperLU's, "
        "nor counted operations: no verdict on an element's cost rests on anything else",
    )
    return Table("Growth of cost with the number of elements", columns, tuple(rows), notes)
