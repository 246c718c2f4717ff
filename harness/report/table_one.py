"""Table I: what the paper prints, the theory, and every reference with the error against it."""

from typing import Any

import numpy as np

from analytic.model import Model
from harness import published
from harness.bench import label
from harness.cases import Case
from harness.compare import PERCENT, case_notes, failure_notes, pairing_notes, relative_error
from harness.report.material import Material
from harness.report.section import Json, Section, number
from harness.studies.table import TableOne

KEY, TITLE, MENU = "table1", "Table I: natural frequencies", "Table I"
PRINTED = ("FEA", "Theoretical", "Error (%)")
DIGITS = 3


def section(run: Material) -> Section | None:
    """Return the section."""
    found = run.of(TableOne)
    if not found:
        return None
    table = next(iter(found.values()))
    cases = [
        {"name": case.name, "heading": case.heading, "rows": _rows(run, table, case)}
        for case in table.study.cases
    ]
    context = {
        "columns": [f"f{i} [Hz]" for i in table.shown],
        "cases": cases,
        "sentences": table.sentences(),
        "notes": _notes(table),
    }
    return Section(KEY, TITLE, MENU, run.only("table"), context)


def _rows(run: Material, table: TableOne, case: Case) -> list[Json]:
    rows = _printed(run, table, case)
    for theory in table.theories:
        ours = table.study.first(case, theory)
        if ours is None:
            continue
        record = run.record(case, theory)
        cells = [_hz(ours.frequencies[i - 1], i, theory, case, record) for i in table.shown]
        rows.append({"head": label(theory), "about": ours.theory, "kind": "theory", "cells": cells})
        if case.published:
            theoretical = np.array(published.table1()[case.published, "Theoretical"])
            rows.append(_deviation(run, table, case, theory, ours.frequencies, theoretical))
        for reference in table.references:
            rows += _reference(run, table, case, theory, reference)
    return rows


def _printed(run: Material, table: TableOne, case: Case) -> list[Json]:
    if not case.published:
        return []
    rows = []
    for method in PRINTED:
        values = published.table1()[case.published, method]
        unit = "%" if "%" in method else "Hz"
        source = {"File": "results/published/table1.csv", "Where": "Table I of the paper"}
        record = run.ledger.add(f"Printed: {method}, {case.published}", source)
        cells = [
            number(f"{values[i - 1]:.2f}", f"{values[i - 1]!r} {unit}",
                   f"f{i}: {method} as printed, {case.published}", record)
            if i <= len(values) else "" for i in table.shown
        ]  # fmt: skip
        rows.append({"head": f"printed: {method}", "about": "", "kind": "printed", "cells": cells})
    return rows


def _deviation(
    run: Material, table: TableOne, case: Case, theory: Model, ours: Any, printed: Any
) -> Json:
    off = relative_error(ours[: len(printed)], printed[: len(ours)]).tolist()
    made = {"Made as": "100 (theoretical / printed theoretical - 1)", "Command": run.only("table")}
    what = f"{label(theory)} against printed (%)"
    record = run.ledger.add(f"{what}, {case.name}", made, [run.record(case, theory)])
    cells = [
        number(f"{off[i - 1]:+.{PERCENT}f}", f"{off[i - 1]!r} %", f"f{i}: {what}, {case.name}",
               record)
        if i <= len(off) and np.isfinite(off[i - 1]) else "-" for i in table.shown
    ]  # fmt: skip
    return {"head": what, "about": "", "kind": "printed", "cells": cells}


def _reference(
    run: Material, table: TableOne, case: Case, theory: Model, reference: Model
) -> list[Json]:
    """Return a reference's frequencies, each with the error of the theory against it."""
    ours, against = table.study.first(case, theory), table.study.get(case, reference)
    pairing = table.study.pairing(case, theory, reference)
    if ours is None or against is None or pairing is None:
        return []
    own = run.record(case, reference)
    made = {"Made as": "100 (theoretical / reference - 1), modes paired by shape",
            "Command": run.only("table")}  # fmt: skip
    what = f"error of {label(theory)} against {label(reference)}"
    error_record = run.ledger.add(f"{what}, {case.name}", made, [run.record(case, theory), own])
    fea = against.frequencies[pairing.partner]
    error = relative_error(ours.frequencies, fea).tolist()
    cells = []
    for i in table.shown:
        value = error[i - 1]
        star = " *" if pairing.reordered[i - 1] or pairing.doubtful[i - 1] else ""
        said = (
            number(f"{value:+.{PERCENT}f} %{star}", f"{value!r} %", f"f{i}: {what}, {case.name}",
                   error_record)
            if np.isfinite(value) else "-"
        )  # fmt: skip
        cells.append({"value": _hz(fea[i - 1], i, reference, case, own), "error": said})
    about = f"{against.theory}; {against.version}"
    return [{"head": label(reference), "about": about, "kind": "reference", "cells": cells}]


def _hz(value: float, i: int, model: Model, case: Case, record: int | None) -> Json | str:
    what = f"f{i} of {label(model)}, {case.name}"
    return number(f"{value:.{DIGITS}f}", f"{float(value)!r} Hz", what, record)


def _notes(table: TableOne) -> list[str]:
    study = table.study
    pick = [i - 1 for i in table.shown]
    notes = [
        note
        for case in study.cases
        for theory in table.theories
        for reference in table.references
        if (pairing := study.pairing(case, theory, reference)) is not None
        for note in pairing_notes(case, theory, reference, pairing, pick)
    ]
    remarks = [f"{label(m)}: {m.info().remark}" for m in table.references if m.info().remark]
    return [*notes, *remarks, *case_notes(study.cases), *failure_notes(study)]
