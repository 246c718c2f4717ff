"""Checks of what elements and beam theory do, without any reference."""

from dataclasses import replace

import numpy as np

from harness.studies.claims.check_printed import ERROR
from harness.studies.claims.data import FAILS, HOLDS, ONLY_IF, Claim, Finding, Rules, reads
from harness.studies.claims.facts import CASES, EXACT, PAPER, Beams, Facts, Floats, Slender

NONE = "none: the limit without elements is exact"


@reads("beams")
def fall(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Does f1's error fall from one element to three as the printed errors do?"""
    beams = facts.beams
    case, i = claim.args["case"], claim.args["mode"] - 1
    few, more = claim.args["from"], claim.args["to"]
    quoted = facts.printed.figure3[case, few, i + 1] - facts.printed.table[case, ERROR][i]
    coarse, fine = (beams.hertz[case, replace(PAPER, elements=s)][i] for s in (few, more))
    value = float(100 * (coarse - fine) / fine)
    both = 2 * rules.rounding
    measured, uncertainty = f"{value:.4f} points", f"{both:g} points (rounding of both errors)"
    if abs(value - quoted) <= both:
        return Finding(measured, uncertainty, HOLDS)
    verdict = (
        f"{FAILS}: f{i + 1} falls by {value:.4f} % from {few} to {more} elements, the printed "
        f"errors by {quoted:.2f}"
    )
    return Finding(measured, uncertainty, verdict)


@reads("beams")
def few_elements(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Do more elements than these change the frequencies no further?"""
    beams = facts.beams
    s, modes = claim.args["elements"], [i - 1 for i in claim.args["modes"]]
    limit = getattr(rules, claim.args["limit"])
    errors = {n: _largest(beams, n, modes) for n in beams.elements}
    fewest = next((n for n, value in errors.items() if value <= limit), None)
    words = ", ".join(f"{value:.3f} % at s = {n}" for n, value in errors.items() if n <= s + 1)
    measured = f"at most {words}"
    if errors[s] <= limit:
        return Finding(measured, NONE, HOLDS)
    least = "more than were tried" if fewest is None else f"{fewest} or more"
    verdict = f"{FAILS}: to stay within {limit:g} % takes {least} elements"
    return Finding(measured, NONE, verdict)


def _largest(beams: Beams, s: int, modes: list[int]) -> float:
    model = replace(PAPER, elements=s)
    off = [beams.hertz[case, model] / beams.hertz[case, EXACT] - 1 for case in CASES]
    return float(100 * np.abs(np.array(off)[:, modes]).max())


@reads("beams")
def repeated(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Are the printed pairs of equal frequencies double roots of the model?"""
    beams = facts.beams
    f = beams.hertz[claim.args["case"], PAPER]
    pairs = [(i, j, float(abs(f[j - 1] / f[i - 1] - 1))) for i, j in claim.args["pairs"]]
    measured = "; ".join(f"f{i} and f{j} are {apart:.0e} apart" for i, j, apart in pairs)
    wrong = [f"f{i} and f{j}" for i, j, apart in pairs if apart > rules.exact]
    verdict = f"{FAILS}: {', '.join(wrong)} differ" if wrong else HOLDS
    return Finding(measured, f"{rules.exact:.0e} (rounding)", verdict)


@reads("slender")
def timoshenko_stiffness(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Does Timoshenko change the platform's stiffness significantly?"""
    slender = facts.slender
    return _significant(slender, slender.stiffness, "the stiffnesses", rules)


@reads("slender")
def timoshenko_frequencies(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Does Timoshenko change the frequencies significantly?"""
    slender = facts.slender
    return _significant(slender, slender.frequencies, "f1-f6", rules)


def _significant(slender: Slender, gaps: Floats, what: str, rules: Rules) -> Finding:
    printed = slender.ratios[-1]
    measured = f"{what} differ by up to {gaps[-1]:.2f} % at the printed d/L = {printed:.3f}"
    limit = rules.significant_percent
    if gaps[-1] <= limit:
        return Finding(measured, NONE, HOLDS)
    return Finding(measured, NONE, _if_slender(slender, gaps, limit))


@reads("slender")
def f1_diameter(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Can rods of the printed diameter have so small an error of f1?"""
    slender, limit = facts.slender, claim.args["printed"] + rules.rounding
    measured = (
        f"shear and rotary inertia lower f1 by up to {slender.first[-1]:.3f} % at the printed d/L "
        f"= {slender.ratios[-1]:.3f}"
    )
    if slender.first[-1] <= limit:
        return Finding(measured, NONE, HOLDS)
    also = ", the finite elements being beams"
    return Finding(measured, NONE, _if_slender(slender, slender.first, limit, also))


def _if_slender(slender: Slender, gaps: Floats, limit: float, also: str = "") -> str:
    """Return below which d/L the gap is at most `limit` [%]."""
    if gaps[0] > limit:
        return f"{FAILS}: {gaps[0]:.2g} % even at d/L = {slender.ratios[0]:g}"
    # The gap grows as a power of d/L: straight between neighbours on logarithms.
    ratio = np.exp(np.interp(np.log(limit), np.log(gaps), np.log(slender.ratios)))
    return f"{ONLY_IF} d/L is at most {ratio:.3f}{also}"


@reads("slender")
def slender(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Are both theories the same for slender rods?"""
    found = facts.slender
    least, most = found.frequencies[0], found.frequencies[-1]
    measured = (
        f"f1-f6 differ by up to {least:.3f} % at d/L = {found.ratios[0]:g}, {most:.2f} % at the "
        f"printed d/L = {found.ratios[-1]:.3f}"
    )
    if least <= rules.agrees_percent:
        return Finding(measured, NONE, HOLDS)
    return Finding(measured, NONE, f"{FAILS}: more than {rules.agrees_percent:g} % apart")
