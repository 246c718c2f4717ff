"""The picture of an identification: profiles of the parameters, and what the fits leave."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from harness.figures import COLOURS, MARKERS
from harness.studies.identification.estimate import Fit
from harness.studies.identification.fit import profiles

if TYPE_CHECKING:
    from matplotlib.axes import Axes

POINTS = 25
"""Points of a profile."""
LOWEST, STEP = 0.04, 0.06
"""Where the bars of the first fit are, and how far above them those of the next, of the height."""


def profile_figure(fits: Sequence[Fit]) -> Figure:
    """Return the profiles of every parameter, and below them what the fits leave."""
    names, table = fits[0].problem.names, fits[0].problem.table
    cases = len(table.cases)
    columns = max(len(names), cases)
    figure = Figure(figsize=(3.1 * columns, 6.2), layout="constrained")
    grid = figure.add_gridspec(2, columns * cases)
    width = columns * cases // len(names)
    above = [figure.add_subplot(grid[0, k * width : (k + 1) * width]) for k in range(len(names))]
    for k, one in enumerate(fits):
        _draw_profiles(above, one, COLOURS[k], LOWEST + k * STEP)
    for axes, name in zip(above, names, strict=True):
        axes.set_xlabel(_with_unit(name), fontsize=9)
        axes.grid(alpha=0.25)
        axes.tick_params(labelsize=8)
        axes.set_ylim(-0.2 * axes.get_ylim()[1], None)
        axes.axhline(0, color="0.4", lw=0.8)
    above[0].set_ylabel("rise of S over noise$^2$")
    modes = np.arange(1, table.frequencies.shape[1] + 1)
    for c, case in enumerate(table.cases):
        axes = figure.add_subplot(grid[1, c * columns : (c + 1) * columns])
        for k, one in enumerate(fits):
            axes.plot(
                modes + 0.12 * (k - 0.5), 100 * one.error[c], ls="none", marker=MARKERS[k],
                color=COLOURS[k], label=one.problem.label,
            )  # fmt: skip
        axes.axhline(0, color="0.4", lw=0.8)
        axes.set_title(case.heading, fontsize=10)
        axes.set_xticks(modes, [f"$f_{i}$" for i in modes])
        axes.grid(alpha=0.25)
        axes.set_ylabel("left over [%]")
        axes.margins(y=0.15)
        if c == 0:
            axes.legend(fontsize=8)
    explained = (
        "dots: fitted; grey line: as given; bars: 95 % intervals, thick of a parameter alone, thin "
        "of all together, an arrow where a bound came first"
    )
    figure.suptitle(f"Fits to {table.source}\n{explained}", fontsize=10)
    return figure


def _with_unit(name: str) -> str:
    """Return "platform radius [mm]" for "platform_radius_mm", "density [kg/m3]" for its like."""
    words = name.split("_")
    unit = -2 if words[-1] == "m3" else -1
    return f"{' '.join(words[:unit])} [{'/'.join(words[unit:])}]"


def _draw_profiles(above: Sequence["Axes"], one: Fit, colour: str, low_down: float) -> None:
    """Draw the profiles, and below them the intervals as bars, `low_down` of the panel's height."""
    problem, (low, high) = one.problem, one.problem.limits
    best, ends = one.x[:, None], problem.to_x(one.together.T).T
    span = np.clip(best + 1.3 * (ends - best), low[:, None], high[:, None])
    residuals = problem.residuals(problem.table.logarithms[None])
    at, sums = profiles(residuals, one.x, low, high, span, POINTS)
    height = (sums - one.sum) / one.noise**2
    for k, (axes, values) in enumerate(zip(above, problem.from_x(at.T).T, strict=True)):
        axes.plot(values, height[k], color=colour, lw=1.4)
        axes.plot(one.values[k], 0, "o", color=colour, ms=4, clip_on=False)
        for interval, width in ((one.alone, 4.5), (one.together, 1.2)):
            axes.plot(interval[k], [low_down] * 2, color=colour, lw=width, scaley=False,
                      solid_capstyle="butt", transform=axes.get_xaxis_transform())  # fmt: skip
        for value, opened, mark in zip(one.together[k], one.open[k], "<>", strict=True):
            if opened:
                axes.plot(value, low_down, mark, color=colour, ms=4, scaley=False,
                          transform=axes.get_xaxis_transform())  # fmt: skip
        axes.axvline(problem.given[k], color="0.5", lw=0.8)
