"""The first screen: what was checked, against what, what was found, and the gate's last answer."""

from collections import Counter
from typing import Any

from harness import published
from harness.bench import label
from harness.report import pictures
from harness.report.material import Material
from harness.report.section import Json, Section
from harness.report.verdicts import OTHER, VERDICTS, verdicts
from harness.studies.table import TableOne, against_print, causes
from reference_models import Named

KEY, TITLE, MENU = "result", "The result", "Result"
SHOWN = ("kind", "model", "case", "mode", "quantity", "before", "after", "tolerance", "verdict",
         "cause")  # fmt: skip
"""What of a finding of the gate is shown, if it has it."""


def section(run: Material, fig3: Section | None) -> Section:
    """Return the section; the gate's answer comes when the page is made: `with_gate`."""
    found = run.of(TableOne)
    table = next(iter(found.values()), None)
    paper = published.paper() if run.about_paper else None
    context = {
        "paper": paper,
        "heading": _heading(run, paper),
        "finding": [] if table is None else causes(table.study, table.theories[0]),
        "answers": _answers(run, table, paper),
        "verdicts": _counts(run),
        "mechanism": pictures.mechanism(run.plan.cases[0]),
        "fig3": None if fig3 is None or fig3.data is None else pictures.fig3(fig3.data),
        "gate": None,
    }
    return Section(KEY, TITLE, MENU, run.command, context)


def _heading(run: Material, paper: Json | None) -> str:
    if paper is not None:
        return "A published model of the 3-RPS manipulator, checked against independent simulators"
    names = ", ".join(case.name for case in run.plan.cases)
    return f"{names}: natural frequencies, checked against independent simulators"


def _answers(run: Material, table: TableOne | None, paper: Json | None) -> list[Json]:
    """Return questions that a reader has, each with what the run says of it."""
    cases = "; ".join(case.heading for case in run.plan.cases)
    notes = "; ".join(dict.fromkeys(case.note for case in run.plan.cases if case.note))
    theory = run.plan.theory
    checked = f"{theory.label} ({theory.info().theory}) at {cases}: {notes or 'as given'}."
    answers = [{"question": "What was checked?", "said": [checked]}]
    if run.plan.references:
        said = "; ".join(_of(model) for model in run.plan.references)
        answers.append({"question": "Against what?", "said": [f"{said}."]})
    if table is not None and paper is not None:
        printed = [case for case in table.study.complete(table.theories[0]) if case.published]
        lines = against_print(table.study, table.theories[0], printed) if printed else []
        errata = {one.id: one for one in published.errata()}
        lines += [errata[name].evidence for name in ("height", "cases-disagree") if name in errata]
        answers.append({"question": "Where does the paper contradict itself?", "said": lines})
    return answers


def _of(model: Named) -> str:
    info = model.info()
    return f"{label(model)} ({info.theory})"


def _counts(run: Material) -> list[Json]:
    counts = Counter(one["kind"] for one in verdicts(run))
    return [{"kind": name, "count": counts[name]} for name in (*VERDICTS, OTHER) if counts[name]]


def gate(check: dict[str, Any] | None) -> Json | None:
    """Return the gate's last answer as the first screen shows it."""
    if check is None:
        return None
    findings = [one for one in check.get("findings", []) if isinstance(one, dict)]
    names = [n for n in SHOWN if any(one.get(n) not in (None, "") for one in findings)]
    status = str(check.get("status", "not said"))
    rows = [["" if one.get(n) is None else _short(one[n]) for n in names] for one in findings]
    table = {"title": "Findings of the gate against what was accepted", "columns": names,
             "numeric": [False] * len(names), "rows": rows, "notes": []}  # fmt: skip
    return {
        "status": status,
        "good": status == "passed",
        "summary": str(check.get("summary", "")).removeprefix(f"{status}: "),
        "time": str(check.get("time", ""))[:16].replace("T", " "),
        "table": table if rows else None,
    }


def _short(value: Any) -> str:
    return f"{value:.9g}" if isinstance(value, float) else str(value)
