"""The cost study as a picture: what nothing beats, named, and all other ways faint behind it."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.bench import label
from harness.figures import COLOURS, panels
from harness.signatures import Figure
from harness.timing import Timed
from harness.unbeaten import Point, draw_front, draw_rest, unbeaten

if TYPE_CHECKING:
    from harness.studies.cost import Cost


def cost_figure(cost: "Cost") -> Figure:
    """Return (a) one pose against elements and (b) a pose against poses a call, both log-log.

    In (a) more elements for less time win, in (b) fewer poses a call.
    """
    from harness.studies.cost import FLOOR, YARDSTICK

    title = "Ways that nothing beats; grey: all others"
    heads = (f"modes of one pose, {YARDSTICK} = 1", f"frequencies, {FLOOR} = 1")
    figure, ((left, right),) = panels(title, 1, 2, (5.8, 5.4), heads)
    exact = 2 * max(cost.steps)
    single = [
        _point(cost, t, YARDSTICK, t.way.model.elements or exact, t.way.method)
        for t in cost.elements
    ]
    batched = [
        _point(cost, t, FLOOR, max(1, t.way.poses), replace(t.way, poses=0).method)
        for t in cost.batches
    ]
    draw_rest(left, single)
    draw_front(left, unbeaten(single, lambda p: (p.y, -p.x)), COLOURS[0], rises=True)
    draw_rest(right, batched)
    draw_front(right, unbeaten(batched, lambda p: (p.x, p.y)), COLOURS[3])
    for axes, what in ((left, "one"), (right, "a")):
        axes.set(xscale="log", yscale="log", ylabel=f"time of {what} pose / yardstick")
        axes.title.set_fontsize(9)
        axes.margins(x=0.2, y=0.12)
        axes.grid(alpha=0.25)
    left.set_xticks([*cost.steps, exact], [*map(str, cost.steps), "exact"])
    left.set_xticks([], minor=True)
    left.set_xlabel("number of elements $s$")
    right.set_xlabel("poses a call")
    return figure


def _point(cost: "Cost", t: Timed, yardstick: str, x: Any, name: str) -> Point:
    time = float(np.median(cost.ratios(t, yardstick)))
    exact = t.way.model.elements is None
    # (a) joins a method's numbers of elements, (b) a model's numbers of poses.
    curve = label(t.way.model) if t.way.poses or exact else name
    return Point(float(x), time, f"{name}, exact" if exact and not t.way.poses else name, curve)
