"""Checks of what is printed: the paper against itself, and any paper's rows against a model."""

import numpy as np

from analytic import InputError
from harness.case import Case
from harness.paper import ERROR, FEA, THEORETICAL, Printed
from harness.signatures import Array
from harness.studies.claims.data import CASES, RULES, Args, Outcome, outcome
from harness.studies.claims.facts import Facts
from reference_models import parse

EDGE = 1e-9
"""A printed value on the very edge of its rounding counts as inside."""
INSIDE = RULES.rounding + EDGE


def _rows_error(facts: Facts, case: str) -> tuple[Array, Array]:
    """Return 100 (t - f) / f of the printed rows and what their own rounding does to it [%]."""
    t, f = (np.array(facts.printed.table[case, method]) for method in (THEORETICAL, FEA))
    return 100 * (t - f) / f, 100 * (1 + t / f) / f * RULES.rounding


def error_follows(facts: Facts, args: Args) -> Outcome:
    """Does a printed error follow from the printed rows?"""
    case, i = args["case"], args["mode"] - 1
    t, f, quoted = (facts.printed.table[case, method][i] for method in (THEORETICAL, FEA, ERROR))
    value, own = (float(column[i]) for column in _rows_error(facts, case))
    of_theory = 100 * (t - f) / t
    verdict, said = _follows(value, own, quoted)
    if verdict == "otherwise" and abs(of_theory - quoted) <= RULES.rounding + own:
        verdict = "of_theory"
    return verdict, said | {"of_theory": of_theory}


def _follows(value: float, own: float, quoted: float) -> Outcome:
    """Is a value what is quoted: as it is rounded, or within what rounding does to it, `own`?"""
    off = abs(value - quoted)
    otherwise = "digits" if off <= RULES.rounding + own else "otherwise"
    return outcome(off <= INSIDE, otherwise, value=value, own=own)


def largest_printed(facts: Facts, args: Args) -> Outcome:
    """Is the largest error that the printed frequencies give what the text says?"""
    modes = [i - 1 for i in args["modes"]]
    both = np.array([_rows_error(facts, case) for case in CASES])[:, :, modes]
    k, m = (int(n) for n in np.unravel_index(both[:, 0].argmax(), both[:, 0].shape))
    value, own = both[k, :, m]
    limit = float(args["printed"]) + (0 if args["strictly"] else INSIDE)
    otherwise = "digits" if value - own < limit else "otherwise"
    where = f"{CASES[k]}, f{modes[m] + 1}"
    return outcome(value < limit, otherwise, value=value, own=own, where=where)


def saved_follows(facts: Facts, args: Args) -> Outcome:
    """Does the percentage saved follow from the two printed times?"""
    theory, fea, saved = (
        facts.printed.cost[k] for k in ("theoretical model", "finite-element model", "cost saved")
    )
    own = 100 * RULES.rounding * (1 / fea + theory / fea**2)
    return _follows(100 * (1 - theory / fea), own, saved)


def blocks(facts: Facts, args: Args) -> Outcome:
    """Do the printed blocks of every row fill the matrix's columns?"""
    matrix = facts.printed.matrices[args["equation"]]
    columns, rows = np.array(matrix["columns"]), matrix["rows"]
    off = {row: np.sum(widths, axis=0) - columns for row, widths in rows.items()}
    wrong = {row: by for row, by in off.items() if by.any()}
    which = "; ".join(f"{row} is {_linear(columns + by)} wide" for row, by in wrong.items())
    return outcome(
        not wrong,
        "one" if len(wrong) == 1 else "otherwise",
        right=len(rows) - len(wrong),
        all=len(rows),
        width=_linear(columns),
        which=which,
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
    off = [(100 * (a.frequency / b.frequency - 1), a, b) for a, b in pairs]
    value, a, b = max(off, key=lambda entry: abs(entry[0]))
    digits = 100 * (a.half / a.frequency + b.half / b.frequency)
    good = abs(value) <= args["at_most_percent"] + digits
    return outcome(good, value=value, digits=digits, mode=a.mode)


def _rows(facts: Facts, args: Args, key: str) -> tuple[Case, list[Printed]]:
    """Return the case of a claim, and its rows by the method that `key` names."""
    by_name = {case.name: case for case in facts.cases}
    if args["case"] not in by_name:
        known = ", ".join(by_name)
        raise InputError(f"claim {args['id']}", args["case"], f"one of the cases {known}")
    case = by_name[args["case"]]
    rows = [row for row in case.printed if row.method == args[key]]
    if not rows:
        known = ", ".join(dict.fromkeys(row.method for row in case.printed)) or "none"
        raise InputError(f"claim {args['id']}", args[key], f"a method that is printed: {known}")
    return case, rows
