"""What a check found, as tables, JSON, JUnit XML and Markdown."""

import json
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any
from xml.etree import ElementTree

from harness.gate.figures import COMPARED, HELD, KINDS, NOTED, Figures, Finding, condense
from harness.gate.plan import Checked, group
from harness.gate.timing_watch import Timing
from harness.plain import plain
from harness.result import Result
from harness.tables import Table

MOVED = ("Kind", "Model", "Case", "Mode", "Quantity", "Before", "After", "Change", "Allowed",
         "Verdict", "Cause")  # fmt: skip
PROPERTIES = ("Property", "Model", "Worst at", "Mode", "Deviation", "Bound", "Bound from", "Holds")
SECONDS = ("Model", "Runs", "Last runs [%]", "Noise of a run [%]", "Slower", "Faster")
SCORE = "slower, faster: mean score over its threshold; from 1 on a change"


@dataclass(frozen=True)
class Report(Result):
    """All that a check looked at.

    Attributes: what was `solved`; `seen`, a row for everything, and every timing in `timings`;
    `now`, what was measured; `baseline`, if any; `about`: provenance, command and seconds; `notes`
    for people.
    """

    solved: Checked
    seen: tuple[Finding, ...]
    timings: tuple[Timing, ...]
    now: Figures
    baseline: Figures | None
    about: Mapping[str, Any]
    notes: tuple[str, ...] = ()

    @property
    def findings(self) -> tuple[Finding, ...]:
        """What is not as it was, or not as it must be, and notes."""
        return tuple(one for one in self.seen if one.verdict != HELD)

    @property
    def failed(self) -> list[Finding]:
        """The findings that make the check fail."""
        return [one for one in self.seen if one.fails]

    @property
    def passed(self) -> bool:
        """Whether something was compared and nothing failed."""
        return self.compared and not self.failed

    @property
    def compared(self) -> bool:
        """Whether anything was compared: with the baseline, or without any by its properties."""
        return self.checked["property" if self.baseline is None else "frequency"] > 0

    @cached_property
    def checked(self) -> dict[str, int]:
        """How many of each kind were compared."""
        counted = Counter(one.kind for one in self.seen)
        return {kind: counted[kind] for kind in COMPARED}

    def records(self) -> list[dict[str, Any]]:
        """Return one row a finding."""
        return [vars(one) for one in self.findings]

    def tables(self) -> dict[str, Table]:
        """Return how much was compared, what moved if anything did, properties and seconds."""
        failed = Counter(one.kind for one in self.failed)
        noted = Counter(one.kind for one in self.findings if not one.fails)
        compared = ((kind, self.checked.get(kind, ""), failed[kind], noted[kind]) for kind in KINDS)
        order = {kind: place for place, kind in enumerate(KINDS)}
        moved = (
            (one.kind, one.model, where, _mode(one), one.quantity, *_numbers(one), one.verdict,
             one.cause)
            for one, where, _ in sorted(condense(self.findings), key=lambda x: order[x[0].kind])
        )  # fmt: skip
        properties = (
            (one.quantity, one.model, one.case, _mode(one), f"{one.after:.1e}",
             f"{one.tolerance:.1e}", one.cause, "NO" if one.fails else "yes")
            for one in self.seen if one.kind == "property"
        )  # fmt: skip
        seconds = (
            (one.model, one.slower.runs, f"{100 * (one.slower.factor - 1):+.0f}",
             f"{100 * one.slower.noise:.0f}", f"{one.slower.score:.2f}", f"{one.faster.score:.2f}")
            for one in self.timings
        )  # fmt: skip
        found = {
            "": Table("Compared", ("Kind", "Compared", "Failed", "Noted"),
                      tuple(row for row in compared if any(row[1:]))),
            "-findings": Table("What moved", MOVED, tuple(moved)),
            "-properties": Table("What needs no baseline", PROPERTIES, tuple(properties)),
            "-timings": Table("Seconds, by the yardstick of the same run", SECONDS, tuple(seconds),
                              (SCORE,)),
        }  # fmt: skip
        return {ending: table for ending, table in found.items() if table.rows or not ending}

    def sentences(self) -> list[str]:
        """Return the outcome, and notes."""
        return [f"rps-bench check {self.outcome}", *self.notes]

    @property
    def outcome(self) -> str:
        """The outcome in one sentence."""
        if self.failed:
            kinds = Counter(one.kind for one in self.failed)
            said = ", ".join(f"{kinds[kind]} x {kind}" for kind in KINDS if kinds[kind])
            models = list(dict.fromkeys(one.model for one in self.failed if one.model))
            return f"failed: {said}; {', '.join(models[:6])}{' and others' * (len(models) > 6)}"
        if self.compared:
            gone = {one.model for one in self.findings if one.kind == "missing"}
            said = f"; accepted but not measured here: {', '.join(sorted(gone))}" if gone else ""
            return f"passed: {sum(self.checked.values())} figures compared, nothing moved{said}"
        what = "and nothing that needs no baseline was seen either"
        if self.baseline is not None:
            what = "for the baseline holds none of these; rps-bench accept adds what is new"
        return f"failed: nothing was compared, {what}"


