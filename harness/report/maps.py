"""The workspace: maps of every mode, one model against another, and what changed since."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.report.ledger import Ledger, environment, in_words, variant
from harness.report.material import Material
from harness.report.recorded import Recorded, Rows
from harness.report.section import Json, Section, digits
from harness.rows import GATE, MAP

KEY, TITLE, MENU = "workspace", "Workspace: frequencies over the poses", "Workspace"
OWN = "this run"
MOST = 60_000
"""Frequencies of the run's own map that the page has room for."""
KEPT = 10
"""Digits of a number of a map: what machines agree on."""
Pose = tuple[float, float, float]
Answer = dict[int, dict[Pose, float]]
"""Frequencies [Hz] by mode and pose [mm, deg, deg]."""


@dataclass(frozen=True)
class Map:
    """What a model gave over many poses.

    Attributes: `kind`, of a map or of the gate; `mechanism`, its hash; `run`; `when` it was, in
    words; `model`; `answer`; `version` of its program; `record`, where it comes from.
    """

    kind: str
    mechanism: str
    run: str
    when: str
    model: str
    answer: Answer
    version: str
    record: int

    @property
    def poses(self) -> frozenset[Pose]:
        """The poses."""
        return frozenset(pose for values in self.answer.values() for pose in values)


def own(run: Material) -> Json | None:
    """Return the maps of this run for page.json: rows of the history's kind, and their records."""
    part = run.part("workspace")
    if part is None:
        return None
    maps, left = [], []
    for result in part.results.values():
        found: dict[tuple[str, str], Rows] = {}
        for row in result.rows():
            if row["case"] == MAP:
                found.setdefault((row["model"], row["settings"]), []).append(row)
        for (model, settings), rows in found.items():
            if len(rows) > MOST:
                left.append(f"{model}, {len(rows):,} frequencies")
                continue
            fields = {"Model": model, "Theory": rows[0]["theory"], "Version": rows[0]["version"],
                      "Settings": in_words(settings), "Mechanism": rows[0]["mechanism"],
                      "Command": run.only("workspace")}  # fmt: skip
            record = run.ledger.add(f"{model} over the workspace", fields, [run.run])
            maps.append({
                "mechanism": rows[0]["mechanism"], "model": model, "version": rows[0]["version"],
                "record": record,
                "rows": [[digits(row[name], KEPT) for name in
                          ("z_m", "azimuth_rad", "tilt_rad", "mode", "frequency_hz")]
                         for row in rows],
            })  # fmt: skip
    sentences = [line for result in part.results.values() for line in result.sentences()]
    return {"maps": maps, "left": left, "command": run.only("workspace"), "sentences": sentences}


def section(kept: Json | None, recorded: Recorded, ledger: Ledger, command: str) -> Section:
    """Return the section of this run's maps, as `own` kept them, and of recorded ones."""
    maps = [] if kept is None else [_own(one) for one in kept["maps"]]
    runs = {row["run"]: row for row in recorded.runs}
    folded: dict[str, Answer] = {}
    left: dict[str, list[str]] = {}
    for row in recorded.maps:
        if row["answer"] in recorded.answers:
            if row["answer"] not in folded:
                folded[row["answer"]] = _folded(recorded.answers[row["answer"]])
            maps.append(_recorded(row, folded[row["answer"]], runs[row["run"]], ledger))
        else:
            left.setdefault(row["case"], []).append(row["model"])
    sets = _sets(maps, left)
    command = command if kept is None else kept["command"]
    if not sets:
        return Section(KEY, TITLE, MENU, command, missing=f"`{command}` makes this section")
    context = {
        "sets": [one["name"] for one in sets],
        "sentences": [] if kept is None else kept["sentences"],
        "left": [] if kept is None else kept["left"],
    }
    return Section(KEY, TITLE, MENU, command, context, sets)


def _own(one: Json) -> Map:
    names = ("z_m", "azimuth_rad", "tilt_rad", "mode", "frequency_hz")
    answer = _folded(dict(zip(names, row, strict=True)) for row in one["rows"])
    return Map(MAP, one["mechanism"], OWN, OWN, one["model"], answer, one["version"], one["record"])


def _recorded(
    row: Mapping[str, Any], answer: Answer, run: Mapping[str, Any], ledger: Ledger
) -> Map:
    apart = variant(row["settings"])
    model = f"{row['model']}, {apart}" if apart else row["model"]
    fields = {
        "Model": row["model"],
        "Theory": row["theory"],
        "Version": row["version"],
        "Settings": in_words(row["settings"]),
        "Mechanism": row["mechanism"],
        **environment(run),
        "Command": run["command"],
    }
    record = ledger.add(f"{model} over the workspace", fields)
    when = f"{run['time']:%Y-%m-%d %H:%M:%S}, {run['commit'][:7]}"
    return Map(row["case"], row["mechanism"], row["run"], when, model, answer, row["version"],
               record)  # fmt: skip


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


def _sets(maps: Sequence[Map], left: Mapping[str, list[str]]) -> list[Json]:
    """Return what can be compared: maps of a mechanism over the same poses, the newest first."""
    groups: dict[tuple[str, str, frozenset[Pose]], list[Map]] = {}
    for one in maps:
        groups.setdefault((one.kind, one.mechanism, one.poses), []).append(one)
    sets: dict[str, Json] = {}
    for (kind, mechanism, where), group in groups.items():
        name = _name(kind, where)
        if name in sets:
            name += f" (mechanism {mechanism}, {group[0].model}, {group[0].when})"
        sets[name] = {"name": name, "note": _note(left.get(kind, [])), **_set(group, sorted(where))}
    return list(sets.values())


def _name(kind: str, poses: frozenset[Pose]) -> str:
    if kind == GATE:
        return "the gate's poses"
    heights = [pose[0] for pose in poses]
    ends = dict.fromkeys(f"{z:.0f}" for z in (min(heights), max(heights)))
    return f"{len(poses):,} poses, {' to '.join(ends)} mm"


def _note(left: Sequence[str]) -> str:
    models = ", ".join(sorted(set(left)))
    return f"Recorded, but no room on the page: {len(left)} more, of {models}." if left else ""


def _set(maps: Sequence[Map], poses: list[Pose]) -> Json:
    """Return maps over `poses` as the page takes them: equal answers once."""
    grids: list[NDArray[np.float64]] = []
    runs: dict[str, Json] = {}
    alone = len({one.model for one in maps}) == 1
    for one in maps:
        modes = max(one.answer)
        grid = np.array([
            [one.answer.get(mode, {}).get(pose, np.nan) for pose in poses]
            for mode in range(1, modes + 1)
        ])  # fmt: skip
        same = (k for k, known in enumerate(grids) if np.array_equal(grid, known, equal_nan=True))
        place = next(same, len(grids))
        grids += [grid] if place == len(grids) else []
        told = alone or one.kind == GATE or one.run == OWN
        name = one.when if told else f"{one.when}, {one.model}"
        about = {"values": place, "version": one.version, "record": one.record}
        runs.setdefault(one.run, {"name": name, "models": {}})["models"][one.model] = about
    return {
        "poses": poses,
        "runs": list(runs.values()),
        "values": [[[digits(f) for f in mode] for mode in grid.tolist()] for grid in grids],
    }
