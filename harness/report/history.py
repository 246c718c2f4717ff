"""History: what every recorded run gave and took, compactly; first the series that moved."""

from collections import Counter, defaultdict
from collections.abc import Sequence
from typing import Any

import numpy as np

from harness.cases import PRESETS
from harness.poses import COLUMNS, columns
from harness.report.recorded import ABOUT_RUN, Recorded, Rows
from harness.report.section import Json, Section, at, digits, in_words, variant
from harness.rows import mechanism_hash

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
