"""Where every number on the page comes from: one record a source, shared by its numbers."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

Fields = dict[str, str]
PHRASES = {
    "way": "{}",
    "timed": "timed by {}",
    "poses": "batches of {} poses",
    "table": "{}",
    "case": "{}",
}
"""Settings of a row that their name and value do not say in words."""
USUAL_SHEAR = "cowper"
"""The shear coefficient that a row need not mention."""


class Ledger:
    """Records by number: a title, what is known in words, and the records it was made from."""

    def __init__(self, records: Sequence[dict[str, Any]] = ()) -> None:
        self.records = list(records)
        self._places = {_key(r["title"], r["fields"], r["parts"]): k
                        for k, r in enumerate(self.records)}  # fmt: skip

    def add(self, title: str, fields: Fields, parts: Sequence[int | None] = ()) -> int:
        """Return the number of a record; the same record is kept once. Empty fields are left out.

        `parts` are the records it was made from.
        """
        known = {name: text for name, text in fields.items() if text}
        used = [part for part in parts if part is not None]
        key = _key(title, known, used)
        if key not in self._places:
            self._places[key] = len(self.records)
            self.records.append({"title": title, "fields": known, "parts": used})
        return self._places[key]


def _key(title: str, fields: Fields, parts: Sequence[int]) -> tuple[Any, ...]:
    return title, tuple(fields.items()), tuple(parts)


def at(z: float | None, azimuth: float | None, tilt: float | None) -> str:
    """Return a pose in words."""
    if z is None or azimuth is None or tilt is None:
        return "no pose"
    degrees = np.degrees([azimuth, tilt])
    return f"z = {1000 * z:.6g} mm, azimuth {degrees[0]:.6g}°, tilt {degrees[1]:.6g}°"


def answer(rows: Sequence[Mapping[str, Any]]) -> Fields:
    """Return in words what the tidy rows of a model at a case say beside its frequencies."""
    row = rows[0]
    gap = row["closure_m"]
    return {
        "Pose": at(row["z_m"], row["azimuth_rad"], row["tilt_rad"]),
        "Mechanism": row["mechanism"],
        "Model": row["model"],
        "Theory": row["theory"],
        "Version": row["version"],
        "Settings": in_words(row["settings"]),
        "Uncertainty": uncertainty(rows),
        "Coordinates": str(row["dofs"] or ""),
        "Joint gap": "none can open" if gap is None else f"{gap:.1e} m",
        "Time": f"{1000 * row['build_s']:.3g} ms to build, {1000 * row['solve_s']:.3g} to solve",
    }


def uncertainty(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return the numerical uncertainty of every mode of a model in words."""
    known = [(row["mode"], row["uncertainty_hz"]) for row in rows if row["uncertainty_hz"]]
    if not known:
        return "not estimated"
    return ", ".join(f"f{mode} ±{value:.2g}" for mode, value in known) + " Hz, by extrapolation"


def in_words(settings: str | None) -> str:
    """Return a row's settings, JSON, in words."""
    return _words(_settings(settings))


def variant(settings: str | None) -> str:
    """Return in words what sets a row apart from its model's usual ones; "" for those."""
    known = _settings(settings)
    usual = {"count": known.get("count"), "shear": USUAL_SHEAR}
    return _words({name: v for name, v in known.items() if name not in usual or v != usual[name]})


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


def environment(run: Mapping[str, Any], heading: str = "Run") -> Fields:
    """Return when, from which commit and on what a run ran."""
    own = f", run {run['run']}" if run.get("run") else ""
    return {
        heading: f"{run['time']:%Y-%m-%d %H:%M} UTC{own}",
        "Commit": f"{run['commit'] or 'none'} (rps-bench {run['release']})",
        "Machine": run["machine"],
        "Python": f"{run['python']}, numpy {run['numpy']}, scipy {run['scipy']}, {run['blas']}",
    }
