"""What a check answers: verdicts, and the words and thresholds that they come with."""

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from analytic import InputError
from harness.cases import PRESETS
from harness.paper import Claim, Paper

KINDS = HOLDS, ONLY_IF, CANNOT, FAILS = (
    "holds", "holds only if", "cannot be reproduced as printed", "fails"
)  # fmt: skip
"""What a verdict begins with."""
MANY = {HOLDS: "hold", ONLY_IF: "hold on a condition", FAILS: "fail"}
"""What several claims of a kind do."""
Args = Mapping[str, Any]
Outcome = tuple[str, dict[str, Any]]
"""Which verdict of findings.toml is true, and what its words are filled in with."""
CASES = ("case1", "case2")
"""The two of Table I."""
TABLE = tuple(PRESETS[name] for name in CASES)


def verb(kind: str, number: int) -> str:
    """Return what so many claims of a kind do, in words."""
    return kind if number == 1 else MANY.get(kind, kind)


def checked() -> Paper:
    """Return the paper that this bench is about."""
    assert TABLE[0].paper is not None, "it is one of its cases"
    return TABLE[0].paper


RULES: Any = SimpleNamespace(**checked().toml("claims.toml")["rules"])
"""The thresholds of all checks; see claims.toml, [rules]."""
WORDS = tomllib.loads(Path(__file__).with_name("findings.toml").read_text(encoding="utf-8"))


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


def select(ids: Sequence[str], claims: Sequence[Claim]) -> list[Claim]:
    """Return the claims called `ids`, in their own order, or raise `InputError`."""
    known = {claim.id for claim in claims}
    for name in ids:
        if name not in known:
            expected = f"one of the {len(known)} ids that `rps-bench claims` lists"
            raise InputError("only", name, expected)
    return [claim for claim in claims if claim.id in ids]
