"""History: what every recorded run gave and took, compactly; first the series that moved."""

from collections import defaultdict
from collections.abc import Sequence
from typing import Any

from harness.cases import PRESETS
from harness.report.ledger import at, in_words, variant
from harness.report.recorded import Recorded, Rows
from harness.report.section import Json, Section, digits
from harness.rows import mechanism_hash

KEY, TITLE, MENU = "history", "History: what moved between runs", "History"
COMMAND = "rps-bench history"
YARDSTICK = "yardstick"
"""The gate's model that only says how fast the machine was."""
RUN = ("run", "time", "command", "commit", "release", "machine", "python", "numpy", "scipy", "blas")
POSE = ("z_m", "azimuth_rad", "tilt_rad")
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


def section(recorded: Recorded) -> Section:
    """Return the section."""
    if not recorded.runs:
        missing = "every run records itself: `rps-bench table`, say, makes this section"
        return Section(KEY, TITLE, MENU, COMMAND, missing=missing)
    points = [row for row in recorded.points if row["model"] != YARDSTICK]
    named = {row["run"] for row in points}
    runs = [row for row in recorded.runs if row["run"] in named]
    place = {row["run"]: k for k, row in enumerate(runs)}
    groups: dict[tuple[str, str, str], Rows] = defaultdict(list)
    for row, apart in zip(points, _told_apart(points), strict=True):
        groups[row["case"], row["model"], apart].append(row)
    newest = sorted(groups, key=lambda key: (place[groups[key][-1]["run"]], key), reverse=True)
    chosen = sorted(newest[:MOST_SERIES])
    series = [_series(key, groups[key], place) for key in chosen]
    seconds = {row["run"]: row["solve_s"] for row in recorded.points if row["model"] == YARDSTICK}
    data = {
        "runs": _runs(runs),
        "series": series,
        "yardstick": [_milliseconds(seconds.get(row["run"])) for row in runs],
    }
    about = {row["run"]: row for row in recorded.runs}
    cards = _cards(series, groups, chosen, place, runs)
    context = {
        "cards": cards[:CARDS],
        "moved": len(cards),
        "card": list(CARD),
        "cases": sorted({one["case"] for one in series}),
        "series": len(series),
        "all_series": len(groups),
        "named_runs": len(runs),
        "older": recorded.older,
        "runs": len(recorded.runs),
        "latest": [_told(row) for row in recorded.runs[::-1][:NEWEST]],
        "sweeps": [
            {**row, "command": about[row["run"]]["command"]} for row in recorded.sweeps[:NEWEST]
        ],
        "all_sweeps": len(recorded.sweeps),
        "skipped": [list(one) for one in recorded.skipped],
    }
    return Section(KEY, TITLE, MENU, COMMAND, context, data if series else None)


def _told(run: dict[str, Any]) -> Json:
    return {**run, "time": f"{run['time']:%Y-%m-%d %H:%M}", "commit": run["commit"][:10]}


def _told_apart(points: Rows) -> list[str]:
    """Return for every row in words what sets it apart from others of a model at a case.

    That is how it was solved, and a mechanism or a pose that is not the case's own; nothing for
    what is usual.
    """
    words: dict[tuple[Any, ...], str] = {}
    mechanisms, poses = defaultdict(set), defaultdict(set)
    keys = [
        (row["case"], row["model"], row["mechanism"], row["settings"], *(row[n] for n in POSE))
        for row in points
    ]
    said = {settings: variant(settings) for settings in {key[3] for key in keys}}
    for case, _, mechanism, settings, *pose in set(keys):
        mechanisms[case, said[settings]].add(mechanism)
        poses[case, said[settings], mechanism].add(tuple(pose))
    for key in set(keys):
        case, _, mechanism, settings, *pose = key
        home = PRESETS.get(case)
        alike = case, said[settings]
        found = [said[settings]]
        if len(mechanisms[alike]) > 1 and (
            home is None or mechanism != mechanism_hash(home.mechanism)
        ):
            found.append(f"mechanism {mechanism}")
        usual = home and (home.pose.z, home.pose.azimuth, home.pose.tilt)
        if len(poses[*alike, mechanism]) > 1 and tuple(pose) != usual:
            found.append(at(*pose))
        words[key] = ", ".join(word for word in found if word)
    return [words[key] for key in keys]


