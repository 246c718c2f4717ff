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
from analytic.errors import InputError, count, number, vector
from analytic.mechanism import DENSITY, STIFFNESS, has_poisson, shear_range
from harness.poses import LENGTHS, NAMES, stated, turn
from harness.toml_table import Given, Three

Tables = Mapping[str, Any]
MATERIAL = "young_GPa", "shear_GPa", "density_kg_m3"
ITEMS = {
    "rod": ("length_mm",),
    "link": ("length_mm",),
    "body_kg": ("centre_mm", "inertia_kg_m2", "frame"),
    "joint": ("axis", "frame", "slider", "stiffness_N_m", "stiffness_Nm_rad",
              "tilt_stiffness_Nm_rad", "largest_deg", "rest"),
}  # fmt: skip
"""What a chain is made of, by the key that says so, and its other keys."""
JOINTS = "R", "U", "S", "P", "fixed"
ORIGIN = [0, 0, 0]
SHORT = {f"{name}_{'mm' if name in LENGTHS else 'deg'}": name for name in NAMES}
"""Keys of a pose's numbers, and which each is."""
POSE = (*SHORT, "position_mm", "rotation")
"""The keys that say a pose."""


def material(given: Given) -> Material:
    """Return the material that a table states, refused in the file's own keys and units."""
    gigapascals = STIFFNESS[0] / 1e9, STIFFNESS[1] / 1e9
    young, shear, density = (
        given.number(key, positive=True, within=within)
        for key, within in zip(MATERIAL, (gigapascals, gigapascals, DENSITY), strict=True)
    )
    if not has_poisson(young, shear):
        stiff, soft = (float(given.get(key)) for key in MATERIAL[:2])
        raise InputError(given.at("shear_GPa"), soft, shear_range(stiff, "young_GPa"))
    return Material(young, shear, density)


def materials(tables: Tables) -> dict[str, Material]:
    """Return the materials of [materials.NAME]."""
    return {
        name: material(Given(f"materials.{name}", table, MATERIAL))
        for name, table in tables.items()
    }


def rods(tables: Tables, known: Mapping[str, Material]) -> dict[str, Rod]:
    """Return the rods of [rods], each of a known material; round ones or by section constants."""
    keys = ("material", "diameter_mm", "bore_mm", "area_mm2", "second_moments_mm4",
            "torsion_constant_mm4", "shear_coefficients")  # fmt: skip
    found = {}
    for name, table in tables.items():
        given = Given(f"rods.{name}", table, keys)
        made_of = given.one_of("material", known)
        if "diameter_mm" in given:
            section = Section.round(given.number("diameter_mm"), given.number("bore_mm", 0.0))
        else:
            kappas = given.get("shear_coefficients")
            section = Section(
                given.number("area_mm2"),
                given.pair("second_moments_mm4", "two numbers, Ix and Iy"),
                given.number("torsion_constant_mm4"),
                tuple(kappas) if isinstance(kappas, list) else kappas,
            )
        found[name] = Rod(made_of, section)
    return found


def chain_mechanism(table: Any, where: str, known: Mapping[str, Rod]) -> Mechanism:
    """Return a mechanism of [mechanisms.NAME] with [[mechanisms.NAME.limbs]]."""
    given = Given(where, table, ("platform", "payloads", "limbs"))
    limbs: list[Limb] = []
    for k, limb in enumerate(given.get("limbs")):
        limbs += _limbs(limb, f"{where}.limbs[{k}]", known)
    platform = _platform(given.get("platform"), given.at("platform"))
    for k, one in enumerate(given.get("payloads", [])):
        load = Given(f"{where}.payloads[{k}]", one, ("mass_kg", "centre_mm", "inertia_kg_m2"))
        platform = platform.carrying(
            load.number("mass_kg"), load.metres("centre_mm", ORIGIN), load.tensor("inertia_kg_m2")
        )
    return Mechanism(tuple(limbs), platform)


def _platform(table: Any, where: str) -> Platform:
    disc = "radius_mm", "thickness_mm", "density_kg_m3"
    given = Given(where, table, (*disc, "mass_kg", "centre_mm", "inertia_kg_m2"))
    if "mass_kg" in given:
        mass, tensor = given.number("mass_kg"), given.tensor("inertia_kg_m2")
        return Platform(mass, tensor, centre=given.metres("centre_mm", ORIGIN))
    return Platform.disc(*map(given.number, disc))


def _limbs(table: Any, where: str, known: Mapping[str, Rod]) -> list[Limb]:
    keys = "copies", "base_mm", "platform_point_mm", "chain", "reference", "stroke_mm"
    given = Given(where, table, keys)
    base, items, stroke = given.metres("base_mm"), given.get("chain"), None
    if not isinstance(items, list):
        raise given.refused("chain", "a list of joints, rods, links and bodies")
    chain = tuple(_item(item, f"{where}.chain[{k}]", base, known) for k, item in enumerate(items))
    reference = _direction(given, "reference", base)
    point = given.metres("platform_point_mm")
    if "stroke_mm" in given:
        expected = "the least and the largest of two lengths in millimetres"
        stroke = given.pair("stroke_mm", expected)
        if not stroke[0] < stroke[1]:
            raise given.refused("stroke_mm", expected)
    limb = Limb(base, point, chain, reference, stroke)
    copies = count(given.at("copies"), given.get("copies", 1), at_most=1000)
    return [limb.turned(2 * math.pi * k / copies) if k else limb for k in range(copies)]


