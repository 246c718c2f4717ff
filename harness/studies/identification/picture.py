"""The picture of an identification: profiles of the parameters, and what the fits leave."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from harness.figures import COLOURS, MARKERS
from harness.studies.identification.estimate import Fitted
from harness.studies.identification.result import model_label

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def profile_figure(results: Sequence[Fitted]) -> Figure:
    """Return the profiles of every parameter, and below them what the fits leave."""
    names = results[0].problem.names
    table = results[0].problem.table
    columns = max(len(names), len(table.cases))
    figure = Figure(figsize=(3.1 * columns, 6.2), layout="constrained")
    grid = figure.add_gridspec(2, columns * len(table.cases))
    width = columns * len(table.cases) // len(names)
    for k, name in enumerate(names):
        axes = figure.add_subplot(grid[0, k * width : (k + 1) * width])
        for result, colour in zip(results, COLOURS, strict=False):
            _draw_profile(axes, result, k, colour)
        axes.set_xlabel(name.replace("_", " "), fontsize=9)
        axes.grid(alpha=0.25)
        axes.tick_params(labelsize=8)
        axes.set_ylim(0, None)
        if k == 0:
            axes.set_ylabel("rise of S over noise$^2$")
    for c, case in enumerate(table.cases):
        axes = figure.add_subplot(grid[1, c * columns : (c + 1) * columns])
        for k, result in enumerate(results):
            modes = np.arange(1, result.error.shape[1] + 1)
            axes.plot(
                modes + 0.12 * (k - 0.5), 100 * result.error[c], ls="none", marker=MARKERS[k],
                color=COLOURS[k], label=model_label(result.problem),
            )  # fmt: skip
        axes.axhline(0, color="0.4", lw=0.8)
        axes.set_title(case.name, fontsize=10)
        axes.set_xticks(modes, [f"$f_{i}$" for i in modes])
        axes.grid(alpha=0.25)
        axes.set_ylabel("left over [%]")
        axes.margins(y=0.15)
        if c == 0:
            axes.legend(fontsize=8)
    explained = "dots: fitted; grey: as given; dotted, dashed: 95 % intervals, alone and together"
    figure.suptitle(f"Fits to {table.source}\n{explained}", fontsize=10)
    return figure


def _draw_profile(axes: "Axes", result: Fitted, k: int, colour: str) -> None:
    problem, fits = result.problem, result.fits
    x = np.zeros((result.profiles.at.shape[1], len(problem.names)))
    x[:, k] = result.profiles.at[k]
    height = (result.profiles.sums[k] - fits.minima.sums[0]) / fits.noise[0] ** 2
    axes.plot(problem.from_x(x)[:, k], height, color=colour, lw=1.4, label=model_label(problem))
    axes.plot(fits.values[0, k], 0, "o", color=colour, ms=4, clip_on=False)
    for ends, style in ((fits.alone, ":"), (fits.together, "--")):
        for value, opened in zip(ends[0, k], fits.open[0, k], strict=True):
            if not opened:
                axes.axvline(value, color=colour, ls=style, lw=0.8)
    axes.axvline(problem.from_x(problem.start)[k], color="0.5", lw=0.8)
