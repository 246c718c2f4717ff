"""A section of the page as JSON can keep it, and numbers that say where they come from."""

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from harness.tables import Number, Table

Json = dict[str, Any]


@dataclass(frozen=True)
class Section:
    """One part of the page.

    Attributes: `context` for its template; `data` for its script; `missing`, why there is nothing
    to show; `key`, its anchor and the name of its templates; `title`; `menu`, its title in the
    navigation; `command`, what makes it.
    """

    context: Json = field(default_factory=dict)
    data: Any = None
    missing: str = ""
    key: str = ""
    title: str = ""
    menu: str = ""
    command: str = ""


def number(text: str, full: str, what: str, record: int | None) -> Json | str:
    """Return a number that can be asked: as shown, with all digits, what it is, and its record."""
    if record is None:
        return text
    return {"text": text, "full": full, "what": what, "record": record}


def digits(value: Any, count: int = 12) -> Any:
    """Return numbers, in lists or not, to `count` significant digits; None for what is none."""
    if isinstance(value, (list, tuple, np.ndarray)):
        return [digits(one, count) for one in value]
    if value is None or not math.isfinite(value):
        return None
    return float(f"{value:.{count}g}")


def shown(table: Table, record: int | None = None) -> Json:
    """Return a table as the page shows it; its numbers come from `record`."""
    rows: list[list[Any]] = []
    for row in table.rows:
        rows.append([str(cell) for cell in row])
        for k, cell in enumerate(row):
            if isinstance(cell, Number):
                words = ", ".join(str(w) for w in row[:k] if isinstance(w, (str, int)) and w)
                what = f"{table.columns[k]}: {words}"
                rows[-1][k] = number(str(cell), repr(float(cell.value)), what, record)
    return {
        "title": table.title,
        "columns": list(table.columns),
        "numeric": [
            any(isinstance(row[k], (int, Number)) for row in table.rows)
            for k in range(len(table.columns))
        ],
        "rows": rows,
        "notes": list(table.notes),
    }
