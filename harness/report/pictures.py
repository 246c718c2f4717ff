"""Pictures that need no script, as coordinates: a mechanism at a pose, Fig. 3 with its floor."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from harness.case import Case
from harness.drawing import at, drawn, seen
from harness.report.section import Json

Array = NDArray[np.float64]
WIDE, HIGH = 320.0, 260.0
"""Size of the drawing of a mechanism."""
PANEL = {"width": 380.0, "height": 300.0, "left": 34.0, "right": 130.0, "top": 28.0, "bottom": 40.0}
"""Size and margins of a panel of Fig. 3."""
LINE = 15.0
"""Height of a label: closer ones are one."""
PANELS = 2


def mechanism(case: Case) -> Json:
    """Return the mechanism of a case at its pose as seen from the front: lines and outlines."""
    there = drawn(case.mechanism, case.pose)
    lines = there.limbs()
    ends = [at(lines[s.limb], np.array([s.begin, s.end])) for s in there.spans]
    parts = [there.ground, there.centre + there.rim(), there.marked(lines), *ends]
    flat, near = seen(np.concatenate(parts))
    low, high = flat.min(axis=0), flat.max(axis=0)
    scale = np.min((np.array([WIDE, HIGH]) - [110, 60]) / (high - low))
    placed = (flat - (low + high) / 2) * scale * [1, -1] + np.array([WIDE, HIGH]) / 2
    cuts = np.cumsum([len(part) for part in parts])[:-1]
    ground, platform, marks, *spans = (p.tolist() for p in np.split(np.round(placed, 1), cuts))
    nearness = [part.sum() for part in np.split(near, cuts)[3:]]
    chains = dict.fromkeys(limb.described for limb in case.mechanism.limbs)
    return {
        "width": WIDE,
        "height": HIGH,
        "base": ground,
        "platform": platform,
        "limbs": [
            {
                "from": spans[k][0],
                "to": spans[k][1],
                "width": round(float(2 * there.spans[k].radius * scale), 1),
            }
            for k in np.argsort(nearness)
        ],
        "joints": [
            {"x": x, "y": y, "kind": one.kind}
            for one, (x, y) in zip(there.marks, marks, strict=True)
        ],
        "chains": "" if there.plain else " and ".join(chains),
        "caption": case.heading,
    }


def fig3(data: Json) -> Json | None:
    """Return Fig. 3 of the first family against the first reference, with the floor, to draw."""
    panels = []
    for name, case in list(data["cases"].items())[:PANELS]:
        family, about = next(iter(case["families"].items()))
        reference = next(iter(case["references"]))
        none = [None] * len(data["modes"])
        rows = [*about["errors"][reference], about["floors"][reference]]
        known = np.array([row or none for row in rows], dtype=float)
        if np.isfinite(known[:-1]).any():
            panels.append(_panel(data, case["heading"] or name, known))
    if not panels:
        return None
    title = f"{family} with s elements a limb against {reference}"
    return {**PANEL, "panels": panels, "title": title, "limit": about["limit"]}


def _panel(data: Json, title: str, shown: Array) -> Json:
    """Return a panel of errors, (elements + 1, modes) [%], whose last row is the floor."""
    from matplotlib.ticker import LogLocator, MaxNLocator

    steps = data["elements"]
    known = shown[np.isfinite(shown)]
    low, high = known.min(), known.max()
    logarithmic = low > 0 and high > 3 * low
    if logarithmic:
        low, high = 0.8 * low, 1.25 * high
        ticks = LogLocator(subs=(1, 2, 5)).tick_values(low, high)
    else:
        low, high = min(0.0, low), max(0.0, high)
        room = 0.08 * (high - low) or 1.0
        low, high = low - room * (low < 0), high + room
        ticks = MaxNLocator(5, steps=[1, 2, 5, 10]).tick_values(low, high)
    inner = PANEL["width"] - PANEL["left"] - PANEL["right"]
    tall = PANEL["height"] - PANEL["top"] - PANEL["bottom"]

    def across(k: int) -> float:
        return round(PANEL["left"] + inner * k / max(1, len(steps) - 1), 1)

    def down(value: float) -> float:
        ends = np.log([low, high, value]) if logarithmic else np.array([low, high, value])
        return round(float(PANEL["top"] + tall * (ends[1] - ends[2]) / (ends[1] - ends[0])), 1)

    lines = []
    for mode, (*values, floor) in zip(data["modes"], shown.T, strict=True):
        finite = [(k, float(v)) for k, v in enumerate(values) if np.isfinite(v)]
        if finite:
            points = [[across(k), down(v)] for k, v in finite]
            own = down(floor) if np.isfinite(floor) else None
            lines.append({"mode": mode, "points": points, "floor": own, "last": finite[-1][1]})
    return {
        "title": title,
        "lines": lines,
        "labels": _labels(lines),
        "across": [[across(k), s] for k, s in enumerate(steps)],
        "down": [[down(t), f"{t:g}"] for t in ticks if low <= t <= high],
    }


def _labels(lines: Sequence[Json]) -> list[Json]:
    """Return one label for all curves that end at nearly one place: "e5, e6"."""
    ordered = sorted(lines, key=lambda line: line["points"][-1][1])
    heights = np.array([line["points"][-1][1] for line in ordered])
    cuts = [0, *(np.flatnonzero(np.diff(heights) >= LINE) + 1), len(ordered)]
    labels = []
    for start, end in pairwise(cuts):
        group = ordered[start:end]
        low, high = (round(f(line["last"] for line in group), 1) for f in (min, max))
        modes = sorted(line["mode"] for line in group)
        labels.append({
            "x": group[0]["points"][-1][0] + 10,
            "y": round(float(heights[start:end].mean()), 1),
            "modes": modes,
            "name": _name(modes),
            "value": f"{low:g} %" if low == high else f"{low:g} to {high:g} %",
        })  # fmt: skip
    return labels


def _name(modes: Sequence[int]) -> str:
    if len(modes) > 2 and modes[-1] - modes[0] == len(modes) - 1:
        return f"e{modes[0]}-e{modes[-1]}"
    return ", ".join(f"e{mode}" for mode in modes)
