"""Mode shapes that turn and move: the theory, its exact limits, and every reference."""

from typing import Any

import numpy as np

from analytic import limbs_at, position
from analytic.model import Model
from harness.bench import label
from harness.cases import Case
from harness.report.material import Material
from harness.report.section import Json, Section, digits

KEY, TITLE, MENU = "shapes", "Mode shapes", "Shapes"
AMPLITUDE = 0.2
"""Largest displacement drawn, relative to the mean limb length."""


def section(run: Material) -> Section | None:
    """Return the section."""
    data = {}
    for case in run.plan.cases:
        models = _models(run, case)
        if models:
            geometry = _geometry(case)
            data[case.name] = {
                **geometry,
                "models": {label(m): _model(run, case, m, geometry["length"]) for m in models},
            }
    if not data:
        return None
    part = run.part("shapes")
    context = {
        "cases": list(data),
        "models": list(dict.fromkeys(name for one in data.values() for name in one["models"])),
        "modes": max(run.plan.shown),
        "amplitude": AMPLITUDE,
        "sentences": [] if part is None else part.sentences(),
    }
    return Section(KEY, TITLE, MENU, run.only("table,convergence,shapes"), context, data)


def _models(run: Material, case: Case) -> list[Model]:
    """Return what is drawn: the theory with each number of elements, references, exact theories."""
    families = list(run.families(case).values())
    wanted = [run.plan.theory, *run.references(case), *(families[0].values() if families else ())]
    return [model for model in dict.fromkeys(wanted) if (case, model) in run.answers]


def _geometry(case: Case) -> Json:
    """Return the undeformed mechanism [m]: limbs from `bases` to `tips`, the disc's two axes."""
    limbs, turned = limbs_at(case.mechanism, case.pose), case.pose.rotation
    bases = case.mechanism.bases
    return {
        "bases": _rounded(bases),
        "tips": _rounded(bases + limbs.lengths[:, None] * limbs.frames[:, :, 2]),
        "rods": [limb.rod.diameter / 2 for limb in case.mechanism.limbs],
        "centre": _rounded(position(case.mechanism, case.pose)),
        "axes": _rounded(turned.T[:2]),
        "radius": digits(float(np.linalg.norm(case.mechanism.platform_points, axis=1).max()), 5),
        "length": float(limbs.lengths.mean()),
    }


def _model(run: Material, case: Case, model: Model, length: float) -> Json:
    modes = run.answers[case, model].first(max(run.plan.shown))
    largest = np.abs(modes.limbs).max(axis=(1, 2, 3))
    scale = AMPLITUDE * length / np.maximum(largest, 1e-12)
    return {
        "f": [digits(float(f)) for f in modes.frequencies],
        "platform": _rounded(scale[:, None] * modes.platform),
        "limbs": _rounded(scale[:, None, None, None] * modes.limbs),
        "record": run.record(case, model),
    }


def _rounded(values: Any) -> Any:
    """Return lengths to a hundredth of a millimetre: more cannot be seen."""
    return np.round(values, 5).tolist()
