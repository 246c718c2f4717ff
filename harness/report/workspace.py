"""The workspace: surfaces of every mode, one model against another, and what changed since."""

from typing import Any

import numpy as np
import polars as pl

from harness.report.ledger import Ledger, environment, in_words
from harness.report.section import Section, digits
from harness.report.sources import Sources

MOST_NUMBERS = 120_000
"""Frequencies kept in the page; the newest runs come first."""
POSE = ("z_mm", "azimuth_deg", "tilt_deg")
MAP_COMMAND = "rps-bench workspace --output results/workspace"
CHECK_COMMAND = "rps-bench check"


def section(sources: Sources, ledger: Ledger) -> Section:
    """Return the section."""
    sets = [one for one in (_detailed(sources, ledger), _recorded(sources, ledger)) if one]
    if not sets:
        missing = f"`{MAP_COMMAND}` and `{CHECK_COMMAND}` make this section"
        return Section("workspace", "Workspace", missing=missing)
    return Section("workspace", "Workspace", {"sets": [one["name"] for one in sets]}, sets)


def _in_degrees(frame: pl.DataFrame) -> pl.DataFrame:
    """Return `frame` with its poses in mm and degrees, tilts never below zero.

    A level platform has azimuth 0.
    """
    azimuth = pl.col("azimuth_rad").degrees() + 180 * (pl.col("tilt_rad") < 0)
    azimuth = pl.when(pl.col("tilt_rad") != 0).then(azimuth).otherwise(0.0)
    return frame.with_columns(
        (1000 * pl.col("z_m")).round(6).alias("z_mm"),
        (azimuth % 360).round(6).alias("azimuth_deg"),
        pl.col("tilt_rad").abs().degrees().round(6).alias("tilt_deg"),
    )


def _detailed(sources: Sources, ledger: Ledger) -> dict[str, Any] | None:
    """Return results/workspace/map.csv: one model, many poses."""
    if sources.map.is_empty():
        return None
    frame = _in_degrees(sources.map).unique(["model", *POSE], keep="first", maintain_order=True)
    modes = [name for name in frame.columns if name.startswith("f") and name.endswith("_hz")]
    first = frame["model"][0]
    frame = frame.filter(model=first)
    record = ledger.add(
        f"Workspace map of {first}",
        {"Model": first, "File": "results/workspace/map.csv",
         "Command": f"{MAP_COMMAND} --model {first}"},
    )  # fmt: skip
    values = [[digits(f, 8) for f in frame[name]] for name in modes]
    run = {"name": "accepted", "models": {first: {"values": 0, "record": record, "version": ""}}}
    return {
        "name": "detailed map",
        "poses": frame.select(POSE).rows(),
        "runs": [run],
        "values": [values],
        "note": "",
    }


def _recorded(sources: Sources, ledger: Ledger) -> dict[str, Any] | None:
    """Return the gate's poses: every model of every run, newest first, equal answers once."""
    if sources.workspace.is_empty():
        return None
    frame = _in_degrees(sources.workspace)
    order = sources.runs["run"].reverse().to_list()
    present = set(frame["run"].unique())
    newest = next(run for run in order if run in present)
    mechanism = frame.filter(run=newest)["mechanism"][0]
    same = frame.filter(mechanism=mechanism)
    poses = same.filter(run=newest).select(POSE).unique().sort(POSE)
    place = poses.with_row_index("place")
    same = same.join(place, on=list(POSE))
    keep: list[Any] = []
    known: dict[bytes, int] = {}
    runs: list[dict[str, Any]] = []
    groups = same.partition_by("run", as_dict=True)
    for run in order:
        if (run,) not in groups:
            continue
        models = {}
        for (label,), rows in groups[(run,)].partition_by("model", as_dict=True).items():
            grid = np.full((int(rows["mode"].to_numpy().max()), len(poses)), np.nan)
            grid[rows["mode"] - 1, rows["place"]] = rows["frequency_hz"]
            key = grid.tobytes()
            if key not in known:
                known[key] = len(keep)
                keep.append(grid)
            models[label] = {
                "values": known[key],
                "version": rows["version"][0],
                "record": _record(ledger, run, label, rows),
            }
        runs.append({"name": _named(ledger, run), "models": models})
        if sum(grid.size for grid in keep) > MOST_NUMBERS:
            break
    left = len(present) - len(runs)
    note = f"{left} older runs, or runs of another mechanism, are not shown" if left else ""
    values = [[[digits(f) for f in mode] for mode in grid.tolist()] for grid in keep]
    return {
        "name": "the gate's poses",
        "poses": poses.rows(),
        "runs": runs,
        "values": values,
        "note": note,
    }


def _named(ledger: Ledger, run: str) -> str:
    row = ledger.versions[run]
    return f"{row['time']:%Y-%m-%d %H:%M}, {str(row['commit'])[:7]}"


def _record(ledger: Ledger, run: str, label: Any, rows: pl.DataFrame) -> int:
    one = ledger.versions[run]
    return ledger.add(
        f"{label} over the workspace",
        {
            "Model": label,
            "Theory": rows["theory"][0],
            "Version": rows["version"][0],
            "Settings": in_words(rows["settings"][0]),
            **environment(one),
            "Command": one["command"],
        },
    )
