"""Mode shapes that turn and move: the theory, its exact limits, and every reference."""

from typing import Any

import numpy as np

from analytic.model import Model
from harness.bench import label
from harness.case import Case
from harness.drawing import AMPLITUDE, drawn, scale
from harness.report.material import Material
from harness.report.section import Json, Section, digits

SHOWN = "starts", "tips", "centre", "axes", "radius", "ground"
"""What the page needs of what is drawn, beside spans and marks."""


def section(run: Material) -> Section | None:
    """Return the section."""
    data = {}
    for case in run.plan.cases:
        families = list(run.families(case).values())
        # The theory with each number of elements, references, exact theories.
        wanted = dict.fromkeys([
            run.plan.theory, *run.references(case), *(families[0].values() if families else ()),
        ])  # fmt: skip
        models = [model for model in wanted if (case, model) in run.answers]
        if models:
            there = drawn(case.mechanism, case.pose)
            data[case.name] = {
                **{name: _rounded(getattr(there, name)) for name in SHOWN},
                "spans": [[s.limb, *_rounded([s.begin, s.end, s.radius])] for s in there.spans],
                "marks": []
                if there.plain
                else [
                    {"kind": m.kind, "limb": m.limb, "place": m.place, "beside": _rounded(m.beside)}
                    for m in there.marks
                ],
                "models": {label(model): _model(run, case, model) for model in models},
            }
    if not data:
        return None
    part = run.part("shapes")
    context = {
        "modes": max(run.plan.shown),
        "amplitude": AMPLITUDE,
        "sentences": part.sentences() if part else [],
    }
    command = run.only("table,convergence,shapes")
    return Section("shapes", "Mode shapes", "Shapes", command, context, data)


def _model(run: Material, case: Case, model: Model) -> Json:
    modes = run.answers[case, model].first(max(run.plan.shown))
    enlarged = scale(drawn(case.mechanism, case.pose), modes.limbs)
    return {
        "f": digits(modes.frequencies),
        "platform": _rounded(enlarged[:, None] * modes.platform),
        "limbs": _rounded(enlarged[:, None, None, None] * modes.limbs),
        "record": run.record(case, model),
    }


def _rounded(values: Any) -> Any:
    """Return lengths to a hundredth of a millimetre: more cannot be seen."""
    return np.round(values, 5).tolist()
