"""Every checkable statement of the paper, and its verdict."""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from harness.claims.checks import CHECKS
from harness.claims.data import KINDS, Claim, Finding, rules
from harness.claims.facts import Facts
from harness.tables import Table

COLUMNS = ("id", "section", "quoted", "measured", "uncertainty", "verdict", "command")
SHORT = ("id", "quoted", "measured", "kind")
"""The columns of a long list in the terminal: its lines are read at a glance."""


@dataclass(frozen=True)
class Checked:
    """A claim with its finding."""

    claim: Claim
    finding: Finding

    def row(self) -> dict[str, str]:
        """Return what `--json` prints of it."""
        claim, finding = self.claim, self.finding
        return {
            "id": claim.id,
            "section": claim.section,
            "quoted": claim.quoted,
            "measured": finding.measured,
            "uncertainty": finding.uncertainty,
            "verdict": finding.verdict,
            "command": claim.command,
            "kind": finding.kind,
            "how": claim.how,
            "erratum": claim.erratum,
        }


def needed(chosen: Iterable[Claim]) -> list[str]:
    """Return the groups of `Facts` that the checks of `chosen` read."""
    return sorted({group for claim in chosen for group in CHECKS[claim.check].groups})


def judge(
    chosen: Iterable[Claim], facts: Facts, missing: Mapping[str, str]
) -> tuple[list[Checked], dict[str, str]]:
    """Return the findings, and by id why a claim could not be checked.

    `missing`: group of `facts` to the reason why it was not measured.
    """
    found, unchecked = [], {}
    for claim in chosen:
        check = CHECKS[claim.check]
        gaps = [missing[group] for group in check.groups if group in missing]
        if gaps:
            unchecked[claim.id] = "; ".join(gaps)
        else:
            found.append(Checked(claim, check.function(facts, claim, rules())))
    return found, unchecked


def claims_table(
    found: Sequence[Checked], unchecked: Mapping[str, str], columns: Sequence[str] = COLUMNS
) -> Table:
    """Return one row a claim, with how many verdicts of each kind there are."""
    rows = tuple(tuple(checked.row()[name] for name in columns) for checked in found)
    kinds = [checked.finding.kind for checked in found]
    limits = rules()
    notes = [
        "; ".join(f"{kinds.count(kind)} {kind}" for kind in KINDS),
        f"printed numbers agree within half a unit of their last digit ({limits.rounding:g}) and "
        "the measured uncertainty; two frequencies are the same within "
        f"{limits.agrees_percent:g} %; significant is more than {limits.significant_percent:g} %, "
        "the error that the paper itself calls acceptable",
        *(f"not checked: {name}: {why}" for name, why in unchecked.items()),
    ]
    if "verdict" not in columns:
        notes.append("`--only ID` or `--output DIR`: with uncertainty, reason and command")
    heads = tuple("Verdict" if name == "kind" else name.capitalize() for name in columns)
    return Table("Claims of the paper", heads, rows, tuple(notes))


def claims_json(found: Sequence[Checked]) -> str:
    """Return the findings as a JSON list."""
    return json.dumps([checked.row() for checked in found], indent=1, ensure_ascii=False) + "\n"
