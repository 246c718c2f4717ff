"""Pictures that need no script, as coordinates: a mechanism at a pose, Fig. 3 with its floor."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic import limbs_at, position
from harness.cases import Case
from harness.report.section import Json

Array = NDArray[np.float64]
TURN, HEIGHT = math.radians(-62), math.radians(20)
"""From where a mechanism is looked at."""
WIDE, HIGH = 320.0, 260.0
"""Size of the drawing of a mechanism."""
PANEL = {"width": 380.0, "height": 300.0, "left": 34.0, "right": 130.0, "top": 28.0, "bottom": 40.0}
"""Size and margins of a panel of Fig. 3."""
LINE = 15.0
"""Height of a label: closer ones are one."""
TICKS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100)
PANELS = 2


def mechanism(case: Case) -> Json:
    """Return the mechanism of a case at its pose as seen from the front: lines and outlines."""
    limbs = limbs_at(case.mechanism, case.pose)
    bases = case.mechanism.bases
    tips = bases + limbs.lengths[:, None] * limbs.frames[:, :, 2]
    centre = np.asarray(position(case.mechanism, case.pose))
    x, y = case.pose.rotation.T[:2]
    radius = float(np.linalg.norm(case.mechanism.platform_points, axis=1).max())
    round_ = np.linspace(0, 2 * np.pi, 49)[:-1]
    disc = centre + radius * (np.cos(round_)[:, None] * x + np.sin(round_)[:, None] * y)
    everything = np.concatenate([bases, tips, disc])
    flat = _seen(everything)
    low, high = flat.min(axis=0), flat.max(axis=0)
    scale = min((WIDE - 110) / (high[0] - low[0]), (HIGH - 60) / (high[1] - low[1]))

    def place(points: Array) -> list[list[float]]:
        off = (_seen(np.atleast_2d(points)) - (low + high) / 2) * scale
        return [[round(WIDE / 2 + u, 1), round(HIGH / 2 - v, 1)] for u, v in off]

    depth = (bases + tips) @ np.array([math.cos(TURN), math.sin(TURN), 0.0])
    drawn = [
        {
            "from": place(bases[k])[0],
            "to": place(tips[k])[0],
            "width": round(case.mechanism.limbs[k].rod.diameter * scale, 1),
        }
        for k in np.argsort(depth)
    ]
    return {
        "width": WIDE,
        "height": HIGH,
        "base": place(bases),
        "platform": place(disc),
        "limbs": drawn,
        "caption": case.heading,
    }


def _seen(points: Array) -> Array:
    """Return where points lie on the picture's plane, to the right and up."""
    side = np.array([-math.sin(TURN), math.cos(TURN), 0.0])
    up = np.array([
        -math.sin(HEIGHT) * math.cos(TURN), -math.sin(HEIGHT) * math.sin(TURN), math.cos(HEIGHT)
    ])  # fmt: skip
    return np.asarray(points @ np.array([side, up]).T)


def fig3(data: Json) -> Json | None:
    """Return Fig. 3 of the first family against the first reference, with the floor, to draw."""
    panels = []
    for name, case in list(data["cases"].items())[:PANELS]:
        family, (reference, *_) = next(iter(case["families"].items())), case["references"]
        errors = _matrix(family[1]["errors"][reference], len(data["modes"]))
        floor = _matrix([family[1]["floors"][reference]], len(data["modes"]))[0]
        if np.isfinite(errors).any():
            panels.append(_panel(data, case["heading"] or name, errors, floor))
    if not panels:
        return None
    title = f"{family[0]} with s elements a limb against {reference}"
    return {**PANEL, "panels": panels, "title": title, "limit": family[1]["limit"]}


def _matrix(rows: Sequence[Any], width: int) -> Array:
    return np.array([[np.nan] * width if row is None else row for row in rows], dtype=float)


def _panel(data: Json, title: str, errors: Array, floor: Array) -> Json:
    steps = data["elements"]
    shown = np.concatenate([errors, floor[None]])
    known = shown[np.isfinite(shown)]
    logarithmic = bool((known > 0).all() and known.max() > 3 * known.min())
    low, high = (0.8 * known.min(), 1.25 * known.max()) if logarithmic else _span(known)
    inner = PANEL["width"] - PANEL["left"] - PANEL["right"]
    tall = PANEL["height"] - PANEL["top"] - PANEL["bottom"]

    def across(k: int) -> float:
        return round(PANEL["left"] + inner * k / max(1, len(steps) - 1), 1)

    def down(value: float) -> float:
        ends = np.log([low, high, value]) if logarithmic else np.array([low, high, value])
        return round(float(PANEL["top"] + tall * (ends[1] - ends[2]) / (ends[1] - ends[0])), 1)

    lines = []
    for place, mode in enumerate(data["modes"]):
        values = errors[:, place]
        points = [[across(k), down(v)] for k, v in enumerate(values) if np.isfinite(v)]
        if points:
            own = None if not np.isfinite(floor[place]) else down(floor[place])
            last = float(values[np.isfinite(values)][-1])
            lines.append({"mode": mode, "points": points, "floor": own, "last": last})
    ticks = [t for t in TICKS if low <= t <= high] if logarithmic else _steps(low, high)
    return {
        "title": title,
        "lines": lines,
        "labels": _labels(lines),
        "across": [[across(k), s] for k, s in enumerate(steps)],
        "down": [[down(t), f"{t:g}"] for t in ticks],
    }


def _labels(lines: Sequence[Json]) -> list[Json]:
    """Return one label for all curves that end at nearly one place: "e5, e6"."""
    groups: list[list[Json]] = []
    for line in sorted(lines, key=lambda one: one["points"][-1][1]):
        end = line["points"][-1][1]
        if groups and end - groups[-1][-1]["points"][-1][1] < LINE:
            groups[-1].append(line)
        else:
            groups.append([line])
    labels = []
    for group in groups:
        modes = sorted(line["mode"] for line in group)
        ends = [line["points"][-1] for line in group]
        low, high = (round(f(line["last"] for line in group), 1) for f in (min, max))
        labels.append({
            "x": ends[0][0] + 10,
            "y": round(float(np.mean([y for _, y in ends])), 1),
            "modes": modes,
            "name": _name(modes),
            "value": f"{low:g} %" if low == high else f"{low:g} to {high:g} %",
        })  # fmt: skip
    return labels


def _name(modes: Sequence[int]) -> str:
    if len(modes) > 2 and modes[-1] - modes[0] == len(modes) - 1:
        return f"e{modes[0]}-e{modes[-1]}"
    return ", ".join(f"e{mode}" for mode in modes)


def _span(known: Array) -> tuple[float, float]:
    low, high = min(0.0, float(known.min())), max(0.0, float(known.max()))
    room = 0.08 * (high - low) or 1.0
    return low - room * (low < 0), high + room


def _steps(low: float, high: float) -> list[float]:
    rough = (high - low) / 5
    power = 10.0 ** math.floor(math.log10(rough))
    step = min((n * power for n in (1, 2, 5, 10) if n * power >= rough), default=rough)
    return [round(k * step, 12) for k in range(math.ceil(low / step), math.floor(high / step) + 1)]
