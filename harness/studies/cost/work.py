"""Counted work of the formulations: what no language and no machine changes."""

from collections.abc import Sequence
from functools import lru_cache

from analytic import InputError, work
from analytic.chain_work import chain_work
from analytic.substructure import DENSE
from analytic.work import Work
from harness.case import Case
from harness.studies.precision import COUNT
from harness.tables import Cell, Number, Table

FORMULATIONS = {
    "paper": "the paper's independent coordinates",
    "null-space": "multipliers, null-space",
    "saddle-point": "multipliers, saddle-point",
}


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
    rows: list[tuple[Cell, ...]] = []
    for s in steps:
        own = counted("paper", s, case)
        for name in FORMULATIONS:
            try:
                one = counted(name, s, case)
            except InputError:  # more coordinates than multipliers are solved for
                continue
            rows.append((
                FORMULATIONS[name], s, one.dofs, one.nonzeros, Number(one.bytes / 1e3, 1),
                Number(one.flops / 1e6, 3), Number(one.flops / own.flops, 2),
            ))  # fmt: skip
    columns = ("Formulation", "s", "dofs", "non-zeros of K", "kB", "Mflop", "paper's = 1")
    alike = "" if case.mechanism.simple else ", multipliers by LAPACK always"
    notes = (
        f"by LAPACK up to {DENSE} coordinates of the paper's, sparse elimination and block "
        f"Lanczos above{alike}; no language or machine changes these",
    )
    return Table("Counted work of one solution", columns, tuple(rows), notes)
