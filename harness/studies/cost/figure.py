"""The cost study as a picture: seconds against elements, and against the poses of a call."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.figures import COLOURS, MARKERS
from harness.timing import Timed

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from harness.studies.cost import Cost

MANY_MARKERS = (*MARKERS, "P", "X", "<", ">", "*", "p")


def cost_figure(cost: "Cost") -> "Figure":
    """Return (a) one pose against elements and (b) a pose against batch size, both log-log.

    Lines join medians; simulators are dashed and hollow.
    """
    from matplotlib.figure import Figure

    from harness.studies.cost import FLOOR, YARDSTICK

    figure = Figure(figsize=(11.5, 5.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    single = [t for t in cost.elements if isinstance(t.way.model.elements, int)]
    for k, method in enumerate(dict.fromkeys(t.way.method for t in single)):
        own = [t for t in single if t.way.method == method]
        _curve(left, cost, own, [int(t.way.size) for t in own], YARDSTICK, k, method)
    for t, dots in zip(
        [t for t in cost.elements if t.way.size == "exact"], (":", "-.", "--"), strict=False
    ):
        level = float(np.median(cost.ratios(t, YARDSTICK)))
        left.axhline(level, color="0.3", ls=dots, lw=1.2, label=f"{t.way.method}, exact")
    left.set(xscale="log", xlabel="number of elements $s$", ylabel="time of one pose / yardstick")
    left.set_title(f"(a) yardstick: {YARDSTICK}", fontsize=9)
    for k, model in enumerate(dict.fromkeys(t.way.model for t in cost.batches)):
        own = [t for t in cost.batches if t.way.model == model]
        name = getattr(model, "label", "")
        _curve(right, cost, own, [max(1, t.way.poses) for t in own], FLOOR, k, name)
    right.set(xscale="log", xlabel="poses a call", ylabel="time a pose / one 6x6 eigh")
    right.set_title(f"(b) yardstick: {FLOOR}", fontsize=9)
    for axes in (left, right):
        axes.set_yscale("log")
        axes.grid(alpha=0.25)
        # Below the axes: inside there is no corner that every run leaves free.
        below = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.13)}
        axes.legend(fontsize=7, ncols=2, frameon=False, **below)
    return figure


def _curve(
    axes: "Axes", cost: "Cost", own: Sequence[Timed], sizes: Sequence[int], yardstick: str, k: int,
    name: str,
) -> None:  # fmt: skip
    simulated = own[0].way.model.info().isolated
    style: dict[str, Any] = {"ls": "--", "mfc": "none"} if simulated else {"ls": "-"}
    middle = [float(np.median(cost.ratios(t, yardstick))) for t in own]
    colour, marker = COLOURS[k % len(COLOURS)], MANY_MARKERS[k % len(MANY_MARKERS)]
    axes.plot(sizes, middle, color=colour, marker=marker, ms=5, lw=1.2, label=name, **style)
