"""Checks of Table I, Fig. 3 and beam theory against models, and where errors come from."""

from dataclasses import replace
from typing import Any

import numpy as np

from harness.cases import PRESETS
from harness.compare import relative_error
from harness.paper import ERROR, FEA, THEORETICAL
from harness.signatures import Array
from harness.studies.claims.data import CASES, RULES, Args, Outcome, checked, outcome
from harness.studies.claims.facts import (
    EXACT,
    PAPER,
    STEPS,
    THEORIES,
    Facts,
    Reference,
)
from reference_models import Named

EFFECTS = ("number of elements", "rotary inertia", "shear", "Timoshenko to reference")
"""Parts of an error, from one model to the next."""


def theoretical(facts: Facts, args: Args) -> Outcome:
    """Is a theoretical value what the paper's model gives for its parameters?"""
    case, i = args["case"], args["mode"] - 1
    quoted, literal = facts.printed.table[case, THEORETICAL][i], f"{case}-as-printed"
    found = {
        name: float(facts.hertz[name, one.theory][i])
        for name, one in PRESETS.items()
        if one.published == case
    }
    off = {name: _off(value, quoted) for name, value in found.items()}
    near = min(found, key=lambda name: abs(found[name] / quoted - 1))
    return outcome(
        abs(found[case] - quoted) <= RULES.rounding,
        value=found[case],
        own=off[case],
        literal=off[literal],
        z=[PRESETS[name].pose.z for name in (literal, case)],
        near=near,
        nearest=off[near],
    )


def fea(facts: Facts, args: Args) -> Outcome:
    """Is an FEA value what independent finite elements give for the paper's parameters?"""
    case, i = args["case"], args["mode"] - 1
    quoted, ours = (facts.printed.table[case, method][i] for method in (FEA, THEORETICAL))
    references = (facts.fea, facts.solid)
    found = {r.label: (float(r.hertz[case][i]), float(r.uncertainty[case][i])) for r in references}
    off = {k: _off(value, quoted) for k, (value, _) in found.items()}
    return _among(
        {k: abs(v - quoted) <= RULES.rounding + own for k, (v, own) in found.items()},
        words="; ".join(f"{v:.3f} Hz ({off[k]}) by {k}" for k, (v, _) in found.items()),
        owns="; ".join(f"{own:.3f} Hz of {k}" for k, (_, own) in found.items()),
        off=" and ".join(off.values()),
        z=PRESETS[case].pose.z,
        theory=_off(float(facts.hertz[case, PAPER][i]), ours),
    )


def error(facts: Facts, args: Args) -> Outcome:
    """Is an error (%) what the model has against finite elements, and where does it come from?"""
    case, i, model = args["case"], args["mode"] - 1, replace(PAPER, elements=args["elements"])
    quoted = facts.printed.table[case, ERROR][i]
    if "method" not in args:
        quoted = facts.printed.figure3[case, args["elements"], i + 1]
    found = {r.label: _error(facts, r, case, model)[:, i] for r in (facts.fea, facts.solid)}
    return _among(
        {k: abs(v - quoted) <= RULES.rounding + own for k, (v, own) in found.items()},
        words="; ".join(f"{v:+.3f} % against {k}" for k, (v, _) in found.items()),
        owns="; ".join(f"{own:.3f} % of {k}" for k, (_, own) in found.items()),
        causes=_causes(facts, case, model, i),
    )


def largest_error(facts: Facts, args: Args) -> Outcome:
    """Is the largest error of some modes within what the paper says?"""
    modes, words, owns, within, causes = args["modes"], [], [], {}, []
    for r in (facts.fea, facts.solid):
        found = np.abs([_error(facts, r, case, PAPER) for case in CASES])[:, :, np.array(modes) - 1]
        k, m = (int(n) for n in np.unravel_index(found[:, 0].argmax(), found[:, 0].shape))
        value, own = found[k, :, m]
        words.append(f"{value:.3f} % ({CASES[k]}, f{modes[m]}) against {r.label}")
        owns.append(f"{own:.3f} % of {r.label}")
        within[r.label] = value <= checked().quoted_number(args) + RULES.rounding + own
        causes.append(_causes(facts, CASES[k], PAPER, modes[m] - 1))
    return _among(within, words="; ".join(words), owns="; ".join(owns), causes=causes[0])


def one_height(facts: Facts, args: Args) -> Outcome:
    """Is there one height at which the printed mechanism gives both printed rows?"""
    z = facts.scan_z
    worst = {
        f"{case} is nearest": np.abs(
            relative_error(scan, facts.printed.table[case, THEORETICAL])
        ).max(1)
        for case, scan in facts.scan.items()
    }
    worst["both"] = np.maximum(*worst.values())
    best = {what: int(np.argmin(off)) for what, off in worst.items()}
    words = [f"{w} at z = {z[k]:.3f} m, to {worst[w][k]:.2f} %" for w, k in best.items()]
    least, step = worst["both"].min(), 1000 * np.diff(z).max()
    holds = least <= RULES.agrees_percent
    return outcome(holds, words="; ".join(words), step=step, z=z[[0, -1]], least=least)


