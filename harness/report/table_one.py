"""Table I: what the paper prints, the theory, and every reference with the error against it."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from harness.bench import label
from harness.case import Case
from harness.compare import PERCENT, match, relative_error
from harness.paper import CHECKED, TABLE_ONE
from harness.report.material import Material
from harness.report.section import Json, Section, number
from harness.studies.table import TableOne, printed

HZ, PERCENTS = ".3f", f"+.{PERCENT}f"
"""How frequencies and errors are written."""


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
    rows = []

    def add(head: str, about: str, kind: str, cells: Sequence[Any]) -> None:
        rows.append({"head": head, "about": about, "kind": kind, "cells": cells})

    def shown(values: Any, form: str, unit: str, what: str, record: int | None,
              marks: Sequence[str] = ()) -> list[Any]:  # fmt: skip
        """Return values of the modes shown as numbers, with `marks`; a dash for what is none."""
        return [
            number(f"{values[i - 1]:{form}}{marks[i - 1] if marks else ''}",
                   f"{float(values[i - 1])!r} {unit}", f"f{i}: {what}, {case.name}", record)
            if i <= len(values) and np.isfinite(values[i - 1]) else "-" for i in table.shown
        ]  # fmt: skip

    def of(made: str, what: str, *parts: int | None) -> int:
        """Return the record of errors, made from those of the answers."""
        fields = {"Made as": made, "Command": run.only("table")}
        return run.ledger.add(f"{what}, {case.name}", fields, parts)

    for method in TABLE_ONE if case.prints_errors else ():
        source = {"File": f"results/published/{CHECKED}/table.csv", "Where": "Table I of the paper"}
        page = run.ledger.add(f"Printed: {method}, {case.published}", source)
        unit = "%" if "%" in method else "Hz"
        values = shown(printed(case, method), ".2f", unit, f"{method} as printed", page)
        add(f"printed: {method}", "", "printed", values)
    for theory in table.theories:
        ours = table.study.first(case, theory)
        if ours is None:
            continue
        name, record = label(theory), run.record(case, theory)
        add(name, ours.theory, "theory", shown(ours.frequencies, HZ, "Hz", name, record))
        if case.prints_errors:
            count = min(len(ours.frequencies), len(printed(case)))
            off = relative_error(ours.frequencies[:count], printed(case)[:count])
            what = f"{name} against printed (%)"
            made = of("100 (theoretical / printed theoretical - 1)", what, record)
            add(what, "", "printed", shown(off, PERCENTS, "%", what, made))
        for reference in table.references:
            found = match(table.study, case, theory, reference)
            if found is None:
                continue
            other, own = label(reference), run.record(case, reference)
            what = f"error of {name} against {other}"
            made = of("100 (theoretical / reference - 1), modes paired by shape", what, record, own)
            marks = np.where(found.odd, " % *", " %").tolist()
            hertz = shown(found.against, HZ, "Hz", other, own)
            errors = shown(found.error, PERCENTS, "%", what, made, marks)
            pairs = zip(hertz, errors, strict=True)
            against = table.study.answers[case, reference]
            add(other, f"{against.theory}; {against.version}", "reference",
                [{"value": value, "error": error} for value, error in pairs])  # fmt: skip
    return rows
