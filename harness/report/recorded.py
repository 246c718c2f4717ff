"""What the page takes of the history: no more than it can show, however long the history is."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from harness.history.store import History, open_history
from harness.rows import GATE, MANY_POSES, MAP, SWEEP

Rows = list[dict[str, Any]]

MOST_NUMBERS = 160_000
"""Rows of named cases, and frequencies and poses of maps, in the page; of more, the newest."""
MOST_POINTS = 100_000
"""Of these, rows of named cases."""
MAPS = (GATE, MAP)
"""What `case` says of poses that are shown as maps."""
ABOUT_RUN = ("command", "commit", "release", "machine", "python", "numpy", "scipy", "blas")
POSE = "round(z_m, 9), round(azimuth_rad, 9), round(tilt_rad, 9)"
"""A pose to a nanometre and a nanoradian: closer than that two of them are one."""
ONE_MAP = """concat_ws(' ', "case", run, mechanism, model, settings)"""
"""What tells one map from another."""
A_LAYER = 12
"""Poses of a height from which on there is a surface to draw; fewer are a row of heights."""


@dataclass(frozen=True)
class Recorded:
    """What is recorded.

    Attributes:
        runs: one row a run, in the order of time.
        points: tidy rows of named cases, of the newest runs.
        older: number of runs with named cases for whose rows there is no room.
        maps: one row a map of each of `MAPS`, the newest first: a model in a run; where `answer` is
            equal, so are poses and frequencies.
        answers: tidy rows of every answer of `maps` for which there is room, each once.
        sweeps: one row a sweep, the newest first.
        skipped: files that could not be read, and why.
    """

    runs: Rows = field(default_factory=list)
    points: Rows = field(default_factory=list)
    older: int = 0
    maps: Rows = field(default_factory=list)
    answers: dict[str, Rows] = field(default_factory=dict)
    sweeps: Rows = field(default_factory=list)
    skipped: tuple[tuple[str, str], ...] = ()


def read_recorded(folder: Path | None, room: int = MOST_NUMBERS) -> Recorded:
    """Return what the history in `folder` holds (None: nothing), with room for so many numbers."""
    if folder is None:
        return Recorded()
    store = open_history(folder)
    skipped = tuple((path.name, why) for path, why in store.skipped)
    points, older = _points(store)
    maps = _maps(store)
    answers = _answers(store, maps, room - len(points))
    return Recorded(_runs(store), points, older, maps, answers, _sweeps(store), skipped)


def _asked(store: History, sql: str, params: Sequence[object] = ()) -> Rows:
    return store.query(sql, list(params)).rows()


def _runs(store: History) -> Rows:
    about = ", ".join(f'coalesce(min("{name}"), \'not known\') AS "{name}"' for name in ABOUT_RUN)
    return _asked(
        store,
        f"""SELECT run, {about}, min(time) AS time, count(*) AS "rows" FROM rows
        GROUP BY run ORDER BY time, run""",
    )


def _points(store: History) -> tuple[Rows, int]:
    named = f'("case" IS NULL OR "case" NOT IN ({_marks(MANY_POSES)}))'
    sizes = _asked(
        store,
        f"""SELECT run, count(*) AS own FROM rows WHERE {named}
        GROUP BY run ORDER BY run DESC""",
        MANY_POSES,
    )
    chosen: list[str] = []
    total = 0
    for size in sizes:
        total += size["own"]
        if chosen and total > MOST_POINTS:
            break
        chosen.append(size["run"])
    points = _asked(
        store,
        f"""SELECT run, coalesce("case", 'none') AS "case", mechanism, z_m, azimuth_rad, tilt_rad,
        model, theory, settings, version, mode, frequency_hz, build_s, solve_s
        FROM rows WHERE {named} AND list_contains(?, run)
        ORDER BY time, run, "case", model, mechanism, settings, mode, frequency_hz, solve_s""",
        [*MANY_POSES, chosen],
    )
    return points, len(sizes) - len(chosen)


def _maps(store: History) -> Rows:
    return _asked(
        store,
        f"""SELECT {ONE_MAP} AS map, "case", run, mechanism, model, settings, min(theory) AS theory,
        min(version) AS version, count(DISTINCT hash({POSE})) AS poses, count(*) + poses AS numbers,
        sum(hash({POSE}, mode, frequency_hz))::VARCHAR AS answer
        FROM rows WHERE "case" IN ({_marks(MAPS)})
        AND z_m + azimuth_rad + tilt_rad + mode IS NOT NULL GROUP BY ALL
        HAVING poses >= {A_LAYER} * count(DISTINCT round(z_m, 9))
        ORDER BY "case", run DESC, model, settings, mechanism""",
        MAPS,
    )


def _answers(store: History, maps: Rows, room: int) -> dict[str, Rows]:
    """Return the rows of the newest different answers, of one kind of map as of the other."""
    once: dict[str, dict[str, Any]] = {}
    for one in maps:
        once.setdefault(one["answer"], one)
    turns: dict[str, int] = {}
    order = []
    for one in once.values():
        turns[one["case"]] = turns.get(one["case"], -1) + 1
        order.append((turns[one["case"]], one))
    kept = []
    for _, one in sorted(order, key=lambda pair: pair[0]):
        if one["numbers"] <= room:
            kept.append(one["map"])
            room -= one["numbers"]
    rows = _asked(
        store,
        f"""SELECT {ONE_MAP} AS map, z_m, azimuth_rad, tilt_rad, mode, frequency_hz
        FROM rows WHERE "case" IN ({_marks(MAPS)}) AND list_contains(?, {ONE_MAP}) ORDER BY ALL""",
        [*MAPS, kept],
    )
    answer = {one["map"]: one["answer"] for one in maps}
    found: dict[str, Rows] = {}
    for row in rows:
        found.setdefault(answer[row["map"]], []).append(row)
    return found


def _sweeps(store: History) -> Rows:
    return _asked(
        store,
        f"""SELECT run, string_agg(DISTINCT model, ', ' ORDER BY model) AS models,
        max(poses) AS poses, sum(poses)::BIGINT AS "rows"
        FROM (SELECT run, model, mode, count(*) AS poses
            FROM rows WHERE "case" = '{SWEEP}' GROUP BY run, model, mode)
        GROUP BY run ORDER BY run DESC""",
    )


def _marks(values: Sequence[str]) -> str:
    return ", ".join("?" * len(values))
