"""Checks of printed numbers: against each other, against models, and where errors come from."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from analytic import InputError
from harness.case import Case
from harness.cases import PRESETS
from harness.compare import relative_error
from harness.paper import ERROR, FEA, THEORETICAL, Printed
from harness.signatures import Array
from harness.studies.claims.facts import (
    CASES,
    EXACT,
    HEIGHTS,
    PAPER,
    RULES,
    STEPS,
    THEORIES,
    Args,
    Facts,
    Outcome,
    Reference,
    outcome,
)
from reference_models import Named, parse

EFFECTS = ("number of elements", "rotary inertia", "shear", "Timoshenko to reference")
"""Parts of an error, from one model to the next."""
INSIDE = RULES.rounding + 1e-9
"""A printed value on the very edge of its rounding counts as inside."""


def _rows_error(facts: Facts, case: str) -> Array:
    """Return 100 (t - f) / f of the printed rows and what rounding does to it, (2, 6) [%]."""
    t, f = (np.array(facts.printed.table[case, method]) for method in (THEORETICAL, FEA))
    return np.array([100 * (t - f) / f, 100 * (1 + t / f) / f * RULES.rounding])


def _follows(value: float, own: float, quoted: float) -> Outcome:
    """Is a value what is quoted: as it is rounded, or within what rounding does to it, `own`?"""
    off = abs(value - quoted)
    otherwise = "digits" if off <= RULES.rounding + own else "otherwise"
    return outcome(off <= INSIDE, otherwise, value=value, own=own)


def _largest(errors: Sequence[Array], modes: Sequence[int]) -> tuple[str, int, float, float]:
    """Return case, mode, size and uncertainty of the largest error of some modes.

    Of errors and uncertainties, (2, 6) a case.
    """
    some = np.array(errors)[:, :, np.array(modes) - 1]
    k, m = divmod(int(some[:, 0].argmax()), len(modes))
    value, own = some[k, :, m].tolist()
    return CASES[k], modes[m], value, own


def error_follows(facts: Facts, args: Args) -> Outcome:
    """Does a printed error follow from the printed rows?"""
    case, i = args["case"], args["mode"] - 1
    t, f, quoted = (facts.printed.table[case, method][i] for method in (THEORETICAL, FEA, ERROR))
    value, own = _rows_error(facts, case)[:, i].tolist()
    of_theory = 100 * (t - f) / t
    verdict, said = _follows(value, own, quoted)
    if verdict == "otherwise" and abs(of_theory - quoted) <= RULES.rounding + own:
        verdict = "of_theory"
    return verdict, said | {"of_theory": of_theory}


def largest_printed(facts: Facts, args: Args) -> Outcome:
    """Is the largest error that the printed frequencies give what the text says?"""
    errors = [_rows_error(facts, case) for case in CASES]
    case, mode, value, own = _largest(errors, args["modes"])
    limit = args["printed"] + (0 if args["strictly"] else INSIDE)
    otherwise = "digits" if value - own < limit else "otherwise"
    return outcome(value < limit, otherwise, value=value, own=own, where=f"{case}, f{mode}")


def saved_follows(facts: Facts, args: Args) -> Outcome:
    """Does the percentage saved follow from the two printed times?"""
    cost = facts.printed.cost
    theory, fea = cost["theoretical model"], cost["finite-element model"]
    own = 100 * RULES.rounding * (1 / fea + theory / fea**2)
    return _follows(100 * (1 - theory / fea), own, cost["cost saved"])


def blocks(facts: Facts, args: Args) -> Outcome:
    """Do the printed blocks of every row fill the matrix's columns?"""
    matrix = facts.printed.matrices[args["equation"]]
    columns, rows = np.array(matrix["columns"]), matrix["rows"]
    off = {row: np.sum(widths, axis=0) - columns for row, widths in rows.items()}
    wrong = {row: by for row, by in off.items() if by.any()}
    return outcome(
        not wrong,
        "one" if len(wrong) == 1 else "otherwise",
        right=len(rows) - len(wrong),
        all=len(rows),
        width=_linear(columns),
        which="; ".join(f"{row} is {_linear(columns + by)} wide" for row, by in wrong.items()),
        missing="".join(_linear(-by) for by in wrong.values()),
    )


def _linear(widths: Array) -> str:
    """Return a s + b in words."""
    a, b = (int(n) for n in widths)
    if not a:
        return f"{b}"
    return f"{a} s" + (f" {'+' if b > 0 else '-'} {abs(b)}" if b else "")


