"""Every checkable statement of the paper, and its verdict.

The statements are about the paper's own mechanism, or those of the papers whose folder is the
`case_file`.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

from harness.bench import Bench
from harness.plan import Plan
from harness.request import Option, Request
from harness.result import Result
from harness.studies.claims import (  # noqa: F401  each adds its checks
    check_cost,
    check_equations,
    check_models,
    check_printed,
    check_workspace,
    papers,
)
from harness.studies.claims.data import CHECKS, KINDS, RULES, Claim, Finding, claims, find, select
from harness.studies.claims.facts import Facts
from harness.studies.claims.measure import gather
from harness.tables import Table

if TYPE_CHECKING:
    import pandas as pd


def _only(text: str) -> tuple[Claim, ...]:
    from harness.text import split

    return tuple(select(split("only", text)))


TAKES = ("case_file",)
OPTIONS = (Option("only", "ID,ID", "Check these claims; default all.", None, _only),)
COLUMNS = ("id", "section", "quoted", "measured", "uncertainty", "verdict", "command")
SHORT = ("id", "quoted", "measured", "kind")
"""The columns of a long list: its lines are read at a glance."""
LONG = 10
"""More claims than this are a long list."""


class Checked(NamedTuple):
    """A claim with its finding."""

    claim: Claim
    finding: Finding

    def row(self) -> dict[str, str]:
        """Return every field in words."""
        every = vars(self.claim) | vars(self.finding) | {"kind": self.finding.kind}
        return {name: every[name] for name in (*COLUMNS, "kind", "how", "erratum")}


@dataclass(frozen=True)
class Claims(Result):
    """Findings on claims of the paper.

    Attributes: `found`, in the order of the file; `unchecked`: by id why a claim could not be
    checked; `solved`, the rows of what was solved.
    """

    found: tuple[Checked, ...]
    unchecked: Mapping[str, str]
    solved: tuple[dict[str, Any], ...] = ()

    def to_frame(self) -> "pd.DataFrame":
        """Return one row a claim: quoted, measured, the verdict, and how it was found."""
        import pandas as pd

        return pd.DataFrame([checked.row() for checked in self.found])

    def counts(self) -> dict[str, int]:
        """Return how many verdicts of each kind there are."""
        kinds = [checked.finding.kind for checked in self.found]
        return {kind: kinds.count(kind) for kind in KINDS}

    def tables(self) -> dict[str, Table]:
        """Return one row a claim: all of it, and of many claims first what is read at a glance."""
        whole = self._table(COLUMNS)
        return {"": whole} if len(self.found) <= LONG else {"": whole, "-short": self._table(SHORT)}

    def _table(self, columns: Sequence[str]) -> Table:
        notes = (
            "; ".join(f"{number} {kind}" for kind, number in self.counts().items()),
            f"printed numbers agree within half a unit of their last digit ({RULES.rounding:g}) "
            "and the measured uncertainty; two frequencies are the same within "
            f"{RULES.agrees_percent:g} %; significant is more than "
            f"{RULES.significant_percent:g} %, the error that the paper itself calls acceptable",
            *(f"not checked: {name}: {why}" for name, why in self.unchecked.items()),
        )
        rows = tuple(tuple(checked.row()[name] for name in columns) for checked in self.found)
        heads = tuple("Verdict" if name == "kind" else name.capitalize() for name in columns)
        return Table("Claims of the paper", heads, rows, notes)

    def sentences(self) -> list[str]:
        """Return how many statements there are of each verdict, then those that fail."""
        counts = ", ".join(f"{number} {kind}" for kind, number in self.counts().items())
        return [f"Of {len(self.found)} statements of the paper: {counts}."] + [
            f"{checked.claim.id}: {checked.finding.verdict}."
            for checked in self.found
            if checked.finding.kind == KINDS[-1]
        ]

    def rows(self) -> list[dict[str, Any]]:
        """Return all that was solved, as rows for the history."""
        return list(self.solved)

    def failures(self) -> dict[str, str]:
        """Return the claims that could not be checked, and why."""
        return dict(self.unchecked)


def needed(chosen: Iterable[Claim]) -> list[str]:
    """Return the groups of `Facts` that the checks of `chosen` read."""
    return sorted({group for claim in chosen for group in CHECKS[claim.check][1]})


def judge(
    chosen: Iterable[Claim], facts: Facts, missing: Mapping[str, str]
) -> tuple[list[Checked], dict[str, str]]:
    """Return the findings, and by id why a claim could not be checked.

    `missing`: group of `facts` to the reason why it was not measured.
    """
    found, unchecked = [], {}
    for claim in chosen:
        _, groups = CHECKS[claim.check]
        gaps = [missing[group] for group in groups if group in missing]
        if gaps:
            unchecked[claim.id] = "; ".join(dict.fromkeys(gaps))
        else:
            found.append(Checked(claim, find(claim, facts)))
    return found, unchecked


def run(request: Request, bench: Bench) -> Claims:
    """Return the verdict on every statement, or on those asked for.

    Verdicts are results: only a claim that could not be checked makes the exit status 1. The
    statements are about the paper's own mechanism; with the folder of another paper as --case-file,
    they are those of its claims.toml.
    """
    if not all(case.published for case in request.cases):
        found_there, rows = papers.judged(request.cases, bench)
        judged, why = papers.split(found_there)
        return Claims(tuple(Checked(*one) for one in judged), why, tuple(rows))
    chosen = request.options["only"] or claims()
    facts, missing, solved = gather(needed(chosen), bench)
    found, unchecked = judge(chosen, facts, missing)
    return Claims(tuple(found), unchecked, tuple(solved))


def jobs(plan: Plan) -> dict[str, Request]:
    """Return what the main job asks: every claim, unless it is about a mechanism of the user's."""
    return {} if plan.case_file else {"claims": plan.request()}
