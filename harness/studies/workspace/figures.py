"""Pictures of the regular workspace and of the frequencies in it: Fig. 6."""

import math
from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from analytic.workspace import boundary
from harness.bench import label
from harness.figures import COLOURS, panels
from harness.signatures import Array
from harness.studies.workspace.checks import ripple
from harness.studies.workspace.map import Grid, Map, Plane

COLOUR_MAP = "viridis"
LEVELS = 10
WIDE = 3  # panels side by side
ACROSS, ALONG = r"$\theta\,\cos\varphi$ [deg]", r"$\theta\,\sin\varphi$ [deg]"


def region_figure(grid: Grid) -> Figure:
    """Return the circles and the cone against height, and each layer's boundary from above."""
    figure = Figure(figsize=(11, 5), layout="constrained")
    side: Any = figure.add_subplot(1, 2, 1)
    above: Any = figure.add_subplot(1, 2, 2, projection="polar")
    circles, cone = grid.region.circles, grid.region.cone
    side.plot(np.degrees(circles.radii), 1000 * circles.z, color="0.2", label="inscribed circles")
    tilt, z = np.degrees(cone.radii), 1000 * cone.z
    side.fill_betweenx(z, tilt, color=COLOURS[0], alpha=0.25, lw=0, label="truncated cone")
    side.plot([0, *tilt, 0], z[[0, 0, 1, 1]], color=COLOURS[0], lw=1)
    azimuth = np.radians(np.arange(0, 361, 1))
    for height, circle, (name, colour) in zip(grid.z, grid.radii, _layers(grid), strict=True):
        edge = boundary(grid.mechanism, height, azimuth, grid.limits)
        radius = float(np.degrees(circle))
        side.plot([0, radius], [1000 * height] * 2, color=colour, lw=1.2)
        above.plot(azimuth, np.degrees(edge), color=colour, lw=1.6, label=name)
        above.plot(azimuth, np.full_like(azimuth, radius), color=colour, lw=0.8, ls="--")
    side.set_xlim(left=0)
    side.set(xlabel="tilt [deg]", ylabel="height $z$ [mm]")
    side.legend(loc="lower right", fontsize=9)
    side.grid(alpha=0.25)
    side.set_title("regular workspace", fontsize=11)
    above.set_title("reachable tilt against azimuth; dashed: inscribed circle", fontsize=11)
    above.set_rlabel_position(22.5)
    above.yaxis.set_major_formatter("{x:.0f}°")
    above.yaxis.set_major_locator(MaxNLocator(4))
    above.legend(loc="center left", bbox_to_anchor=(1.08, 0.5), fontsize=9, title="height $z$")
    return figure


def contour_figure(data: Map[Grid], shown: Sequence[int]) -> Figure:
    """Return filled contours, a row a mode and a column a layer, each with its own scale.

    Seen from above: tilt outwards, azimuth round; the dots stand at the limbs' azimuths.
    """
    title = (
        f"{label(data.answers.model)}: frequencies over azimuth $\\varphi$ and tilt $\\theta$\n"
        "every panel has its own scale; dots: azimuths of the limbs"
    )
    layers = data.grid.z
    figure, grid = panels(title, len(shown), len(layers), (2.6, 3.1), sharex=True, sharey=True)
    rims = np.degrees(np.nanmax(data.grid.tilt, axis=1))
    edge = 1.12 * rims.max()
    towards = data.grid.mechanism.bases[:, :2]
    towards = towards / np.linalg.norm(towards, axis=1, keepdims=True)
    for (row, k), axes in np.ndenumerate(grid):
        drawn = filled(axes, *_disc(data, k, shown[row]))
        bar = colour_bar(figure, drawn, axes, shown[row], pad=0.02)
        bar.ax.tick_params(labelsize=8)
        bar.ax.xaxis.label.set_fontsize(9)
        axes.plot(*(rims[k] * 1.06 * towards.T), ls="none", marker="o", ms=3, color="0.3")
        axes.set(aspect="equal", xlim=(-edge, edge), ylim=(-edge, edge))
        axes.tick_params(labelsize=8, length=0)
        axes.spines[:].set_visible(False)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(MaxNLocator(5, symmetric=True))
    for axes in grid[:, 0]:
        axes.set_ylabel(ALONG, fontsize=9)
    for axes, z in zip(grid[0], layers, strict=True):
        axes.set_title(f"$z$ = {1000 * z:.0f} mm", fontsize=11)
    for axes in grid[-1]:
        axes.set_xlabel(ACROSS, fontsize=9)
    return figure


def surface_figure(data: Map[Grid], shown: Sequence[int]) -> Figure:
    """Return surfaces of frequency over azimuth and tilt: a panel a mode, all layers in each.

    The frequency's axis is logarithmic, so that equal shapes are equal relative changes.
    """
    model = label(data.answers.model)
    title = f"{model}: frequencies by layer, each marked with its height $z$ [mm]"
    kind = {"projection": "3d", "computed_zorder": False}
    figure, every = _beside(title, len(shown), (5.6, 6.1), subplot_kw=kind)
    for axes, i in zip(every, shown, strict=True):
        values = data.frequencies[..., i - 1]
        low, high = np.nanmin(values), np.nanmax(values)
        scale = LogNorm(low, high)
        order = np.argsort(np.nanmean(values, axis=(1, 2)))  # the farthest down are drawn first
        for place, k in enumerate(order.tolist()):
            x, y, f = _disc(data, k, i)
            colours, height = mpl.colormaps[COLOUR_MAP](scale(f)), np.log10(f)
            axes.plot_surface(
                x, y, height, facecolors=colours, rstride=1, cstride=1, lw=0, shade=False,
                antialiased=False, zorder=2 * place, rasterized=True,
            )  # fmt: skip
            edge = np.stack([x[:, -1], y[:, -1], height[:, -1]])
            axes.plot(*edge, color="0.2", lw=0.7, zorder=2 * place + 1)
            right, up, top = edge[:, np.argmax(edge[0] + 0.6 * edge[1])]
            axes.text(1.08 * right, 1.08 * up, top, f"{1000 * data.grid.z[k]:.0f}", fontsize=9,
                      va="center", zorder=100)  # fmt: skip
        axes.set(xlabel=ACROSS, ylabel=ALONG)
        axes.set_zlabel(f"$f_{{{i}}}$ [Hz]", labelpad=8)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(MaxNLocator(4, symmetric=True))
        ticks = MaxNLocator(6, prune="both").tick_values(low, high)
        named = [f"{tick:g}" for tick in ticks]
        axes.set_zticks(np.log10(ticks), named)
        axes.view_init(elev=20, azim=-60)
        axes.set_box_aspect((1, 1, 1.15), zoom=0.92)
        bar = colour_bar(figure, ScalarMappable(scale, COLOUR_MAP), axes, i, shrink=0.7, pad=0.05)
        bar.set_ticks(ticks, labels=named)
        bar.minorticks_off()
    return figure


