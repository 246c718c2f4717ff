"""Checks of the paper against itself: what its own numbers say."""

import numpy as np

from harness.studies.claims.data import CANNOT, FAILS, HOLDS, ONLY_IF, Claim, Finding, Rules, reads
from harness.studies.claims.facts import CASES, Facts, Floats

FEA, THEORETICAL, ERROR = "FEA", "Theoretical", "Error (%)"
EDGE = 1e-9
"""A printed value on the very edge of its rounding counts as inside."""


def rows_error(facts: Facts, case: str) -> tuple[Floats, Floats]:
    """Return 100 (t - f) / f of the printed rows and what their own rounding does to it [%]."""
    t, f = (np.array(facts.printed.table[case, method]) for method in (THEORETICAL, FEA))
    return 100 * (t - f) / f, 100 * (1 + t / f) / f


@reads()
def error_follows(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Does a printed error follow from the printed rows?"""
    case, i = claim.args["case"], claim.args["mode"] - 1
    quoted = facts.printed.table[case, ERROR][i]
    errors, slopes = rows_error(facts, case)
    value, own = float(errors[i]), float(slopes[i]) * rules.rounding
    measured, uncertainty = f"{value:.4f} %", f"{own:.4f} % (rounding of both rows)"
    off = abs(value - quoted)
    if off <= rules.rounding + EDGE:
        return Finding(measured, uncertainty, HOLDS)
    if off <= rules.rounding + own:
        verdict = f"{ONLY_IF} the frequencies had more digits: as printed they give {value:.2f} %"
        return Finding(measured, uncertainty, verdict)
    t, f = (facts.printed.table[case, method][i] for method in (THEORETICAL, FEA))
    of_theory = 100 * (t - f) / t
    why = f"the printed rows give {value:.2f} %"
    if abs(of_theory - quoted) <= rules.rounding + own:
        why += f"; relative to the theoretical value instead it is {of_theory:.2f} %"
    return Finding(measured, uncertainty, f"{FAILS}: {why}")


@reads()
def largest_printed(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Is the largest error that the printed frequencies give what the text says?"""
    quoted, modes = float(claim.args["printed"]), [i - 1 for i in claim.args["modes"]]
    both = [rows_error(facts, case) for case in CASES]
    errors = np.array([errors[modes] for errors, _ in both])
    k, m = (int(n) for n in np.unravel_index(errors.argmax(), errors.shape))
    value, own = float(errors[k, m]), float(both[k][1][modes[m]]) * rules.rounding
    where = f"{CASES[k]}, f{modes[m] + 1}"
    measured, uncertainty = f"{value:.4f} % ({where})", f"{own:.4f} % (rounding of both rows)"
    strictly = claim.args["strictly"]
    limit = quoted if strictly else quoted + rules.rounding + EDGE
    if value < limit:
        return Finding(measured, uncertainty, HOLDS)
    if value - own < limit:
        verdict = f"{ONLY_IF} the frequencies had more digits: as printed they give {value:.4f} %"
        return Finding(measured, uncertainty, verdict)
    return Finding(measured, uncertainty, f"{FAILS}: the printed rows give {value:.2f} %, {where}")


@reads()
def blocks(facts: Facts, claim: Claim, rules: Rules) -> Finding:
    """Do the printed blocks of every row fill the matrix's columns?"""
    name = claim.args["equation"]
    columns = np.array(facts.printed.columns[name])
    rows = facts.printed.blocks[name]
    off = {row: np.sum(widths, axis=0) - columns for row, widths in rows.items()}
    wrong = {row: by for row, by in off.items() if by.any()}
    measured = f"{len(rows) - len(wrong)} of {len(rows)} rows are {_linear(columns)} wide"
    exact = "none: whole numbers"
    if not wrong:
        return Finding(measured, exact, HOLDS)
    which = "; ".join(f"{row} is {_linear(columns + by)} wide" for row, by in wrong.items())
    if len(wrong) == 1:
        by = next(iter(wrong.values()))
        verdict = f"{ONLY_IF} a zero block is {_linear(-by)} wider: {which}"
        return Finding(measured, exact, verdict)
    return Finding(measured, exact, f"{CANNOT}: {which}")


def _linear(widths: Floats) -> str:
    """Return a s + b in words."""
    a, b = (int(n) for n in widths)
    if not a:
        return f"{b}"
    return f"{a} s" + (f" {'+' if b > 0 else '-'} {abs(b)}" if b else "")
