"""Error against time as a picture: the ways that nothing beats, the rest faint behind them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from harness.bench import label
from harness.compare import percent
from harness.figures import COLOURS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from harness.studies.precision import WorkPrecision

NAMED = 3.0
"""Factor in error from one named way to the next."""
LETTER = 0.0125
"""Part of a panel's width that a letter of a name takes."""
LEAST = 1e-9
"""Errors are drawn no smaller than this [%]: below it is rounding."""


def precision_figure(result: "WorkPrecision") -> "Figure":
    """Return error against time, log-log: a column a group of modes, a row a truth.

    The front is drawn in colour and its ways are named; what it beats is faint.
    """
    from matplotlib.figure import Figure

    from harness.studies.precision import GROUPS

    kinds = result.kinds
    figure = Figure(figsize=(12, 4.6 * len(kinds)), layout="constrained")
    panels = figure.subplots(len(kinds), len(GROUPS), squeeze=False)
    for strip, (kind, against) in zip(panels, kinds.items(), strict=True):
        for axes, (group, modes) in zip(strip, GROUPS.items(), strict=True):
            _panel(axes, result, kind, modes)
            axes.set_title(f"{group}, against {against}", fontsize=10)
            axes.set_xlabel("time of a pose [ms]")
        strip[0].set_ylabel("largest error [%]")
    figure.suptitle(
        "Ways that nothing beats, for one pose (blue) and many poses a call (orange); "
        "grey: all others", fontsize=10,
    )  # fmt: skip
    return figure


def _panel(axes: "Axes", result: "WorkPrecision", kind: str, modes: int) -> None:
    known = [p for p in result.points if np.isfinite(p.worst(kind, modes))]
    axes.plot(
        [1e3 * p.seconds for p in known], [max(LEAST, p.worst(kind, modes)) for p in known],
        "o", color="0.8", ms=4, zorder=1,
    )  # fmt: skip
    names: dict[bool, list[tuple[float, str]]] = {False: [], True: []}
    for many, colour in ((False, COLOURS[0]), (True, COLOURS[3])):
        front = result.front(kind, modes, many)
        times = [1e3 * p.seconds for p in front]
        errors = [max(LEAST, p.worst(kind, modes)) for p in front]
        axes.plot(times, errors, "o-", color=colour, ms=6, lw=1.4, drawstyle="steps-post", zorder=2)
        said = np.inf
        for k, point in enumerate(front):
            # A way that is hardly better than the last one named goes without a name.
            if errors[k] > said / NAMED:
                continue
            said = errors[k]
            name = label(point.model)
            names[many].append((float(np.log(times[k])), name))
            axes.annotate(
                name, (times[k], errors[k]), xytext=(-6, -9) if many else (5, 5),
                ha="right" if many else "left", textcoords="offset points", fontsize=7,
                color=colour,
            )  # fmt: skip
    unsure = result.known_to(kind, modes)
    if unsure:
        axes.axhspan(LEAST / 2, unsure, color="0.92", zorder=0)
        axes.text(0.99, 0.01, f"grey band: the truth is known to {percent(unsure)}", fontsize=7,
                  ha="right", va="bottom", transform=axes.transAxes)  # fmt: skip
    axes.set(xscale="log", yscale="log")
    axes.set_xlim(*np.exp(_with_room(np.log(axes.get_xlim()).tolist(), names[True], names[False])))
    if unsure:
        axes.set_ylim(bottom=unsure / 3)
    axes.grid(alpha=0.25)


def _with_room(
    limits: Sequence[float],
    before: Sequence[tuple[float, str]],
    after: Sequence[tuple[float, str]],
) -> tuple[float, float]:
    """Return limits with room for the names left of `before`, and right of `after`, (x, name)."""
    low, high = limits
    for _ in range(30):  # what is added widens the panel, by less each time
        letter = LETTER * (high - low)
        low = min([low, *(x - letter * len(name) for x, name in before)])
        high = max([high, *(x + letter * len(name) for x, name in after)])
    return low, high
