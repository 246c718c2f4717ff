"""Poses as columns, in words, and from numbers by name: one way for all tables and files."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from analytic import InputError, Pose
from harness.tables import Cell, Number

COLUMNS = {
    "z_m": "z", "azimuth_rad": "azimuth", "tilt_rad": "tilt",
    "torsion_rad": "torsion", "x_m": "x", "y_m": "y",
}  # fmt: skip
"""Columns of a pose, SI, and which number of it each holds; the last three where there are any."""
TURNS = "yaw", "pitch", "roll"
"""About z, then the new y, then the new x: what may stand for azimuth, tilt and torsion."""
NAMES = (*COLUMNS.values(), *TURNS)
"""All that a pose may be stated by; lengths are z, x and y."""
LENGTHS = "z", "x", "y"


def columns(pose: Pose) -> dict[str, Any]:
    """Return a pose's numbers, or arrays of them, by column: None where the hinges say x and y."""
    return {column: getattr(pose, name) for column, name in COLUMNS.items()}


def used(poses: Iterable[Pose]) -> tuple[str, ...]:
    """Return the columns that say something of any of some poses: without torsion that is 0."""
    some = list(poses)
    more = {
        "torsion_rad": any(np.any(pose.torsion) for pose in some),
        "x_m": any(pose.x is not None for pose in some),
        "y_m": any(pose.y is not None for pose in some),
    }
    return tuple(column for column in COLUMNS if more.get(column, True))


def stated(values: Mapping[str, Any]) -> Pose:
    """Return the pose, or poses, of numbers by `NAMES`, SI; angles that are left out are 0.

    Without x and y the hinges say them; with both z may be left out too, and is 0. Raises
    `InputError` for a height or a half of x and y that is missing, or turns of both kinds.
    """
    turns = [name for name in TURNS if name in values]
    others = [name for name in ("azimuth", "tilt", "torsion") if name in values]
    if turns and others:
        raise InputError("pose", f"{turns[0]}, {others[0]}", "angles of one kind")
    if "z" not in values and not ("x" in values and "y" in values):
        raise InputError("pose", ", ".join(values), "z, or x and y")
    given = {"z": 0.0} | dict(values)
    if not turns:
        return Pose(**given)
    shape = np.broadcast_shapes(*(np.shape(value) for value in given.values()))
    yaw, pitch, roll = (np.broadcast_to(given.get(name, 0.0), shape) for name in TURNS)
    at = np.stack([np.broadcast_to(given.get(name, 0.0), shape) for name in ("x", "y", "z")], -1)
    found = Pose.at(at, turn(2, yaw) @ turn(1, pitch) @ turn(0, roll))
    if "x" in given and "y" in given:
        return found
    return Pose(found.z, found.azimuth, found.tilt, found.torsion, given.get("x"), given.get("y"))


def turn(axis: int, angle: Any) -> Any:
    """Return the rotation (..., 3, 3) by `angle` (...) [rad] about a coordinate axis."""
    c, s = np.cos(angle), np.sin(angle)
    R = np.zeros((*np.shape(angle), 3, 3))
    first, second = (axis + 1) % 3, (axis + 2) % 3
    R[..., axis, axis] = 1.0
    R[..., first, first] = R[..., second, second] = c
    R[..., second, first], R[..., first, second] = s, -s
    return R


def turned(pose: Pose, angle: float) -> Pose:
    """Return the pose of a mechanism turned by `angle` about z [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    x, y = pose.x, pose.y
    across = (None, None) if x is None else (c * x - s * y, s * x + c * y)
    return Pose(pose.z, pose.azimuth + angle, pose.tilt, pose.torsion, *across)


def named(pose: Pose) -> str:
    """Return one pose in words."""
    return words(**columns(pose))


def words(
    z_m: float | None,
    azimuth_rad: float | None,
    tilt_rad: float | None,
    torsion_rad: float | None = None,
    x_m: float | None = None,
    y_m: float | None = None,
) -> str:
    """Return one pose in words, from its columns."""
    if z_m is None or azimuth_rad is None or tilt_rad is None:
        return "no pose"
    place = [f"{name} = {1000 * v:.6g} mm" for name, v in (("x", x_m), ("y", y_m)) if v is not None]
    place.append(f"z = {1000 * z_m:.6g} mm")
    place += [f"azimuth {np.degrees(azimuth_rad):.6g} deg", f"tilt {np.degrees(tilt_rad):.6g} deg"]
    if torsion_rad:
        place.append(f"torsion {np.degrees(torsion_rad):.6g} deg")
    return ", ".join(place)


def headings(shown: Iterable[str]) -> tuple[str, ...]:
    """Return what a table calls some of `COLUMNS`."""
    return tuple(
        f"{COLUMNS[column]} [{'mm' if column.endswith('_m') else 'deg'}]" for column in shown
    )


def cells(values: Mapping[str, Any], shown: Iterable[str], digits: int = 2) -> tuple[Cell, ...]:
    """Return one pose, by column, as cells under `headings`; empty where hinges say it."""
    units = {column: 1000 if column.endswith("_m") else np.degrees(1) for column in shown}
    return tuple(
        "" if values[column] is None else Number(float(values[column] * unit), digits)
        for column, unit in units.items()
    )