def ripple_figure(data: Map[Grid], shown: Sequence[int]) -> Figure:
    """Return how far from circularly symmetric each mode is: ripple against tilt, by layer."""
    title = f"{label(data.answers.model)}: ripple round circles of one tilt"
    figure, every = _beside(title, len(shown), (3.8, 3.5), sharey=True)
    wave, tilts = 100 * ripple(data), np.degrees(data.grid.tilt)
    for axes, i in zip(every, shown, strict=True):
        for tilt, own, (name, colour) in zip(tilts, wave, _layers(data.grid), strict=True):
            axes.plot(tilt, own[:, i - 1], color=colour, marker=".", ms=4, lw=1.2, label=name)
        axes.set_title(f"$f_{{{i}}}$", fontsize=11)
        axes.set_xlabel(r"tilt $\theta$ [deg]")
        axes.grid(alpha=0.25)
    for axes in every[::WIDE]:
        axes.set_ylabel("(max - min) / mean over azimuth [%]")
    every[0].legend(fontsize=8, title="height $z$", title_fontsize=8)
    return figure


def plane_figure(data: Map[Plane], shown: Sequence[int]) -> Figure:
    """Return contours over a plane, a panel a mode, each with its own scale."""
    title = f"{label(data.answers.model)}: frequencies of {data.grid.case.name}"
    figure, grid = panels(title, 1, len(shown), (3.4, 3.6))
    for axes, mode in zip(grid[0], shown, strict=True):
        drawn = over_plane(axes, data.grid, data.frequencies[..., mode - 1])
        colour_bar(figure, drawn, axes, mode)
    return figure


def over_plane(axes: Axes, plane: Plane, values: Array) -> Any:
    """Draw contours of `values` (A, R), and what the axes are; return them for a colour bar."""
    closed = [*range(len(plane.direction)), 0]
    x, y = (1000 * getattr(plane.poses, name)[closed] for name in plane.names)
    axes.set(aspect="equal", xlabel=f"${plane.names[0]}$ [mm]", ylabel=f"${plane.names[1]}$ [mm]")
    axes.tick_params(labelsize=8)
    return filled(axes, x, y, values[closed])


def filled(axes: Axes, x: Array, y: Array, f: Array) -> Any:
    """Draw filled contours with lines between, and the rim; return them for a colour bar."""
    masked = np.ma.masked_invalid(f)
    levels = MaxNLocator(LEVELS).tick_values(masked.min(), masked.max())
    drawn = axes.contourf(x, y, masked, levels, cmap=COLOUR_MAP, antialiased=True)
    axes.contour(x, y, masked, levels, colors="white", linewidths=0.4)
    axes.plot(x[:, -1], y[:, -1], color="0.3", lw=0.6)
    return drawn


def colour_bar(figure: Figure, drawn: Any, axes: Axes, mode: int, **how: Any) -> Any:
    """Draw the colour bar of a mode's contours below them, and return it."""
    bar: Any = figure.colorbar(drawn, ax=axes, location="bottom", **{"shrink": 0.85} | how)
    bar.locator = MaxNLocator(4)
    bar.update_ticks()
    bar.set_label(f"$f_{{{mode}}}$ [Hz]")
    return bar


def _layers(grid: Grid) -> list[tuple[str, Any]]:
    """Return every layer's height in words, and its colour."""
    colours = mpl.colormaps[COLOUR_MAP](np.linspace(0.0, 0.9, len(grid.z)))
    return [(f"{1000 * z:.0f} mm", colour) for z, colour in zip(grid.z, colours, strict=True)]


def _beside(title: str, count: int, size: tuple[float, float], **how: Any) -> tuple[Figure, Any]:
    """Return a figure and `count` panels of it, so many side by side as is `WIDE`."""
    figure, grid = panels(title, math.ceil(count / WIDE), min(WIDE, count), size, **how)
    for axes in grid.flat[count:]:
        axes.remove()
    return figure, grid.flat[:count]


def _disc(data: Map[Grid], layer: int, mode: int) -> tuple[Array, Array, Array]:
    """Return x, y [deg] and the frequency of one layer, (A + 1, rings), closed round."""
    rings = np.isfinite(data.grid.tilt[layer])
    tilt = np.degrees(data.grid.tilt[layer, rings])
    azimuth = np.append(data.grid.azimuth, data.grid.azimuth[0] + 2 * np.pi)[:, None]
    f = data.frequencies[layer][:, rings, mode - 1]
    return tilt * np.cos(azimuth), tilt * np.sin(azimuth), np.concatenate([f, f[:1]])
