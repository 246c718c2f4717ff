"""The paper's two statements on Fig. 6, checked: circular symmetry, and height."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from analytic import Pose, reachable
from harness.bench import label
from harness.columns import laid_out
from harness.compare import at
from harness.poses import named
from harness.signatures import Array
from harness.studies.workspace.map import Flags, Grid, Map, limits_met, limits_said
from harness.tables import Row, Table

ORDER = "modes are numbered by order, from the lowest: where two cross, they change places"
ROUNDING = 1e-9
"""Relative differences below this are the solvers' own."""
SAMPLES = 20_000
"""Random poses by which the cone is checked to be reachable between its layers."""


def ripple(data: Map[Grid]) -> Array:
    """Return (max - min) / mean over azimuth, shape (n, T, count); NaN where a value is missing."""
    f = data.frequencies
    return np.asarray((f.max(axis=1) - f.min(axis=1)) / f.mean(axis=1))


def largest_ripple(data: Map[Grid]) -> Array:
    """Return each mode's largest ripple over complete circles, (count,); NaN without any."""
    rings = ripple(data)[:, 1:]  # a level platform has no azimuth
    complete = rings[np.isfinite(rings).all(axis=-1)]
    return complete.max(axis=0) if len(complete) else np.full(rings.shape[-1], np.nan)