def printed(facts: Facts, args: Args) -> Outcome:
    """Is a printed row what a model gives, the case's own where none is named?"""
    case, rows = _rows(facts, args, "method")
    model = parse(args["model"], "model") if "model" in args else case.theory
    f = facts.solved_for(case, model, max(row.mode for row in rows))
    off = [(100 * (row.frequency / f[row.mode - 1] - 1), 100 * row.half / row.frequency, row.mode)
           for row in rows]  # fmt: skip
    # The one that is furthest beyond its last digit.
    value, digits, mode = max(off, key=lambda entry: abs(entry[0]) - entry[1])
    good = abs(value) <= args["within_percent"] + digits
    return outcome(good, label=model.label, value=value, digits=digits, mode=mode)


def difference(facts: Facts, args: Args) -> Outcome:
    """Is the largest difference of two printed rows as small as is said?"""
    other = {row.mode: row for row in _rows(facts, args, "against")[1]}
    pairs = [(row, other[row.mode]) for row in _rows(facts, args, "method")[1] if row.mode in other]
    if not pairs:
        raise InputError(f"claim {args['id']}", args["against"], "rows of the same modes")
    a, b = max(pairs, key=lambda pair: abs(pair[0].frequency / pair[1].frequency - 1))
    value = 100 * (a.frequency / b.frequency - 1)
    digits = 100 * (a.half / a.frequency + b.half / b.frequency)
    good = abs(value) <= args["at_most_percent"] + digits
    return outcome(good, value=value, digits=digits, mode=a.mode)


def _rows(facts: Facts, args: Args, key: str) -> tuple[Case, list[Printed]]:
    """Return the case of a claim, and its rows by the method that `key` names."""
    by_name = {case.name: case for case in facts.cases}
    if args["case"] not in by_name:
        expected = f"one of the cases {', '.join(by_name)}"
        raise InputError(f"claim {args['id']}", args["case"], expected)
    case = by_name[args["case"]]
    rows = [row for row in case.printed if row.method == args[key]]
    if not rows:
        known = ", ".join(dict.fromkeys(row.method for row in case.printed)) or "none"
        raise InputError(f"claim {args['id']}", args[key], f"a method that is printed: {known}")
    return case, rows


def theoretical(facts: Facts, args: Args) -> Outcome:
    """Is a theoretical value what the paper's model gives for its parameters?"""
    case, i = args["case"], args["mode"] - 1
    quoted, literal = facts.printed.table[case, THEORETICAL][i], f"{case}-as-printed"
    read = {name: one for name, one in PRESETS.items() if one.published == case}
    found = {name: facts.hertz[name, one.theory][i] for name, one in read.items()}
    off = {name: relative_error(value, quoted) for name, value in found.items()}
    near = min(off, key=lambda name: abs(off[name]))
    z = [read[name].pose.z for name in (literal, case)]
    holds = abs(found[case] - quoted) <= RULES.rounding
    said = {"literal": off[literal], "near": near, "nearest": off[near], "z": z}
    return outcome(holds, "otherwise", value=found[case], own=off[case], **said)


def fea(facts: Facts, args: Args) -> Outcome:
    """Is an FEA value what independent finite elements give for the paper's parameters?"""
    case, i = args["case"], args["mode"] - 1
    quoted, ours = (facts.printed.table[case, method][i] for method in (FEA, THEORETICAL))
    found, off = {}, []
    for r in (facts.fea, facts.solid):
        f = r.hertz[case][i]
        off.append(f"{relative_error(f, quoted):+.2f} %")
        said = f"{f:.3f} Hz ({off[-1]}) by {r.label}"
        found[r.label] = said, abs(f - quoted), r.uncertainty[case][i]
    theory = relative_error(facts.hertz[case, PAPER][i], ours)
    return _among(found, "Hz", off=" and ".join(off), z=PRESETS[case].pose.z, theory=theory)


def error(facts: Facts, args: Args) -> Outcome:
    """Is an error (%) what the model has against finite elements, and where does it come from?"""
    case, i, model = args["case"], args["mode"] - 1, replace(PAPER, elements=args["elements"])
    quoted, found = facts.printed.table[case, ERROR][i], {}
    if "method" not in args:
        quoted = facts.printed.figure3[case, args["elements"], i + 1]
    for r in (facts.fea, facts.solid):
        value, own = _error(facts, r, case, model)[:, i]
        found[r.label] = f"{value:+.3f} % against {r.label}", abs(value - quoted), own
    return _among(found, "%", causes=_causes(facts, case, model, i))


