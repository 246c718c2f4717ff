"""What the figures say, in plain words: every number in a sentence is computed for it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analytic.theory import BEAMS
from harness import published
from harness.budget import Budget
from harness.cases import Case
from harness.compare import relative_error
from harness.convergence import Convergence
from harness.models import PAPER_ELEMENTS, Spec, formal_order
from harness.precision.ways import theory_of
from harness.refinement import Refinement
from harness.run import Study
from harness.slenderness import THEORIES, Slenderness

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


def headlines(study: Study, theory: Spec, references: Sequence[Spec]) -> list[str]:
    """Return what holds over all cases, one sentence a cause; arguments as of `summarise`."""
    cases = study.cases
    lines = []
    printed = [case for case in cases if case.published]
    if printed:
        off = np.concatenate([_off_print(case, study, theory) for case in printed])
        agreeing = int((np.abs(off) <= AGREES).sum())
        lines.append(
            f"{agreeing} of the {len(off)} printed theoretical values agree with {theory.label} at "
            f"the parameters read from the paper to {AGREES} %; ours lie {_span(off, signed=True)} "
            "from them."
        )
        wrong = [mode for case in printed for mode in _not_following(case)]
        lines.append(
            f"{len(wrong)} of the {6 * len(printed)} errors that Table I prints do not follow from "
            f"the digits of the two rows above them: {', '.join(wrong) or 'none'}."
        )
    own = [
        relative_error(_first(case, study, theory), _exact(case, study, theory, theory.name))
        for case in cases
    ]
    beam = np.array([
        relative_error(*(_exact(case, study, theory, name) for name in (EULER, TIMOSHENKO)))
        for case in cases
    ])  # fmt: skip
    lines.append(
        f"The number of elements ({theory.label}) costs {_at_most(np.abs(own).max())}; "
        f"beam theory (Euler-Bernoulli against Timoshenko, both without elements) costs "
        f"{_span(beam[:, :3])} on f1-f3 and {_span(beam[:, 3:6])} on f4-f6, which no number of "
        "elements removes."
    )
    return lines + _all_simulators(study, theory, references)


def _off_print(case: Case, study: Study, theory: Spec) -> NDArray[np.float64]:
    printed = np.array(published.table1()[case.published, "Theoretical"])
    return relative_error(study.modes[case.name, theory.label].frequencies[:6], printed)


def _not_following(case: Case) -> list[str]:
    """Return the modes whose printed error is not 100 (theory - FEA) / FEA, rounded."""
    fea, ours, error = (
        np.array(published.table1()[case.published, row])
        for row in ("FEA", "Theoretical", "Error (%)")
    )
    # Half a unit of the last digit, and what binary fractions add to it.
    off = np.abs(relative_error(ours, fea) - error) > 0.00501
    return [f"f{i + 1} of {case.name}" for i in np.flatnonzero(off)]


def _all_simulators(study: Study, theory: Spec, references: Sequence[Spec]) -> list[str]:
    """Return how far simulators are from exact beams: their own theory's, or Timoshenko's."""
    beams: dict[str, float] = {}
    solids: dict[str, dict[str, NDArray[np.float64]]] = {}
    for reference in references:
        if any(study.get(case, reference) is None for case in study.cases):
            continue
        of = theory_of(reference)
        limit = Spec(of if of in (EULER, TIMOSHENKO) else TIMOSHENKO, None, theory.shear)
        errors = []
        for case in study.cases:
            pairing = study.pairing(case, limit, reference)
            assert pairing is not None, "both models have an answer"
            found = study.modes[case.name, reference.label].frequencies[pairing.partner]
            errors.append(relative_error(found, _exact(case, study, theory, limit.name)))
        if of in BEAMS:
            beams[reference.label] = float(np.abs(errors).max())
        else:
            solids.setdefault(of, {})[reference.label] = np.array(errors)
    lines = []
    if beams:
        lines.append(
            f"The beam simulators ({', '.join(beams)}) meet the exact limit of their own theory to "
            f"{_percent(max(beams.values()))}."
        )
    for of, models in solids.items():
        each = np.array(list(models.values()))
        apart = f", which agree to {_percent(float(np.ptp(each, axis=0).max()))}," * (len(each) > 1)
        lines.append(
            f"Solid rods ({of}: {', '.join(models)}{apart.rstrip(',')}) lie "
            f"{_span(each[..., :3], signed=True)} from exact Timoshenko on f1-f3 and "
            f"{_span(each[..., 3:6], signed=True)} on f4-f6."
        )
    return lines


def closure(study: Study) -> list[str]:
    """Return the largest gap of a joint in any simulator."""
    gaps = [modes.residual for modes in study.modes.values() if modes.residual is not None]
    if not gaps:
        return []
    return [f"No joint of a simulator is open by more than {max(gaps):.0e} m."]


def orders(result: Convergence) -> list[str]:
    """Return the observed order of the discretisation error over the two finest meshes."""
    last = np.array([result.order(case.name)[-1] for case in result.study.cases])
    coarse, fine = result.elements[-2:]
    return [
        f"From {coarse} to {fine} elements the discretisation error of {result.theory.name} falls "
        f"with order {np.nanmin(last):.2f} to {np.nanmax(last):.2f}; in theory "
        f"{formal_order(result.theory):g}."
    ]


def refinements(result: Refinement) -> list[str]:
    """Return each model's observed orders, widest band and how often there is a warning."""
    lines = []
    for ladder in result.ladders:
        name = ladder[0].name
        found = [seen for (_, model, _), seen in result.found.items() if model == name]
        if not found:
            continue
        band = max(100 * seen.gci / values[-1] for values, seen in found)
        known = [seen.order for _, seen in found if np.isfinite(seen.order)]
        span = f"{min(known):.2f} to {max(known):.2f}" if known else "not to be read"
        warned = sum(bool(seen.remark) for _, seen in found)
        lines.append(
            f"{name}, {', '.join(str(spec.elements) for spec in ladder)} elements: order {span} "
            f"(in theory {formal_order(ladder[0]):g}), GCI {_at_most(band)} of the finest, "
            f"{warned} of {len(found)} frequencies with a warning."
        )
    return lines