def _item(table: Any, where: str, base: Three, known: Mapping[str, Rod]) -> Any:
    kinds = [key for key in ITEMS if isinstance(table, dict) and key in table] or ["joint"]
    given = Given(where, table, (kinds[0], *ITEMS[kinds[0]]))
    match kinds[0]:
        case "rod":
            rod: Rod = given.one_of("rod", known)
            return replace(rod, length=given.number("length_mm", None))
        case "link":
            return Link(given.number("length_mm", None))
        case "body_kg":
            mass, tensor = given.number("body_kg"), given.tensor("inertia_kg_m2")
            at = given.metres("centre_mm", ORIGIN)
            return Body(mass, tensor, at, given.get("frame", "base"))
    found = _joint(given, base)
    rest = _direction(given, "rest", base)
    found = found if rest is None else replace(found, rest=rest)
    largest = given.number("largest_deg", None)
    if largest is not None and not 0 < largest <= math.pi:
        raise given.refused("largest_deg", "degrees above 0 and at most 180")
    return found if largest is None else replace(found, largest=largest)


def _joint(given: Given, base: Three) -> Joint:
    name, frame = given.get("joint"), given.get("frame", "base")
    if name not in JOINTS:
        raise given.refused("joint", f"one of {', '.join(JOINTS)}")
    direction = _direction(given, "axis", base)
    turning = given.number("stiffness_Nm_rad", 0.0)
    rest = tuple(
        Freedom(
            "rotation",
            vector(given.where, axis.split(","), "x,y,z of an axis"),
            frame,
            number(given.where, k, "a stiffness"),
        )
        for axis, k in given.get("tilt_stiffness_Nm_rad", {}).items()
    )
    if name == "P":
        drive, slider = given.number("stiffness_N_m", 0.0), given.get("slider", "")
        return Joint.prismatic(direction, drive, slider=slider, rest=rest)
    if name == "S":
        return Joint.spherical(turning)
    if name == "fixed":
        return Joint(rest, name="fixed")
    if direction is None:
        raise given.refused("axis", "an axis of the joint")
    of = Joint.revolute if name == "R" else Joint.universal
    joint = of(direction, frame, turning)
    return Joint((*joint.freedoms, *rest), name=joint.name)


def _direction(given: Given, key: str, base: Three) -> Three | None:
    """Return a direction, at a `base`, or None where there is none."""
    said = given.get(key)
    if said not in ("tangential", "radial"):
        expected = "'tangential', 'radial' or three numbers"
        return None if said is None else vector(given.at(key), said, expected)
    x, y, _ = base
    radius = math.hypot(x, y)
    if not radius:
        raise given.refused(key, "a base off the z axis, or three numbers")
    out = (x / radius, y / radius, 0.0)
    return out if said == "radial" else (-out[1], out[0], 0.0)


def read_pose(given: Given) -> Pose:
    """Return the pose of a case: z, azimuth and tilt (torsion, x, y); x, y and torsion; x, y, z,
    yaw, pitch and roll; or position and rotation.
    """
    if "position_mm" in given:
        for key in SHORT:
            if key in given:
                raise InputError(given.where, key, "no other key of a pose beside position_mm")
        return Pose.at(given.metres("position_mm"), _rotation(given))
    if "rotation" in given:
        raise InputError(given.where, "rotation", "position_mm with it")
    if not ("x_mm" in given and "y_mm" in given):
        given.number("z_mm")  # refuses that there is none
    return stated({name: given.number(key) for key, name in SHORT.items() if key in given})


def _rotation(of: Given) -> Any:
    """Return a rotation matrix from an axis and an angle, or from yaw, pitch and roll [deg]."""
    if of.get("rotation") is None:
        return None
    turns = "yaw_deg", "pitch_deg", "roll_deg"
    given = Given(of.at("rotation"), of.get("rotation"), ("axis", "angle_deg", *turns))
    if "axis" in given:
        n = np.array(vector(given.at("axis"), given.get("axis"), "three numbers"))
        return _about(n / np.linalg.norm(n), given.number("angle_deg"))
    yaw, pitch, roll = (
        turn(axis, given.number(key, 0.0)) for axis, key in zip((2, 1, 0), turns, strict=True)
    )
    return yaw @ pitch @ roll


def _about(n: Any, angle: float) -> Any:
    cross = np.array([[0, -n[2], n[1]], [n[2], 0, -n[0]], [-n[1], n[0], 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross
