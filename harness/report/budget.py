"""The error budget: the parts that add up to the paper's one "error (%)"."""

from dataclasses import replace

import numpy as np

from harness.bench import label
from harness.report.material import Material
from harness.report.section import Json, Section, digits, shown
from harness.studies.budget import ELEMENTS, Budget

KEY, TITLE, MENU = "budget", "Error budget", "Budget"
MEANING = {
    ELEMENTS: "the theory with s elements less the same theory without any",
    "rotary inertia": "exact Euler-Bernoulli less exact Rayleigh",
    "shear": "exact Rayleigh less exact Timoshenko",
}


def section(run: Material) -> Section | None:
    """Return the section."""
    found = {stem: one for stem, one in run.of(Budget).items() if one.shares}
    if not found:
        return None
    ordered = sorted(found.values(), key=lambda one: one.reference != run.plan.solid)
    data = [_budget(run, one) for one in ordered]
    context = {
        "cases": list(dict.fromkeys(name for one in data for name in one["cases"])),
        "references": [one["reference"] for one in data],
        "elements": list(dict.fromkeys(str(s) for one in data for s in one["elements"])),
        "sentences": [line for one in ordered for line in one.sentences()],
        "tables": [shown(one.table(), lambda row, k: None) for one in ordered],
    }
    return Section(KEY, TITLE, MENU, run.only("budget"), context, data)


def _budget(run: Material, one: Budget) -> Json:
    pick = [i - 1 for i in one.shown]
    cases = {}
    for case, shares in one.shares.items():
        records = []
        for s in one.elements:
            mesh = replace(one.theory, elements=s)
            models = [run.record(case, model) for model in (mesh, one.reference)]
            records.append([
                run.ledger.add(
                    f"Error budget, {case.name}: {part}, s = {s}, against {label(one.reference)}",
                    {"What": MEANING.get(part, "in points of the reference's frequency"),
                     "Command": run.only("budget")}, models,
                )
                for part in (*one.parts, "total error")
            ])  # fmt: skip
        cases[case.name] = {
            "shares": [[[digits(float(v), 8) for v in part[pick]] for part in table]
                       for table in shares],
            "total": [[digits(float(v), 8) for v in table.sum(axis=0)[pick]] for table in shares],
            "band": [digits(float(v), 4) if np.isfinite(v) else None
                     for v in one.bands[case][one.reference][pick]],
            "records": records,
        }  # fmt: skip
    return {
        "theory": one.theory.name,
        "reference": label(one.reference),
        "parts": list(one.parts),
        "elements": list(one.elements),
        "modes": list(one.shown),
        "cases": cases,
    }
