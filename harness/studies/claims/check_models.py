"""Checks of Table I, Fig. 3 and beam theory against models, and where errors come from."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from harness.cases import PRESETS
from harness.studies.claims.check_printed import ERROR, FEA, THEORETICAL
from harness.studies.claims.data import (
    CANNOT,
    FAILS,
    HOLDS,
    ONLY_IF,
    ROUNDED,
    RULES,
    Finding,
    finding,
    quoted_number,
    reads,
)
from harness.studies.claims.facts import (
    CASES,
    EXACT,
    PAPER,
    STEPS,
    THEORIES,
    Facts,
    Floats,
    Reference,
    Slender,
)
from reference_models import Named

NONE = "none: the limit without elements is exact"
EFFECTS = ("number of elements", "rotary inertia", "shear", "Timoshenko to reference")
"""Parts of an error, from one model to the next."""


@reads("beams")
def theoretical(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Is a theoretical value what the paper's model gives for its parameters?"""
    case, i = args["case"], args["mode"] - 1
    quoted = facts.printed.table[case, THEORETICAL][i]
    found = {
        name: float(facts.beams.hertz[name, one.theory][i])
        for name, one in PRESETS.items()
        if one.published == case
    }
    off = {name: _off(value, quoted) for name, value in found.items()}
    near = min(found, key=lambda name: abs(found[name] / quoted - 1))
    literal = f"{case}-as-printed"
    otherwise = (
        f"{CANNOT}: {off[literal]} at the printed z = {PRESETS[literal].pose.z:g} m, {off[case]} "
        f"at z = {PRESETS[case].pose.z:g} m; nearest of the readings tried: {near} ({off[near]})"
    )
    measured = f"{found[case]:.3f} Hz ({off[case]}) by {PAPER.label}"
    uncertainty = f"{RULES.rounding:g} Hz (rounding of the printed value)"
    holds = abs(found[case] - quoted) <= RULES.rounding
    return finding(holds, measured, uncertainty, otherwise)


