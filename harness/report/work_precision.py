"""Work and precision: what an accuracy costs, model by model."""

from collections.abc import Sequence

from harness.report.ledger import Ledger
from harness.report.results_table import cells, number
from harness.report.section import Cell, Section, digits
from harness.report.sources import Sources, TableFile

COMMAND = "rps-bench work-precision --output results"


def section(sources: Sources, ledger: Ledger) -> Section:
    """Return the section."""
    table, cheapest = sources.tables.get("work-precision"), sources.tables.get("cheapest")
    wanted = ("Case", "Model", "Elements", "Modes", "Error", "ms a pose")
    columns = [_column(table, name) for name in wanted] if table else []
    if table is None or None in columns:
        missing = f"`{COMMAND}` makes this section"
        return Section("work-precision", "Work and precision", missing=missing)
    record = ledger.table("work-precision", COMMAND, "; ".join(table.notes[:3]))
    case, model, elements, modes, error, time = (k for k in columns if k is not None)
    data = []
    for row in table.rows:
        try:
            values = (digits(float(row[time]), 4), digits(abs(float(row[error])), 5))
        except ValueError:
            continue
        label = f"{row[model]}@{row[elements]}" if "@" not in row[model] else row[model]
        part = ledger.model(row[case], label)
        own = record if part is None else ledger.add(f"Cost and error of {label}", {
            "File": "results/work-precision.csv", "Command": COMMAND}, [record, part])  # fmt: skip
        data.append([row[case], row[model], row[elements], row[modes], *values, own])
    context = {
        "cases": list(dict.fromkeys(row[0] for row in data)),
        "modes": list(dict.fromkeys(row[3] for row in data)),
        "tables": [
            (one, cells(one.rows, _maker(one, ledger.table(stem, COMMAND))))
            for stem, one in (("cheapest", cheapest), ("work-precision", table))
            if one is not None
        ],
    }
    return Section("work-precision", "Work and precision", context, data)


def _column(table: TableFile, name: str) -> int | None:
    return next((k for k, one in enumerate(table.columns) if one.startswith(name)), None)


def _maker(table: TableFile, record: int):  # type: ignore[no-untyped-def]
    def make(row: Sequence[str], k: int) -> str | Cell:
        if "." not in row[k] and "e" not in row[k]:
            return row[k]
        return number(row[k], ".4g", "", f"{table.columns[k]}: {', '.join(row[:4])}", record)

    return make
