"""Error against time as a picture: the ways that nothing beats, the rest faint behind them."""

from typing import TYPE_CHECKING

import numpy as np

from harness.bench import label
from harness.compare import percent
from harness.figures import COLOURS, panels
from harness.signatures import Axes, Figure
from harness.unbeaten import Point, draw_front, draw_rest, unbeaten

if TYPE_CHECKING:
    from harness.studies import precision
    from harness.studies.precision import WorkPrecision

LEAST = 1e-9
"""Errors are drawn no smaller than this [%]: below it is rounding."""
ROOM = 0.5
"""Room for names on either side of what is drawn, in its own width."""


def precision_figure(result: "WorkPrecision") -> Figure:
    """Return error against time, log-log: a column a group of modes, a row a truth.

    The front is drawn in colour and its ways are named; what it beats is faint.
    """
    from harness.studies.precision import GROUPS

    kinds, groups = result.kinds, len(GROUPS)
    title = (
        "Ways that nothing beats, for one pose (blue) and many poses a call (orange); "
        "grey: all others"
    )
    figure, grid = panels(title, len(kinds), groups, (6, 5.2))
    for strip, (kind, against) in zip(grid, kinds.items(), strict=True):
        for axes, (group, modes) in zip(strip, GROUPS.items(), strict=True):
            _panel(axes, result, kind, modes)
            axes.set_title(f"{group}, against {against}", fontsize=10)
            axes.set_xlabel("time of a pose [ms]")
        strip[0].set_ylabel("largest error [%]")
    return figure


def _panel(axes: Axes, result: "WorkPrecision", kind: str, modes: int) -> None:
    def placed(p: "precision.Point") -> Point:
        return Point(1e3 * p.seconds, max(LEAST, p.worst(kind, modes)), label(p.model))

    draw_rest(axes, [placed(p) for p in result.points if np.isfinite(p.worst(kind, modes))])
    for many, colour in ((False, COLOURS[0]), (True, COLOURS[3])):
        drawn = [placed(p) for p in result.front(kind, modes, many)]
        front = unbeaten(drawn, lambda p: (p.x, p.y))
        draw_front(axes, front, colour, right=not many, thin=True)
    axes.set(xscale="log", yscale="log")
    axes.margins(x=ROOM, y=0.1)
    axes.grid(alpha=0.25)
    if unsure := result.known_to(kind, modes):
        axes.axhspan(LEAST / 2, unsure, color="0.92", zorder=0)
        axes.text(0.99, 0.01, f"grey band: the truth is known to {percent(unsure)}", fontsize=7,
                  ha="right", va="bottom", transform=axes.transAxes)  # fmt: skip
        axes.set_ylim(bottom=unsure / 3)
