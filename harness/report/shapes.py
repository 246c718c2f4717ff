"""Mode shapes that turn and move: every analytic model at the paper's two cases."""

from typing import Any

import numpy as np

from analytic import limbs_at, position
from analytic.theory import BEAMS
from harness.cases import Case
from harness.models import Spec
from harness.report.ledger import Ledger
from harness.report.section import Section, digits
from harness.report.sources import ELEMENTS, Sources
from harness.shapes import AMPLITUDE

SHOWN = 6


def section(sources: Sources, ledger: Ledger) -> Section:
    """Return the section."""
    study = sources.study
    specs = [Spec(beam, s) for beam in BEAMS for s in (*ELEMENTS, None)]
    data = {}
    for case in study.cases:
        geometry = _geometry(case)
        models = {
            spec.label: _model(sources, ledger, case, spec, geometry["length"]) for spec in specs
        }
        data[case.name] = {**geometry, "models": models}
    context = {"cases": list(data), "models": [spec.label for spec in specs], "modes": SHOWN}
    return Section("shapes", "Mode shapes", context, data)


def _geometry(case: Case) -> dict[str, Any]:
    """Return the undeformed mechanism [m]: limbs from `bases` to `tips`, the disc's two axes."""
    limbs, R = limbs_at(case.mechanism, case.pose), case.pose.rotation
    bases = case.mechanism.bases
    return {
        "bases": _rounded(bases),
        "tips": _rounded(bases + limbs.lengths[:, None] * limbs.frames[:, :, 2]),
        "rods": [limb.rod.diameter / 2 for limb in case.mechanism.limbs],
        "centre": _rounded(position(case.mechanism, case.pose)),
        "axes": _rounded(R.T[:2]),
        "radius": digits(float(np.linalg.norm(case.mechanism.platform_points, axis=1).max()), 5),
        "length": float(limbs.lengths.mean()),
    }


def _model(
    sources: Sources, ledger: Ledger, case: Case, spec: Spec, length: float
) -> dict[str, Any]:
    modes = sources.study.modes[case.name, spec.label].first(SHOWN)
    largest = np.abs(modes.limbs).max(axis=(1, 2, 3))
    scale = AMPLITUDE * length / np.maximum(largest, 1e-12)
    return {
        "f": [digits(float(f)) for f in modes.frequencies],
        "platform": _rounded(scale[:, None] * modes.platform),
        "limbs": _rounded(scale[:, None, None, None] * modes.limbs),
        "record": ledger.solved(sources.study, case, spec),
    }


def _rounded(values: Any) -> Any:
    """Return lengths to a hundredth of a millimetre: more cannot be seen."""
    return np.round(values, 5).tolist()
