"""Status: the gate, the claims, the newest run, and what could not be read."""

from collections import Counter
from typing import Any

from harness.report.ledger import Ledger
from harness.report.section import Section
from harness.report.sources import Sources

VERDICTS = ("holds", "holds only if", "fails", "cannot be reproduced")

SHOWN = ("kind", "model", "case", "mode", "quantity", "before", "after", "tolerance", "verdict",
         "cause")  # fmt: skip


def kind(verdict: str) -> str:
    """Return which of `VERDICTS` a claim's verdict is; "other" for none of them."""
    found = [one for one in VERDICTS if verdict.lower().startswith(one)]
    return max(found, key=len, default="other")


def section(sources: Sources, ledger: Ledger) -> Section:
    """Return the section."""
    counts = Counter(kind(claim.get("verdict", "")) for claim in sources.claims)
    runs = sources.recorded.runs
    latest = runs.tail(1).to_dicts()
    context = {
        "gate": _gate(sources.check),
        "claims": [(name, counts[name]) for name in (*VERDICTS, "other") if counts[name]],
        "latest": _newest(latest[0]) if latest else None,
        "runs": len(runs),
        "rows": int(runs["rows"].sum()) if latest else 0,
        "skipped": sources.skipped,
    }
    return Section("status", "Status", context)


def _newest(run: dict[str, Any]) -> dict[str, str]:
    commit, dash, dirty = run["commit"].partition("-")
    return {
        "when": f"{run['time']:%Y-%m-%d %H:%M} UTC",
        "command": run["command"],
        "commit": f"{commit[:10]}{dash}{dirty}, rps-bench {run['release']}",
    }


def _gate(check: dict[str, Any] | None) -> dict[str, Any] | None:
    if check is None:
        return None
    findings = [one for one in check.get("findings", []) if isinstance(one, dict)]
    names = [n for n in SHOWN if any(one.get(n) not in (None, "") for one in findings)]
    status = str(check.get("status", "not said"))
    return {
        "status": status,
        "good": status == "passed",
        "summary": str(check.get("summary", "")).removeprefix(f"{status}: "),
        "time": str(check.get("time", ""))[:16].replace("T", " "),
        "columns": names,
        "rows": [["" if one.get(n) is None else _short(one[n]) for n in names] for one in findings],
    }


def _short(value: Any) -> str:
    return f"{value:.9g}" if isinstance(value, float) else str(value)
