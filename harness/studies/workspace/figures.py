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
from harness.studies.workspace.map import Grid, Region, WorkspaceMap

COLOUR_MAP = "viridis"
LEVELS = 10
WIDE = 3  # panels side by side


def region_figure(region: Region, grid: Grid) -> Figure:
    """Return the circles and the cone against height, and each layer's boundary from above."""
    figure = Figure(figsize=(11, 5), layout="constrained")
    side: Any = figure.add_subplot(1, 2, 1)
    above: Any = figure.add_subplot(1, 2, 2, projection="polar")
    circles, cone = region.circles, region.cone
    side.plot(np.degrees(circles.radii), 1000 * circles.z, color="0.2", label="inscribed circles")
    tilt, z = np.degrees(cone.radii), 1000 * cone.z
    side.fill_betweenx(z, tilt, color=COLOURS[0], alpha=0.25, lw=0, label="truncated cone")
    side.plot([0, *tilt, 0], z[[0, 0, 1, 1]], color=COLOURS[0], lw=1)
    colours = mpl.colormaps[COLOUR_MAP](np.linspace(0.0, 0.9, len(grid.z)))
    azimuth = np.radians(np.arange(0, 361, 1))
    for height, circle, colour in zip(grid.z, grid.radii, colours, strict=True):
        edge = boundary(region.mechanism, height, azimuth, region.limits)
        radius = float(np.degrees(circle))
        side.plot([0, radius], [1000 * height] * 2, color=colour, lw=1.2)
        above.plot(azimuth, np.degrees(edge), color=colour, lw=1.6, label=f"{1000 * height:.0f} mm")
        above.plot(azimuth, np.full_like(azimuth, radius), color=colour, lw=0.8, ls="--")
    side.set_xlim(left=0)
    side.set_xlabel("tilt [deg]")
    side.set_ylabel("height $z$ [mm]")
    side.legend(loc="lower right", fontsize=9)
    side.grid(alpha=0.25)
    side.set_title("regular workspace", fontsize=11)
    above.set_title("reachable tilt against azimuth; dashed: inscribed circle", fontsize=11)
    above.set_rlabel_position(22.5)
    above.yaxis.set_major_formatter("{x:.0f}°")
    above.yaxis.set_major_locator(MaxNLocator(4))
    above.legend(loc="center left", bbox_to_anchor=(1.08, 0.5), fontsize=9, title="height $z$")
    return figure


def contour_figure(data: WorkspaceMap, shown: Sequence[int]) -> Figure:
    """Return filled contours, a row a mode and a column a layer, each with its own scale.

    Seen from above: tilt outwards, azimuth round; the dots stand at the limbs' azimuths.
    """
    title = (
        f"{label(data.model)}: frequencies over azimuth $\\varphi$ and tilt $\\theta$\n"
        "every panel has its own scale; dots: azimuths of the limbs"
    )
    size = len(shown), len(data.grid.z)
    figure, grid = panels(title, *size, (2.6, 3.1), sharex=True, sharey=True)
    edge = 1.12 * np.degrees(np.nanmax(data.grid.tilt))
    limbs = np.array([limb.base for limb in data.region.mechanism.limbs])
    towards = limbs[:, :2] / np.linalg.norm(limbs[:, :2], axis=1, keepdims=True)
    for row, i in zip(grid, shown, strict=True):
        for k, axes in enumerate(row):
            x, y, f = _disc(data, k, i)
            rim = np.degrees(np.nanmax(data.grid.tilt[k]))
            drawn = filled(axes, x, y, f)
            bar = figure.colorbar(drawn, ax=axes, location="bottom", shrink=0.85, pad=0.02)
            bar.locator = MaxNLocator(4)
            bar.update_ticks()
            bar.ax.tick_params(labelsize=8)
            bar.set_label(f"$f_{{{i}}}$ [Hz]", fontsize=9)
            axes.plot(*(rim * 1.06 * towards.T), ls="none", marker="o", ms=3, color="0.3")
            axes.set(aspect="equal", xlim=(-edge, edge), ylim=(-edge, edge))
            axes.tick_params(labelsize=8, length=0)
            axes.spines[:].set_visible(False)
            axes.xaxis.set_major_locator(MaxNLocator(5, symmetric=True))
            axes.yaxis.set_major_locator(MaxNLocator(5, symmetric=True))
        row[0].set_ylabel(r"$\theta\,\sin\varphi$ [deg]", fontsize=9)
    for k, axes in enumerate(grid[0]):
        axes.set_title(f"$z$ = {1000 * data.grid.z[k]:.0f} mm", fontsize=11)
    for axes in grid[-1]:
        axes.set_xlabel(r"$\theta\,\cos\varphi$ [deg]", fontsize=9)
    return figure


