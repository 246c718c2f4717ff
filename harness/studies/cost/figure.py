"""The cost study as a picture: what nothing beats, named, and all other ways faint behind it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.bench import label
from harness.figures import COLOURS
from harness.timing import Timed

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from harness.studies.cost import Cost

CLOSE = 3.0
"""Factor in elements or poses, and in time, within which one name would run into the next."""


@dataclass(frozen=True)
class Point:
    """A way at `x` (elements, or poses a call): its `time` in yardsticks; `curve` joins them."""

    x: float
    time: float
    curve: str
    name: str


def unbeaten(points: Sequence[Point], *, more: bool) -> list[Point]:
    """Return the points, by x, to which no other is equal or better in both and better in one.

    Less time is better, and `more` of x or less of it.
    """
    sign = -1 if more else 1

    def beats(a: Point, b: Point) -> bool:
        own, other = (sign * a.x, a.time), (sign * b.x, b.time)
        return own != other and own[0] <= other[0] and own[1] <= other[1]

    front = [p for p in points if not any(beats(q, p) for q in points)]
    return sorted(front, key=lambda p: p.x)


def cost_figure(cost: "Cost") -> "Figure":
    """Return (a) one pose against elements and (b) a pose against poses a call, both log-log.

    In (a) more elements for less time win, in (b) fewer poses a call.
    """
    from matplotlib.figure import Figure

    from harness.studies.cost import FLOOR, YARDSTICK

    figure = Figure(figsize=(11.5, 5.0), layout="constrained")
    left, right = figure.subplots(1, 2)
    exact = 2 * max(cost.steps)
    points = [
        _point(cost, t, YARDSTICK, t.way.model.elements or exact, t.way.method)
        for t in cost.elements
    ]
    panel(left, points, COLOURS[0], more=True)
    ticks = [*cost.steps, exact]
    left.set_xscale("log")
    left.set_xticks(ticks, [*map(str, cost.steps), "exact"])
    left.set_xticks([], minor=True)
    left.set(xlabel="number of elements $s$", ylabel="time of one pose / yardstick")
    left.set_title(f"(a) modes of one pose, {YARDSTICK} = 1", fontsize=9)
    points = [
        _point(cost, t, FLOOR, max(1, t.way.poses), replace(t.way, poses=0).method)
        for t in cost.batches
    ]
    panel(right, points, COLOURS[3], more=False)
    right.set(xscale="log", xlabel="poses a call", ylabel="time of a pose / yardstick")
    right.set_title(f"(b) frequencies, {FLOOR} = 1", fontsize=9)
    for axes in (left, right):
        axes.set_yscale("log")
        axes.margins(x=0.15, y=0.1)
        axes.grid(alpha=0.25)
    figure.suptitle("Ways that nothing beats; grey: all others", fontsize=10)
    return figure


def _point(cost: "Cost", t: Timed, yardstick: str, x: Any, name: str) -> Point:
    time = float(np.median(cost.ratios(t, yardstick)))
    exact = t.way.model.elements is None
    # (a) joins a method's numbers of elements, (b) a model's numbers of poses.
    curve = label(t.way.model) if t.way.poses or exact else name
    return Point(float(x), time, curve, f"{name}, exact" if exact and not t.way.poses else name)


def panel(axes: "Axes", points: Sequence[Point], colour: str, *, more: bool) -> None:
    """Draw `points`: what nothing beats in `colour` and named, `more` as in `unbeaten`."""
    for curve in dict.fromkeys(p.curve for p in points):
        own = sorted((p for p in points if p.curve == curve), key=lambda p: p.x)
        axes.plot([p.x for p in own], [p.time for p in own], "o-", color="0.82", ms=3, lw=0.8,
                  zorder=1)  # fmt: skip
    front = unbeaten(points, more=more)
    axes.plot([p.x for p in front], [p.time for p in front], "o-", color=colour, ms=5, lw=1.4,
              zorder=2)  # fmt: skip
    lasts = sorted({p.name: p for p in front}.values(), key=lambda p: p.x)
    below = 0
    for before, last in zip([None, *lasts], lasts, strict=False):
        # Beside the curve, which rises in (a) and falls in (b), and inside the panel; names of
        # close neighbours stand under each other.
        near = before and last.x < CLOSE * before.x and 1 / CLOSE < last.time / before.time < CLOSE
        below = below + 1 if near else 0
        side, (x, y) = "left", (6, -12 - 10 * below)
        if last == front[-1]:
            side, (x, y) = "right", (4, 8 if more else -14)
        axes.annotate(last.name, (last.x, last.time), xytext=(x, y), textcoords="offset points",
                      fontsize=7, color=colour, ha=side, zorder=3)  # fmt: skip
