"""The first screen: what was checked, against what, what was found, and the gate's last answer.

Its pictures need no script: the mechanism at a pose, and Fig. 3.
"""

import re
from base64 import b64encode
from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np

from harness.bench import label
from harness.drawing import drawn
from harness.figures import COLOURS, own_style, picture
from harness.report.section import Json, Material, Section, shown
from harness.report.sections import VERDICTS, verdicts
from harness.signatures import Figure
from harness.studies.claims import verb
from harness.studies.convergence import Convergence, convergence_figure
from harness.studies.shapes import KEY, rest_figure
from harness.studies.table import TableOne, against_print, causes
from harness.tables import Table

CITED = ("authors", "title", "source", "year", "url")
"""What is said of the paper."""
SHOWN = ("kind", "model", "case", "mode", "quantity", "before", "after", "tolerance", "verdict",
         "cause")  # fmt: skip
"""What of a finding of the gate is shown, if it has it."""
PANELS = 2
"""Cases of Fig. 3 that the first screen has room for."""

INKS = {colour.lower(): f"var(--m{mode})" for mode, colour in enumerate(COLOURS, 1)} | {
    "#ffffff": "var(--paper)", "#b0b0b0": "var(--faint)", "#cccccc": "var(--rule)",
}  # fmt: skip
"""What the page calls the colours of curves, of ground, grid and frame, light or dark."""


def first(run: Material) -> Section:
    """Return the section; the gate's answer, `gate`, is put in when the page is made."""
    cases = run.plan.cases
    table = run.one(TableOne)
    paper = next((case.paper for case in cases if case.paper and case.published), None)
    ours = any(case.prints_errors for case in cases)
    names = ", ".join(case.name for case in cases)
    what = "A published model of the 3-RPS manipulator" if ours else f"{names}: natural frequencies"
    fig3 = next((one for one in run.of(Convergence) if not one.same_theory), None)
    chains = dict.fromkeys(limb.described for limb in cases[0].mechanism.limbs)
    plain = drawn(cases[0].mechanism, cases[0].pose).plain
    with own_style():
        rest = b64encode(picture(rest_figure(cases[0]), "png")).decode()
    counts = Counter(one["kind"] for one in verdicts(run))
    context = {
        "paper": {name: getattr(paper, name) for name in CITED} if paper else None,
        "heading": f"{what}, checked against independent simulators",
        "finding": _finding(table) if table else [],
        "answers": _answers(run, table if ours else None),
        "verdicts": [
            {"kind": n, "count": counts[n], "said": verb(n, counts[n])}
            for n in VERDICTS
            if counts[n]
        ],
        "mechanism": {
            "picture": f"data:image/png;base64,{rest}",
            "chains": "" if plain else " and ".join(chains),
            "key": "" if plain else KEY,
            "caption": cases[0].heading,
        },
        "fig3": _fig3(fig3) if fig3 else None,
        "gate": None,
    }
    return Section(context)


def _finding(table: TableOne) -> list[Json]:
    """Return what elements and theory cost, each behind the question that it answers."""
    theory, limit = table.theories[0], table.theories[0].limit()
    of_theory = [] if limit is None else causes(table.study, limit)
    of_elements = [line for line in causes(table.study, theory) if line not in of_theory]
    number = theory.elements
    enough = "Is one element enough?" if number == 1 else f"Are {number} elements a limb enough?"
    return [
        *({"question": enough, "said": line} for line in of_elements),
        *({"question": "What does beam theory cost?", "said": line} for line in of_theory),
    ]


def _answers(run: Material, printed: TableOne | None) -> list[Json]:
    """Return questions that a reader has, each with what the run says of it."""
    cases = "; ".join(case.heading for case in run.plan.cases)
    notes = "; ".join(dict.fromkeys(case.note for case in run.plan.cases if case.note))
    studies = [study for result in run.results for study in result.studies]
    lost = {model for study in studies for _, model in study.failures}
    lost -= {model for study in studies for _, model in study.answers}
    theory, *references = [
        f"{label(model)} ({model.info().theory})"
        for model in (run.plan.theory, *run.plan.references)
        if model == run.plan.theory or model not in lost
    ]
    said = {"What was checked?": [f"{theory} at {cases}: {notes or 'as given'}."]}
    if references:
        said["Against what?"] = [f"{'; '.join(references)}."]
    if printed:
        study, first = printed.study, printed.theories[0]
        known = [case for case in study.complete(first) if case.prints_errors]
        errata = {one.id: one.evidence for case in known if case.paper for one in case.paper.errata}
        said["Where does the paper contradict itself?"] = [
            # How far off they are is in Table I.
            *(against_print(study, first, known)[::2] if known else []),
            *(errata[name] for name in ("height", "cases-disagree") if name in errata),
        ]
    return [{"question": question, "said": lines} for question, lines in said.items()]


def gate(check: dict[str, Any] | None) -> Json | None:
    """Return the gate's last answer as the first screen shows it."""
    if check is None:
        return None
    findings = [one for one in check.get("findings", []) if isinstance(one, dict)]
    names = [n for n in SHOWN if any(one.get(n) not in (None, "") for one in findings)]
    status = str(check.get("status", "not said"))
    cells = [[one.get(name, "") for name in names] for one in findings]
    rows = [
        tuple(f"{c:.9g}" if isinstance(c, float) else "" if c is None else str(c) for c in row)
        for row in cells
    ]
    table = Table("Findings of the gate against what was accepted", names, rows)
    return {
        "status": status,
        "good": status == "passed",
        "summary": str(check.get("summary", "")).removeprefix(f"{status}: "),
        "time": str(check.get("time", ""))[:16].replace("T", " "),
        "table": shown(table) if findings else None,
    }


def _fig3(found: Convergence) -> Json:
    """Return Fig. 3 of a result, a picture for each of its first few cases, and its caption."""
    cases = [case for case, off in found.errors.items() if np.isfinite(off).any()]
    pictures, limit = [], found.theory.limit()
    for k, case in enumerate(cases[:PANELS]):
        with own_style():
            figure = convergence_figure(replace(found, study=replace(found.study, cases=(case,))))
            figure.set_size_inches(4.4, 3.7)
            figure.suptitle("")  # the caption says it
            figure.axes[0].set_title(case.heading)
        pictures.append({"title": case.heading, "picture": _inline(figure, f"panel{k}")})
    title = f"{found.theory.name} with s elements a limb against {found.reference.label}"
    return {"panels": pictures, "title": title, "limit": limit and limit.label}


def _inline(figure: Figure, name: str) -> str:
    """Return a figure as SVG in the page's colours, all ids beginning with `name`."""
    drawing = picture(figure, "svg").decode()
    drawing = re.sub(r'(id="|"#|\(#)', rf"\g<1>{name}-", drawing[drawing.index("<svg") :])
    for colour, own in INKS.items():
        drawing = drawing.replace(colour, own)
    return drawing.replace("*{", ".drawn *{")
