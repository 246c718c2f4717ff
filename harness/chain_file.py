"""Mechanisms of any chain from a TOML file, in the units that the keys say.

[rods]
leg = {material = "steel", diameter_mm = 40, bore_mm = 20}

[[mechanisms.mine.limbs]]
copies = 3
base_mm = {radius = 600, angle_deg = -12}
platform_point_mm = [380, 0, 0]
chain = [{joint = "U", axis = "tangential"}, {rod = "leg"}, {joint = "S"}]
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from analytic import (
    Body,
    Freedom,
    InputError,
    Joint,
    Limb,
    Link,
    Material,
    Mechanism,
    Platform,
    Pose,
    Rod,
    Section,
)
from analytic.errors import count, number, unknown, vector
from harness.poses import LENGTHS, NAMES, stated, turn

Table = dict[str, Any]
Three = tuple[float, float, float]

SECTION = "area_mm2", "second_moments_mm4", "torsion_constant_mm4", "shear_coefficients"
UNITS = {
    "mm": "millimetres", "deg": "degrees", "GPa": "gigapascals", "kg_m3": "kg/m^3",
    "kg": "kilograms",
}  # fmt: skip
"""What the ends of keys mean."""
JOINTS = "R", "U", "S", "P", "fixed"
DEGREES = math.pi / 180


def only(table: Any, where: str, *keys: str) -> Table:
    """Return `table` if it is one with no other keys, or raise `InputError`."""
    if not isinstance(table, dict):
        raise InputError(where, table, f"a table with the keys {', '.join(keys)}")
    for key in table:
        if key not in keys:
            raise InputError(where, key, f"only the keys {', '.join(dict.fromkeys(keys))}")
    return table


def get(
    table: Table, where: str, key: str, default: float | None = None, *, positive: bool = False
) -> float:
    """Return a number of a table, or `default`; raises `InputError` naming the key."""
    if key not in table and default is not None:
        return default
    unit = next((f" of {words}" for end, words in UNITS.items() if key.endswith(f"_{end}")), "")
    expected = f"a {'positive' if positive else 'finite'} number{unit}"
    return number(f"{where}.{key}", table.get(key), expected, positive=positive)


def one_of(name: Any, where: str, known: Mapping[str, Any]) -> Any:
    """Return what is known by a name; raises `InputError` naming what there is."""
    if not isinstance(name, str):
        raise InputError(where, name, f"one of {', '.join(known)}")
    if name not in known:
        raise unknown(where, name, known)
    return known[name]


def materials(tables: Mapping[str, Table]) -> dict[str, Material]:
    """Return the materials of [materials.NAME]."""
    found = {}
    for name, table in tables.items():
        where = f"materials.{name}"
        only(table, where, "young_GPa", "shear_GPa", "density_kg_m3")
        found[name] = Material(
            get(table, where, "young_GPa") * 1e9,
            get(table, where, "shear_GPa") * 1e9,
            get(table, where, "density_kg_m3"),
        )
    return found


def rods(tables: Mapping[str, Table], known: Mapping[str, Material]) -> dict[str, Rod]:
    """Return the rods of [rods], each of a known material; round ones or by section constants."""
    found = {}
    for name, table in tables.items():
        where = f"rods.{name}"
        only(table, where, "material", "diameter_mm", "bore_mm", *SECTION)
        material = one_of(table.get("material"), f"{where}.material", known)
        if "diameter_mm" in table:
            bore = get(table, where, "bore_mm", 0.0) / 1000
            section = Section.round(get(table, where, "diameter_mm") / 1000, bore)
        else:
            second = table.get("second_moments_mm4", ())
            if not isinstance(second, list) or len(second) != 2:
                raise InputError(f"{where}.second_moments_mm4", second, "two numbers, Ix and Iy")
            kappas = table.get("shear_coefficients")
            section = Section(
                get(table, where, "area_mm2") * 1e-6,
                (float(second[0]) * 1e-12, float(second[1]) * 1e-12),
                get(table, where, "torsion_constant_mm4") * 1e-12,
                tuple(kappas) if isinstance(kappas, list) else kappas,
            )
        found[name] = Rod(material, section)
    return found


def chain_mechanism(table: Table, where: str, known: Mapping[str, Rod]) -> Mechanism:
    """Return a mechanism of [mechanisms.NAME] with [[mechanisms.NAME.limbs]]."""
    only(table, where, "platform", "payloads", "limbs")
    limbs: list[Limb] = []
    for k, limb in enumerate(table["limbs"]):
        limbs += _limbs(limb, f"{where}.limbs[{k}]", known)
    platform = _platform(table.get("platform"), f"{where}.platform")
    for k, load in enumerate(table.get("payloads", [])):
        at = f"{where}.payloads[{k}]"
        only(load, at, "mass_kg", "centre_mm", "inertia_kg_m2")
        own = load.get("inertia_kg_m2")
        platform = platform.carrying(
            get(load, at, "mass_kg"),
            _metres(load.get("centre_mm", [0, 0, 0]), f"{at}.centre_mm"),
            None if own is None else _tensor(own, f"{at}.inertia_kg_m2"),
        )
    return Mechanism(tuple(limbs), platform)


def _platform(table: Any, where: str) -> Platform:
    only(
        table, where, "radius_mm", "thickness_mm", "density_kg_m3", "mass_kg", "centre_mm",
        "inertia_kg_m2",
    )  # fmt: skip
    if "mass_kg" in table:
        return Platform(
            get(table, where, "mass_kg"),
            _tensor(table.get("inertia_kg_m2"), f"{where}.inertia_kg_m2"),
            centre=_metres(table.get("centre_mm", [0, 0, 0]), f"{where}.centre_mm"),
        )
    return Platform.disc(
        get(table, where, "radius_mm") / 1000,
        get(table, where, "thickness_mm") / 1000,
        get(table, where, "density_kg_m3"),
    )


def _limbs(table: Any, where: str, known: Mapping[str, Rod]) -> list[Limb]:
    only(table, where, "copies", "base_mm", "platform_point_mm", "chain", "reference", "stroke_mm")
    base = _metres(table.get("base_mm"), f"{where}.base_mm")
    items = table.get("chain")
    if not isinstance(items, list):
        raise InputError(f"{where}.chain", items, "a list of joints, rods, links and bodies")
    chain = tuple(_item(item, f"{where}.chain[{k}]", base, known) for k, item in enumerate(items))
    reference = table.get("reference")
    if reference is not None:
        reference = _direction(reference, f"{where}.reference", base)
    point = _metres(table.get("platform_point_mm"), f"{where}.platform_point_mm")
    stroke = table.get("stroke_mm")
    if stroke is not None:
        expected = "the least and the largest of two lengths in millimetres"
        if not isinstance(stroke, list) or len(stroke) != 2:
            raise InputError(f"{where}.stroke_mm", stroke, expected)
        low, high = (number(f"{where}.stroke_mm", v, expected) / 1000 for v in stroke)
        if not low < high:
            raise InputError(f"{where}.stroke_mm", stroke, expected)
        stroke = low, high
    limb = Limb(base, point, chain, reference, stroke)
    copies = count(f"{where}.copies", table.get("copies", 1), at_most=1000)
    return [limb.turned(2 * math.pi * k / copies) if k else limb for k in range(copies)]


def _item(table: Any, where: str, base: Three, known: Mapping[str, Rod]) -> Any:
    if isinstance(table, dict) and "rod" in table:
        only(table, where, "rod", "length_mm")
        rod = one_of(table["rod"], f"{where}.rod", known)
        length = get(table, where, "length_mm") / 1000 if "length_mm" in table else None
        return Rod(rod.material, rod.section, length)
    if isinstance(table, dict) and "link" in table:
        only(table, where, "link", "length_mm")
        return Link(get(table, where, "length_mm") / 1000 if "length_mm" in table else None)
    if isinstance(table, dict) and "body_kg" in table:
        only(table, where, "body_kg", "centre_mm", "inertia_kg_m2", "frame")
        return Body(
            get(table, where, "body_kg"),
            _tensor(table.get("inertia_kg_m2"), f"{where}.inertia_kg_m2"),
            _metres(table.get("centre_mm", [0, 0, 0]), f"{where}.centre_mm"),
            table.get("frame", "base"),
        )
    return _joint(table, where, base)


def _joint(table: Any, where: str, base: Three) -> Joint:
    """Return a joint with its limits of the workspace."""
    only(
        table, where, "joint", "axis", "frame", "slider", "stiffness_N_m", "stiffness_Nm_rad",
        "tilt_stiffness_Nm_rad", "largest_deg", "rest",
    )  # fmt: skip
    found = _free_joint(table, where, base)
    if "rest" in table:
        found = replace(found, rest=_direction(table["rest"], f"{where}.rest", base))
    if "largest_deg" not in table:
        return found
    largest = get(table, where, "largest_deg")
    if not 0 < largest <= 180:
        raise InputError(f"{where}.largest_deg", largest, "degrees above 0 and at most 180")
    return replace(found, largest=largest * DEGREES)


def _free_joint(table: Table, where: str, base: Three) -> Joint:
    name, frame = table.get("joint"), table.get("frame", "base")
    if name not in JOINTS:
        raise InputError(f"{where}.joint", name, f"one of {', '.join(JOINTS)}")
    axis = table.get("axis")
    direction = None if axis is None else _direction(axis, f"{where}.axis", base)
    turning = get(table, where, "stiffness_Nm_rad", 0.0)
    tilts = table.get("tilt_stiffness_Nm_rad", {})
    rest = tuple(
        Freedom("rotation", _numbers(key, where), frame, number(where, k, "a stiffness"))
        for key, k in tilts.items()
    )
    if name == "P":
        drive = get(table, where, "stiffness_N_m", 0.0)
        return Joint.prismatic(direction, drive, slider=table.get("slider", ""), rest=rest)
    if name == "S":
        return Joint.spherical(turning)
    if name == "fixed":
        return Joint(rest, name="fixed")
    if direction is None:
        raise InputError(f"{where}.axis", axis, "an axis of the joint")
    of = Joint.revolute if name == "R" else Joint.universal
    joint = of(direction, frame, turning)
    return Joint((*joint.freedoms, *rest), name=joint.name)


def _numbers(text: str, where: str) -> Three:
    try:
        return vector(where, [float(part) for part in text.split(",")], "x,y,z of an axis")
    except ValueError:
        raise InputError(where, text, "x,y,z of an axis") from None


def _direction(given: Any, where: str, base: Three) -> Three:
    x, y, _ = base
    if given in ("tangential", "radial"):
        radius = math.hypot(x, y)
        if not radius:
            raise InputError(where, given, "a base off the z axis, or three numbers")
        out = (x / radius, y / radius, 0.0)
        return out if given == "radial" else (-out[1], out[0], 0.0)
    return vector(where, given, "'tangential', 'radial' or three numbers")


def _metres(given: Any, where: str) -> Three:
    if isinstance(given, dict):
        only(given, where, "radius", "angle_deg", "z")
        r, angle = get(given, where, "radius"), get(given, where, "angle_deg") * DEGREES
        given = [r * math.cos(angle), r * math.sin(angle), get(given, where, "z", 0.0)]
    x, y, z = vector(where, given, "three coordinates in millimetres, or a radius and angle_deg")
    return x / 1000, y / 1000, z / 1000


def _tensor(given: Any, where: str) -> Any:
    """Return an inertia tensor given as three moments or as three rows."""
    if isinstance(given, list) and not any(isinstance(row, list) for row in given):
        x, y, z = vector(where, given, "three moments of inertia, or three rows of three")
        return ((x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z))
    return given


SHORT = {f"{name}_{'mm' if name in LENGTHS else 'deg'}": name for name in NAMES}
"""Keys of a pose's numbers, and which each is."""
POSE = (*SHORT, "position_mm", "rotation")
"""The keys that say a pose."""


