"""Table I: what the paper prints, the theory, and every reference with the error against it."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from analytic.model import Model
from harness.bench import label
from harness.case import Case
from harness.compare import PERCENT, match, relative_error
from harness.paper import CHECKED, TABLE_ONE
from harness.report.material import Material
from harness.report.section import Json, Section, number
from harness.studies.table import TableOne
from harness.studies.table import printed as printed_row

DIGITS = 3


def section(run: Material) -> Section | None:
    """Return the section."""
    table = next(iter(run.of(TableOne)), None)
    if table is None:
        return None
    context = {
        "columns": [f"f{i} [Hz]" for i in table.shown],
        "cases": [
            {"name": case.name, "heading": case.heading, "rows": _rows(run, table, case)}
            for case in table.study.cases
        ],
        "sentences": table.sentences(),
        "notes": list(table.table().notes),
    }
    title = "Table I: natural frequencies"
    return Section("table1", title, "Table I", run.only("table"), context)


def _row(head: str, about: str, kind: str, cells: Sequence[Any]) -> Json:
    return {"head": head, "about": about, "kind": kind, "cells": list(cells)}


def _rows(run: Material, table: TableOne, case: Case) -> list[Json]:
    rows = [_printed(run, table, case, method) for method in TABLE_ONE if case.prints_errors]
    for theory in table.theories:
        ours = table.study.first(case, theory)
        if ours is None:
            continue
        record = run.record(case, theory)
        cells = [_hz(ours.frequencies[i - 1], i, theory, case, record) for i in table.shown]
        rows.append(_row(label(theory), ours.theory, "theory", cells))
        if case.prints_errors:
            printed = printed_row(case)
            off = relative_error(ours.frequencies[: len(printed)], printed[: len(ours.frequencies)])
            made, what = "theoretical / printed theoretical", f"{label(theory)} against printed (%)"
            cells = _errors(run, table, case, f"100 ({made} - 1)", what, [record], off)
            rows.append(_row(what, "", "printed", cells))
        for reference in table.references:
            found = match(table.study, case, theory, reference)
            if found is None:
                continue
            own, against = run.record(case, reference), table.study.answers[case, reference]
            made = "100 (theoretical / reference - 1), modes paired by shape"
            what = f"error of {label(theory)} against {label(reference)}"
            ends = np.where(found.odd, " % *", " %").tolist()
            errors = _errors(run, table, case, made, what, [record, own], found.error, ends)
            cells = [
                {"value": _hz(found.against[i - 1], i, reference, case, own), "error": one}
                for i, one in zip(table.shown, errors, strict=True)
            ]
            about = f"{against.theory}; {against.version}"
            rows.append(_row(label(reference), about, "reference", cells))
    return rows


def _printed(run: Material, table: TableOne, case: Case, method: str) -> Json:
    values = printed_row(case, method)
    unit = "%" if "%" in method else "Hz"
    source = {"File": f"results/published/{CHECKED}/table.csv", "Where": "Table I of the paper"}
    record = run.ledger.add(f"Printed: {method}, {case.published}", source)
    cells = [
        number(f"{values[i - 1]:.2f}", f"{values[i - 1]!r} {unit}",
               f"f{i}: {method} as printed, {case.published}", record)
        if i <= len(values) else "" for i in table.shown
    ]  # fmt: skip
    return _row(f"printed: {method}", "", "printed", cells)


def _errors(
    run: Material, table: TableOne, case: Case, made: str, what: str,
    parts: Sequence[int | None], errors: Any, ends: Sequence[str] | None = None,
) -> list[Json | str]:  # fmt: skip
    """Return errors [%] as numbers, each with its own of `ends`; a dash for what is none."""
    fields = {"Made as": made, "Command": run.only("table")}
    record = run.ledger.add(f"{what}, {case.name}", fields, parts)
    return [
        number(f"{errors[i - 1]:+.{PERCENT}f}{ends[i - 1] if ends else ''}",
               f"{float(errors[i - 1])!r} %", f"f{i}: {what}, {case.name}", record)
        if i <= len(errors) and np.isfinite(errors[i - 1]) else "-" for i in table.shown
    ]  # fmt: skip


def _hz(value: float, i: int, model: Model, case: Case, record: int | None) -> Json | str:
    what = f"f{i} of {label(model)}, {case.name}"
    return number(f"{value:.{DIGITS}f}", f"{float(value)!r} Hz", what, record)
