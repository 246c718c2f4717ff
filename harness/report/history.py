"""History: every frequency and timing of every recorded run, compactly."""

from collections import defaultdict
from collections.abc import Sequence
from typing import Any

import polars as pl

from harness.cases import PRESETS
from harness.report.ledger import Ledger, at, in_words, variant
from harness.report.section import Section, digits
from harness.report.sources import Sources
from harness.run import mechanism_hash

YARDSTICK = "yardstick"  # the gate's model that only says how fast the machine was
RUN = ("run", "time", "command", "commit", "release", "machine", "python", "numpy", "scipy", "blas")
POSE = ["z_m", "azimuth_rad", "tilt_rad"]
SERIES = ["case", "model", "variant"]
MOST_SERIES = 2000
"""Series in the page, half a kilobyte each before their first number; of more, the newest."""
NEWEST = 12
"""Rows of the tables of runs and of sweeps."""


def section(sources: Sources, ledger: Ledger) -> Section:
    """Return the section."""
    recorded = sources.recorded
    if recorded.runs.is_empty():
        missing = "every run records itself: `rps-bench table`, say, makes this section"
        return Section("history", "History", missing=missing)
    yard = recorded.points.filter(pl.col("model") == YARDSTICK)
    points = recorded.points.filter(pl.col("model") != YARDSTICK)
    runs = recorded.runs.filter(pl.col("run").is_in(points["run"].unique().implode()))
    place = {run: k for k, run in enumerate(runs["run"])}
    points = _told_apart(points).with_columns(pl.col("run").replace_strict(place).alias("place"))
    every = (
        points.group_by(SERIES).agg(pl.col("place").max()).sort("place", *SERIES, descending=True)
    )
    points = points.join(every.head(MOST_SERIES), on=SERIES, how="semi", maintain_order="left")
    series = [_series(group) for group in points.partition_by(SERIES, maintain_order=True)]
    seconds = dict(zip(yard["run"], yard["solve_s"], strict=True))
    yardstick = [_milliseconds(seconds.get(run)) for run in runs["run"]]
    data = {"runs": _runs(runs), "series": series, "yardstick": yardstick} if series else None
    about = {row["run"]: row for row in recorded.runs.to_dicts()}
    context = {
        "cases": list(dict.fromkeys(one["case"] for one in series)),
        "series": len(series),
        "all_series": len(every),
        "shown": len(runs),
        "older": recorded.older,
        "latest": recorded.runs.tail(NEWEST).reverse().to_dicts(),
        "all": len(recorded.runs),
        "sweeps": [about[one["run"]] | one for one in recorded.sweeps.head(NEWEST).to_dicts()],
        "all_sweeps": len(recorded.sweeps),
    }
    return Section("history", "History", context, data)


def _told_apart(points: pl.DataFrame) -> pl.DataFrame:
    """Return `points` with `variant`: in words what sets rows of a model at a case apart.

    That is how they were solved, and a mechanism or a pose that are not the case's own; nothing for
    what is usual.
    """
    keys = ["case", "model", "mechanism", "settings", *POSE]
    known = points.select(keys).unique(maintain_order=True).to_dicts()
    mechanisms, poses = defaultdict(set), defaultdict(set)
    for one in known:
        one["variant"] = variant(one["settings"])
        one["pose"] = tuple(one.pop(name) for name in POSE)
        alike = one["case"], one["variant"]
        mechanisms[alike].add(one["mechanism"])
        poses[alike, one["mechanism"]].add(one["pose"])
    for one in known:
        home, alike = PRESETS.get(one["case"]), (one["case"], one["variant"])
        mechanism = home and mechanism_hash(home.mechanism)
        pose = home and (home.pose.z, home.pose.azimuth, home.pose.tilt)
        words = [one["variant"]]
        if len(mechanisms[alike]) > 1 and one["mechanism"] != mechanism:
            words.append(f"mechanism {one['mechanism']}")
        if len(poses[alike, one["mechanism"]]) > 1 and one["pose"] != pose:
            words.append(at(*one["pose"]))
        one["variant"] = ", ".join(word for word in words if word)
        one |= dict(zip(POSE, one.pop("pose"), strict=True))
    apart = pl.DataFrame(known, {**points.select(keys).schema, "variant": pl.String})
    return points.join(apart, on=keys, nulls_equal=True, maintain_order="left")


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
        known = rows.unique("place", keep="first", maintain_order=True)
        given = dict(zip(known["place"], known["frequency_hz"], strict=True))
        frequency[str(mode)] = changes([digits(given.get(place)) for place in places])
    settings = [in_words(one) for one in once["settings"]]
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
        "settings": changes(settings),
        **{name: changes(once[name].to_list()) for name in ("version", "theory")},
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
