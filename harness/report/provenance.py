"""Provenance: every model of the accepted run, its version, size, joint gap and cost."""

from harness.report.ledger import Ledger, measured
from harness.report.section import Section
from harness.report.sources import Sources


def section(sources: Sources, ledger: Ledger) -> Section:
    """Return the section."""
    title = "Provenance: where the numbers come from"
    if sources.frequencies.is_empty():
        return Section("provenance", title, missing="`rps-bench reproduce` makes this section")
    once = sources.frequencies.filter(mode=1).to_dicts()
    rows = [
        {
            "case": row["case"],
            "model": row["model"],
            "theory": row["theory"],
            "version": row["version"],
            **{name.lower(): text for name, text in measured(row).items()},
            "uncertainty": _percent(row),
            "record": ledger.model(row["case"], row["model"]),
        }
        for row in once
    ]
    return Section("provenance", title, {"rows": rows})


def _percent(row: dict[str, float | None]) -> str:
    own, frequency = row["uncertainty_hz"], row["frequency_hz"]
    return "" if own is None or frequency is None else f"{100 * own / frequency:.2g}"
