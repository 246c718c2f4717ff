"""The paper's claims and their verdicts, as the study of claims judged them."""

from harness.report.material import Material
from harness.report.section import Json, Section

KEY, TITLE, MENU = "claims", "The paper's claims, one by one", "Claims"
VERDICTS = ("fails", "cannot be reproduced", "holds only if", "holds")
"""Kinds of verdicts, what a reader looks for first."""


def verdicts(run: Material) -> list[Json]:
    """Return the claims of the run: every field of each as text."""
    part = run.part("claims")
    if part is None:
        return []
    return [
        {str(name): "" if value is None else str(value) for name, value in row.items()}
        for result in part.results.values()
        for row in result.to_frame().to_dict("records")
    ]


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
    groups = [(kind, [c for c in claims if c["kind"] == kind]) for kind in VERDICTS]
    context = {"count": len(claims), "groups": [list(group) for group in groups if group[1]]}
    return Section(KEY, TITLE, MENU, run.only("claims"), context)
