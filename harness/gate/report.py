"""What a check found, as tables, JSON, JUnit XML and Markdown."""

import json
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

from harness.gate.compare import KINDS, Finding, condense, moved
from harness.gate.measured import Measured
from harness.gate.plan import group
from harness.gate.properties import Property
from harness.gate.ratchet import Baseline
from harness.gate.timing_watch import Timing
from harness.result import Result
from harness.tables import Cell, Table

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Report(Result):
    """All that a check looked at.

    Attributes: `findings`, every property in `held` and timing in `timings`; `now`, what was
    measured; `baseline`, if any; `about`: provenance, command and seconds; `notes` for people.
    """

    findings: tuple[Finding, ...]
    held: tuple[Property, ...]
    timings: tuple[Timing, ...]
    now: Measured
    baseline: Baseline | None
    about: Mapping[str, Any]
    notes: tuple[str, ...] = ()

    @property
    def failed(self) -> list[Finding]:
        """The findings that make the check fail."""
        return [one for one in self.findings if one.fails]

    @property
    def passed(self) -> bool:
        """Whether something was compared and nothing failed."""
        return self.compared and not self.failed

    @property
    def compared(self) -> bool:
        """Whether anything was compared: with the baseline, or without any by its properties."""
        return self.checked["property" if self.baseline is None else "frequency"] > 0

    @property
    def checked(self) -> dict[str, int]:
        """How many of each kind were compared."""
        old, now = Measured() if self.baseline is None else self.baseline.figures, self.now
        return {
            "frequency": sum(key in old.modes for key in now.modes),
            "uncertainty": sum(key in old.uncertainties for key in now.modes),
            "shape": sum(key in old.modes for key in now.modes),
            "mode count": sum(key in old.counts for key in now.counts),
            "order": sum(key in old.orders for key in now.orders),
            "property": len(self.held),
            "timing": len(self.timings),
        }

    def timed(self, seconds: float) -> "Report":
        """Return the report with how long the check took."""
        return replace(self, about={**self.about, "seconds": round(seconds, 1)})

    def to_frame(self) -> "pd.DataFrame":
        """Return one row a finding."""
        import pandas as pd

        names = list(Finding.__dataclass_fields__)
        return pd.DataFrame([one.record() for one in self.findings], columns=names)

    def tables(self) -> dict[str, Table]:
        """Return how much was compared, what moved if anything did, properties and seconds."""
        found = {"": summary_table(self)}
        if self.findings:
            found["-findings"] = findings_table(self)
        if self.held:
            found["-properties"] = properties_table(self)
        if self.timings:
            found["-timings"] = timings_table(self)
        return found

    def sentences(self) -> list[str]:
        """Return the outcome, and notes."""
        return [f"rps-bench check {sentence(self)}", *self.notes]


def findings_table(report: Report) -> Table:
    """Return what moved, by kind; of the map's poses each model's worst."""
    rows: list[tuple[Cell, ...]] = []
    shown = condense(report.findings)
    for one, of in sorted(shown, key=lambda pair: KINDS.index(pair[0].kind)):
        where = one.case if of == 1 else f"{one.case} (worst of {of})"
        rows.append(
            (one.kind, one.model, where, "" if one.mode is None else f"f{one.mode}", one.quantity,
             _value(one.before), _value(one.after), _change(one), _tolerance(one), one.verdict,
             one.cause)
        )  # fmt: skip
    columns = ("Kind", "Model", "Case", "Mode", "Quantity", "Before", "After", "Change",
               "Allowed", "Verdict", "Cause")  # fmt: skip
    return Table("What moved", columns, tuple(rows))


def summary_table(report: Report) -> Table:
    """Return how much was compared and how much of it failed."""
    failed = Counter(one.kind for one in report.failed)
    noted = Counter(one.kind for one in report.findings if not one.fails)
    counted: dict[str, Cell] = dict(report.checked)
    rows = tuple(
        (kind, counted.get(kind, ""), failed[kind], noted[kind])
        for kind in KINDS
        if counted.get(kind) or failed[kind] or noted[kind]
    )
    return Table("Compared", ("Kind", "Compared", "Failed", "Noted"), rows)


def properties_table(report: Report) -> Table:
    """Return every property with its measured deviation and bound."""
    rows = tuple(
        (one.name, one.model, one.case, "" if one.mode is None else f"f{one.mode}",
         f"{one.deviation:.1e}", f"{one.bound:.1e}", one.remark, "yes" if one.holds else "NO")
        for one in report.held
    )  # fmt: skip
    columns = ("Property", "Model", "Worst at", "Mode", "Deviation", "Bound", "Bound from", "Holds")
    return Table("What needs no baseline", columns, rows)


def timings_table(report: Report) -> Table:
    """Return every model's seconds: the last runs against those before, and the noise."""
    rows = tuple(
        (one.model, one.slower.runs, f"{100 * (one.slower.factor - 1):+.0f}",
         f"{100 * one.slower.noise:.0f}", f"{one.slower.score:.2f}", f"{one.faster.score:.2f}")
        for one in report.timings
    )  # fmt: skip
    columns = ("Model", "Runs", "Last runs [%]", "Noise of a run [%]", "Slower", "Faster")
    note = "slower, faster: mean score over its threshold; from 1 on a change"
    return Table("Seconds, by the yardstick of the same run", columns, rows, (note,))


