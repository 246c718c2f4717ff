"""Checks of the paper against itself: what its own numbers say."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from harness.studies.claims.data import CANNOT, FAILS, ONLY_IF, RULES, Finding, finding, reads
from harness.studies.claims.facts import CASES, Facts, Floats

FEA, THEORETICAL, ERROR = "FEA", "Theoretical", "Error (%)"
EDGE = 1e-9
"""A printed value on the very edge of its rounding counts as inside."""
INSIDE = RULES.rounding + EDGE
WHOLE = "none: whole numbers"
MORE_DIGITS = f"{ONLY_IF} the {{}} had more digits: as printed they give {{}} %"


def rows_error(facts: Facts, case: str) -> tuple[Floats, Floats]:
    """Return 100 (t - f) / f of the printed rows and what their own rounding does to it [%]."""
    t, f = (np.array(facts.printed.table[case, method]) for method in (THEORETICAL, FEA))
    return 100 * (t - f) / f, 100 * (1 + t / f) / f * RULES.rounding


@reads()
def error_follows(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Does a printed error follow from the printed rows?"""
    case, i = args["case"], args["mode"] - 1
    t, f, quoted = (facts.printed.table[case, method][i] for method in (THEORETICAL, FEA, ERROR))
    value, own = (float(column[i]) for column in rows_error(facts, case))
    of_theory, off = 100 * (t - f) / t, abs(value - quoted)
    otherwise = f"{FAILS}: the printed rows give {value:.2f} %"
    if off <= RULES.rounding + own:
        otherwise = MORE_DIGITS.format("frequencies", f"{value:.2f}")
    elif abs(of_theory - quoted) <= RULES.rounding + own:
        otherwise += f"; relative to the theoretical value instead it is {of_theory:.2f} %"
    return finding(off <= INSIDE, f"{value:.4f} %", f"{own:.4f} % (rounding of both rows)",
                   otherwise)  # fmt: skip


@reads()
def largest_printed(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Is the largest error that the printed frequencies give what the text says?"""
    modes = [i - 1 for i in args["modes"]]
    errors, slack = np.array([rows_error(facts, case) for case in CASES])[:, :, modes].swapaxes(
        0, 1
    )
    k, m = (int(n) for n in np.unravel_index(errors.argmax(), errors.shape))
    value, own, where = float(errors[k, m]), float(slack[k, m]), f"{CASES[k]}, f{modes[m] + 1}"
    limit = float(args["printed"]) + (0 if args["strictly"] else INSIDE)
    otherwise = f"{FAILS}: the printed rows give {value:.2f} %, {where}"
    if value - own < limit:
        otherwise = MORE_DIGITS.format("frequencies", f"{value:.4f}")
    return finding(value < limit, f"{value:.4f} % ({where})",
                   f"{own:.4f} % (rounding of both rows)", otherwise)  # fmt: skip


@reads()
def blocks(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Do the printed blocks of every row fill the matrix's columns?"""
    matrix = facts.printed.matrices[args["equation"]]
    columns, rows = np.array(matrix["columns"]), matrix["rows"]
    off = {row: np.sum(widths, axis=0) - columns for row, widths in rows.items()}
    wrong = {row: by for row, by in off.items() if by.any()}
    which = "; ".join(f"{row} is {_linear(columns + by)} wide" for row, by in wrong.items())
    otherwise = f"{CANNOT}: {which}"
    if len(wrong) == 1:
        otherwise = (
            f"{ONLY_IF} a zero block is {_linear(-next(iter(wrong.values())))} wider: {which}"
        )
    measured = f"{len(rows) - len(wrong)} of {len(rows)} rows are {_linear(columns)} wide"
    return finding(not wrong, measured, WHOLE, otherwise)


def _linear(widths: Floats) -> str:
    """Return a s + b in words."""
    a, b = (int(n) for n in widths)
    if not a:
        return f"{b}"
    return f"{a} s" + (f" {'+' if b > 0 else '-'} {abs(b)}" if b else "")


@reads()
def saved_follows(facts: Facts, args: Mapping[str, Any]) -> Finding:
    """Does the percentage saved follow from the two printed times?"""
    cost = facts.printed.cost
    own, fea = cost["theoretical model"], cost["finite-element model"]
    value = 100 * (1 - own / fea)
    slack = 100 * RULES.rounding * (1 / fea + own / fea**2)
    off = abs(value - cost["cost saved"])
    otherwise = f"{FAILS}: the two times give {value:.2f} %"
    if off <= RULES.rounding + slack:
        otherwise = MORE_DIGITS.format("times", f"{value:.2f}")
    own_words = f"{slack:.3f} % (rounding of both times)"
    return finding(off <= INSIDE, f"{value:.3f} %", own_words, otherwise)