@reads("beams", "fea", "solid")
def fea(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Is an FEA value what independent finite elements give for the paper's parameters?"""
    case, i = args["case"], args["mode"] - 1
    quoted, ours = (facts.printed.table[case, method][i] for method in (FEA, THEORETICAL))
    found = {
        r.label: (float(r.hertz[case][i]), float(r.uncertainty[case][i]))
        for r in (facts.fea, facts.solid)
    }
    off = {k: _off(value, quoted) for k, (value, _) in found.items()}
    measured = "; ".join(f"{v:.3f} Hz ({off[k]}) by {k}" for k, (v, _) in found.items())
    uncertainty = "; ".join(f"{own:.3f} Hz of {k}" for k, (_, own) in found.items())
    otherwise = (
        f"{CANNOT}: {' and '.join(off.values())} at z = {PRESETS[case].pose.z:g} m, where "
        f"{PAPER.label} is {_off(float(facts.beams.hertz[case, PAPER][i]), ours)} off the printed "
        "theoretical value"
    )
    agree = {k: abs(v - quoted) <= RULES.rounding + own for k, (v, own) in found.items()}
    return Finding(measured, uncertainty, _among(agree, otherwise))


@reads("beams", "fea", "solid")
def error(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Is an error (%) what the model has against finite elements, and where does it come from?"""
    case, i, model = args["case"], args["mode"] - 1, replace(PAPER, elements=args["elements"])
    quoted = facts.printed.table[case, ERROR][i]
    if "method" not in args:
        quoted = facts.printed.figure3[case, args["elements"], i + 1]
    found = {r.label: _error(facts, r, case, model)[:, i] for r in (facts.fea, facts.solid)}
    measured = "; ".join(f"{v:+.3f} % against {k}" for k, (v, _) in found.items())
    uncertainty = "; ".join(f"{own:.3f} % of {k}" for k, (_, own) in found.items())
    agree = {k: abs(v - quoted) <= RULES.rounding + own for k, (v, own) in found.items()}
    return Finding(measured, uncertainty, _among(agree, _causes(facts, case, model, i)))


@reads("beams", "fea", "solid")
def largest_error(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Is the largest error of some modes within what the paper says?"""
    modes, words, owns, within, places = args["modes"], [], [], {}, []
    for r in (facts.fea, facts.solid):
        found = np.abs([_error(facts, r, case, PAPER) for case in CASES])[:, :, np.array(modes) - 1]
        k, m = (int(n) for n in np.unravel_index(found[:, 0].argmax(), found[:, 0].shape))
        value, own = found[k, :, m]
        words.append(f"{value:.3f} % ({CASES[k]}, f{modes[m]}) against {r.label}")
        owns.append(f"{own:.3f} % of {r.label}")
        within[r.label] = value <= quoted_number(args) + RULES.rounding + own
        places.append((CASES[k], modes[m] - 1))
    case, i = places[0]
    otherwise = _causes(facts, case, PAPER, i)
    return Finding("; ".join(words), "; ".join(owns), _among(within, otherwise))


@reads("beams")
def one_height(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Is there one height at which the printed mechanism gives both printed rows?"""
    z = facts.beams.scan_z
    worst = {
        f"{case} is nearest": np.abs(_percent(scan, facts.printed.table[case, THEORETICAL])).max(1)
        for case, scan in facts.beams.scan.items()
    }
    worst["both"] = np.maximum(*worst.values())
    words = [
        f"{what} at z = {z[k]:.3f} m, to {off[k]:.2f} %"
        for what, off in worst.items()
        for k in [int(np.argmin(off))]
    ]
    least = worst["both"].min()
    step = 1000 * float(np.diff(z).max())
    uncertainty = f"{step:.2g} mm (steps of the scan from {z[0]:g} to {z[-1]:g} m)"
    otherwise = f"{FAILS}: no height gives both rows nearer than {least:.2f} %"
    return finding(least <= RULES.agrees_percent, "; ".join(words), uncertainty, otherwise)


@reads("beams")
def fall(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Does f1's error fall from one element to three as the printed errors do?"""
    case, mode, few, more = (args[key] for key in ("case", "mode", "from", "to"))
    quoted = facts.printed.figure3[case, few, mode] - facts.printed.table[case, ERROR][mode - 1]
    coarse, fine = (facts.beams.hertz[case, replace(PAPER, elements=s)] for s in (few, more))
    value, both = float(_percent(coarse, fine)[mode - 1]), 2 * RULES.rounding
    otherwise = (
        f"{FAILS}: f{mode} falls by {value:.4f} % from {few} to {more} elements, the printed "
        f"errors by {quoted:.2f}"
    )
    uncertainty = f"{both:g} points (rounding of both errors)"
    return finding(abs(value - quoted) <= both, f"{value:.4f} points", uncertainty, otherwise)


@reads("beams")
def few_elements(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Do more elements than these change the frequencies no further?"""
    hertz, elements, limit = facts.beams.hertz, args["elements"], getattr(RULES, args["limit"])
    models = {s: replace(PAPER, elements=s) for s in STEPS}
    off = [
        [_percent(hertz[case, model], hertz[case, EXACT]) for case in CASES]
        for model in models.values()
    ]
    errors = np.abs(off)[:, :, np.array(args["modes"]) - 1].max(axis=(1, 2))
    worst = dict(zip(models, errors.tolist(), strict=True))
    fewest = next((f"{s} or more" for s in STEPS if worst[s] <= limit), "more than were tried")
    words = ", ".join(
        f"{value:.3f} % at s = {s}" for s, value in worst.items() if s <= elements + 1
    )
    otherwise = f"{FAILS}: to stay within {limit:g} % takes {fewest} elements"
    return finding(worst[elements] <= limit, f"at most {words}", NONE, otherwise)


@reads("beams")
def repeated(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Are the printed pairs of equal frequencies double roots of the model?"""
    f = facts.beams.hertz[args["case"], PAPER]
    apart = {f"f{i} and f{j}": float(abs(f[j - 1] / f[i - 1] - 1)) for i, j in args["pairs"]}
    measured = "; ".join(f"{pair} are {value:.0e} apart" for pair, value in apart.items())
    wrong = [pair for pair, value in apart.items() if value > RULES.exact]
    return finding(not wrong, measured, ROUNDED, f"{FAILS}: {', '.join(wrong)} differ")


@reads("slender")
def timoshenko_stiffness(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Does Timoshenko change the platform's stiffness significantly?"""
    return _significant(facts.slender, facts.slender.stiffness, "the stiffnesses")


@reads("slender")
def timoshenko_frequencies(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Does Timoshenko change the frequencies significantly?"""
    return _significant(facts.slender, facts.slender.frequencies.max(axis=1), "f1-f6")


def _significant(slender: Slender, gaps: Floats, what: str) -> Finding:
    printed, limit = slender.ratios[-1], RULES.significant_percent
    measured = f"{what} differ by up to {gaps[-1]:.2f} % at the printed d/L = {printed:.3f}"
    return finding(gaps[-1] <= limit, measured, NONE, _if_slender(slender, gaps, limit))


@reads("slender")
def f1_diameter(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Can rods of the printed diameter have so small an error of f1?"""
    slender, limit = facts.slender, args["printed"] + RULES.rounding
    first = slender.frequencies[:, 0]
    measured = (
        f"shear and rotary inertia lower f1 by up to {first[-1]:.3f} % at the printed d/L = "
        f"{slender.ratios[-1]:.3f}"
    )
    otherwise = f"{_if_slender(slender, first, limit)}, the finite elements being beams"
    return finding(first[-1] <= limit, measured, NONE, otherwise)


def _if_slender(slender: Slender, gaps: Floats, limit: float) -> str:
    """Return below which d/L the gap is at most `limit` [%]."""
    if gaps[0] > limit:
        return f"{FAILS}: {gaps[0]:.2g} % even at d/L = {slender.ratios[0]:g}"
    # The gap grows as a power of d/L: straight between neighbours on logarithms.
    ratio = np.exp(np.interp(np.log(limit), np.log(gaps), np.log(slender.ratios)))
    return f"{ONLY_IF} d/L is at most {ratio:.3f}"


@reads("slender")
def slender(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Are both theories the same for slender rods?"""
    ratios, gaps = facts.slender.ratios, facts.slender.frequencies.max(axis=1)
    measured = (
        f"f1-f6 differ by up to {gaps[0]:.3f} % at d/L = {ratios[0]:g}, {gaps[-1]:.2f} % at the "
        f"printed d/L = {ratios[-1]:.3f}"
    )
    limit = RULES.agrees_percent
    return finding(gaps[0] <= limit, measured, NONE, f"{FAILS}: more than {limit:g} % apart")


def _percent(value: Any, against: Any) -> Floats:
    return np.asarray(100 * (np.asarray(value) / against - 1))


def _off(value: float, quoted: float) -> str:
    return f"{100 * (value / quoted - 1):+.2f} %"


def _error(facts: Facts, reference: Reference, case: str, model: Named) -> Floats:
    """Return the model's error and the reference's own uncertainty, (2, 6) [%]."""
    f = reference.hertz[case]
    own = 100 * reference.uncertainty[case] / f
    return np.array([_percent(facts.beams.hertz[case, model], f), own])


def _causes(facts: Facts, case: str, model: Named, i: int) -> str:
    """Return the largest part of an error, and all of them, in words."""
    words, most = [], ""
    for r in (facts.fea, facts.solid):
        f = r.hertz[case][i]
        chain = [facts.beams.hertz[case, one][i] for one in (model, *THEORIES)]
        parts = dict(zip(EFFECTS, -100 * np.diff([*chain, f]) / f, strict=True))
        shares = ", ".join(f"{name} {share:+.3f}" for name, share in parts.items())
        words.append(f"against {r.label} {shares}")
        most = most or max(parts, key=lambda name: abs(parts[name]))
    return f"{CANNOT}: mostly {most}; points of {case}'s f{i + 1} {'; '.join(words)}"


def _among(agree: Mapping[str, Any], otherwise: str) -> str:
    """Return that a statement holds, for which references it does, or what is true otherwise."""
    some = [label for label, holds in agree.items() if holds]
    if len(some) == len(agree):
        return HOLDS
    return f"{ONLY_IF} the finite elements are those of {' or '.join(some)}" if some else otherwise