def largest_error(facts: Facts, args: Args) -> Outcome:
    """Is the largest error of some modes within what the paper says?"""
    found, causes = {}, []
    for r in (facts.fea, facts.solid):
        errors = [np.abs(_error(facts, r, case, PAPER)) for case in CASES]
        case, mode, value, own = _largest(errors, args["modes"])
        said = f"{value:.3f} % ({case}, f{mode}) against {r.label}"
        found[r.label] = said, value - args["printed"], own
        causes.append(_causes(facts, case, PAPER, mode - 1))
    return _among(found, "%", causes=causes[0])


def _among(found: Mapping[str, tuple[str, float, float]], unit: str, **values: Any) -> Outcome:
    """Return that a statement holds, for which references it does, or what is true otherwise.

    `found` of each: words, how far the printed number is off, and its own uncertainty [`unit`].
    """
    those = [k for k, (_, off, own) in found.items() if off <= RULES.rounding + own]
    owns = "; ".join(f"{own:.3f} {unit} of {label}" for label, (_, _, own) in found.items())
    words = "; ".join(said for said, _, _ in found.values())
    values |= {"words": words, "owns": owns, "those": " or ".join(those)}
    return outcome(len(those) == len(found), "some" if those else "otherwise", **values)


def _error(facts: Facts, reference: Reference, case: str, model: Named) -> Array:
    """Return the model's error and the reference's own uncertainty, (2, 6) [%]."""
    f = reference.hertz[case]
    own = 100 * reference.uncertainty[case] / f
    return np.array([relative_error(facts.hertz[case, model], f), own])


def _causes(facts: Facts, case: str, model: Named, i: int) -> str:
    """Return the largest part of an error, and all of them, in words."""
    words, most = [], ""
    chain = [facts.hertz[case, one][i] for one in (model, *THEORIES)]
    for r in (facts.fea, facts.solid):
        f = r.hertz[case][i]
        parts = dict(zip(EFFECTS, -100 * np.diff([*chain, f]) / f, strict=True))
        shares = ", ".join(f"{name} {share:+.3f}" for name, share in parts.items())
        words.append(f"against {r.label} {shares}")
        most = most or max(parts, key=lambda name: abs(parts[name]))
    return f"mostly {most}; points of {case}'s f{i + 1} {'; '.join(words)}"


def one_height(facts: Facts, args: Args) -> Outcome:
    """Is there one height at which the printed mechanism gives both printed rows?"""
    z, worst = HEIGHTS, {}
    for case, scan in facts.scan.items():
        off = relative_error(scan, facts.printed.table[case, THEORETICAL])
        worst[f"{case} is nearest"] = np.abs(off).max(1)
    worst["both"] = np.maximum(*worst.values())
    best = {what: np.argmin(off) for what, off in worst.items()}
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
    worst = {}
    for s in STEPS:
        model = replace(PAPER, elements=s)
        off = [relative_error(hertz[case, model], hertz[case, EXACT]) for case in CASES]
        worst[s] = np.abs(off)[:, np.array(args["modes"]) - 1].max()
    fewest = next((f"{s} or more" for s in STEPS if worst[s] <= most), "more than were tried")
    words = ", ".join(f"{worst[s]:.3f} % at s = {s}" for s in STEPS if s <= elements + 1)
    return outcome(worst[elements] <= most, words=words, most=most, fewest=fewest)


def repeated(facts: Facts, args: Args) -> Outcome:
    """Are the printed pairs of equal frequencies double roots of the model?"""
    f = facts.hertz[args["case"], PAPER]
    apart = {f"f{i} and f{j}": abs(f[j - 1] / f[i - 1] - 1) for i, j in args["pairs"]}
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
    _, said = _within(facts, facts.slender.frequencies.max(axis=1), RULES.agrees_percent)
    return outcome(said["gaps"][0] <= RULES.agrees_percent, **said)


def _within(facts: Facts, gaps: Array, limit: float) -> Outcome:
    """Is the gap at most `limit` [%] for the printed rods, and else below which d/L is it?"""
    ratios, ends = facts.slender.ratios, [0, -1]
    # The gap grows as a power of d/L: straight between neighbours on logarithms.
    ratio = np.exp(np.interp(np.log(limit), np.log(gaps), np.log(ratios)))
    otherwise = "even" if gaps[0] > limit else "otherwise"
    return outcome(gaps[-1] <= limit, otherwise, gaps=gaps[ends], ratios=ratios[ends], ratio=ratio)
