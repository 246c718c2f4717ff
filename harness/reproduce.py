"""The main job: every table and figure of the paper that this bench has, into one folder."""

import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import polars as pl

from harness.cases import PRESETS, Case
from harness.compare import (
    errata_table,
    provenance_table,
    readings_table,
    reference_table,
    table_one,
)
from harness.convergence import Convergence, converge, convergence_files, convergence_tables
from harness.models import Spec, parse
from harness.run import Study, rows, run
from harness.summary import causes, closest_readings, summarise
from harness.tables import Table

LADDER = (1, 2, 4, 8, 16)  # doubling, to read the order of convergence from


@dataclass(frozen=True)
class Reproduction:
    """What was reproduced: `table1`, `files` by name, `summary` in plain words, `studies`."""

    table1: Table
    files: dict[str, bytes]
    summary: list[str]
    studies: tuple[Study, ...]


def solves(
    cases: Sequence[Case], theory: Spec, references: Sequence[Spec], elements: Sequence[int]
) -> int:
    """Return how many (model, case) solutions `reproduce` asks for, for a progress bar."""
    first = len({theory, *references, *causes(theory)})
    return len(cases) * (first + 1 + len(elements) + 1 + len(LADDER)) + len(PRESETS)


def reproduce(
    cases: Sequence[Case],
    theory: Spec,
    references: Sequence[Spec],
    elements: Sequence[int],
    shown: Sequence[int],
    done: Callable[[str], None] = lambda _: None,
) -> Reproduction:
    """Return all tables and figures. Fig. 3 is drawn against the first of `references`."""
    count = max(6, *shown)
    study = run(cases, [theory, *references, *causes(theory)], count, done)
    tables = {
        "table1": table_one(study, [theory], references[:1], shown),
        "references": reference_table(study, theory, references, shown),
        "provenance": provenance_table(study),
        "errata": errata_table(),
    }
    readings = [run([case], [parse(case.model, "model")], 6, done) for case in PRESETS.values()]
    tables["readings"] = readings_table(readings)
    summary = summarise(study, theory, references) + closest_readings(readings)

    fig3 = converge(cases, theory, elements, references[0], count, done)
    limit = replace(theory, elements=None)
    alone = converge(cases, theory, LADDER, limit, count, done)
    files = {"frequencies.csv": tidy(rows(study))}
    for stem, table in tables.items():
        files |= table.files(stem)
    curves = {"fig3": fig3, "discretisation": alone}
    for stem, result in curves.items():
        files |= convergence_files(result, shown, stem)
    files["summary.md"] = _page(summary, tables, curves, shown)
    studies = (study, fig3.study, alone.study, *readings)
    return Reproduction(tables["table1"], files, summary, studies)


def tidy(records: list[dict[str, Any]]) -> bytes:
    """Return tidy rows as CSV."""
    text = io.BytesIO()
    pl.DataFrame(records, infer_schema_length=None).write_csv(text)
    return text.getvalue()


def _page(
    summary: Sequence[str],
    tables: dict[str, Table],
    curves: dict[str, Convergence],
    shown: Sequence[int],
) -> bytes:
    parts = ["# Summary\n", "".join(f"- {line}\n" for line in summary)]
    parts += [tables[name].markdown() for name in ("table1", "readings", "references")]
    for stem, result in curves.items():
        parts += [f"![{stem}]({stem}.svg)\n"]
        parts += [table.markdown() for table in convergence_tables(result, shown)]
    parts += [tables[name].markdown() for name in ("provenance", "errata")]
    return "\n".join(parts).encode()
