"""Checks that any paper's claims can ask for: a printed row against a model, or another row."""

from analytic import InputError
from harness.case import Case
from harness.paper import Printed
from harness.studies.claims.data import Args, Outcome, outcome
from harness.studies.claims.facts import Facts
from reference_models import parse


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
