"""Every checkable statement of the paper, and its verdict.

The statements are about the paper's own mechanism, or those of the papers whose folder is the
`case_file`.
"""

import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from analytic import InputError
from harness.bench import Bench
from harness.paper import FORMS, Claim
from harness.request import Option, Plan, Request
from harness.result import Result
from harness.studies.claims import check_cost, check_mechanism, check_numbers
from harness.studies.claims.facts import (
    HOLDS,
    PAPER,
    RULES,
    TABLE,
    Args,
    Facts,
    Outcome,
    UnmeasuredError,
    checked,
)
from harness.tables import Table
from harness.text import split
from reference_models import UnavailableError

TAKES = ("case_file",)
OPTIONS = (
    Option("only", "ID,ID", "Check these claims; default all.", None,
           lambda text: split("only", text)),
)  # fmt: skip
KINDS = _, ONLY_IF, CANNOT, FAILS = (
    HOLDS, "holds only if", "cannot be reproduced as printed", "fails"
)  # fmt: skip
"""What a verdict begins with."""
MANY = {HOLDS: "hold", ONLY_IF: "hold on a condition", FAILS: "fail"}
"""What several claims of a kind do."""
COLUMNS = ("id", "section", "quoted", "measured", "uncertainty", "verdict", "command")
SHORT = ("id", "quoted", "measured", "kind")
"""The columns of a long list: its lines are read at a glance."""
LONG = 10
"""More claims than this are a long list."""
WORDS = tomllib.loads(Path(__file__).with_name("findings.toml").read_text(encoding="utf-8"))
CHECKS: dict[str, Callable[[Facts, Args], Outcome]] = {
    name: check
    for module in (check_cost, check_mechanism, check_numbers)
    for name, check in vars(module).items()
    if name in WORDS
}
"""The checks by name: which verdict the facts and a claim's arguments give, and what with."""


@dataclass(frozen=True)
class Finding:
    """What a check of a `claim` found, in words made for the measured numbers."""

    claim: Claim
    measured: str
    uncertainty: str
    verdict: str

    @property
    def kind(self) -> str:
        """The one of `KINDS` that it is; raises `StopIteration` where it is none."""
        return next(k for k in (ONLY_IF, HOLDS, CANNOT, FAILS) if self.verdict.startswith(k))


@dataclass(frozen=True)
class Claims(Result):
    """Findings on claims of the paper.

    Attributes: `found`, in the order of the file; `unchecked`: by id why a claim could not be
    checked; `solved`, the rows of what was solved.
    """

    found: tuple[Finding, ...]
    unchecked: Mapping[str, str]
    solved: tuple[dict[str, Any], ...] = ()

    def records(self) -> list[dict[str, str]]:
        """Return one row a claim: quoted, measured, the verdict, and how it was found."""
        names = (*COLUMNS, "kind", "how", "erratum")
        each = (vars(one.claim) | vars(one) | {"kind": one.kind} for one in self.found)
        return [{name: every[name] for name in names} for every in each]

    def counts(self) -> dict[str, int]:
        """Return how many verdicts of each kind there are."""
        kinds = [finding.kind for finding in self.found]
        return {kind: kinds.count(kind) for kind in KINDS}

    def tables(self) -> dict[str, Table]:
        """Return one row a claim: all of it, and of many claims first what is read at a glance."""
        whole = self._table(COLUMNS)
        return {"": whole} if len(self.found) <= LONG else {"": whole, "-short": self._table(SHORT)}

    def _table(self, columns: Sequence[str]) -> Table:
        notes = ["; ".join(f"{number} {kind}" for kind, number in self.counts().items())]
        # Claims of any paper bring their own thresholds.
        if any(one.claim.check not in FORMS for one in self.found):
            notes.append(
                f"printed numbers agree within half a unit of their last digit "
                f"({RULES.rounding:g}) and the measured uncertainty; two frequencies are the same "
                f"within {RULES.agrees_percent:g} %; significant is more than "
                f"{RULES.significant_percent:g} %, the error that the paper itself calls acceptable"
            )
        notes += [f"not checked: {name}: {why}" for name, why in self.unchecked.items()]
        rows = tuple(tuple(row[name] for name in columns) for row in self.records())
        heads = tuple("Verdict" if name == "kind" else name.capitalize() for name in columns)
        return Table("Claims of the paper", heads, rows, tuple(notes))

    def sentences(self) -> list[str]:
        """Return how many statements there are of each verdict, then those that fail."""
        counts = ", ".join(f"{n} {verb(kind, n)}" for kind, n in self.counts().items())
        return [f"Of {len(self.found)} statements of the paper: {counts}."] + [
            f"{one.claim.id}: {one.verdict}." for one in self.found if one.kind == FAILS
        ]

    def rows(self) -> list[dict[str, Any]]:
        """Return all that was solved, as rows for the history."""
        return list(self.solved)

    def failures(self) -> dict[str, str]:
        """Return the claims that could not be checked, and why."""
        return dict(self.unchecked)


def verb(kind: str, number: int) -> str:
    """Return what so many claims of a kind do, in words."""
    return kind if number == 1 else MANY.get(kind, kind)


def find(claim: Claim, facts: Facts) -> Finding:
    """Return what a claim's check finds, in the words of findings.toml.

    Raises `InputError` for a claim of a case or method that is not there, and what `Facts` raises
    where a figure that it asks for cannot be measured.
    """
    verdict, values = CHECKS[claim.check](facts, {**claim.args, "id": claim.id})
    known = {**vars(facts), **vars(RULES), "paper": PAPER.label, **claim.args, **values}
    words = {HOLDS: HOLDS} | WORDS[claim.check]
    said = (words[key].format(**known) for key in ("measured", "uncertainty", verdict))
    return Finding(claim, *said)


def judge(chosen: Iterable[Claim], facts: Facts) -> Claims:
    """Return the findings, and by id why a claim could not be checked."""
    found, unchecked = [], {}
    for claim in chosen:
        try:
            found.append(find(claim, facts))
        except (UnavailableError, UnmeasuredError) as error:
            unchecked[claim.id] = str(error)
    return Claims(tuple(found), unchecked, tuple(facts.solved))


def select(ids: Sequence[str], claims: Sequence[Claim]) -> list[Claim]:
    """Return the claims called `ids`, in their own order, or raise `InputError`."""
    known = {claim.id for claim in claims}
    for name in ids:
        if name not in known:
            expected = f"one of the {len(known)} ids that `rps-bench claims` lists"
            raise InputError("only", name, expected)
    return [claim for claim in claims if claim.id in ids]


def run(request: Request, bench: Bench) -> Claims:
    """Return the verdict on every statement, or on those asked for.

    Verdicts are results: only a claim that could not be checked makes the exit status 1. The
    statements are about the paper's own mechanism; with the folder of another paper as --case-file,
    they are those of its claims.toml.
    """
    paper, only = request.cases[0].paper, request.options["only"]
    if paper is None or not paper.claims or not all(case.published for case in request.cases):
        names = ", ".join(case.name for case in request.cases)
        raise InputError("case_file", names, "the folder of a paper with claims.toml")
    chosen = paper.claims if only is None else select(only, paper.claims)
    return judge(chosen, Facts(bench, TABLE if paper == checked() else request.cases))


def jobs(plan: Plan) -> dict[str, Request]:
    """Return what the main job asks: every claim, unless it is about a mechanism of the user's."""
    return {} if plan.case_file else {"claims": plan.request()}