def _runs(runs: Rows) -> Json:
    """Return each column of the runs as changes only."""
    columns: Json = {name: [row[name] for row in runs] for name in RUN}
    columns["time"] = [f"{time:%Y-%m-%d %H:%M:%S}" for time in columns["time"]]
    return {k: v if k in ("run", "time") else changes(v) for k, v in columns.items()}


def _series(key: tuple[str, str, str], rows: Rows, place: dict[str, int]) -> Json:
    """Return one model at one case: what it gave and took in each run that had it."""
    case, model, apart = key
    once: dict[int, dict[str, Any]] = {}
    given: dict[int, dict[int, float]] = defaultdict(dict)
    for row in rows:
        once.setdefault(place[row["run"]], row)
        given[row["mode"]].setdefault(place[row["run"]], row["frequency_hz"])
    places, firsts = list(once), list(once.values())
    return {
        "case": case,
        "model": model,
        "mechanism": firsts[0]["mechanism"],
        "variant": apart,
        "pose": [firsts[0][name] for name in POSE],
        "at": changes([place - k for k, place in enumerate(places)]),
        "build": [_milliseconds(row["build_s"]) for row in firsts],
        "solve": [_milliseconds(row["solve_s"]) for row in firsts],
        "f": {
            str(mode): changes([digits(found.get(place)) for place in places])
            for mode, found in sorted(given.items())
        },
        "settings": changes([in_words(row["settings"]) for row in firsts]),
        **{name: changes([row[name] for row in firsts]) for name in ("version", "theory")},
    }


def _cards(
    series: Sequence[Json], groups: dict[tuple[str, str, str], Rows],
    keys: Sequence[tuple[str, str, str]], place: dict[str, int], runs: Rows,
) -> list[Json]:  # fmt: skip
    """Return the series whose frequencies moved: when last, by how much, and a small picture."""
    cards = []
    for number, key in enumerate(keys):
        values: dict[int, dict[int, float]] = defaultdict(dict)
        for row in groups[key]:
            if row["frequency_hz"] is not None:
                values[row["mode"]].setdefault(place[row["run"]], row["frequency_hz"])
        last = max((_last_move(found) for found in values.values()), default=(-1, 0.0))
        if last[0] < 0:
            continue
        moved = [(mode, f) for mode, f in values.items() if _last_move(f)[0] == last[0]]
        mode, found = max(moved, key=lambda one: abs(_last_move(one[1])[1]))
        size = _last_move(found)[1]
        cards.append({
            "series": number,
            "place": last[0],
            "case": series[number]["case"],
            "model": series[number]["model"],
            "variant": series[number]["variant"],
            "mode": mode,
            "change": f"{1e6 * size:+.3g} ppm" if abs(size) < 1e-4 else f"{100 * size:+.3g} %",
            "when": f"{runs[last[0]]['time']:%Y-%m-%d %H:%M}",
            "points": _spark(found),
        })  # fmt: skip
    return sorted(cards, key=lambda card: -card["place"])


def _last_move(found: dict[int, float]) -> tuple[int, float]:
    """Return at which run a frequency moved last, and by how much; (-1, 0) if it never did."""
    places = list(found)
    for earlier, later in zip(places[-2::-1], places[:0:-1], strict=True):
        if abs(found[later] - found[earlier]) > MOVED * abs(found[earlier]):
            before = found[earlier]
            return later, found[later] / before - 1 if before else float("inf")
    return -1, 0.0


def _spark(found: dict[int, float]) -> list[list[float]]:
    """Return the points of a small picture: steps from run to run."""
    values = list(found.values())
    low, high = min(values), max(values)
    wide, tall = CARD
    points: list[list[float]] = []
    for k, value in enumerate(values):
        x = 3 + (wide - 6) * k / max(1, len(values) - 1)
        y = 4 + (tall - 8) * (high - value) / (high - low)
        points += [[round(x, 1), points[-1][1]]] if points else []
        points.append([round(x, 1), round(y, 1)])
    return points


def _milliseconds(seconds: float | None) -> float | None:
    return None if seconds is None else digits(1000 * seconds, 3)


def changes(values: Sequence[Any]) -> list[Any]:
    """Return [length, place, value, place, value, ...]: a value only where it is a new one."""
    result: list[Any] = [len(values)]
    for k, value in enumerate(values):
        if not k or value != values[k - 1]:
            result += [k, value]
    return result