def as_json(report: Report) -> bytes:
    """Return everything, for programs; of the map's poses each model's worst, `of` so many."""
    content = {
        "status": "passed" if report.passed else "failed",
        "summary": report.outcome,
        **report.about,
        "checked": report.checked,
        "findings": [vars(one) | {"of": of} for one, _, of in condense(report.findings)],
        "properties": [
            {"name": one.quantity, "model": one.model, "case": one.case, "mode": one.mode,
             "deviation": one.after, "bound": one.tolerance, "remark": one.cause,
             "holds": not one.fails}
            for one in report.seen if one.kind == "property"
        ],
        "timings": [
            {"model": one.model, "runs": one.slower.runs, "factor": one.slower.factor,
             "noise": one.slower.noise, "slower": one.slower.score, "faster": one.faster.score}
            for one in report.timings
        ],
        "notes": report.notes,
    }  # fmt: skip
    # JSON has no number that is not finite: a text stands for it.
    text = json.dumps(content, default=str)
    finite = json.loads(text, parse_constant=lambda constant: str(float(constant)))
    return (json.dumps(finite, indent=1) + "\n").encode()


def as_markdown(report: Report) -> bytes:
    """Return a summary for a CI's page: GitHub-flavoured Markdown."""
    mark = ":white_check_mark:" if report.passed else ":x:"
    parts, details = [f"# {mark} rps-bench check {report.outcome}\n"], []
    for ending, table in report.tables().items():
        if ending in ("", "-findings"):
            parts.append(table.markdown())
        else:
            summary = f"<details><summary>{table.title}</summary>"
            details.append(f"{summary}\n\n{table.markdown()}\n</details>\n")
    notes = [f"- {plain(note)}\n" for note in report.notes]
    about = ", ".join(f"{name} {value}" for name, value in report.about.items())
    return "\n".join([*parts, *notes, *details, f"{about}\n"]).encode()


def as_junit(report: Report) -> bytes:
    """Return JUnit XML: a suite a kind, a test case a model and case, a property or a timing.

    The map is one case; a failure has a line for each of its poses.
    """
    root = ElementTree.Element("testsuites", name="rps-bench check")
    for kind in KINDS:
        tests: dict[tuple[str, str], list[Finding]] = {}
        for one in report.seen:
            if one.kind == kind:
                other = {"property": one.quantity, "timing": "seconds"}
                name = other.get(kind, group(one.case) or one.quantity)
                tests.setdefault((one.model, name), []).append(one)
        suite = ElementTree.SubElement(root, "testsuite", name=kind, tests=str(len(tests)))
        for (model, name), found in sorted(tests.items()):
            test = ElementTree.SubElement(suite, "testcase", classname=f"{kind}.{model}", name=name)
            failed = [_line(one) for one in found if one.fails]
            noted = [_line(one) for one in found if one.verdict == NOTED]
            if failed:
                ElementTree.SubElement(test, "failure", message=failed[0]).text = "\n".join(failed)
            elif noted:
                ElementTree.SubElement(test, "system-out").text = "\n".join(noted)
        suite.set("failures", str(len(suite.findall("testcase/failure"))))
    for element in root.iter():  # XML has no characters that steer a terminal
        element.attrib = {key: plain(value) for key, value in element.attrib.items()}
        element.text = "\n".join(map(plain, (element.text or "").split("\n")))
    ElementTree.indent(root)
    text = ElementTree.tostring(root, encoding="unicode")
    return f"<?xml version='1.0' encoding='utf-8'?>\n{text}\n".encode()


FORMS = {
    "json": ("check.json", as_json),
    "markdown": ("check.md", as_markdown),
    "junit": ("check.xml", as_junit),
}
"""How a report is written, and its usual file, by the option that names another."""


def _line(one: Finding) -> str:
    mode = one.mode and f" mode {one.mode}"
    before, after, change, allowed = _numbers(one)
    cause = one.cause and f" ({one.cause})"
    return (
        f"{one.model} {one.case}{mode or ''}: {one.quantity} {before} -> {after}, {change}, "
        f"allowed {allowed}: {one.verdict}{cause}"
    )


def _mode(one: Finding) -> str:
    return "" if one.mode is None else f"f{one.mode}"


def _numbers(one: Finding) -> tuple[str, str, str, str]:
    """Return a finding's value before and after, its change, and the change allowed."""
    before, after = (
        f"{value:.12g}" if isinstance(value, float) else value or ""
        for value in (one.before, one.after)
    )
    change = (
        "" if one.moved is None else f"{one.moved:{'+.1e' if one.kind == 'frequency' else '+.3g'}}"
    )
    allowed = "" if one.tolerance is None else f"{one.tolerance:.1e}"
    if one.kind == "timing" and one.moved is not None:
        change, allowed = f"{100 * one.moved:+.0f} %", f"noise {100 * (one.tolerance or 0):.0f} %"
    return before, after, change, allowed
