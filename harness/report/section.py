"""A section of the page as JSON can keep it, and where its numbers come from.

Every number has a record: one a source, shared by its numbers.
"""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any

import numpy as np

from harness.poses import COLUMNS, words
from harness.tables import Number, Table

Json = dict[str, Any]
Fields = dict[str, str]
PHRASES = {"way": "{}", "timed": "timed by {}", "poses": "batches of {} poses", "table": "{}",
           "case": "{}"}  # fmt: skip
"""Settings of a row that their name and value do not say in words."""
USUAL_SHEAR = "cowper"
"""The shear coefficient that a row need not mention."""


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


class Ledger:
    """Records by number: a title, what is known in words, and the records it was made from."""

    def __init__(self, records: Sequence[dict[str, Any]] = ()) -> None:
        self.records = list(records)
        self._places = {json.dumps(one): k for k, one in enumerate(self.records)}

    def add(self, title: str, fields: Fields, parts: Sequence[int | None] = ()) -> int:
        """Return the number of a record, kept once; `parts` are the records it was made from.

        Empty fields are left out.
        """
        known = {name: text for name, text in fields.items() if text}
        one = {"title": title, "fields": known, "parts": [p for p in parts if p is not None]}
        place = self._places.setdefault(json.dumps(one), len(self.records))
        if place == len(self.records):
            self.records.append(one)
        return place


def at(row: Mapping[str, Any]) -> str:
    """Return the pose of a tidy row in words."""
    return words(*(row.get(column) for column in COLUMNS)).replace(" deg", "°")


def answer(rows: Sequence[Mapping[str, Any]]) -> Fields:
    """Return in words what the tidy rows of a model at a case say beside its frequencies."""
    row = rows[0]
    gap = row["closure_m"]
    own = [f"f{one['mode']} ±{one['uncertainty_hz']:.2g}" for one in rows if one["uncertainty_hz"]]
    return {
        "Pose": at(row),
        "Mechanism": row["mechanism"],
        "Model": row["model"],
        "Theory": row["theory"],
        "Version": row["version"],
        "Settings": in_words(row["settings"]),
        "Uncertainty": f"{', '.join(own)} Hz, by extrapolation" if own else "not estimated",
        "Coordinates": str(row["dofs"] or ""),
        "Joint gap": "none can open" if gap is None else f"{gap:.1e} m",
        "Time": f"{1000 * row['build_s']:.3g} ms to build, {1000 * row['solve_s']:.3g} to solve",
    }


def in_words(settings: str | None) -> str:
    """Return a row's settings, JSON, in words."""
    return _words(_settings(settings))


@cache
def variant(settings: str | None) -> str:
    """Return in words what sets a row apart from its model's usual ones; "" for those."""
    known = _settings(settings)
    known.pop("count", None)
    if known.get("shear") == USUAL_SHEAR:
        del known["shear"]
    return _words(known)


def _settings(text: str | None) -> dict[str, Any]:
    try:
        known = json.loads(text or "{}")
    except ValueError:
        known = text
    return known if isinstance(known, dict) else {"settings": known}


def _words(known: Mapping[str, Any]) -> str:
    return ", ".join(
        f"{name} ({_words(value)})"
        if isinstance(value, dict)
        else PHRASES.get(name, name + " {}").format(value)
        for name, value in known.items()
    )


def environment(run: Mapping[str, Any]) -> Fields:
    """Return when, from which commit and on what a run ran."""
    own = f", run {run['run']}" if run.get("run") else ""
    return {
        "Run": f"{run['time']:%Y-%m-%d %H:%M} UTC{own}",
        "Commit": f"{run['commit'] or 'none'} (rps-bench {run['release']})",
        "Machine": run["machine"],
        "Python": f"{run['python']}, numpy {run['numpy']}, scipy {run['scipy']}, {run['blas']}",
    }
