"""What a check found, as tables, JSON, JUnit XML and Markdown."""

import json
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree

from harness.gate.gate import Finding, condense, moved
from harness.gate.measured import Measured
from harness.gate.metamorphic import Property
from harness.gate.ratchet import Baseline, group
from harness.gate.timing_watch import Timing
from harness.tables import Cell, Table

KINDS = ("frequency", "shape", "mode count", "order", "property", "timing", "failure", "source")
"""Every kind of finding, in the order in which tables show them."""


@dataclass(frozen=True)
class Report:
    """All that a check looked at: `findings`, every property and timing; `now`, what was measured;
    `baseline`, if any; `about`: provenance, command and seconds; `notes` for people.
    """

    findings: tuple[Finding, ...]
    properties: tuple[Property, ...]
    timings: tuple[Timing, ...]
    now: Measured
    baseline: Baseline | None
    about: Mapping[str, Any]
    notes: tuple[str, ...] = ()

    @property
    def passed(self) -> bool:
        """Whether nothing failed."""
        return not any(one.fails for one in self.findings)

    @property
    def checked(self) -> dict[str, int]:
        """How many of each kind were compared."""
        old = self.baseline.figures if self.baseline is not None else None
        return {
            "frequency": sum(key in old.modes for key in self.now.modes) if old else 0,
            "shape": sum(key in old.modes for key in self.now.modes) if old else 0,
            "mode count": sum(key in old.counts for key in self.now.counts) if old else 0,
            "order": sum(key in old.orders for key in self.now.orders) if old else 0,
            "property": len(self.properties),
            "timing": len(self.timings),
        }


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
    failed = Counter(one.kind for one in report.findings if one.fails)
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
        for one in report.properties
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
    compared = sum(report.checked.values())
    failed = [one for one in report.findings if one.fails]
    if report.passed:
        return f"passed: {compared} figures compared, nothing moved"
    kinds = Counter(one.kind for one in failed)
    said = ", ".join(f"{kinds[kind]} x {kind}" for kind in KINDS if kinds[kind])
    models = list(dict.fromkeys(one.model for one in failed if one.model))
    return f"failed: {said}; {', '.join(models[:6])}{' and others' if len(models) > 6 else ''}"


def as_json(report: Report) -> bytes:
    """Return everything, for programs; of the map's poses each model's worst, `of` so many."""
    content = {
        "status": "passed" if report.passed else "failed",
        "summary": sentence(report),
        **report.about,
        "checked": report.checked,
        "findings": [one.record() | {"of": of} for one, of in condense(report.findings)],
        "properties": [vars(one) | {"holds": one.holds} for one in report.properties],
        "timings": [
            {"model": one.model, "runs": one.slower.runs, "factor": one.slower.factor,
             "noise": one.slower.noise, "slower": one.slower.score, "faster": one.faster.score}
            for one in report.timings
        ],
        "notes": list(report.notes),
    }  # fmt: skip
    return (json.dumps(content, indent=1, default=str) + "\n").encode()


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
    for one in report.properties:
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
