"""History: every frequency and timing of every recorded run, compactly."""

import json
from collections.abc import Sequence
from typing import Any

import polars as pl

from harness.report.ledger import Ledger
from harness.report.section import Section, digits
from harness.report.sources import Sources

MOST_NUMBERS = 120_000
"""Values kept in the page; of more, the newest runs."""
YARDSTICK = "yardstick"  # the gate's model that only says how fast the machine was
RUN = ("run", "time", "command", "commit", "release", "machine", "python", "numpy", "scipy", "blas")
SERIES = ["case", "model", "mechanism", "variant"]


def section(sources: Sources, ledger: Ledger) -> Section:
    """Return the section."""
    title = "History"
    if sources.points.is_empty():
        missing = "every run records itself: `rps-bench table`, say, makes this section"
        return Section("history", title, missing=missing)
    yard = sources.points.filter(pl.col("model") == YARDSTICK)
    runs, points = _newest(sources.runs, sources.points.filter(pl.col("model") != YARDSTICK))
    place = {run: k for k, run in enumerate(runs["run"])}
    points = points.with_columns(pl.col("run").replace_strict(place).alias("place"))
    variants = {one: _variant(one) for one in points["settings"].unique()}
    points = points.with_columns(
        pl.col("settings").replace_strict(variants, return_dtype=pl.String).alias("variant")
    ).sort("place", "mode", maintain_order=True)
    series = [_series(group) for group in points.partition_by(SERIES, maintain_order=True)]
    seconds = dict(zip(yard["run"], yard["solve_s"], strict=True))
    yardstick = [_milliseconds(seconds.get(run)) for run in runs["run"]]
    data = {"runs": _runs(runs), "series": series, "yardstick": yardstick}
    context = {
        "models": list(dict.fromkeys(one["model"] for one in series)),
        "cases": list(dict.fromkeys(one["case"] for one in series)),
        "shown": len(runs),
        "all": len(sources.runs),
        "latest": sources.runs.tail(12).reverse().to_dicts(),
    }
    return Section("history", title, context, data)


def _variant(settings: str | None) -> str:
    """Return the settings that make a number another one: not how many modes were asked for."""
    try:
        known = json.loads(settings or "{}")
    except ValueError:
        return settings or ""
    known = {name: value for name, value in known.items() if name != "count"}
    return json.dumps(known, sort_keys=True) if known else ""


def _newest(runs: pl.DataFrame, points: pl.DataFrame) -> tuple[pl.DataFrame, pl.DataFrame]:
    """Return the newest runs that have points, as many as the page can hold."""
    size = points.group_by("run").len("own")
    runs = runs.join(size, on="run").sort("time", "run", descending=True)
    runs = runs.filter((pl.col("own").cum_sum() <= MOST_NUMBERS) | (pl.col("own").cum_count() == 1))
    runs = runs.reverse()
    return runs, points.filter(pl.col("run").is_in(runs["run"].implode()))


def _runs(runs: pl.DataFrame) -> dict[str, list[Any]]:
    """Return each column of the runs as changes only."""
    text = runs.with_columns(pl.col("time").dt.strftime("%Y-%m-%d %H:%M:%S"))
    return {
        name: text[name].to_list() if name in ("run", "time") else changes(text[name].to_list())
        for name in RUN
    }


def _series(group: pl.DataFrame) -> dict[str, Any]:
    """Return one model at one case: what it gave and took in each run that had it."""
    first = group.row(0, named=True)
    once = group.unique("place", keep="first", maintain_order=True)
    places = once["place"].to_list()
    frequency: dict[str, list[Any]] = {}
    for (mode,), rows in group.partition_by("mode", as_dict=True, maintain_order=True).items():
        known = dict(zip(rows["place"], rows["frequency_hz"], strict=True))
        frequency[str(mode)] = changes([digits(known.get(place)) for place in places])
    constant = {name: changes(once[name].to_list()) for name in ("version", "theory", "settings")}
    return {
        "case": first["case"],
        "model": first["model"],
        "mechanism": first["mechanism"],
        "variant": first["variant"],
        "pose": [first["z_m"], first["azimuth_rad"], first["tilt_rad"]],
        "at": changes([place - k for k, place in enumerate(places)]),
        "build": [_milliseconds(value) for value in once["build_s"]],
        "solve": [_milliseconds(value) for value in once["solve_s"]],
        "f": frequency,
        **constant,
    }


def _milliseconds(seconds: float | None) -> float | None:
    return None if seconds is None else digits(1000 * seconds, 3)


def changes(values: Sequence[Any]) -> list[Any]:
    """Return [length, place, value, place, value, ...]: a value only where it is a new one."""
    result: list[Any] = [len(values)]
    for k, value in enumerate(values):
        if not k or value != values[k - 1]:
            result += [k, value]
    return result