def read_pose(table: Table, where: str) -> Pose:
    """Return the pose of a case: z, azimuth and tilt (torsion, x, y); x, y and torsion; x, y, z,
    yaw, pitch and roll; or position and rotation.
    """
    if "position_mm" in table:
        for key in SHORT:
            if key in table:
                raise InputError(where, key, "no other key of a pose beside position_mm")
        at = _metres(table["position_mm"], f"{where}.position_mm")
        return Pose.at(at, _rotation(table.get("rotation"), f"{where}.rotation"))
    if "rotation" in table:
        raise InputError(where, "rotation", "position_mm with it")
    if "z_mm" not in table and not ("x_mm" in table and "y_mm" in table):
        get(table, where, "z_mm")  # refuses that there is none
    return stated({
        name: get(table, where, key) * (1e-3 if name in LENGTHS else DEGREES)
        for key, name in SHORT.items() if key in table
    })  # fmt: skip


def _rotation(given: Any, where: str) -> Any:
    """Return a rotation matrix from an axis and an angle, or from yaw, pitch and roll [deg]."""
    if given is None:
        return None
    only(given, where, "axis", "angle_deg", "yaw_deg", "pitch_deg", "roll_deg")
    if "axis" in given:
        n = np.array(vector(f"{where}.axis", given["axis"], "three numbers"))
        return _about(n / np.linalg.norm(n), get(given, where, "angle_deg") * DEGREES)
    yaw, pitch, roll = (
        turn(axis, get(given, where, key, 0.0) * DEGREES)
        for axis, key in ((2, "yaw_deg"), (1, "pitch_deg"), (0, "roll_deg"))
    )
    return yaw @ pitch @ roll


def _about(n: Any, angle: float) -> Any:
    cross = np.array([[0, -n[2], n[1]], [n[2], 0, -n[0]], [-n[1], n[0], 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross
