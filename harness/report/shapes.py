"""Mode shapes that turn and move: the theory, its exact limits, and every reference."""

from typing import Any

import numpy as np

from analytic import limbs_at, position
from analytic.model import Model
from harness.bench import label
from harness.cases import Case
from harness.report.material import Material
from harness.report.section import Json, Section, digits

AMPLITUDE = 0.2
"""Largest displacement drawn, relative to the mean limb length."""


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
            data[case.name] = {
                **{name: _rounded(value) for name, value in geometry(case).items()},
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


def geometry(case: Case) -> dict[str, Any]:
    """Return the undeformed mechanism [m]: limbs from `bases` to `tips`, the disc's two axes."""
    limbs, bases = limbs_at(case.mechanism, case.pose), case.mechanism.bases
    return {
        "bases": bases,
        "tips": bases + limbs.lengths[:, None] * limbs.frames[:, :, 2],
        "rods": [limb.rod.diameter / 2 for limb in case.mechanism.limbs],
        "centre": np.asarray(position(case.mechanism, case.pose)),
        "axes": case.pose.rotation.T[:2],
        "radius": float(np.linalg.norm(case.mechanism.platform_points, axis=1).max()),
    }


def _model(run: Material, case: Case, model: Model) -> Json:
    modes = run.answers[case, model].first(max(run.plan.shown))
    length = limbs_at(case.mechanism, case.pose).lengths.mean()
    scale = AMPLITUDE * length / np.maximum(np.abs(modes.limbs).max(axis=(1, 2, 3)), 1e-12)
    return {
        "f": digits(modes.frequencies),
        "platform": _rounded(scale[:, None] * modes.platform),
        "limbs": _rounded(scale[:, None, None, None] * modes.limbs),
        "record": run.record(case, model),
    }


def _rounded(values: Any) -> Any:
    """Return lengths to a hundredth of a millimetre: more cannot be seen."""
    return np.round(values, 5).tolist()
