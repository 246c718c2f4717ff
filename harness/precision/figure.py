"""The work-precision diagram: error against time, log-log."""

from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from harness.figures import COLOURS
from harness.precision.cost_report import MANY_MARKERS
from harness.precision.ways import theory_of
from harness.precision.work_precision import (
    GROUPS,
    OWN,
    SOLID,
    Point,
    WorkPrecision,
    milliseconds,
    worst,
)

LEAST = 1e-8
"""Errors are drawn no smaller than this [%]: below it is the rounding of eigen-solutions."""


def precision_figure(result: WorkPrecision) -> Figure:
    """Return error against time, log-log: a column a group of modes, a row a truth."""
    kinds = {OWN: "own theory's limit"}
    if result.solid is not None:
        kinds[SOLID] = result.solid.spec.label
    size = (11.5, 4.2 * len(kinds) + 1.6)
    figure = Figure(figsize=size, layout="constrained")
    panels = figure.subplots(len(kinds), len(GROUPS), squeeze=False, sharex=True, sharey="row")
    looks = _looks(result)
    for strip, (kind, against) in zip(panels, kinds.items(), strict=True):
        for axes, (group, modes) in zip(strip, GROUPS.items(), strict=True):
            for method, look in looks.items():
                points = [point for point in result.points if point.method == method]
                _curve(axes, [p for p in points if not _itself(result, p)], kind, modes, look)
            if kind == SOLID and result.solid is not None:
                axes.axhspan(0, result.solid.uncertainty(modes), color="0.85", zorder=0)
            axes.set(xscale="log", yscale="log", title=f"{group}, against {against}")
            axes.title.set_fontsize(10)
            axes.grid(alpha=0.25)
        strip[0].set_ylabel("largest error [%]")
        # Last: a limit set earlier would be kept from what is drawn after it.
        strip[0].set_ylim(bottom=LEAST / 2 if kind == OWN else 3e-3)
    for axes in panels[-1]:
        axes.set_xlabel("time of a pose [ms]")
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.suptitle(
        "Colours: theories; hollow: extrapolated from two meshes; errors below "
        f"{LEAST:g} % (no elements) are drawn there; grey: the truth's own uncertainty",
        fontsize=9,
    )
    figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=8, frameon=False)
    return figure


def _itself(result: WorkPrecision, point: Point) -> bool:
    """Whether the point is what stands for the limit of its own theory."""
    truth = result.limits.get(theory_of(point.spec))
    return truth is not None and point.kind == "simulator" and point.spec == truth.spec


def _looks(result: WorkPrecision) -> dict[str, tuple[str, str]]:
    """Return each method's colour, that of its theory, and marker, its own among these."""
    theories = list(result.limits)
    looks: dict[str, tuple[str, str]] = {}
    for point in result.points:
        if point.method not in looks:
            colour = COLOURS[theories.index(theory_of(point.spec)) % len(COLOURS)]
            taken = sum(colour == other for other, _ in looks.values())
            looks[point.method] = (colour, MANY_MARKERS[taken % len(MANY_MARKERS)])
    return looks


def _curve(
    axes: Axes, points: Sequence[Point], kind: str, modes: int, look: tuple[str, str]
) -> None:
    """Draw one model; a line joins its meshes, and extrapolated pairs are hollow on their own."""
    colour, marker = look
    style: dict[str, Any] = {"color": colour, "marker": marker, "ms": 5, "lw": 1.0}
    pairs = [point for point in points if isinstance(point.spec.elements, tuple)]
    meshes = [point for point in points if not isinstance(point.spec.elements, tuple)]
    for some, line in ((meshes, {"ls": "-"}), (pairs, {"ls": ":", "mfc": "none"})):
        if not some:
            continue
        errors = [max(worst(point.errors(kind), modes), LEAST) for point in some]
        style["label"] = points[0].method if some is meshes else None
        axes.plot([milliseconds(p) for p in some], errors, **style | line)
