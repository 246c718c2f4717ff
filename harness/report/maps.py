"""The workspace: maps of every mode, one model against another, and what changed since."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from harness.report.history import Recorded
from harness.report.section import (
    Fields,
    Json,
    Ledger,
    Material,
    Section,
    digits,
    environment,
    in_words,
    shown,
    variant,
)
from harness.rows import GATE, MAP
from harness.studies.workspace import PlaneMap

OWN = "this run"
MOST = 60_000
"""Frequencies of the run's own map that the page has room for."""
KEPT = 10
"""Digits of a number of a map: what machines agree on."""
COLUMNS = ["z_m", "azimuth_rad", "tilt_rad", "mode", "frequency_hz"]


def own(run: Material) -> Json | None:
    """Return the maps of this run for page.json: rows of the history's kind, and their records."""
    part = run.part("workspace")
    if not (part.results or part.why):
        return None
    results, found = part.results.values(), defaultdict(list)
    for row in (row for result in results for row in result.rows() if row["case"] == MAP):
        found[row["model"], row["settings"]].append(row)
    maps, left = [], []
    for (model, _), rows in found.items():
        if len(rows) > MOST:
            left.append(f"{model}, {len(rows):,} frequencies")
            continue
        fields = {**_about(rows[0]), "Command": run.only("workspace")}
        maps.append({
            **{name: rows[0][name] for name in ("mechanism", "model")},
            "record": run.note(f"{model} over the workspace", fields),
            "rows": digits([[row[name] for name in COLUMNS] for row in rows], KEPT),
        })  # fmt: skip
    tables = [one.tables().values() for one in results if isinstance(one, PlaneMap)]
    return {
        "maps": maps,
        "left": left,
        "sentences": [line for result in results for line in result.sentences()],
        "tables": [shown(one) for some in tables for one in some],
    }


def _about(row: Mapping[str, Any]) -> Fields:
    names = ("model", "theory", "version", "settings", "mechanism")
    said = {name.capitalize(): row[name] for name in names}
    return {**said, "Settings": in_words(row["settings"])}


def section(kept: Json | None, recorded: Recorded, ledger: Ledger, command: str) -> Section:
    """Return the section of this run's maps, as `own` kept them, and of recorded ones.

    `command` made the run.
    """
    kept = kept or {"maps": [], "left": [], "sentences": [], "tables": []}
    maps = [
        {**one, "kind": MAP, "run": OWN, "when": OWN, "answer": _folded(one["rows"])}
        for one in kept["maps"]
    ]
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
        record = ledger.add(f"{model} over the workspace", fields)
        when = f"{run['time']:%Y-%m-%d %H:%M:%S}, {run['commit'][:7]}"
        answer = folded[row["answer"]]
        maps.append(
            {
                **row,
                "kind": row["case"],
                "when": when,
                "model": model,
                "record": record,
                "answer": answer,
            }
        )
    sets = _sets(maps, left)
    if not sets and not kept["tables"]:
        return Section(missing=f"`{command} --only workspace` makes this section")
    return Section({name: kept[name] for name in ("sentences", "left", "tables")}, sets or None)


def _folded(rows: Any) -> pd.DataFrame:
    """Return frequencies [Hz] by mode, from 1 on, and pose [mm, deg, deg], in order.

    Tilts are never below zero, and a level platform is at azimuth 0.
    """
    found = pd.DataFrame(rows, columns=COLUMNS).dropna()
    tilt = np.degrees(found["tilt_rad"])
    turned = (np.degrees(found["azimuth_rad"]) + 180 * (tilt < 0)) % 360
    poses = [(1000 * found["z_m"]).round(6), (turned.round(6) % 360).where(tilt != 0, 0.0),
             tilt.abs().round(6).rename("tilt")]  # fmt: skip
    answer = found.pivot_table("frequency_hz", found["mode"].astype(int), poses, "first")
    answer = answer.reindex(range(1, int(found["mode"].max()) + 1))
    return answer.map(lambda value: float(f"{value:.{KEPT}g}"))


def _sets(maps: Sequence[Json], left: Mapping[str, list[str]]) -> list[Json]:
    """Return what can be compared: maps of a mechanism over the same poses, the newest first.

    A map: `kind`, of a map or of the gate; `mechanism`, its hash; `run`; `when` it was, in words;
    `model`; `record`, where it comes from; `answer`. Equal answers are
    kept once.
    """
    groups: dict[tuple[Any, ...], list[Json]] = {}
    for one in maps:
        groups.setdefault((one["kind"], one["mechanism"], *one["answer"]), []).append(one)
    sets: dict[str, Json] = {}
    for (kind, mechanism, *poses), group in groups.items():
        ends = dict.fromkeys(f"{pose[0]:.0f}" for pose in (poses[0], poses[-1]))
        name = f"{len(poses):,} poses, {' to '.join(ends)} mm"
        if kind == GATE:
            name = "the gate's poses"
        if name in sets:
            name += f" (mechanism {mechanism}, {group[0]['model']}, {group[0]['when']})"
        none = left.get(kind, [])
        models = ", ".join(sorted(set(none)))
        note = f"Recorded, but no room on the page: {len(none)} more, of {models}."
        grids: list[NDArray[np.float64]] = []
        runs: dict[str, Json] = {}
        alone = len({one["model"] for one in group}) == 1
        for one in group:
            grid = one["answer"].to_numpy()
            same = [k for k, own in enumerate(grids) if np.array_equal(grid, own, equal_nan=True)]
            place = same[0] if same else len(grids)
            grids += [] if same else [grid]
            told = alone or kind == GATE or one["run"] == OWN
            heading = one["when"] if told else f"{one['when']}, {one['model']}"
            about = {"values": place, "record": one["record"]}
            run = runs.setdefault(one["run"], {"name": heading, "models": {}})
            run["models"][one["model"]] = about
        sets[name] = {
            "name": name,
            "note": note if none else "",
            "poses": poses,
            "runs": list(runs.values()),
            "values": digits(grids),
        }
    return list(sets.values())
