"""A section of the page as JSON can keep it, and numbers that say where they come from."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from harness.tables import Cell, Number, Table

Json = dict[str, Any]


@dataclass(frozen=True)
class Section:
    """One part of the page.

    Attributes: `key`, its anchor and the name of its templates; `title`; `menu`, its title in the
    navigation; `command`, what makes it; `context` for the template; `data` for its script;
    `missing`, why there is nothing to show.
    """

    key: str
    title: str
    menu: str
    command: str
    context: Json = field(default_factory=dict)
    data: Any = None
    missing: str = ""


def number(text: str, full: str, what: str, record: int | None) -> Json | str:
    """Return a number that can be asked: as shown, with all digits, what it is, and its record."""
    if record is None:
        return text
    return {"text": text, "full": full, "what": what, "record": record}


def digits(value: float | None, count: int = 12) -> float | None:
    """Return `value` with `count` significant digits; None for what is no number."""
    if value is None or not math.isfinite(value):
        return None
    return float(f"{value:.{count}g}")


Recorder = Callable[[Sequence[Cell], int], int | None]


def shown(table: Table, record: Recorder) -> Json:
    """Return a table as the page shows it; `record(row, column)` says where a number comes from."""
    numeric = [
        any(isinstance(row[k], (int, Number)) for row in table.rows)
        for k in range(len(table.columns))
    ]

    def one(row: Sequence[Cell], k: int) -> Json | str:
        value = row[k]
        if not isinstance(value, Number):
            return str(value)
        words = ", ".join(str(cell) for cell in row[:k] if isinstance(cell, (str, int)) and cell)
        what = f"{table.columns[k]}: {words}"
        return number(str(value), repr(float(value.value)), what, record(row, k))

    rows = [[one(row, k) for k in range(len(row))] for row in table.rows]
    return {
        "title": table.title,
        "columns": list(table.columns),
        "numeric": numeric,
        "rows": rows,
        "notes": list(table.notes),
    }
