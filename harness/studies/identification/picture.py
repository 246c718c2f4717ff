"""The picture of an identification: profiles of the parameters, and what the fits leave."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.interpolate import BarycentricInterpolator

from harness.figures import COLOURS, MARKERS
from harness.signatures import Axes
from harness.studies.identification.estimate import Fit
from harness.studies.identification.problem import split

POINTS = 49
"""Points of a profile as drawn."""
LOWEST, STEP = 0.04, 0.06
"""Where the bars of the first fit are, and how far above them those of the next, of the height."""


def profile_figure(fits: Sequence[Fit]) -> Figure:
    """Return the profiles of every parameter, and below them what the fits leave."""
    names, table = fits[0].problem.names, fits[0].problem.table
    cases = {str(c): case for c, case in enumerate(table.cases)}
    figure = Figure(figsize=(3.1 * max(len(names), len(cases)), 6.2), layout="constrained")
    rows = [[n for n in names for _ in cases], [c for c in cases for _ in names]]
    axes_of: dict[str, Any] = figure.subplot_mosaic(np.array(rows).tolist())
    for k, one in enumerate(fits):
        _draw_profiles([axes_of[name] for name in names], one, COLOURS[k], LOWEST + k * STEP)
    axes_of[names[0]].set_ylabel("rise of S over noise$^2$")
    modes = np.arange(1, table.frequencies.shape[1] + 1)
    for name, axes in axes_of.items():
        axes.grid(alpha=0.25)
        if name in names:
            words, unit = split(name)
            axes.set_xlabel(f"{words.replace('_', ' ')} [{unit}]", fontsize=9)
            axes.tick_params(labelsize=8)
            axes.set_ylim(-0.2 * axes.get_ylim()[1], None)
            axes.axhline(0, color="0.4", lw=0.8)
            continue
        for k, one in enumerate(fits):
            axes.plot(
                modes + 0.12 * (k - 0.5), 100 * one.error[int(name)], ls="none", marker=MARKERS[k],
                color=COLOURS[k], label=one.problem.label,
            )  # fmt: skip
        axes.axhline(0, color="0.4", lw=0.8)
        axes.set_title(cases[name].heading, fontsize=10)
        axes.set_xticks(modes, [f"$f_{i}$" for i in modes])
        axes.set_ylabel("left over [%]")
        axes.margins(y=0.15)
    axes_of["0"].legend(fontsize=8)
    explained = (
        "dots: fitted; grey line: as given; bars: 95 % intervals, thick of a parameter alone, thin "
        "of all together, an arrow where a bound came first"
    )
    figure.suptitle(f"Fits to {table.source}\n{explained}", fontsize=10)
    return figure


def _draw_profiles(above: Sequence[Axes], one: Fit, colour: str, low_down: float) -> None:
    """Draw the profiles, and below them the intervals as bars, `low_down` of the panel's height."""
    # S is all but a parabola: where its root is so far is a smooth curve through what was computed.
    columns = (one.together[:, 0], one.alone[:, 0], one.values, one.alone[:, 1], one.together[:, 1])
    ends = np.stack(columns)
    roots = np.sqrt(one.heights[[1, 0, 0, 0, 1]]) / one.noise * [-1, -1, 0, 1, 1]
    x, (low, high) = one.problem.to_x(ends), one.problem.limits
    within = (x > low) & (x < high)
    each = zip(above, one.intervals(), ends.T, within.T, strict=True)
    for axes, (_, value, given, alone, together, opened), at, inside in each:
        known, first = np.unique(roots[inside], return_index=True)  # of one alone, both are one
        if known.size:
            root = np.linspace(known[0], known[-1], POINTS)
            values = BarycentricInterpolator(known, at[inside][first])(root)
            axes.plot(values, root**2, color=colour, lw=1.4)
        axes.plot(value, 0, "o", color=colour, ms=4, clip_on=False)
        place = axes.get_xaxis_transform()
        bar: dict[str, Any] = {"color": colour, "scaley": False, "transform": place}
        for interval, width in ((alone, 4.5), (together, 1.2)):
            axes.plot(interval, [low_down] * 2, lw=width, solid_capstyle="butt", **bar)
        for end, shut, mark in zip(together, opened, "<>", strict=True):
            if shut:
                axes.plot(end, low_down, mark, ms=4, **bar)
        axes.axvline(given, color="0.5", lw=0.8)
