"""How cost grows with the number of elements: seconds as measured, operations as counted."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from analytic import InputError
from harness.case import Case
from harness.studies.cost.work import FORMULATIONS, counted
from harness.tables import Cell, Number, Table
from harness.timing import Timed

LARGE = 8
"""From this s on, growth is fitted a second time: below it, what does not grow dominates."""


@dataclass(frozen=True)
class Growth:
    """t ~ size^exponent by least squares on logarithms, with the exponent's standard error."""

    method: str
    what: str
    sizes: tuple[int, ...]
    exponent: float
    error: float


def growth(
    timed: Sequence[Timed], steps: Sequence[int], case: Case, least: int = 1
) -> list[Growth]:
    """Return how time, solve time and counted operations grow with s, from `least` on.

    Of every method that was timed with three sizes at least, and of every formulation counted.
    """
    found: list[tuple[str, str, list[tuple[object, float]]]] = []
    for method in dict.fromkeys(t.way.method for t in timed):
        own = [t for t in timed if t.way.method == method]
        for what in ("time", "solve time"):
            points: list[tuple[object, float]] = [
                (t.way.model.elements, t.median if what == "time" else t.solve or 0.0) for t in own
            ]
            found.append((method, what, points))
    for name, method in FORMULATIONS.items():
        for sparse in (False, True):
            work: list[tuple[object, float]] = []
            for s in steps:
                with suppress(InputError):  # more coordinates than multipliers are solved for
                    work.append((s, float(counted(name, s, case, sparse=sparse).flops)))
            found.append((method, f"operations, {'sparse' if sparse else 'dense'}", work))
    fits = (_fit(*one, least) for one in found)
    return [fit for fit in fits if fit is not None]


def _fit(
    method: str, what: str, points: Sequence[tuple[object, float]], least: int
) -> Growth | None:
    from scipy.stats import linregress

    known = [(s, value) for s, value in points if isinstance(s, int) and s >= least and value]
    if len(known) < 3:
        return None
    sizes, values = zip(*known, strict=True)
    fit = linregress(np.log(sizes), np.log(values))
    return Growth(method, what, sizes, float(fit.slope), float(fit.stderr))


def growth_table(timed: Sequence[Timed], steps: Sequence[int], case: Case) -> Table:
    """Return every exponent, over all sizes and over large ones."""
    large = {(g.method, g.what): g for g in growth(timed, steps, case, LARGE)}
    rows: list[tuple[Cell, ...]] = []
    for g in growth(timed, steps, case):
        tail = large.get((g.method, g.what))
        end: tuple[Cell, ...] = ("-", "-", "-")
        if tail is not None:
            end = (_range(tail.sizes), Number(tail.exponent, 2), Number(tail.error, 2))
        own = (Number(g.exponent, 2), Number(g.error, 2))
        rows.append((g.method, g.what, _range(g.sizes), *own, *end))
    columns = ("Model", "Of", "s", "exponent", "std. error", "large s", "exponent", "std. error")
    notes = (
        "cost ~ s^exponent, least squares on logarithms of medians; three sizes at least",
        "a compiled language would change neither solve times, which are LAPACK's and SuperLU's, "
        "nor counted operations: no verdict on an element's cost rests on anything else",
    )
    return Table("Growth of cost with the number of elements", columns, tuple(rows), notes)


def _range(sizes: Sequence[int]) -> str:
    return f"{sizes[0]}-{sizes[-1]}"
