"""Where every number on the page comes from: one record a source, shared by its numbers."""

import json
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from harness.poses import COLUMNS, words

Fields = dict[str, str]
PHRASES = {"way": "{}", "timed": "timed by {}", "poses": "batches of {} poses", "table": "{}",
           "case": "{}"}  # fmt: skip
"""Settings of a row that their name and value do not say in words."""
USUAL_SHEAR = "cowper"
"""The shear coefficient that a row need not mention."""


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
