"""What the figures say, in plain words: every number in a sentence is computed for it."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analytic.theory import BEAMS
from harness import published
from harness.cases import Case
from harness.compare import relative_error
from harness.models import Spec
from harness.run import Study

AGREES = 0.1
"""Two sets of figures agree if none differs by more than this [%]: ten times Table I's rounding."""

EULER, TIMOSHENKO = "euler-bernoulli", "timoshenko"


def causes(theory: Spec) -> list[Spec]:
    """Return the models, besides theory and references, that tell the causes of error apart."""
    return [
        Spec(name, None, theory.shear) for name in dict.fromkeys((theory.name, EULER, TIMOSHENKO))
    ]


def summarise(study: Study, theory: Spec, references: Sequence[Spec]) -> list[str]:
    """Return what does and does not agree with the printed Table I, and why.

    `study` holds `theory`, the `references` and its `causes` at every case.
    """
    lines = []
    for case in study.cases:
        lines += _against_print(case, study, theory, references)
        lines += _causes(case, study, theory)
        lines += _simulators(case, study, theory, references)
    return lines


def closest_readings(readings: Sequence[Study]) -> list[str]:
    """Return which of the `readings` of the paper comes closest to each printed case."""
    worst: dict[str, list[tuple[float, Case]]] = {}
    for study in readings:
        for case, spec in zip(study.cases, study.specs, strict=True):
            printed = np.array(published.table1()[case.published, "Theoretical"])
            off = relative_error(study.modes[case.name, spec.label].frequencies[:6], printed)
            worst.setdefault(case.published, []).append((float(np.abs(off).max()), case))
    lines = []
    for name, found in worst.items():
        off_by, case = min(found, key=lambda entry: entry[0])
        lines.append(
            f"{name}: of all readings tried here, {case.name} comes closest to the printed "
            f"theoretical values, to {_percent(off_by)}: {case.note}."
        )
    return lines


def _exact(case: Case, study: Study, theory: Spec, name: str) -> NDArray[np.float64]:
    label = Spec(name, None, theory.shear).label
    return study.modes[case.name, label].frequencies[: study.count]


def _against_print(case: Case, study: Study, theory: Spec, references: Sequence[Spec]) -> list[str]:
    if not case.published:
        return []
    printed = np.array(published.table1()[case.published, "Theoretical"])
    quoted = np.array(published.table1()[case.published, "Error (%)"])
    ours = study.modes[case.name, theory.label].frequencies
    off = relative_error(ours[:6], printed)
    agreeing = int((np.abs(off) <= AGREES).sum())
    lines = [
        f"{case.name}: {agreeing} of the 6 printed theoretical values agree with {theory.label} "
        f"to {AGREES} %; ours are {_span(off)} off ({case.note})."
    ]
    pairing = study.pairing(case, theory, references[0])
    against = study.get(case, references[0])
    if pairing is not None and against is not None:
        fea = against.frequencies[pairing.partner]
        error = relative_error(ours[: study.count], fea)[:6]
        agreeing = int((np.abs(error - quoted) <= AGREES).sum())
        lines.append(
            f"{case.name}: against {references[0].label} the errors of f1-f3 are "
            f"{_span(error[:3])} (printed: {_span(quoted[:3])}), those of f4-f6 "
            f"{_span(error[3:])} (printed: {_span(quoted[3:])}); {agreeing} of 6 agree to "
            f"{AGREES} points."
        )
    return lines


def _causes(case: Case, study: Study, theory: Spec) -> list[str]:
    ours = study.modes[case.name, theory.label].frequencies[: study.count]
    own = relative_error(ours, _exact(case, study, theory, theory.name))
    beam = relative_error(*(_exact(case, study, theory, name) for name in (EULER, TIMOSHENKO)))
    return [
        f"{case.name}: of that, the number of elements ({theory.label}) accounts for at most "
        f"{_percent(np.abs(own).max())}, and beam theory (Euler-Bernoulli against Timoshenko, both "
        f"without elements) for {_span(beam[:3])} on f1-f3 and {_span(beam[3:6])} on f4-f6, which "
        "no number of elements removes."
    ]


def _simulators(case: Case, study: Study, theory: Spec, references: Sequence[Spec]) -> list[str]:
    beams, others = [], []
    for reference in references:
        modes = study.get(case, reference)
        if modes is None:
            others.append(f"{case.name}: {reference.label} failed.")
            continue
        name = next((n for n in BEAMS if modes.theory.startswith(BEAMS[n])), None)
        limit = Spec(name if name in (EULER, TIMOSHENKO) else TIMOSHENKO, None, theory.shear)
        pairing = study.pairing(case, limit, reference)
        assert pairing is not None, "both models have an answer"
        exact = _exact(case, study, theory, limit.name)
        error = relative_error(modes.frequencies[pairing.partner], exact)
        if limit.name == name:
            worst = _percent(np.abs(error).max())
            beams.append(f"{reference.label} ({modes.version}) to {worst} of {BEAMS[name]}")
        else:
            own = "not known"
            if modes.uncertainty is not None:
                own = _percent(100 * float((modes.uncertainty / modes.frequencies).max()))
            others.append(
                f"{case.name}: {reference.label} ({modes.version}; {modes.theory}) lies "
                f"{_span(error, signed=True)} from exact Timoshenko: what beam theory leaves out, "
                f"and the mesh's own uncertainty ({own})."
            )
    if not beams:
        return others
    text = f"{case.name}: the beam simulators meet the exact limit of their own theory: "
    return [f"{text}{'; '.join(beams)}.", *others]


def _percent(value: float) -> str:
    return f"{value:.2g} %" if value >= 1e-3 else "less than 0.001 %"


def _span(values: NDArray[np.float64], *, signed: bool = False) -> str:
    low, high = (f"{value:{'+' if signed else ''}.2f}" for value in (values.min(), values.max()))
    return f"{low} %" if low == high else f"{low} to {high} %"
