"""The paper's two statements on Fig. 6, checked: circular symmetry, and height."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analytic import Pose, reachable
from harness.bench import label
from harness.poses import named
from harness.signatures import Array
from harness.studies.workspace.map import ORDER, Region, WorkspaceMap, limits_met, limits_said
from harness.tables import Cell, Number, Table

ROUNDING = 1e-9
"""Relative differences below this are the solvers' own."""
SAMPLES = 20_000
"""Random poses by which the cone is checked to be reachable between its layers."""


def ripple(data: WorkspaceMap) -> Array:
    """Return (max - min) / mean over azimuth, shape (n, T, count); NaN where a value is missing."""
    f = data.frequencies
    return np.asarray((f.max(axis=1) - f.min(axis=1)) / f.mean(axis=1))


def largest_ripple(data: WorkspaceMap) -> Array:
    """Return each mode's largest ripple over complete circles, (count,); NaN without any."""
    rings = ripple(data)[:, 1:]  # a level platform has no azimuth
    complete = np.isfinite(rings).all(axis=-1)
    nothing = np.full(rings.shape[-1], np.nan)
    return np.asarray(rings[complete].max(axis=0)) if complete.any() else nothing


def turned(data: WorkspaceMap, turns: int) -> float:
    """Return the largest relative change when the azimuth turns by 360 / `turns` degrees."""
    f = data.frequencies
    return _largest(f, np.roll(f, f.shape[1] // turns, axis=1))


def mirrored(data: WorkspaceMap) -> float:
    """Return the largest relative change when the azimuth is mirrored about the first limb."""
    f = data.frequencies
    return _largest(f, f[:, -np.arange(f.shape[1])])


def _largest(f: Array, g: Array) -> float:
    change = np.abs(g - f) / f
    return float(change[np.isfinite(change)].max(initial=0.0))


def region_table(region: Region, data: WorkspaceMap, shown: Sequence[int]) -> Table:
    """Return each layer's circle, what limits it, the cone, and the range of frequencies in it."""
    grid, limits = data.grid, region.limits
    rows: list[tuple[Cell, ...]] = []
    for k, z in enumerate(grid.z):
        cone = np.degrees(region.cone.radius(z))
        cells: list[Cell] = [Number(1000 * z, 1), Number(np.degrees(grid.radii[k]), 3)]
        cells += [Number(float(cone), 3) if cone > 0 else ""]
        cells += [limits_met(region.mechanism, limits, Pose(z, grid.touch[k], grid.radii[k]))]
        f = data.frequencies[k]
        for i in shown:
            found = f[..., i - 1][np.isfinite(f[..., i - 1])]
            cells += [Number(found.min(), 2), Number(found.max(), 2)] if found.size else ["", ""]
        rows.append(tuple(cells))
    said = limits_said(region.mechanism, limits)
    if limits.x is not None:
        said += f"; x = {1000 * limits.x:g} mm, y = {1000 * (limits.y or 0.0):g} mm everywhere"
    notes = (
        said,
        "circle: largest tilt that every azimuth reaches; cone: the truncated cone's at that z",
        ORDER,
    )
    columns = ("z [mm]", "circle [deg]", "cone [deg]", "limited by")
    bounds = tuple(f"f{i} {end} [Hz]" for i in shown for end in ("min", "max"))
    return Table(f"Regular workspace: {label(data.model)}", (*columns, *bounds), tuple(rows), notes)


def symmetry_table(data: WorkspaceMap, shown: Sequence[int]) -> Table:
    """Return the azimuthal ripple of each mode: largest, where, and at half the rim there."""
    wave = ripple(data)
    rows: list[tuple[Cell, ...]] = []
    for i in shown:
        mode = wave[..., i - 1]
        if not np.isfinite(mode[:, 1:]).any():
            rows.append((f"f{i}", "", "", "", ""))
            continue
        k, j = (int(n) for n in np.unravel_index(np.nanargmax(mode), mode.shape))
        tilts = data.grid.tilt[k, : j + 1]
        half = np.interp(tilts[-1] / 2, tilts, mode[k, : j + 1])
        z, tilt = 1000 * data.grid.z[k], np.degrees(tilts[-1])
        cells = (Number(100 * mode[k, j], 3), Number(z, 1), Number(tilt, 2))
        rows.append((f"f{i}", *cells, Number(100 * float(half), 3)))
    columns = ("Mode", "ripple [%]", "at z [mm]", "and tilt [deg]", "at half that tilt [%]")
    limbs = len(data.region.mechanism.limbs)
    notes = (
        "ripple: (largest - smallest) / mean over azimuth, at one tilt and height",
        f"turn by {360 / limbs:g} deg: no frequency changes by more than {turned(data, limbs):.1e}",
        f"mirror about the first limb: no frequency changes by more than {mirrored(data):.1e}",
    )
    return Table(f"Circular symmetry: {label(data.model)}", columns, tuple(rows), notes)


def rises(data: WorkspaceMap) -> tuple[Array, NDArray[np.bool_]]:
    """Return the relative change from each layer to the next at the same azimuth and tilt.

    Shape (n - 1, A, T, count), NaN where either is missing; and whether a (A, T, count) column
    could be checked at all.
    """
    f = np.where(data.grid.shared[:, None, :, None], data.frequencies, np.nan)
    f[:, 1:, 0] = np.nan  # the level pose counts once
    change = np.diff(f, axis=0) / f[:-1]
    return change, np.asarray(np.isfinite(change).any(axis=0))


def height_table(data: WorkspaceMap, shown: Sequence[int]) -> Table:
    """Return, for each mode, how many (azimuth, tilt) fall with height throughout, or where not."""
    change, checked = rises(data)
    per_ten = change / np.diff(data.grid.z)[:, None, None, None] * 0.01
    rows: list[tuple[Cell, ...]] = []
    for i in shown:
        mode, slope = change[..., i - 1], per_ten[..., i - 1]
        falling = checked[..., i - 1] & ~(mode >= 0).any(axis=0)
        columns = int(checked[..., i - 1].sum())
        slowest, where = "", ""
        if columns:
            k, a, t = (int(n) for n in np.unravel_index(np.nanargmax(slope), slope.shape))
            slowest = f"{100 * slope[k, a, t]:+.3f}"
            pose = data.grid.pose(k, a, t)
            where = f"{named(pose)}, to {1000 * data.grid.z[k + 1]:.1f} mm"
        rows.append((f"f{i}", columns, int(falling.sum()), slowest, where))
    heights = 1000 * data.grid.z
    columns_ = ("Mode", "(azimuth, tilt)", "falling throughout", "slowest [%/10 mm]", "where")
    notes = (
        f"{len(heights)} layers from {heights[0]:.1f} to {heights[-1]:.1f} mm, each compared with "
        "the next at the azimuths and tilts inside both their circles",
        ORDER,
    )
    return Table(f"Frequency against height: {label(data.model)}", columns_, tuple(rows), notes)


def verdicts(region: Region, data: WorkspaceMap, shown: Sequence[int]) -> list[str]:
    """Return the region and the paper's two statements in plain sentences."""
    low, high = 1000 * region.cone.z
    start, end = np.degrees(region.cone.radii)
    bottom, top = 1000 * region.circles.z[[0, -1]]
    inside = reachable(region.mechanism, region.cone.random(SAMPLES, 0), region.limits).sum()
    lines = [
        f"The level platform reaches z = {bottom:.1f} to {top:.1f} mm. The largest truncated cone "
        f"in its inscribed circles reaches a tilt of {start:.2f} deg at {low:.1f} mm and "
        f"{end:.2f} deg at {high:.1f} mm; {inside} of {SAMPLES} random poses in it are reachable."
    ]
    return [*lines, _symmetry(data, shown), _height(data, shown)]


def _symmetry(data: WorkspaceMap, shown: Sequence[int]) -> str:
    said = '"Circularly symmetrical"'
    most = largest_ripple(data)
    if not np.isfinite(most).all():
        return f"{said}: not checked, for no circle of one tilt is complete."
    largest = {i: float(most[i - 1]) for i in shown}
    limbs = len(data.region.mechanism.limbs)
    change = turned(data, limbs)
    if max(largest.values()) < ROUNDING:
        return f"{said}: yes, to {max(largest.values()):.1e}."
    sizes = ", ".join(f"f{i} by {100 * size:.2f} %" for i, size in largest.items())
    vary = f"round a circle of one tilt they vary: up to {sizes}"
    turn = f"{360 / limbs:g}"
    # A simulator's own scatter is far below the ripple, not zero.
    if change > 1e-3 * max(largest.values()):
        return f"{said}: no. A turn of {turn} deg changes frequencies by {change:.1e}; {vary}."
    return (
        f"{said}: only {turn}-degree periodic. That turn changes no frequency by more than "
        f"{change:.1e}, but {vary}."
    )


def _height(data: WorkspaceMap, shown: Sequence[int]) -> str:
    change, checked = rises(data)
    said = '"The increased platform height decreases the natural frequency"'
    modes = [i - 1 for i in shown]
    rising = np.argwhere((change[..., modes] >= 0).transpose(3, 0, 1, 2))
    total = int(np.isfinite(change[..., modes]).sum())
    if not total:
        return f"{said}: not checked, for no two layers share a pose."
    if not len(rising):
        columns = int(checked[..., modes].sum())
        return f"{said}: yes, in all {total} steps of {columns} columns of poses."
    m, k, a, t = rising[0]
    pose = data.grid.pose(k, a, t)
    step = f"{named(pose)}, to z = {1000 * data.grid.z[k + 1]:.1f} mm"
    return f"{said}: not in {len(rising)} of {total} steps; first f{shown[m]} at {step}."
