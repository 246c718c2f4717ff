"""What the figures say, in plain words: every number in a sentence is computed for it."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from harness import published
from harness.cases import Case
from harness.compare import relative_error
from harness.models import Spec
from harness.run import Study

AGREES = 0.1
"""Two sets of figures agree if none differs by more than this [%]: ten times Table I's rounding."""

EULER, TIMOSHENKO = Spec("euler-bernoulli", None), Spec("timoshenko", None)
CAUSES = (EULER, TIMOSHENKO)
"""The models, besides the theory and the references, that tell the causes of error apart."""


def summarise(study: Study, theory: Spec, references: Sequence[Spec]) -> list[str]:
    """Return what does and does not agree with the printed Table I, and why.

    `study` holds `theory`, the `references` and `CAUSES` at every case.
    """
    lines = []
    for case in study.cases:
        ours = study.modes[case.name, theory.label].frequencies[: study.count]
        lines += _against_print(case, theory, ours)
        lines += _causes(case, study, theory, ours)
        for reference in references:
            lines += _reference(case, study, reference)
    return lines


def _against_print(case: Case, theory: Spec, ours: NDArray[np.float64]) -> list[str]:
    if not case.published:
        return []
    printed = np.array(published.table1()[case.published, "Theoretical"])
    error = relative_error(ours[:6], printed[: len(ours)])
    if np.abs(error).max() <= AGREES:
        verdict = "agrees with"
    elif np.abs(error).min() > AGREES:
        verdict = "does not agree with"
    else:
        verdict = "agrees only in part with"
    return [
        f"{case.name}: {theory.label} {verdict} the printed theoretical values: "
        f"{_span(error)} off ({case.note})."
    ]


def _causes(case: Case, study: Study, theory: Spec, ours: NDArray[np.float64]) -> list[str]:
    exact, sheared = (
        study.modes[case.name, spec.label].frequencies[: len(ours)] for spec in CAUSES
    )
    beam = relative_error(exact, sheared)
    low, high = beam[:3], beam[3:]
    lines = []
    if theory.name == EULER.name:
        elements = np.abs(relative_error(ours, exact)).max()
        lines.append(
            f"{case.name}: {theory.elements} elements a limb cost at most {elements:.2g} %; "
            "that is the discretisation error."
        )
    parts = [
        f"{_span(part)} on {name}" for part, name in ((low, "f1-f3"), (high, "f4-f6")) if len(part)
    ]
    lines.append(
        f"{case.name}: Euler-Bernoulli lies {' and '.join(parts)} above Timoshenko "
        "(both without elements); that is beam theory, and no number of elements removes it."
    )
    if case.published and len(high):
        quoted = np.array(published.table1()[case.published, "Error (%)"])[3 : len(ours)]
        lines.append(
            f"{case.name}: so the {_span(quoted)} that the paper quotes for f4-f6 is of the size "
            "of beam theory, not of the number of elements."
        )
    return lines


def _reference(case: Case, study: Study, reference: Spec) -> list[str]:
    modes = study.get(case, reference)
    if modes is None:
        why = study.failures[case.name, reference.label]
        return [f"{case.name}: {reference.label} failed: {why}"]
    same = TIMOSHENKO if modes.theory.startswith("Timoshenko") else EULER
    pairing = study.pairing(case, same, reference)
    assert pairing is not None, "both models have an answer"
    exact = study.modes[case.name, same.label].frequencies[: study.count]
    error = relative_error(modes.frequencies[pairing.partner], exact)
    return [
        f"{case.name}: {reference.label} ({modes.version}) is within "
        f"{np.abs(error).max():.2g} % of the exact {same.name} limit; "
        "that is the simulator's own error."
    ]


def _span(values: NDArray[np.float64]) -> str:
    low, high = f"{values.min():.2f}", f"{values.max():.2f}"
    return f"{low} %" if low == high else f"{low} to {high} %"
