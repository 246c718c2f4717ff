"""Poses as columns, in words, and from numbers by name: one way for all tables and files."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
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
    twisted = any(np.any(pose.torsion) for pose in some)
    placed = any(pose.x is not None for pose in some)
    z, azimuth, tilt, torsion, *across = COLUMNS
    return (z, azimuth, tilt, *([torsion] if twisted else ()), *(across if placed else ()))


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
    given = {"z": 0.0, **values}
    if not turns:
        return Pose(**given)
    *at, yaw, pitch, roll = np.broadcast_arrays(
        *(given.get(name, 0.0) for name in ("x", "y", "z", *TURNS))
    )
    found = Pose.at(np.stack(at, -1), turn(2, yaw) @ turn(1, pitch) @ turn(0, roll))
    if "x" in given and "y" in given:
        return found
    return replace(found, x=given.get("x"), y=given.get("y"))


def turn(axis: int, angle: Any) -> Any:
    """Return the rotation (..., 3, 3) by `angle` (...) [rad] about a coordinate axis."""
    c, s = np.cos(angle), np.sin(angle)
    R = np.zeros((*np.shape(angle), 3, 3))
    R[..., 0, 0] = 1.0
    R[..., 1, 1] = R[..., 2, 2] = c
    R[..., 2, 1], R[..., 1, 2] = s, -s
    return np.roll(R, axis, (-2, -1))


def turned(pose: Pose, angle: float) -> Pose:
    """Return the pose of a mechanism turned by `angle` about z [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    x, y = pose.x, pose.y
    across = {} if x is None else {"x": c * x - s * y, "y": s * x + c * y}
    return replace(pose, azimuth=pose.azimuth + angle, **across)


def named(pose: Pose) -> str:
    """Return one pose in words."""
    return words(*columns(pose).values())


def words(*values: float | None) -> str:
    """Return one pose in words, from its `COLUMNS`."""
    given = dict(zip(COLUMNS.values(), values, strict=True))
    if None in (given["z"], given["azimuth"], given["tilt"]):
        return "no pose"
    given["torsion"] = given["torsion"] or None  # 0 is none
    return ", ".join(
        f"{name} = {1000 * v:.6g} mm" if name in LENGTHS else f"{name} {np.degrees(v):.6g} deg"
        for name in ("x", "y", "z", "azimuth", "tilt", "torsion")
        if (v := given[name]) is not None
    )


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
