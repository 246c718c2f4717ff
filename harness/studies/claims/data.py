"""The paper's claims as data: results/published/claims.toml, and what a check answers."""

import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product
from types import MappingProxyType
from typing import Any

from analytic import InputError
from harness import published
from harness.studies.claims.facts import PAPER, Facts

HOLDS = "holds"
FAILS = "fails"
ONLY_IF = "holds only if"
CANNOT = "cannot be reproduced as printed"
KINDS = (HOLDS, ONLY_IF, CANNOT, FAILS)
"""What a verdict begins with."""


@dataclass(frozen=True)
class Rules:
    """The thresholds of all checks; see claims.toml, [rules]."""

    rounding: float
    agrees_percent: float
    significant_percent: float
    exact: float


@dataclass(frozen=True)
class Claim:
    """One statement: what is quoted, how it is checked (`check` with `args`), what shows it."""

    id: str
    section: str
    quoted: str
    how: str
    check: str
    args: Mapping[str, Any]
    command: str
    erratum: str = ""


@dataclass(frozen=True)
class Finding:
    """What a check found, in words made for the measured numbers."""

    measured: str
    uncertainty: str
    verdict: str

    @property
    def kind(self) -> str:
        """The one of `KINDS` that it is; raises `StopIteration` where it is none."""
        return next(k for k in (ONLY_IF, HOLDS, CANNOT, FAILS) if self.verdict.startswith(k))


Args = Mapping[str, Any]
Outcome = tuple[str, dict[str, Any]]
"""Which verdict of findings.toml is true, and what its words are filled in with."""
Check = Callable[[Facts, Args], Outcome]
CHECKS: dict[str, tuple[Check, tuple[str, ...]]] = {}
"""By a check's name: the function, and the groups of `Facts` that it reads besides what is printed.
"""
_FILE = tomllib.loads(published.text("claims.toml"))
RULES = Rules(**_FILE["rules"])
_WORDS = tomllib.loads(published.text("findings.toml"))


def reads(*groups: str, name: str = "") -> Callable[[Check], Check]:
    """Return a decorator that adds a check to `CHECKS`."""

    def add(check: Check) -> Check:
        CHECKS[name or check.__name__] = (check, groups)
        return check

    return add


def outcome(holds: Any, otherwise: str = "otherwise", **values: Any) -> Outcome:
    """Return that a statement holds, or which of its verdicts is true `otherwise`."""
    return HOLDS if holds else otherwise, values


def find(claim: Claim, facts: Facts) -> Finding:
    """Return what a claim's check finds, in the words of findings.toml."""
    verdict, values = CHECKS[claim.check][0](facts, claim.args)
    known = {**vars(facts), **vars(RULES), "paper": PAPER.label, **claim.args, **values}
    words = {HOLDS: HOLDS} | _WORDS[claim.check]
    return Finding(*(words[key].format(**known) for key in ("measured", "uncertainty", verdict)))


@cache
def claims() -> tuple[Claim, ...]:
    """Return all claims in the order of the file; an entry with `over` gives one a combination."""
    found: list[Claim] = []
    for entry in _FILE["claim"]:
        over = entry.get("over", {})
        for values in product(*over.values()):
            args = entry.get("args", {}) | dict(zip(over, values, strict=True))
            words = args | {"name": args.get("case", "").replace("case", "Case ")}
            words["printed"] = quoted_number(args)
            text = {k: v.format(**words) for k, v in entry.items() if isinstance(v, str)}
            found.append(Claim(args=MappingProxyType(args), **text))
    return tuple(found)


def quoted_number(args: Mapping[str, Any]) -> float:
    """Return the number that a claim with `args` quotes; NaN if it quotes none."""
    match args:
        case {"printed": value}:
            return float(value)
        case {"quantity": quantity}:
            return float(published.cost()[quantity])
        case {"case": case, "mode": mode, "method": method}:
            return float(published.table1()[case, method][mode - 1])
        case {"case": case, "mode": mode, "from": few, "to": _}:
            last = published.table1()[case, "Error (%)"][mode - 1]
            return float(published.figure3()[case, few, mode] - last)
        case {"case": case, "mode": mode, "elements": elements}:
            return published.figure3()[case, elements, mode]
    return float("nan")


def select(ids: Sequence[str]) -> list[Claim]:
    """Return the claims called `ids`, in the order of the file, or raise `InputError`."""
    known = {claim.id for claim in claims()}
    for name in ids:
        if name not in known:
            expected = f"one of the {len(known)} ids that `rps-bench claims` lists"
            raise InputError("only", name, expected)
    return [claim for claim in claims() if claim.id in ids]
