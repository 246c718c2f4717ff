"""The paper's claims as data: results/published/claims.toml, and what a check answers."""

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import product
from types import MappingProxyType, SimpleNamespace
from typing import Any

from analytic import InputError
from harness import published

KINDS = HOLDS, ONLY_IF, CANNOT, FAILS = (
    "holds", "holds only if", "cannot be reproduced as printed", "fails"
)  # fmt: skip
"""What a verdict begins with."""
MANY = {HOLDS: "hold", ONLY_IF: "hold on a condition", FAILS: "fail"}
"""What several claims of a kind do."""
Args = Mapping[str, Any]
Outcome = tuple[str, dict[str, Any]]
"""Which verdict of findings.toml is true, and what its words are filled in with."""
_FILE = tomllib.loads(published.text("claims.toml"))
RULES: Any = SimpleNamespace(**_FILE["rules"])
"""The thresholds of all checks; see claims.toml, [rules]."""
WORDS = tomllib.loads(published.text("findings.toml"))


@dataclass(frozen=True)
class Claim:
    """One statement: what is quoted, how it is checked (`check` with `args`), what shows it."""

    id: str
    section: str
    quoted: str
    how: str
    check: str
    args: Args
    command: str
    erratum: str = ""


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

    def row(self) -> dict[str, str]:
        """Return every field in words."""
        every = vars(self.claim) | vars(self) | {"kind": self.kind}
        return {name: every[name] for name in (*COLUMNS, "kind", "how", "erratum")}


COLUMNS = ("id", "section", "quoted", "measured", "uncertainty", "verdict", "command")


def outcome(holds: Any, otherwise: str = "otherwise", **values: Any) -> Outcome:
    """Return that a statement holds, or which of its verdicts is true `otherwise`."""
    return HOLDS if holds else otherwise, values


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


def quoted_number(args: Args) -> float:
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
