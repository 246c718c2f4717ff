"""The paper's claims and their verdicts, as the study of claims judged them."""

from harness.report.material import Material
from harness.report.section import Json, Section

KEY, TITLE, MENU = "claims", "The paper's claims, one by one", "Claims"
VERDICTS = ("fails", "cannot be reproduced", "holds only if", "holds")
"""Kinds of verdicts as they begin, what a reader looks for first."""
OTHER = "other"
FIELDS = ("id", "section", "quoted", "how", "measured", "uncertainty", "verdict", "command")


def verdicts(run: Material) -> list[Json]:
    """Return the claims of the run: each of `FIELDS` as text, and the `kind` of its verdict."""
    part = run.part("claims")
    if part is None:
        return []
    return [
        {name: _text(row.get(name)) for name in FIELDS} | {"kind": _kind(str(row["verdict"]))}
        for result in part.results.values()
        for row in result.to_frame().to_dict("records")
    ]


def _text(value: object) -> str:
    return value if isinstance(value, str) else ""


def _kind(verdict: str) -> str:
    found = [one for one in VERDICTS if verdict.lower().startswith(one)]
    return max(found, key=len, default=OTHER)


def section(run: Material) -> Section | None:
    """Return the section."""
    claims = verdicts(run)
    if not claims:
        return None
    for claim in claims:
        fields = {
            "Where": claim["section"],
            "Printed": claim["quoted"],
            "Checked": claim["how"],
            "Measured": claim["measured"],
            "Uncertainty": claim["uncertainty"],
            "Verdict": claim["verdict"],
            "Command": claim["command"],
        }
        record = run.ledger.add(f"Claim {claim['id']}", fields, [run.run])
        claim["record"] = record
        claim["verdict"], _, claim["why"] = claim["verdict"].partition(": ")
    groups = [(kind, [c for c in claims if c["kind"] == kind]) for kind in (*VERDICTS, OTHER)]
    context = {"count": len(claims), "groups": [list(group) for group in groups if group[1]]}
    return Section(KEY, TITLE, MENU, run.only("claims"), context)