def fall(facts: Facts, args: Args) -> Outcome:
    """Does f1's error fall from one element to three as the printed errors do?"""
    case, mode, few, more = (args[key] for key in ("case", "mode", "from", "to"))
    quoted = facts.printed.figure3[case, few, mode] - facts.printed.table[case, ERROR][mode - 1]
    coarse, fine = (facts.hertz[case, replace(PAPER, elements=s)] for s in (few, more))
    value, both = relative_error(coarse, fine)[mode - 1], 2 * RULES.rounding
    holds = abs(value - quoted) <= both
    return outcome(holds, value=value, both=both, few=few, more=more, quoted=quoted)


def few_elements(facts: Facts, args: Args) -> Outcome:
    """Do more elements than these change the frequencies no further?"""
    hertz, elements, most = facts.hertz, args["elements"], getattr(RULES, args["limit"])
    models = [replace(PAPER, elements=s) for s in STEPS]
    off = [[relative_error(hertz[case, m], hertz[case, EXACT]) for case in CASES] for m in models]
    errors = np.abs(off)[:, :, np.array(args["modes"]) - 1].max(axis=(1, 2))
    worst = dict(zip(STEPS, errors.tolist(), strict=True))
    fewest = next((f"{s} or more" for s in STEPS if worst[s] <= most), "more than were tried")
    words = ", ".join(f"{worst[s]:.3f} % at s = {s}" for s in STEPS if s <= elements + 1)
    return outcome(worst[elements] <= most, words=words, most=most, fewest=fewest)


def repeated(facts: Facts, args: Args) -> Outcome:
    """Are the printed pairs of equal frequencies double roots of the model?"""
    f = facts.hertz[args["case"], PAPER]
    apart = {f"f{i} and f{j}": float(abs(f[j - 1] / f[i - 1] - 1)) for i, j in args["pairs"]}
    words = "; ".join(f"{pair} are {value:.0e} apart" for pair, value in apart.items())
    wrong = [pair for pair, value in apart.items() if value > RULES.exact]
    return outcome(not wrong, words=words, wrong=", ".join(wrong))


def timoshenko_stiffness(facts: Facts, args: Args) -> Outcome:
    """Does Timoshenko change the platform's stiffness significantly?"""
    return _within(facts, facts.slender.stiffness, RULES.significant_percent)


def timoshenko_frequencies(facts: Facts, args: Args) -> Outcome:
    """Does Timoshenko change the frequencies significantly?"""
    return _within(facts, facts.slender.frequencies.max(axis=1), RULES.significant_percent)


def f1_diameter(facts: Facts, args: Args) -> Outcome:
    """Can rods of the printed diameter have so small an error of f1?"""
    return _within(facts, facts.slender.frequencies[:, 0], args["printed"] + RULES.rounding)


def slender(facts: Facts, args: Args) -> Outcome:
    """Are both theories the same for slender rods?"""
    gaps = facts.slender.frequencies.max(axis=1)[[0, -1]]
    return outcome(gaps[0] <= RULES.agrees_percent, gaps=gaps, ratios=facts.slender.ratios[[0, -1]])


def _within(facts: Facts, gaps: Array, limit: float) -> Outcome:
    """Is the gap at most `limit` [%] for the printed rods, and else below which d/L is it?"""
    ratios = facts.slender.ratios
    # The gap grows as a power of d/L: straight between neighbours on logarithms.
    ratio = np.exp(np.interp(np.log(limit), np.log(gaps), np.log(ratios)))
    otherwise = "even" if gaps[0] > limit else "otherwise"
    ends = [0, -1]
    return outcome(gaps[-1] <= limit, otherwise, gaps=gaps[ends], ratios=ratios[ends], ratio=ratio)


def _off(value: float, quoted: float) -> str:
    return f"{100 * (value / quoted - 1):+.2f} %"


def _error(facts: Facts, reference: Reference, case: str, model: Named) -> Array:
    """Return the model's error and the reference's own uncertainty, (2, 6) [%]."""
    f = reference.hertz[case]
    own = 100 * reference.uncertainty[case] / f
    return np.array([relative_error(facts.hertz[case, model], f), own])


def _causes(facts: Facts, case: str, model: Named, i: int) -> str:
    """Return the largest part of an error, and all of them, in words."""
    words, most = [], ""
    for r in (facts.fea, facts.solid):
        f = r.hertz[case][i]
        chain = [facts.hertz[case, one][i] for one in (model, *THEORIES)]
        parts = dict(zip(EFFECTS, -100 * np.diff([*chain, f]) / f, strict=True))
        shares = ", ".join(f"{name} {share:+.3f}" for name, share in parts.items())
        words.append(f"against {r.label} {shares}")
        most = most or max(parts, key=lambda name: abs(parts[name]))
    return f"mostly {most}; points of {case}'s f{i + 1} {'; '.join(words)}"


def _among(agree: dict[str, Any], **values: Any) -> Outcome:
    """Return that a statement holds, for which references it does, or what is true otherwise."""
    those = [label for label, holds in agree.items() if holds]
    otherwise = "some" if those else "otherwise"
    return outcome(len(those) == len(agree), otherwise, those=" or ".join(those), **values)
