"""The workspace: maps of every mode, one model against another, and what changed since."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.report.ledger import Fields, Ledger, environment, in_words, variant
from harness.report.material import Material
from harness.report.recorded import Recorded, Rows
from harness.report.section import Json, Section, digits, shown
from harness.rows import GATE, MAP
from harness.studies.workspace.plane import PlaneMap

KEY = "workspace"
OWN = "this run"
MOST = 60_000
"""Frequencies of the run's own map that the page has room for."""
KEPT = 10
"""Digits of a number of a map: what machines agree on."""
COLUMNS = ("z_m", "azimuth_rad", "tilt_rad", "mode", "frequency_hz")
Pose = tuple[float, float, float]
Answer = dict[int, dict[Pose, float]]
"""Frequencies [Hz] by mode and pose [mm, deg, deg]."""


def own(run: Material) -> Json | None:
    """Return the maps of this run for page.json: rows of the history's kind, and their records."""
    part = run.part("workspace")
    if part is None:
        return None
    command = run.only("workspace")
    found: dict[tuple[str, str], Rows] = {}
    for result in part.results.values():
        for row in result.rows():
            if row["case"] == MAP:
                found.setdefault((row["model"], row["settings"]), []).append(row)
    maps, left = [], []
    for (model, _), rows in found.items():
        if len(rows) > MOST:
            left.append(f"{model}, {len(rows):,} frequencies")
            continue
        fields = {**_about(rows[0]), "Command": command}
        maps.append({
            "mechanism": rows[0]["mechanism"],
            "model": model,
            "version": rows[0]["version"],
            "record": run.ledger.add(f"{model} over the workspace", fields, [run.run]),
            "rows": digits([[row[name] for name in COLUMNS] for row in rows], KEPT),
        })  # fmt: skip
    results = part.results.values()
    planes = [one for one in results if isinstance(one, PlaneMap)]
    return {
        "maps": maps, "left": left, "command": command,
        "sentences": [line for result in results for line in result.sentences()],
        "tables": [shown(one) for result in planes for one in result.tables().values()],
    }  # fmt: skip


def _about(row: Mapping[str, Any]) -> Fields:
    names = ("model", "theory", "version", "settings", "mechanism")
    return {name.capitalize(): row[name] for name in names} | {
        "Settings": in_words(row["settings"])
    }


def section(kept: Json | None, recorded: Recorded, ledger: Ledger, command: str) -> Section:
    """Return the section of this run's maps, as `own` kept them, and of recorded ones."""
    kept = kept or {"maps": [], "left": [], "command": command, "sentences": [], "tables": []}
    maps: list[Json] = []
    for one in kept["maps"]:
        answer = _folded(dict(zip(COLUMNS, row, strict=True)) for row in one["rows"])
        maps.append({**one, "kind": MAP, "run": OWN, "when": OWN, "answer": answer})
    runs = {row["run"]: row for row in recorded.runs}
    folded = {name: _folded(rows) for name, rows in recorded.answers.items()}
    left: dict[str, list[str]] = {}
    for row in recorded.maps:
        if row["answer"] not in folded:
            left.setdefault(row["case"], []).append(row["model"])
            continue
        run = runs[row["run"]]
        model = ", ".join(filter(None, [row["model"], variant(row["settings"])]))
        fields = {**_about(row), **environment(run), "Command": run["command"]}
        maps.append(
            {
                **row,
                "kind": row["case"],
                "when": f"{run['time']:%Y-%m-%d %H:%M:%S}, {run['commit'][:7]}",
                "model": model,
                "record": ledger.add(f"{model} over the workspace", fields),
                "answer": folded[row["answer"]],
            }
        )
    sets = _sets(maps, left)
    about = KEY, "Workspace: frequencies over the poses", "Workspace", kept["command"]
    if not sets and not kept["tables"]:
        return Section(*about, missing=f"`{kept['command']}` makes this section")
    context = {name: kept[name] for name in ("sentences", "left", "tables")}
    return Section(*about, context, sets or None)


def _folded(rows: Iterable[Mapping[str, Any]]) -> Answer:
    """Return the rows by mode and pose: tilts never below zero, a level platform at azimuth 0."""
    found: Answer = {}
    for row in rows:
        tilt = float(np.degrees(row["tilt_rad"]))
        azimuth = float(np.degrees(row["azimuth_rad"])) + 180 * (tilt < 0)
        turned = round(azimuth % 360, 6) % 360 if tilt else 0.0
        pose = (round(1000 * row["z_m"], 6), turned, round(abs(tilt), 6))
        frequency = digits(row["frequency_hz"], KEPT)
        if frequency is not None:
            found.setdefault(int(row["mode"]), {}).setdefault(pose, frequency)
    return found


def _sets(maps: Sequence[Json], left: Mapping[str, list[str]]) -> list[Json]:
    """Return what can be compared: maps of a mechanism over the same poses, the newest first.

    A map: `kind`, of a map or of the gate; `mechanism`, its hash; `run`; `when` it was, in words;
    `model`; `version` of its program; `record`, where it comes from; `answer`.
    """
    groups: dict[tuple[str, str, frozenset[Pose]], list[Json]] = {}
    for one in maps:
        poses = frozenset(pose for found in one["answer"].values() for pose in found)
        groups.setdefault((one["kind"], one["mechanism"], poses), []).append(one)
    sets: dict[str, Json] = {}
    for (kind, mechanism, where), group in groups.items():
        ordered = sorted(where)
        ends = dict.fromkeys(f"{pose[0]:.0f}" for pose in (ordered[0], ordered[-1]))
        name = f"{len(ordered):,} poses, {' to '.join(ends)} mm"
        if kind == GATE:
            name = "the gate's poses"
        if name in sets:
            name += f" (mechanism {mechanism}, {group[0]['model']}, {group[0]['when']})"
        none = left.get(kind, [])
        models = ", ".join(sorted(set(none)))
        note = f"Recorded, but no room on the page: {len(none)} more, of {models}."
        sets[name] = {"name": name, "note": note if none else "", **_set(group, ordered)}
    return list(sets.values())


def _set(maps: Sequence[Json], poses: list[Pose]) -> Json:
    """Return maps over `poses` as the page takes them: equal answers once."""
    grids: list[NDArray[np.float64]] = []
    runs: dict[str, Json] = {}
    alone = len({one["model"] for one in maps}) == 1
    for one in maps:
        grid = np.array([
            [one["answer"].get(mode, {}).get(pose, np.nan) for pose in poses]
            for mode in range(1, max(one["answer"]) + 1)
        ])  # fmt: skip
        same = (k for k, known in enumerate(grids) if np.array_equal(grid, known, equal_nan=True))
        place = next(same, len(grids))
        grids += [grid] if place == len(grids) else []
        told = alone or one["kind"] == GATE or one["run"] == OWN
        name = one["when"] if told else f"{one['when']}, {one['model']}"
        about = {"values": place, "version": one["version"], "record": one["record"]}
        runs.setdefault(one["run"], {"name": name, "models": {}})["models"][one["model"]] = about
    return {"poses": poses, "runs": list(runs.values()), "values": digits(grids)}