def turned(data: Map[Grid], turns: int) -> float:
    """Return the largest relative change when the azimuth turns by 360 / `turns` degrees."""
    azimuths = np.arange(data.frequencies.shape[1])
    return _changed(data, azimuths - len(azimuths) // turns)


def mirrored(data: Map[Grid]) -> float:
    """Return the largest relative change when the azimuth is mirrored about the first limb."""
    return _changed(data, -np.arange(data.frequencies.shape[1]))


def _changed(data: Map[Grid], azimuths: Any) -> float:
    f = data.frequencies
    change = np.abs(f[:, azimuths] - f) / f
    return float(change[np.isfinite(change)].max(initial=0.0))


def region_table(data: Map[Grid], shown: Sequence[int]) -> Table:
    """Return each layer's circle, what limits it, the cone, and the range of frequencies in it."""
    grid, rows = data.grid, list[Any]()
    mechanism, limits = grid.mechanism, grid.limits
    for z, radius, touch, f in zip(grid.z, grid.radii, grid.touch, data.frequencies, strict=True):
        cone = np.degrees(grid.region.cone.radius(z))
        met = limits_met(mechanism, limits, Pose(z, touch, radius))
        known = at(f[np.isfinite(f[..., 0])], shown)
        ends: Any = [""] * 2 * len(shown)
        if len(known):
            ends = np.stack([known.min(axis=0), known.max(axis=0)], axis=1).ravel()
        there = (1000 * z, np.degrees(radius), cone if cone > 0 else "", met)
        rows.append((*there, *ends))
    said = limits_said(mechanism, limits)
    if limits.x is not None:
        said += f"; x = {1000 * limits.x:g} mm, y = {1000 * (limits.y or 0.0):g} mm everywhere"
    columns = {"z [mm]": 1, "circle [deg]": 3, "cone [deg]": 3, "limited by": None}
    columns |= {f"f{i} {end} [Hz]": 2 for i in shown for end in ("min", "max")}
    notes = (
        said,
        "circle: largest tilt that every azimuth reaches; cone: the truncated cone's at that z",
        ORDER,
    )
    return laid_out(f"Regular workspace: {label(data.answers.model)}", columns, rows, notes)


def symmetry_table(data: Map[Grid], shown: Sequence[int]) -> Table:
    """Return the azimuthal ripple of each mode: largest, where, and at half the rim there."""
    rows = list[Row]()
    for i, wave in zip(shown, np.moveaxis(at(ripple(data), shown), -1, 0), strict=True):
        if not np.isfinite(wave[:, 1:]).any():
            rows.append((f"f{i}", "", "", "", ""))
            continue
        k, j = np.unravel_index(np.nanargmax(wave), wave.shape)
        tilts, own = data.grid.tilt[k, : j + 1], wave[k, : j + 1]
        half = np.interp(tilts[-1] / 2, tilts, own)
        z, tilt = 1000 * data.grid.z[k], np.degrees(tilts[-1])
        rows.append((f"f{i}", 100 * own[-1], z, tilt, 100 * half))
    columns = dict.fromkeys(("Mode",)) | {"ripple [%]": 3, "at z [mm]": 1}
    columns |= {"and tilt [deg]": 2, "at half that tilt [%]": 3}
    limbs = len(data.grid.mechanism.limbs)
    notes = (
        "ripple: (largest - smallest) / mean over azimuth, at one tilt and height",
        f"turn by {360 / limbs:g} deg: no frequency changes by more than {turned(data, limbs):.1e}",
        f"mirror about the first limb: no frequency changes by more than {mirrored(data):.1e}",
    )
    return laid_out(f"Circular symmetry: {label(data.answers.model)}", columns, rows, notes)


def rises(data: Map[Grid]) -> tuple[Array, Flags]:
    """Return the relative change from each layer to the next at the same azimuth and tilt.

    Shape (n - 1, A, T, count), NaN where either is missing; and whether a (A, T, count) column
    could be checked at all.
    """
    f = np.where(data.grid.shared[:, None, :, None], data.frequencies, np.nan)
    f[:, 1:, 0] = np.nan  # the level pose counts once
    change = np.diff(f, axis=0) / f[:-1]
    return change, np.asarray(np.isfinite(change).any(axis=0))


def height_table(data: Map[Grid], shown: Sequence[int]) -> Table:
    """Return, for each mode, how many (azimuth, tilt) fall with height throughout, or where not."""
    grid, (change, checked), rows = data.grid, rises(data), list[Row]()
    for i in shown:
        mode, columns = change[..., i - 1], checked[..., i - 1]
        falling = columns & ~(mode >= 0).any(axis=0)
        slowest, where = "", ""
        if columns.any():
            slope = mode / np.diff(grid.z)[:, None, None] * 0.01
            k, a, t = np.unravel_index(np.nanargmax(slope), slope.shape)
            slowest = f"{100 * slope[k, a, t]:+.3f}"
            where = f"{named(grid.poses[k, a, t])}, to {1000 * grid.z[k + 1]:.1f} mm"
        rows.append((f"f{i}", int(columns.sum()), int(falling.sum()), slowest, where))
    z = 1000 * grid.z
    heads = ("Mode", "(azimuth, tilt)", "falling throughout", "slowest [%/10 mm]", "where")
    notes = (
        f"{len(z)} layers from {z[0]:.1f} to {z[-1]:.1f} mm, each compared with the next at the "
        "azimuths and tilts inside both their circles",
        ORDER,
    )
    title = f"Frequency against height: {label(data.answers.model)}"
    return Table(title, heads, rows, notes)


def verdicts(data: Map[Grid], shown: Sequence[int]) -> list[str]:
    """Return the region and the paper's two statements in plain sentences."""
    region = data.grid.region
    low, high = 1000 * region.cone.z
    start, end = np.degrees(region.cone.radii)
    bottom, top = 1000 * region.circles.z[[0, -1]]
    inside = reachable(region.mechanism, region.cone.random(SAMPLES, 0), region.limits).sum()
    return [
        f"The level platform reaches z = {bottom:.1f} to {top:.1f} mm. The largest truncated cone "
        f"in its inscribed circles reaches a tilt of {start:.2f} deg at {low:.1f} mm and "
        f"{end:.2f} deg at {high:.1f} mm; {inside} of {SAMPLES} random poses in it are reachable.",
        f'"Circularly symmetrical": {_symmetry(data, shown)}',
        f'"The increased platform height decreases the natural frequency": {_height(data, shown)}',
    ]


def _symmetry(data: Map[Grid], shown: Sequence[int]) -> str:
    most = largest_ripple(data)
    if not np.isfinite(most).all():
        return "not checked, for no circle of one tilt is complete."
    largest, limbs = at(most, shown), len(data.grid.mechanism.limbs)
    if largest.max() < ROUNDING:
        return f"yes, to {largest.max():.1e}."
    sizes = (f"f{i} by {100 * size:.2f} %" for i, size in zip(shown, largest, strict=True))
    vary = f"round a circle of one tilt they vary: up to {', '.join(sizes)}"
    turn, change = f"{360 / limbs:g}", turned(data, limbs)
    # A simulator's own scatter is far below the ripple, not zero.
    if change > 1e-3 * largest.max():
        return f"no. A turn of {turn} deg changes frequencies by {change:.1e}; {vary}."
    return (
        f"only {turn}-degree periodic. That turn changes no frequency by more than {change:.1e}, "
        f"but {vary}."
    )


def _height(data: Map[Grid], shown: Sequence[int]) -> str:
    change, checked = (values[..., np.array(shown) - 1] for values in rises(data))
    rising = np.argwhere(np.moveaxis(change >= 0, -1, 0)).tolist()
    total = int(np.isfinite(change).sum())
    if not total:
        return "not checked, for no two layers share a pose."
    if not rising:
        return f"yes, in all {total} steps of {int(checked.sum())} columns of poses."
    m, k, a, t = rising[0]
    step = f"{named(data.grid.poses[k, a, t])}, to z = {1000 * data.grid.z[k + 1]:.1f} mm"
    return f"not in {len(rising)} of {total} steps; first f{shown[m]} at {step}."
