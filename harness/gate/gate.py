"""The gate: one check from a plan to a report, and what of it may be accepted."""

from collections.abc import Mapping
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any

from analytic import InputError
from harness.bench import Bench
from harness.gate.compare import compare, failures, slower
from harness.gate.finding import FAILED, condense
from harness.gate.measured import measure
from harness.gate.plan import Checked
from harness.gate.properties import properties
from harness.gate.ratchet import Baseline, Reason, accept, measure_noise
from harness.gate.report import Report
from harness.gate.timing_watch import Timing

NEVER = ("property", "failure")
"""Kinds of findings that cannot be accepted, for whatever reason."""


class NotAcceptedError(RuntimeError):
    """Why nothing was accepted."""


def look(
    checked: Checked,
    bench: Bench,
    known: Baseline | None,
    about: Mapping[str, Any] | None = None,
    history: Path | None = None,
) -> Report:
    """Return what moved since the baseline `known`, and what does not hold.

    `about`: provenance; `history`: with what was solved now, to compare its seconds with.
    """
    now, about = measure(checked, bench), about or {}
    timings, notes = _watched(history, checked, known, about["machine"]) if history else ([], [])
    seen = [*failures(checked), *properties(checked, bench), *slower(timings)]
    if known is None:
        notes = ["compared with no baseline", *notes]
    else:
        seen += compare(known, now, checked)
    return Report(tuple(seen), tuple(timings), now, known, about, (*checked.plan.notes, *notes))


def _watched(
    history: Path, checked: Checked, known: Baseline | None, machine: str
) -> tuple[list[Timing], list[str]]:
    """Return the timings of what was solved now, from a history that holds it; and notes."""
    from harness.gate.timing_watch import timings
    from harness.history.store import open_history

    past = open_history(history)
    accepted = {} if known is None else known.timed_since
    since = {model: datetime.fromisoformat(text) for model, text in accepted.items()}
    solved = {row["model"] for row in checked.rows}
    # What was not solved now has not changed now.
    found = [one for one in timings(past, machine, since) if one.model in solved]
    return found, [f"history: skipped {path}: {why}" for path, why in past.skipped]


def accepted(report: Report, checked: Checked, bench: Bench, reason: str) -> Baseline:
    """Return the baseline that takes what was found.

    Raises `NotAcceptedError` where a property or a model fails, and `InputError` where something
    lowers the bar and no reason is given.
    """
    about = report.about
    never = [one.kind for one in report.failed if one.kind in NEVER]
    if never:
        kinds = " and ".join(sorted({*never}))
        raise NotAcceptedError(f"nothing accepted: {len(never)} x {kinds}, which cannot be")
    lower = [one for one in report.failed if one.verdict == FAILED]
    if lower and not reason:
        raise InputError("reason", None, f"why {len(lower)} findings that lower the bar are right")
    gone = {one.model for one in lower if one.kind == "missing"} - report.now.sources.keys()
    reasons = [
        Reason(about["time"], about["commit"], one.quantity, one.model,
               one.case if of == 1 else f"{one.case} (worst of {of})", one.mode or 0,
               str(one.before), str(one.after), reason)
        for one, of in condense(lower)
    ]  # fmt: skip
    noise = measure_noise(checked, bench)
    result = accept(report.baseline, report.now, noise, about, reason, reasons, gone)
    moved = {one.model for one in report.findings if one.kind == "timing"}
    since = {one.model: one.since.isoformat() for one in report.timings if one.model in moved}
    return replace(result, timed_since=result.timed_since | since)
