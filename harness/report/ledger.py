"""Where every number on the page comes from: one record a source, shared by its numbers."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from analytic import Modes, __version__
from analytic.theory import BEAMS
from harness.cases import PRESETS, Case
from harness.models import Spec
from harness.report.sources import Sources
from harness.run import Study

Fields = dict[str, str]
PHRASES = {
    "way": "{}",
    "timed": "timed by {}",
    "poses": "batches of {} poses",
    "table": "{}",
    "case": "{}",
}
"""Settings of a row that their name and value do not say in words."""


class Ledger:
    """Records by number: a title, what is known in words, and the records it was made from."""

    def __init__(self, sources: Sources) -> None:
        self._sources = sources
        self._places: dict[Any, int] = {}
        self.records: list[dict[str, Any]] = []
        self.versions = {row["run"]: row for row in sources.recorded.runs.iter_rows(named=True)}

    def add(self, title: str, fields: Fields, parts: Sequence[int | None] = ()) -> int:
        """Return the number of a record; the same record is kept once. Empty fields are left out.

        `parts` are the records it was made from.
        """
        known = {name: text for name, text in fields.items() if text}
        used = [part for part in parts if part is not None]
        key = (title, tuple(known.items()), tuple(used))
        if key not in self._places:
            self._places[key] = len(self.records)
            self.records.append({"title": title, "fields": known, "parts": used})
        return self._places[key]

    def table(self, stem: str, command: str) -> int:
        """Return the record of a table in the results folder."""
        return self.add(f"results/{stem}.csv", {"Command": command})

    def model(self, case: str, label: str) -> int | None:
        """Return the record of a model in the accepted run at `case`, or None: not in it."""
        frame = self._sources.frequencies
        if frame.is_empty():
            return None
        found = frame.filter(case=case, model=label).sort("mode").to_dicts()
        if not found:
            return None
        row = found[0]
        recorded = self._recorded(case, label, row["frequency_hz"])
        merged = (recorded or {}) | row
        fields = {
            **where(case, row["z_m"], row["azimuth_rad"], row["tilt_rad"], row["mechanism"]),
            **what(label, row["theory"], row["version"], merged.get("settings")),
            "Uncertainty": uncertainty(found),
            **measured(merged),
            "File": "results/frequencies.csv",
            **(
                {}
                if recorded is None
                else environment(self.versions[recorded["run"]], "Same number in")
            ),
            "Command": command(case, label),
        }
        return self.add(f"{label} at {case}", fields)

    def solved(self, study: Study, case: Case, spec: Spec) -> int | None:
        """Return the record of a model solved for this page."""
        modes: Modes | None = study.get(case, spec)
        if modes is None:
            return None
        pose = case.pose
        fields = {
            **where(case.name, pose.z, pose.azimuth, pose.tilt, ""),
            **what(spec.label, modes.theory, modes.version, None),
            "Coordinates": str(modes.dofs),
            "Solved": f"by rps-bench {__version__} when this page was made",
            "Command": command(case.name, spec.label),
        }
        return self.add(f"{spec.label} at {case.name}", fields)

    def _recorded(self, case: str, label: str, first: float) -> dict[str, Any] | None:
        """Return a row of the newest recorded run whose first frequency is this one, if any."""
        points = self._sources.recorded.points
        if points.is_empty():
            return None
        same = points.filter(case=case, model=label, mode=1)
        same = same.filter(np.isclose(same["frequency_hz"].to_numpy(), first, rtol=1e-12, atol=0))
        place = {run: number for number, run in enumerate(self.versions)}
        rows: list[dict[str, Any]] = same.to_dicts()
        return max(rows, key=lambda row: place[row["run"]], default=None)


def where(case: str, z: float, azimuth: float, tilt: float, mechanism: str) -> Fields:
    """Return case, pose and mechanism in words."""
    note = PRESETS[case].note if case in PRESETS else ""
    return {
        "Case": f"{case}: {note}" if note else case,
        "Pose": at(z, azimuth, tilt),
        "Mechanism": mechanism,
    }


def at(z: float | None, azimuth: float | None, tilt: float | None) -> str:
    """Return a pose in words."""
    if z is None or azimuth is None or tilt is None:
        return "no pose"
    degrees = np.degrees([azimuth, tilt])
    return f"z = {1000 * z:.6g} mm, azimuth {degrees[0]:.6g}°, tilt {degrees[1]:.6g}°"


def what(label: str, theory: str, version: str, settings: str | None) -> Fields:
    """Return model, theory, elements, version and settings in words."""
    elements = label.partition("@")[2]
    if "+" in elements:
        elements = f"{elements.replace('+', ' and ')} a limb, extrapolated"
    elif elements == "exact":
        elements = "none: exact"
    elif elements:
        elements += " a limb"
    fields = {"Model": label, "Theory": theory, "Elements": elements, "Version": version}
    return fields | {"Settings": in_words(settings)}


def in_words(settings: str | None) -> str:
    """Return a row's settings, JSON, in words."""
    return _words(_settings(settings))


def variant(settings: str | None) -> str:
    """Return in words what sets a row apart from its model's usual ones; "" for those."""
    known = _settings(settings)
    usual = {"count": known.get("count"), "shear": Spec.shear}
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


def uncertainty(rows: Sequence[dict[str, Any]]) -> str:
    """Return the numerical uncertainty of every mode of a model in words."""
    known = [(row["mode"], row["uncertainty_hz"]) for row in rows if row["uncertainty_hz"]]
    if not known:
        return "not estimated"
    return ", ".join(f"f{mode} ±{value:.2g}" for mode, value in known) + " Hz, by extrapolation"


def measured(row: dict[str, Any]) -> Fields:
    """Return coordinates, joint gap and seconds of a tidy row in words."""
    gap, build, solve = row["closure_m"], row.get("build_s"), row.get("solve_s")
    spent = ""
    if build is not None and solve is not None:
        spent = f"{1000 * build:.3g} ms to build, {1000 * solve:.3g} to solve"
    return {
        "Coordinates": str(row["dofs"] or ""),
        "Joint gap": "none can open" if gap is None else f"{gap:.1e} m",
        "Time": spent,
    }


def environment(run: dict[str, Any], heading: str = "Run") -> Fields:
    """Return when, from which commit and on what a recorded run ran."""
    return {
        heading: f"{run['time']:%Y-%m-%d %H:%M} UTC, run {run['run']}",
        "Commit": f"{run['commit']} (rps-bench {run['release']})",
        "Machine": run["machine"],
        "Python": f"{run['python']}, numpy {run['numpy']}, scipy {run['scipy']}, {run['blas']}",
    }


def command(case: str, label: str) -> str:
    """Return the command that gives a model's frequencies at a case again."""
    given = "--model" if label.partition("@")[0] in BEAMS else "--references"
    own = "" if case in PRESETS else "--case-file FILE "
    return f"rps-bench table {own}--cases {case} {given} {label}"
