"""Checks of Table I against models: theoretical values, FEA values and errors, by cause."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from harness.studies.claims.check_printed import ERROR, THEORETICAL
from harness.studies.claims.data import (
    CANNOT,
    FAILS,
    HOLDS,
    ONLY_IF,
    Claim,
    Finding,
    Rules,
    quoted_number,
    reads,
)
from harness.studies.claims.facts import CASES, EFFECTS, PAPER, Beams, Facts, Floats, Reference
from reference_models import Named


@reads("beams")
def theoretical(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Is a theoretical value what the paper's model gives for its parameters?"""
    beams = facts.beams
    case, i = claim.args["case"], claim.args["mode"] - 1
    quoted = facts.printed.table[case, THEORETICAL][i]
    value = float(beams.hertz[case, PAPER][i])
    measured = f"{value:.3f} Hz ({_off(value, quoted)}) by {PAPER.label}"
    uncertainty = f"{rules.rounding:g} Hz (rounding of the printed value)"
    if abs(value - quoted) <= rules.rounding:
        return Finding(measured, uncertainty, HOLDS)
    literal = float(beams.readings[f"{case}-as-printed"][1][i])
    near = min(
        (name for name, (stands_for, _) in beams.readings.items() if stands_for == case),
        key=lambda name: abs(beams.readings[name][1][i] / quoted - 1),
    )
    fitted = _off(float(beams.readings[near][1][i]), quoted)
    verdict = (
        f"{CANNOT}: {_off(literal, quoted)} at the printed z = "
        f"{beams.heights[f'{case}-as-printed']:g} m, {_off(value, quoted)} at z = "
        f"{beams.heights[case]:g} m; nearest of the readings tried: {near} ({fitted})"
    )
    return Finding(measured, uncertainty, verdict)


