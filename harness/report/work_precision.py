"""Work and precision: what an accuracy costs, model by model."""

from collections.abc import Callable, Sequence

from harness.report.ledger import Ledger
from harness.report.results_table import cells, number
from harness.report.section import Cell, Section, digits
from harness.report.sources import Sources, TableFile

COMMAND = "rps-bench work-precision --output results"
WANTED = ("Case", "Model", "Theory", "Elements", "Modes", "ms a pose")


def section(sources: Sources, ledger: Ledger) -> Section:
    """Return the section."""
    table, cheapest = sources.tables.get("work-precision"), sources.tables.get("cheapest")
    columns = [_column(table, name) for name in WANTED] if table else []
    errors = (
        [k for k, name in enumerate(table.columns) if name.startswith("Error")] if table else []
    )
    if table is None or None in columns or not errors:
        missing = f"`{COMMAND}` makes this section"
        return Section("work-precision", "Work and precision", missing=missing)
    case, model, theory, elements, modes, time = (row for row in columns if row is not None)
    data = []
    for row in table.rows:
        label = row[model] if row[elements] in ("", "-") else f"{row[model]}@{row[elements]}"
        label = row[model] if "@" in row[model] else label
        about = {name: text for name, text in zip(table.columns, row, strict=True) if text}
        own = ledger.add(f"Work and precision of {label}", {
            **about, "File": "results/work-precision.csv", "Command": COMMAND})  # fmt: skip
        values = [digits(_value(row[k]), 5) for k in (time, *errors)]
        data.append([row[case], row[model], row[theory], row[elements], row[modes], own, *values])
    context = {
        "cases": list(dict.fromkeys(row[0] for row in data)),
        "theories": list(dict.fromkeys(row[2] for row in data)),
        "modes": list(dict.fromkeys(row[4] for row in data)),
        "errors": [(str(k), table.columns[column]) for k, column in enumerate(errors)],
        "tables": [
            (one, cells(one.rows, _maker(one, ledger.table(stem, COMMAND))))
            for stem, one in (("cheapest", cheapest), ("work-precision", table))
            if one is not None
        ],
    }
    return Section("work-precision", "Work and precision", context, data)


def _column(table: TableFile, name: str) -> int | None:
    return next((k for k, one in enumerate(table.columns) if one.startswith(name)), None)


def _value(text: str) -> float | None:
    try:
        return float(text)
    except ValueError:
        return None


def _maker(table: TableFile, record: int) -> Callable[[Sequence[str], int], str | Cell]:
    def make(row: Sequence[str], k: int) -> str | Cell:
        if "." not in row[k] and "e" not in row[k]:
            return row[k]
        return number(row[k], ".4g", "", f"{table.columns[k]}: {', '.join(row[:4])}", record)

    return make
