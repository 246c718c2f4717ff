"""The history on the page: what it takes of it, however long it is; first the series that moved."""

from collections import Counter, defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import accumulate, chain, zip_longest
from pathlib import Path
from typing import Any

import numpy as np

from harness.cases import PRESETS
from harness.history.store import History, open_history
from harness.poses import COLUMNS, columns
from harness.report.section import Json, Section, at, digits, in_words, variant
from harness.rows import GATE, MANY_POSES, MAP, SWEEP, mechanism_hash

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
YARDSTICK = "yardstick"
"""The gate's model that only says how fast the machine was."""
MOST_SERIES = 2000
"""Series in the page, half a kilobyte each before their first number; of more, the newest."""
NEWEST = 12
"""Rows of the tables of runs and of sweeps."""
MOVED = 1e-9
"""A frequency that changed by more than this, relative, moved: the digits that machines share."""
CARDS = 24
"""Series that moved shown at once, the newest."""
CARD = (150.0, 44.0)
"""Width and height of a card's picture."""


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


def section(recorded: Recorded) -> Section:
    """Return the section."""
    if not recorded.runs:
        missing = "every run records itself: `rps-bench table`, say, makes this section"
        return Section(missing=missing)
    points = [row for row in recorded.points if row["model"] != YARDSTICK]
    named = {row["run"] for row in points}
    runs = [row for row in recorded.runs if row["run"] in named]
    place = {row["run"]: k for k, row in enumerate(runs)}
    groups: dict[tuple[str, str, str], Rows] = defaultdict(list)
    for row, apart in zip(points, _told_apart(points), strict=True):
        groups[row["case"], row["model"], apart].append({**row, "place": place[row["run"]]})
    newest = sorted(groups, key=lambda key: (groups[key][-1]["place"], key), reverse=True)
    series: list[Json] = []
    cards: list[Json] = []
    for key in sorted(newest[:MOST_SERIES]):
        about = dict(zip(("case", "model", "variant"), key, strict=True))
        found, moved = _series(groups[key])
        if moved:
            when = f"{runs[moved['place']]['time']:%Y-%m-%d %H:%M}"
            cards.append({"series": len(series), **about, **moved, "when": when})
        series.append({**about, **found})
    seconds = {row["run"]: row["solve_s"] for row in recorded.points if row["model"] == YARDSTICK}
    data = {
        "runs": {
            "run": [row["run"] for row in runs],
            "time": [f"{row['time']:%Y-%m-%d %H:%M:%S}" for row in runs],
            **{name: changes([row[name] for row in runs]) for name in ABOUT_RUN},
        },
        "series": series,
        "yardstick": _milliseconds([seconds.get(row["run"]) for row in runs]),
    }
    context = {
        "cards": sorted(cards, key=lambda card: -card["place"])[:CARDS],
        "moved": len(cards),
        "card": CARD,
        "all_series": len(groups),
        "recorded": recorded,
        "newest": NEWEST,
    }
    return Section(context, data if series else None)


def _told_apart(points: Rows) -> list[str]:
    """Return for every row in words what sets it apart from others of a model at a case.

    That is how it was solved, and a mechanism or a pose that is not the case's own; nothing for
    what is usual.
    """
    keys = [
        (row["case"], variant(row["settings"]), row["mechanism"], tuple(row[n] for n in COLUMNS))
        for row in points
    ]
    known = set(keys)
    mechanisms = Counter((case, said) for case, said, _ in {key[:3] for key in known})
    poses = Counter(key[:3] for key in known)
    words = {}
    for key in known:
        case, said, mechanism, pose = key
        home, found = PRESETS.get(case), [said]
        usual = (mechanism_hash(home.mechanism), (*columns(home.pose).values(),)) if home else ()
        if mechanisms[case, said] > 1 and mechanism not in usual:
            found.append(f"mechanism {mechanism}")
        if poses[key[:3]] > 1 and pose not in usual:
            found.append(at(dict(zip(COLUMNS, pose, strict=True))))
        words[key] = ", ".join(filter(None, found))
    return [words[key] for key in keys]


def _series(rows: Rows) -> tuple[Json, Json]:
    """Return what one model gave and took at one case in each run that had it.

    And if a frequency moved: at which run last, which most, by how much, a small picture.
    """
    once: dict[int, dict[str, Any]] = {}
    given: dict[int, dict[int, float]] = defaultdict(dict)
    for row in rows:
        once.setdefault(row["place"], row)
        found = given[row["mode"]]
        if row["frequency_hz"] is not None:
            found.setdefault(row["place"], row["frequency_hz"])
    firsts = list(once.values())
    series = {
        "mechanism": firsts[0]["mechanism"],
        "pose": [firsts[0][name] for name in COLUMNS],
        "at": changes([place - k for k, place in enumerate(once)]),
        "build": _milliseconds([row["build_s"] for row in firsts]),
        "solve": _milliseconds([row["solve_s"] for row in firsts]),
        "f": {
            str(mode): changes(digits([found.get(place) for place in once]))
            for mode, found in sorted(given.items())
        },
        "settings": changes([in_words(row["settings"]) for row in firsts]),
        **{name: changes([row[name] for row in firsts]) for name in ("version", "theory")},
    }
    moves = {mode: _last_move(found) for mode, found in given.items()}
    mode = max(moves, key=lambda mode: (moves[mode][0], abs(moves[mode][1])))
    place, size = moves[mode]
    if place < 0:
        return series, {}
    change = f"{1e6 * size:+.3g} ppm" if abs(size) < 1e-4 else f"{100 * size:+.3g} %"
    points = _spark(list(given[mode].values()))
    return series, {"place": place, "mode": mode, "change": change, "points": points}


def _last_move(found: dict[int, float]) -> tuple[int, float]:
    """Return at which run a frequency moved last, and by how much; (-1, 0) if it never did."""
    places = list(found)
    for earlier, later in zip(places[-2::-1], places[:0:-1], strict=True):
        before, after = found[earlier], found[later]
        if abs(after - before) > MOVED * abs(before):
            return later, after / before - 1 if before else float("inf")
    return -1, 0.0


def _spark(values: Sequence[float]) -> Any:
    """Return the points of a small picture: steps from run to run."""
    low, high = min(values), max(values)
    x = np.linspace(3, CARD[0] - 3, len(values))
    y = 4 + (CARD[1] - 8) * (high - np.array(values)) / (high - low)
    return np.round(np.column_stack([np.repeat(x, 2)[1:], np.repeat(y, 2)[:-1]]), 1).tolist()


def _milliseconds(seconds: Sequence[float | None]) -> Any:
    return digits([None if s is None else 1000 * s for s in seconds], 3)


def changes(values: Sequence[Any]) -> list[Any]:
    """Return [length, place, value, place, value, ...]: a value only where it is a new one."""
    result: list[Any] = [len(values)]
    for k, value in enumerate(values):
        if not k or value != values[k - 1]:
            result += [k, value]
    return result
