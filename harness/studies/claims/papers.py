"""Claims of papers that are data: a printed row against our model, or against another row."""

from collections.abc import Sequence
from typing import Any

from analytic import InputError
from harness.bench import Bench, Study, label
from harness.cases import Case
from harness.paper import Paper, Printed, Statement
from harness.studies.claims.data import FAILS, HOLDS, Claim, Finding
from reference_models import Named, parse

Said = tuple[str, str, str]
"""What was measured, how surely, and the verdict."""
Judged = tuple[tuple[Finding, ...], dict[str, str], tuple[dict[str, Any], ...]]


def judged(cases: Sequence[Case], bench: Bench) -> Judged:
    """Return what is found on every claim of the papers of `cases`.

    And by id why one could not be checked, and the rows solved. Raises `InputError` for a claim of
    a case or method that is not there, or no claims at all.
    """
    papers = dict.fromkeys(case.paper for case in cases if case.paper is not None)
    if not any(paper.claims for paper in papers):
        names = ", ".join(case.name for case in cases)
        raise InputError("case_file", names, "the folder of a paper with claims.toml")
    by_name = {case.name: case for case in cases}
    found: list[Finding] = []
    unchecked, rows = {}, list[dict[str, Any]]()
    for paper in papers:
        for one in paper.claims:
            args = dict(one.args)
            if args["case"] not in by_name:
                known = ", ".join(by_name)
                raise InputError(f"claim {one.id}", args["case"], f"one of the cases {known}")
            case = by_name[args["case"]]
            if one.check == "printed":
                model = parse(args["model"], "model") if "model" in args else case.theory
                study = _solved(one, case, model, bench)
                rows += study.rows()
                if study.failures:
                    unchecked[one.id] = study.failures[case, model]
                    continue
                said = _against_model(one, case, model, study)
            else:
                said = _against_row(one, case)
            found.append(Finding(_claim(one, paper, args), *said))
    return tuple(found), unchecked, tuple(rows)


def _claim(one: Statement, paper: Paper, args: dict[str, Any]) -> Claim:
    command = f"rps-bench claims --case-file {paper.name}"
    return Claim(one.id, one.section, one.quoted, one.how, one.check, args, command)


def _rows(one: Statement, case: Case, method: str) -> list[Printed]:
    found = [row for row in case.printed if row.method == method]
    if not found:
        known = ", ".join(dict.fromkeys(row.method for row in case.printed)) or "none"
        raise InputError(f"claim {one.id}", method, f"a method that is printed: {known}")
    return found


def _solved(one: Statement, case: Case, model: Named, bench: Bench) -> Study:
    rows = _rows(one, case, dict(one.args)["method"])
    return bench.run([case], [model], max(row.mode for row in rows))


def _against_model(one: Statement, case: Case, model: Named, study: Study) -> Said:
    args, f = dict(one.args), study.answers[case, model].frequencies
    off = [(100 * (row.frequency / f[row.mode - 1] - 1), 100 * row.half / row.frequency, row.mode)
           for row in _rows(one, case, args["method"])]  # fmt: skip
    # The one that is furthest beyond its last digit.
    value, digits, mode = max(off, key=lambda entry: abs(entry[0]) - entry[1])
    good = abs(value) <= args["within_percent"] + digits
    measured = f"against {label(model)} {value:+.3g} %, at f{mode}"
    return measured, f"{digits:.1g} % (last digit)", _verdict(good, value)


def _against_row(one: Statement, case: Case) -> Said:
    args = dict(one.args)
    other = {row.mode: row for row in _rows(one, case, args["against"])}
    pairs = [(row, other[row.mode]) for row in _rows(one, case, args["method"])
             if row.mode in other]  # fmt: skip
    if not pairs:
        raise InputError(f"claim {one.id}", args["against"], "rows of the same modes")
    off = [(100 * (a.frequency / b.frequency - 1), a, b) for a, b in pairs]
    value, a, b = max(off, key=lambda entry: abs(entry[0]))
    digits = 100 * (a.half / a.frequency + b.half / b.frequency)
    good = abs(value) <= args["at_most_percent"] + digits
    measured = f"{a.method} against {b.method} at most {value:+.3g} %, at f{a.mode}"
    return measured, f"{digits:.1g} % (last digits)", _verdict(good, value)


def _verdict(good: bool, value: float) -> str:
    return HOLDS if good else f"{FAILS}: {value:+.3g} %"