def surface_figure(data: WorkspaceMap, shown: Sequence[int]) -> Figure:
    """Return surfaces of frequency over azimuth and tilt: a panel a mode, all layers in each.

    The frequency's axis is logarithmic, so that equal shapes are equal relative changes.
    """
    title = f"{label(data.model)}: frequencies by layer, each marked with its height $z$ [mm]"
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
            axes.plot(x[:, -1], y[:, -1], height[:, -1], color="0.2", lw=0.7, zorder=2 * place + 1)
            right = int(np.argmax(x[:, -1] + 0.6 * y[:, -1]))
            axes.text(
                1.08 * x[right, -1], 1.08 * y[right, -1], height[right, -1],
                f"{1000 * data.grid.z[k]:.0f}", fontsize=9, va="center", zorder=100,
            )  # fmt: skip
        axes.set_xlabel(r"$\theta\,\cos\varphi$ [deg]")
        axes.set_ylabel(r"$\theta\,\sin\varphi$ [deg]")
        axes.set_zlabel(f"$f_{{{i}}}$ [Hz]", labelpad=8)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(MaxNLocator(4, symmetric=True))
        ticks = MaxNLocator(6, prune="both").tick_values(low, high)
        axes.set_zticks(np.log10(ticks), [f"{tick:g}" for tick in ticks])
        axes.view_init(elev=20, azim=-60)
        axes.set_box_aspect((1, 1, 1.15), zoom=0.92)
        bar = figure.colorbar(
            ScalarMappable(scale, COLOUR_MAP), ax=axes, location="bottom", shrink=0.7, pad=0.05
        )
        bar.set_ticks(ticks, labels=[f"{tick:g}" for tick in ticks])
        bar.minorticks_off()
        bar.set_label(f"$f_{{{i}}}$ [Hz]")
    return figure


def ripple_figure(data: WorkspaceMap, shown: Sequence[int]) -> Figure:
    """Return how far from circularly symmetric each mode is: ripple against tilt, by layer."""
    title = f"{label(data.model)}: ripple round circles of one tilt"
    figure, every = _beside(title, len(shown), (3.8, 3.5), sharey=True)
    colours = mpl.colormaps[COLOUR_MAP](np.linspace(0.0, 0.9, len(data.grid.z)))
    wave = 100 * ripple(data)
    for axes, i in zip(every, shown, strict=True):
        for k, colour in enumerate(colours):
            tilt = np.degrees(data.grid.tilt[k])
            height = f"{1000 * data.grid.z[k]:.0f} mm"
            axes.plot(tilt, wave[k, :, i - 1], color=colour, marker=".", ms=4, lw=1.2, label=height)
        axes.set_title(f"$f_{{{i}}}$", fontsize=11)
        axes.set_xlabel(r"tilt $\theta$ [deg]")
        axes.grid(alpha=0.25)
    for axes in every[::WIDE]:
        axes.set_ylabel("(max - min) / mean over azimuth [%]")
    every[0].legend(fontsize=8, title="height $z$", title_fontsize=8)
    return figure


def _beside(title: str, count: int, size: tuple[float, float], **how: Any) -> tuple[Figure, Any]:
    """Return a figure and `count` panels of it, so many side by side as is `WIDE`."""
    figure, grid = panels(title, math.ceil(count / WIDE), min(WIDE, count), size, **how)
    for axes in grid.flat[count:]:
        axes.remove()
    return figure, grid.flat[:count]


def _disc(data: WorkspaceMap, layer: int, mode: int) -> tuple[Array, Array, Array]:
    """Return x, y [deg] and the frequency of one layer, (A + 1, rings), closed round."""
    rings = np.isfinite(data.grid.tilt[layer])
    tilt = np.degrees(data.grid.tilt[layer, rings])
    azimuth = np.append(data.grid.azimuth, data.grid.azimuth[0] + 2 * np.pi)[:, None]
    f = data.frequencies[layer][:, rings, mode - 1]
    return tilt * np.cos(azimuth), tilt * np.sin(azimuth), np.concatenate([f, f[:1]])


def filled(axes: Axes, x: Array, y: Array, f: Array) -> Any:
    """Draw filled contours with lines between, and the rim; return them for a colour bar."""
    masked = np.ma.masked_invalid(f)
    levels = MaxNLocator(LEVELS).tick_values(masked.min(), masked.max())
    drawn = axes.contourf(x, y, masked, levels, cmap=COLOUR_MAP, antialiased=True)
    axes.contour(x, y, masked, levels, colors="white", linewidths=0.4)
    axes.plot(x[:, -1], y[:, -1], color="0.3", lw=0.6)
    return drawn