@reads("beams", "fea", "solid")
def fea(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Is an FEA value what independent finite elements give for the paper's parameters?"""
    beams, references = facts.beams, (facts.fea, facts.solid)
    case, i = claim.args["case"], claim.args["mode"] - 1
    quoted = facts.printed.table[case, "FEA"][i]
    values = {r.label: float(r.hertz[case][i]) for r in references}
    own = {r.label: float(r.uncertainty[case][i]) for r in references}
    measured = "; ".join(f"{v:.3f} Hz ({_off(v, quoted)}) by {k}" for k, v in values.items())
    uncertainty = "; ".join(f"{own[k]:.3f} Hz of {k}" for k in values)
    agree = [k for k, v in values.items() if abs(v - quoted) <= rules.rounding + own[k]]
    if agree:
        return Finding(measured, uncertainty, _among(agree, list(values)))
    theory = _off(float(beams.hertz[case, PAPER][i]), facts.printed.table[case, THEORETICAL][i])
    verdict = (
        f"{CANNOT}: {' and '.join(_off(v, quoted) for v in values.values())} at z = "
        f"{beams.heights[case]:g} m, where {PAPER.label} is {theory} off the printed theoretical "
        "value"
    )
    return Finding(measured, uncertainty, verdict)


@reads("beams", "fea", "solid")
def error(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Is an error (%) what the model has against finite elements, and where does it come from?"""
    beams, references = facts.beams, (facts.fea, facts.solid)
    case, mode, elements = (claim.args[key] for key in ("case", "mode", "elements"))
    i, model = mode - 1, replace(PAPER, elements=elements)
    in_table = facts.printed.table[case, ERROR][i]
    quoted = in_table if "method" in claim.args else facts.printed.figure3[case, elements, mode]
    found = {r.label: _percent(beams, r, case, model)[i] for r in references}
    own = {r.label: _own(r, case)[i] for r in references}
    measured = "; ".join(f"{v:+.3f} % against {k}" for k, v in found.items())
    uncertainty = "; ".join(f"{own[k]:.3f} % of {k}" for k in found)
    agree = [k for k, v in found.items() if abs(v - quoted) <= rules.rounding + own[k]]
    if agree:
        return Finding(measured, uncertainty, _among(agree, list(found)))
    verdict = f"{CANNOT}: {_causes(beams, references, case, model, i)}"
    return Finding(measured, uncertainty, verdict)


@reads("beams", "fea", "solid")
def largest_error(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Is the largest error of some modes within what the paper says?"""
    beams, references = facts.beams, (facts.fea, facts.solid)
    modes, limit = [i - 1 for i in claim.args["modes"]], quoted_number(claim.args)
    words, owns, within = [], [], []
    for r in references:
        errors = np.array([np.abs(_percent(beams, r, case, PAPER))[modes] for case in CASES])
        k, m = (int(n) for n in np.unravel_index(errors.argmax(), errors.shape))
        value, own = float(errors[k, m]), float(_own(r, CASES[k])[modes[m]])
        words.append(f"{value:.3f} % ({CASES[k]}, f{modes[m] + 1}) against {r.label}")
        owns.append(f"{own:.3f} % of {r.label}")
        if value <= limit + rules.rounding + own:
            within.append(r.label)
        if r is references[0]:
            causes = _causes(beams, references, CASES[k], PAPER, modes[m])
    measured, uncertainty = "; ".join(words), "; ".join(owns)
    if within:
        return Finding(measured, uncertainty, _among(within, [r.label for r in references]))
    return Finding(measured, uncertainty, f"{CANNOT}: {causes}")


@reads("beams")
def one_height(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Is there one height at which the printed mechanism gives both printed rows?"""
    beams = facts.beams
    worst = {}
    for case in CASES:
        printed = np.array(facts.printed.table[case, THEORETICAL])
        worst[case] = 100 * np.abs(beams.scan[case] / printed - 1).max(axis=1)
    best = {case: int(np.argmin(off)) for case, off in worst.items()}
    words = [
        f"{case} is nearest at z = {beams.scan_z[k]:.3f} m, to {worst[case][k]:.2f} %"
        for case, k in best.items()
    ]
    both = np.maximum(*worst.values())
    k = int(np.argmin(both))
    measured = f"{'; '.join(words)}; both at z = {beams.scan_z[k]:.3f} m, to {both[k]:.2f} %"
    step = 1000 * float(np.diff(beams.scan_z).max())
    uncertainty = f"{step:.2g} mm (steps of the scan from {beams.scan_z[0]:g} to "
    uncertainty += f"{beams.scan_z[-1]:g} m)"
    if both[k] <= rules.agrees_percent:
        return Finding(measured, uncertainty, HOLDS)
    verdict = f"{FAILS}: no height gives both rows nearer than {both[k]:.2f} %"
    return Finding(measured, uncertainty, verdict)


def _off(value: float, quoted: float) -> str:
    return f"{100 * (value / quoted - 1):+.2f} %"


def _percent(beams: Beams, reference: Reference, case: str, model: Named) -> Floats:
    return np.asarray(100 * (beams.hertz[case, model] / reference.hertz[case] - 1))


def _own(reference: Reference, case: str) -> Floats:
    return np.asarray(100 * reference.uncertainty[case] / reference.hertz[case])


def _parts(beams: Beams, reference: Reference, case: str, model: Named) -> dict[str, Floats]:
    """Return the error's parts in points of the reference's frequency, which add up to it."""
    f = reference.hertz[case]
    ends = [
        (beams.hertz[case, first or model], f if last is None else beams.hertz[case, last])
        for first, last in EFFECTS.values()
    ]
    shares = [100 * (a - b) / f for a, b in ends]
    return dict(zip(EFFECTS, shares, strict=True))


def _causes(beams: Beams, references: Sequence[Reference], case: str, model: Named, i: int) -> str:
    """Return the largest part of an error, and all of them, in words."""
    words = []
    for r in references:
        parts = {name: float(share[i]) for name, share in _parts(beams, r, case, model).items()}
        shares = ", ".join(f"{name} {share:+.3f}" for name, share in parts.items())
        words.append(f"against {r.label} {shares}")
        if r is references[0]:
            most = max(parts, key=lambda name: abs(parts[name]))
    return f"mostly {most}; points of {case}'s f{i + 1} {'; '.join(words)}"


def _among(agree: list[str], all_of_them: list[str]) -> str:
    """Return that a statement holds, or for which references it does."""
    if len(agree) == len(all_of_them):
        return HOLDS
    return f"{ONLY_IF} the finite elements are those of {' or '.join(agree)}"
