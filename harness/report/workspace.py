"""The workspace: surfaces of every mode, one model against another, and what changed since."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import polars as pl

from harness.cases import PRESETS
from harness.report.ledger import Ledger, environment, in_words, variant
from harness.report.section import Section, digits
from harness.report.sources import Sources
from harness.run import GATE, MAP, mechanism_hash

POSE = ["z_mm", "azimuth_deg", "tilt_deg"]
MAP_COMMAND = "rps-bench workspace --output results/workspace"
CHECK_COMMAND = "rps-bench check"
ACCEPTED = "accepted"
Poses = frozenset[tuple[float, ...]]


@dataclass(frozen=True)
class Map:
    """What a model gave over many poses.

    Attributes: `kind`, of `MAPS`; `mechanism`, its hash; `run`; `when` it was, in words; `model`;
    `answer`, the name of its frequencies; `version` of its program; `record`, where it comes from.
    """

    kind: str
    mechanism: str
    run: str
    when: str
    model: str
    answer: str
    version: str
    record: int


def section(sources: Sources, ledger: Ledger) -> Section:
    """Return the section."""
    sets = _sets(sources, ledger)
    if not sets:
        missing = f"`{MAP_COMMAND}` and `{CHECK_COMMAND}` make this section"
        return Section("workspace", "Workspace", missing=missing)
    return Section("workspace", "Workspace", {"sets": [one["name"] for one in sets]}, sets)


def _sets(sources: Sources, ledger: Ledger) -> list[dict[str, Any]]:
    """Return what can be compared: maps of the same mechanism over the same poses, newest first."""
    maps = [_map(row, ledger) for row in sources.recorded.maps.to_dicts()]
    answers = _by_answer(sources.recorded.answers) if maps else {}
    if not sources.map.is_empty():
        accepted, rows = _accepted(sources.map, ledger)
        maps, answers = [accepted, *maps], {accepted.answer: rows} | answers
    poses = {answer: frozenset(rows.select(POSE).rows()) for answer, rows in answers.items()}
    groups: dict[tuple[str, str, Poses], list[Map]] = {}
    for one in maps:
        if one.answer in answers:
            groups.setdefault((one.kind, one.mechanism, poses[one.answer]), []).append(one)
    sets: dict[str, dict[str, Any]] = {}
    for (kind, mechanism, where), group in groups.items():
        name = _name(kind, where)
        if name in sets:
            name += f" (mechanism {mechanism}, {group[0].model}, {group[0].when})"
        left = [one.model for one in maps if one.kind == kind and one.answer not in answers]
        sets[name] = {"name": name, "note": _note(left), **_set(group, sorted(where), answers)}
    return list(sets.values())


def _name(kind: str, poses: Poses) -> str:
    if kind == GATE:
        return "the gate's poses"
    heights = [pose[0] for pose in poses]
    ends = dict.fromkeys(f"{z:.0f}" for z in (min(heights), max(heights)))
    return f"{len(poses):,} poses, {' to '.join(ends)} mm"


def _note(left: Sequence[str]) -> str:
    models = ", ".join(sorted(set(left)))
    return f"Recorded, but no room on the page: {len(left)} more, of {models}." if left else ""


def _set(
    maps: Sequence[Map], poses: list[tuple[float, ...]], answers: Mapping[str, pl.DataFrame]
) -> dict[str, Any]:
    """Return maps over `poses` as the page takes them: equal answers once."""
    place = pl.DataFrame(poses, POSE, orient="row").with_row_index("place")
    grids: list[np.ndarray[Any, Any]] = []
    numbers: dict[str, int] = {}
    runs: dict[str, dict[str, Any]] = {}
    alone = len({one.model for one in maps}) == 1
    for one in maps:
        if one.answer not in numbers:
            rows = answers[one.answer].join(place, on=POSE)
            grid = np.full((int(rows["mode"].to_numpy().max()), len(poses)), np.nan)
            grid[rows["mode"] - 1, rows["place"]] = rows["frequency_hz"]
            same = (np.array_equal(grid, known, equal_nan=True) for known in grids)
            numbers[one.answer] = next((k for k, equal in enumerate(same) if equal), len(grids))
            grids += [grid] if numbers[one.answer] == len(grids) else []
        told = alone or one.kind == GATE or one.run == ACCEPTED
        name = one.when if told else f"{one.when}, {one.model}"
        about = {"values": numbers[one.answer], "version": one.version, "record": one.record}
        runs.setdefault(one.run, {"name": name, "models": {}})["models"][one.model] = about
    return {
        "poses": poses,
        "runs": list(runs.values()),
        "values": [[[digits(f) for f in mode] for mode in grid.tolist()] for grid in grids],
    }


def _by_answer(rows: pl.DataFrame) -> dict[str, pl.DataFrame]:
    """Return the rows of each answer, poses in mm and degrees, each pose and mode once.

    Tilts are never below zero; a level platform has azimuth 0.
    """
    azimuth = pl.col("azimuth_rad").degrees() + 180 * (pl.col("tilt_rad") < 0)
    azimuth = pl.when(pl.col("tilt_rad") != 0).then(azimuth).otherwise(0.0)
    folded = rows.with_columns(
        (1000 * pl.col("z_m")).round(6).alias("z_mm"),
        (azimuth % 360).round(6).alias("azimuth_deg"),
        pl.col("tilt_rad").abs().degrees().round(6).alias("tilt_deg"),
    ).unique(["answer", *POSE, "mode"], keep="first", maintain_order=True)
    parts = folded.partition_by("answer", as_dict=True, maintain_order=True)
    return {answer: part for (answer,), part in parts.items()}


def _accepted(frame: pl.DataFrame, ledger: Ledger) -> tuple[Map, pl.DataFrame]:
    """Return results/workspace/map.csv, and its rows: one model, many poses.

    The command that makes it takes the paper's mechanism unless told otherwise.
    """
    model = frame["model"][0]
    command = f"{MAP_COMMAND} --model {model}"
    fields = {"Model": model, "File": "results/workspace/map.csv", "Command": command}
    record = ledger.add(f"Workspace map of {model}", fields)
    mechanism = mechanism_hash(PRESETS["case1"].mechanism)
    rows = frame.filter(model=model).unpivot(
        pl.selectors.matches(r"^f\d+_hz$"),
        index=["z_m", "azimuth_rad", "tilt_rad"],
        value_name="frequency_hz",
    )
    rows = rows.with_columns(
        pl.col("variable").str.extract(r"(\d+)").cast(int).alias("mode"),
        pl.lit(ACCEPTED).alias("answer"),
    )
    accepted = Map(MAP, mechanism, ACCEPTED, ACCEPTED, model, ACCEPTED, "", record)
    return accepted, _by_answer(rows)[ACCEPTED]


def _map(row: Mapping[str, Any], ledger: Ledger) -> Map:
    """Return one recorded map."""
    run = ledger.versions[row["run"]]
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
    when = f"{run['time']:%Y-%m-%d %H:%M:%S}, {str(run['commit'])[:7]}"
    kind, mechanism, answer, version = (row[n] for n in ("case", "mechanism", "answer", "version"))
    return Map(kind, mechanism, row["run"], when, model, answer, version, record)
