"""Provenance: every model with an answer, its version, size, joint gap and cost."""

from harness.bench import label
from harness.report.ledger import answer
from harness.report.material import Material
from harness.report.section import Section, number
from harness.rows import mode_rows

KEY, TITLE, MENU = "provenance", "Provenance: where the numbers come from", "Provenance"
COLUMNS = ("Case", "Model", "Theory", "Version", "Coordinates", "Joint gap",
           "Uncertainty of f1 [%]", "Time")  # fmt: skip


def section(run: Material) -> Section | None:
    """Return the section."""
    left = {
        what: why
        for part in run.parts
        for result in part.results.values()
        for what, why in result.failures().items()
    }
    left |= {part.entry.title: part.why for part in run.parts if part.why}
    failures = [f"{what}: {why}" for what, why in left.items()]
    if not run.answers and not failures:
        return None
    order = {case: k for k, case in enumerate(run.plan.cases)}
    rows = []
    for (case, model), modes in sorted(run.answers.items(), key=lambda one: order[one[0][0]]):
        said = answer(mode_rows(case, label(model), "", modes, 1))
        own = modes.uncertainty
        percent = "" if own is None else f"{100 * own[0] / modes.frequencies[0]:.2g}"
        name = number(label(model), "", f"{label(model)} at {case.name}", run.record(case, model))
        rows.append([case.name, name, said["Theory"], said["Version"], said["Coordinates"],
                     said["Joint gap"], percent, said["Time"]])  # fmt: skip
    table = {
        "title": "Every model of the run; uncertainty is the numerical one, by extrapolation",
        "columns": list(COLUMNS),
        "numeric": [False, False, False, False, True, True, True, False],
        "rows": rows,
        "notes": [],
    }
    context = {"table": table, "failures": failures}
    return Section(KEY, TITLE, MENU, run.command, context)