def sentence(report: Report) -> str:
    """Return the outcome in one sentence."""
    failed, count = report.failed, sum(report.checked.values())
    if failed:
        kinds = Counter(one.kind for one in failed)
        said = ", ".join(f"{kinds[kind]} x {kind}" for kind in KINDS if kinds[kind])
        models = list(dict.fromkeys(one.model for one in failed if one.model))
        more = " and others" if len(models) > 6 else ""
        return f"failed: {said}; {', '.join(models[:6])}{more}"
    if report.compared:
        return f"passed: {count} figures compared, nothing moved"
    what = "and nothing that needs no baseline was seen either"
    if report.baseline is not None:
        what = "for the baseline holds none of these; rps-bench accept adds what is new"
    return f"failed: nothing was compared, {what}"


def as_json(report: Report) -> bytes:
    """Return everything, for programs; of the map's poses each model's worst, `of` so many."""
    content = {
        "status": "passed" if report.passed else "failed",
        "summary": sentence(report),
        **report.about,
        "checked": report.checked,
        "findings": [one.record() | {"of": of} for one, of in condense(report.findings)],
        "properties": [vars(one) | {"holds": one.holds} for one in report.held],
        "timings": [
            {"model": one.model, "runs": one.slower.runs, "factor": one.slower.factor,
             "noise": one.slower.noise, "slower": one.slower.score, "faster": one.faster.score}
            for one in report.timings
        ],
        "notes": list(report.notes),
    }  # fmt: skip
    return (json.dumps(_finite(content), indent=1, default=str) + "\n").encode()


def _finite(value: Any) -> Any:
    """Return `value` with text in the place of numbers that JSON does not have."""
    if isinstance(value, dict):
        return {key: _finite(one) for key, one in value.items()}
    if isinstance(value, list):
        return [_finite(one) for one in value]
    if isinstance(value, float) and not abs(value) < float("inf"):
        return str(value)
    return value


def as_markdown(report: Report) -> bytes:
    """Return a summary for a CI's page: GitHub-flavoured Markdown."""
    mark = ":white_check_mark:" if report.passed else ":x:"
    parts = [f"# {mark} rps-bench check {sentence(report)}\n", summary_table(report).markdown()]
    if report.findings:
        parts.append(findings_table(report).markdown())
    parts += [f"- {note}\n" for note in report.notes]
    parts += [
        f"<details><summary>{table.title}</summary>\n\n{table.markdown()}\n</details>\n"
        for table in (properties_table(report), timings_table(report))
        if table.rows
    ]
    parts.append(", ".join(f"{name} {value}" for name, value in report.about.items()) + "\n")
    return "\n".join(parts).encode()


def as_junit(report: Report) -> bytes:
    """Return JUnit XML: a suite a kind, a test case a model and case, a property or a timing.

    The map is one case; a failure has a line for each of its poses.
    """
    tests: dict[str, dict[tuple[str, str], list[Finding]]] = {kind: {} for kind in KINDS}
    if report.baseline is not None:
        for case, model, _ in report.now.modes.keys() & report.baseline.figures.modes.keys():
            for kind in ("frequency", "shape", "mode count"):
                tests[kind].setdefault((model, group(case)), [])
        for case, name, _ in report.now.orders.keys() & report.baseline.figures.orders.keys():
            tests["order"].setdefault((name, case), [])
    for one in report.held:
        tests["property"].setdefault((one.model, one.name), [])
    for timing in report.timings:
        tests["timing"].setdefault((timing.model, "seconds"), [])
    for finding in report.findings:
        name = group(finding.case) or finding.quantity
        if finding.kind in ("property", "timing"):
            name = finding.quantity if finding.kind == "property" else "seconds"
        tests[finding.kind].setdefault((finding.model, name), []).append(finding)
    root = ElementTree.Element("testsuites", name="rps-bench check")
    for kind, found in tests.items():
        bad = sum(any(one.fails for one in findings) for findings in found.values())
        suite = ElementTree.SubElement(
            root, "testsuite", name=kind, tests=str(len(found)), failures=str(bad)
        )
        for (model, name), findings in sorted(found.items()):
            test = ElementTree.SubElement(suite, "testcase", classname=f"{kind}.{model}", name=name)
            failed = [_line(one) for one in findings if one.fails]
            if failed:
                ElementTree.SubElement(test, "failure", message=failed[0]).text = "\n".join(failed)
            elif findings:
                ElementTree.SubElement(test, "system-out").text = "\n".join(map(_line, findings))
    ElementTree.indent(root)
    text = ElementTree.tostring(root, encoding="unicode")
    return f"<?xml version='1.0' encoding='utf-8'?>\n{text}\n".encode()


FORMS = {"json": as_json, "markdown": as_markdown, "junit": as_junit}
"""How a report is written, by the option that names its file."""


def _line(one: Finding) -> str:
    mode = "" if one.mode is None else f" mode {one.mode}"
    cause = f" ({one.cause})" if one.cause else ""
    return (
        f"{one.model} {one.case}{mode}: {one.quantity} {_value(one.before)} -> "
        f"{_value(one.after)}, {_change(one)}, allowed {_tolerance(one)}: {one.verdict}{cause}"
    )


def _value(value: float | str | None) -> str:
    return "" if value is None else f"{value:.12g}" if isinstance(value, float) else value


def _change(one: Finding) -> str:
    change = moved(one)
    if change is None:
        return ""
    if one.kind == "timing":
        return f"{100 * change:+.0f} %"
    return f"{change:+.1e}" if one.kind in ("frequency", "property") else f"{change:+.3g}"


def _tolerance(one: Finding) -> str:
    if one.tolerance is None:
        return ""
    return f"noise {100 * one.tolerance:.0f} %" if one.kind == "timing" else f"{one.tolerance:.1e}"
