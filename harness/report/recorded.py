"""What the page takes of the history: no more than it can show, however long the history is."""

from dataclasses import dataclass, field
from itertools import accumulate, chain, zip_longest
from pathlib import Path
from typing import Any

from harness.history.store import History, open_history
from harness.rows import GATE, MANY_POSES, MAP, SWEEP

Rows = list[dict[str, Any]]

MOST_NUMBERS = 160_000
"""Rows of named cases, and frequencies and poses of maps, in the page; of more, the newest."""
MOST_POINTS = 100_000
"""Of these, rows of named cases."""
MAPS = (MAP, GATE)
"""What `case` says of poses that are shown as maps."""
ABOUT_RUN = ("command", "commit", "release", "machine", "python", "numpy", "scipy", "blas")
NAMED = f"""("case" IS NULL OR "case" NOT IN {MANY_POSES})"""
POSE = """round(z_m, 9), round(azimuth_rad, 9), round(tilt_rad, 9),
    round(coalesce(torsion_rad, 0), 9), coalesce(round(x_m, 9)::VARCHAR, ''),
    coalesce(round(y_m, 9)::VARCHAR, '')"""
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
    about = ", ".join(f'coalesce(min("{name}"), \'not known\') AS "{name}"' for name in ABOUT_RUN)
    runs = store.query(
        f"""SELECT run, {about}, min(time) AS time, count(*) AS "rows",
        count(*) FILTER ({NAMED}) AS named FROM rows GROUP BY run ORDER BY time, run"""
    ).rows()
    sizes = {row["run"]: row["named"] for row in runs if row["named"]}
    newest = list(sizes)[::-1]
    totals = list(accumulate(sizes[run] for run in newest))
    chosen = [run for k, run in enumerate(newest) if not k or totals[k] <= MOST_POINTS]
    points = store.query(
        f"""SELECT run, coalesce("case", 'none') AS "case", mechanism, z_m, azimuth_rad, tilt_rad,
        coalesce(torsion_rad, 0) AS torsion_rad, x_m, y_m, model, theory, settings,
        version, mode, frequency_hz, build_s, solve_s
        FROM rows WHERE {NAMED} AND list_contains(?, run)
        ORDER BY time, run, "case", model, mechanism, settings, mode, frequency_hz, solve_s""",
        [chosen],
    ).rows()
    maps = store.query(
        f"""SELECT {ONE_MAP} AS map, "case", run, mechanism, model, settings, min(theory) AS theory,
        min(version) AS version, count(DISTINCT hash({POSE})) AS poses, count(*) + poses AS numbers,
        sum(hash({POSE}, mode, frequency_hz))::VARCHAR AS answer
        FROM rows WHERE "case" IN {MAPS}
        AND z_m + azimuth_rad + tilt_rad + mode IS NOT NULL GROUP BY ALL
        HAVING poses >= {A_LAYER} * count(DISTINCT round(z_m, 9))
        ORDER BY "case", run DESC, model, settings, mechanism"""
    ).rows()
    sweeps = store.query(
        f"""SELECT run, coalesce(min(command), 'not known') AS command,
        string_agg(DISTINCT model, ', ' ORDER BY model) AS models,
        max(poses) AS poses, sum(poses)::BIGINT AS "rows"
        FROM (SELECT run, model, mode, min(command) AS command, count(*) AS poses
            FROM rows WHERE "case" = '{SWEEP}' GROUP BY run, model, mode)
        GROUP BY run ORDER BY run DESC"""
    ).rows()
    answers = _answers(store, maps, room - len(points))
    skipped = tuple((path.name, why) for path, why in store.skipped)
    return Recorded(runs, points, len(newest) - len(chosen), maps, answers, sweeps, skipped)


def _answers(store: History, maps: Rows, room: int) -> dict[str, Rows]:
    """Return the rows of the newest different answers, of one kind of map as of the other."""
    first: dict[str, Any] = {}
    for one in maps:
        first.setdefault(one["answer"], one)
    kinds = [[one for one in first.values() if one["case"] == kind] for kind in MAPS]
    kept = []
    for one in chain.from_iterable(zip_longest(*kinds)):
        if one and one["numbers"] <= room:
            kept.append(one["map"])
            room -= one["numbers"]
    rows = store.query(
        f"""SELECT {ONE_MAP} AS map, z_m, azimuth_rad, tilt_rad, mode, frequency_hz
        FROM rows WHERE "case" IN {MAPS} AND list_contains(?, {ONE_MAP}) ORDER BY ALL""",
        [kept],
    ).rows()
    answer = {one["map"]: one["answer"] for one in maps}
    found: dict[str, Rows] = {}
    for row in rows:
        found.setdefault(answer[row["map"]], []).append(row)
    return found