def causes_of(result: Budget) -> list[str]:
    """Return the range of each part over cases, with the paper's number of elements."""
    if not result.shares or PAPER_ELEMENTS not in result.elements:
        return []
    k = result.elements.index(PAPER_ELEMENTS)
    shares = np.array([table[k] for table in result.shares.values()])
    parts = "; ".join(
        f"{part} {_span(shares[:, p, :3], signed=True)} on f1-f3 and "
        f"{_span(shares[:, p, 3:6], signed=True)} on f4-f6"
        for p, part in enumerate(result.parts)
    )
    label, against = replace(result.theory, elements=PAPER_ELEMENTS).label, result.reference.label
    own = np.array([bands[against] for bands in result.uncertainty.values()])
    known = "not known" if np.isnan(own).any() else _at_most(float(own.max()))
    return [f"{label} against {against}, by cause: {parts}. The reference's own GCI: {known}."]


def slender(result: Slenderness) -> list[str]:
    """Return the largest errors of both theories for the most slender and the stoutest rods."""
    lines = []
    for k in (0, len(result.ratios) - 1):
        worst = [
            max(float(np.nanmax(np.abs(result.errors[case.name, theory][k])))
                for case in result.cases)
            for theory in THEORIES
        ]  # fmt: skip
        lines.append(
            f"At d/L = {result.ratios[k]:g} exact Euler-Bernoulli is up to {_percent(worst[0])} "
            f"from {result.reference.label}, exact Timoshenko up to {_percent(worst[1])}."
        )
    return lines


def alike(study: Study, theory: Spec, references: Sequence[Spec]) -> list[str]:
    """Return the smallest assurance of a mode with its partner, reference by reference."""
    lines = []
    for reference in references:
        pairings = [study.pairing(case, theory, reference) for case in study.cases]
        least = min((float(p.assurance.min()) for p in pairings if p is not None), default=None)
        if least is not None:
            lines.append(
                f"Every mode of {theory.label} has its partner in {reference.label} with an "
                f"assurance of at least {least:.4f}."
            )
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


def _first(case: Case, study: Study, spec: Spec) -> NDArray[np.float64]:
    return study.modes[case.name, spec.label].frequencies[: study.count]


def _exact(case: Case, study: Study, theory: Spec, name: str) -> NDArray[np.float64]:
    return _first(case, study, Spec(name, None, theory.shear))


def _against_print(case: Case, study: Study, theory: Spec, references: Sequence[Spec]) -> list[str]:
    if not case.published:
        return []
    quoted = np.array(published.table1()[case.published, "Error (%)"])
    ours = study.modes[case.name, theory.label].frequencies
    off = _off_print(case, study, theory)
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


def _at_most(value: float) -> str:
    return f"at most {value:.2g} %" if value >= 1e-3 else _percent(value)


def _percent(value: float) -> str:
    return f"{value:.2g} %" if value >= 1e-3 else "less than 0.001 %"


def _span(values: NDArray[np.float64], *, signed: bool = False) -> str:
    low, high = (f"{value:{'+' if signed else ''}.2f}" for value in (values.min(), values.max()))
    return f"{low} %" if low == high else f"{low} to {high} %"
