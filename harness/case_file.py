"""Users' own cases, from a TOML file: degrees, millimetres and gigapascals, as the keys say.

[mechanisms.light]
base_radius_mm = 300
platform_radius_mm = 200
platform_thickness_mm = 20
rod_diameter_mm = 60
young_GPa = 200
shear_GPa = 77
density_kg_m3 = 7820

[rods]
leg = {material = "steel", diameter_mm = 40, bore_mm = 20}

[[mechanisms.mine.limbs]]
copies = 3
base_mm = {radius = 600, angle_deg = -12}
platform_point_mm = [380, 0, 0]
chain = [{joint = "U", axis = "tangential"}, {rod = "leg"}, {joint = "S"}]

[cases.low]
mechanism = "light"
z_mm = 400
azimuth_deg = 10
tilt_deg = -12
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
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
from analytic.errors import count, number, vector
from analytic.mechanism import LARGEST, MOST_LIMBS, has_poisson, shear_range
from harness.case import Case
from harness.paper import CASES, CHECKED, case_file, folder, names, read_paper
from harness.poses import LENGTHS, NAMES, stated
from harness.toml_table import Given, Three, read_toml
from reference_models import parse

Table = dict[str, Any]
OF_PAPER = "published", "errata", "title"
"""The keys that a case of a paper may have beside those of every case."""
MATERIAL = "young_GPa", "shear_GPa", "density_kg_m3"
ROD = ("material", "diameter_mm", "bore_mm", "area_mm2", "second_moments_mm4",
       "torsion_constant_mm4", "shear_coefficients")  # fmt: skip
BODY = "mass_kg", "centre_mm", "inertia_kg_m2"
ITEMS = {
    "rod": ("length_mm",),
    "link": ("length_mm",),
    "body_kg": ("centre_mm", "inertia_kg_m2", "frame"),
    "joint": ("axis", "frame", "slider", "stiffness_N_m", "stiffness_Nm_rad",
              "tilt_stiffness_Nm_rad", "largest_deg", "rest"),
}  # fmt: skip
"""What a chain is made of, by the key that says so, and its other keys."""
JOINTS = "R", "U", "S", "P", "fixed"
SHORT = {f"{name}_{'mm' if name in LENGTHS else 'deg'}": name for name in NAMES}
"""Keys of a pose's numbers, and which each is."""
TURNS = "yaw_deg", "pitch_deg", "roll_deg"


@cache
def presets() -> dict[str, Case]:
    """Return the cases of the paper that is checked, by name."""
    path = folder(CHECKED)
    assert path is not None, "it is shipped"
    return _of_paper(path)


def load_cases(path: Path) -> dict[str, Case]:
    """Return the cases of `path` by name; raises `InputError` naming the key that is wrong.

    `path`: a file, the folder of a paper, or the name of either that comes along.
    """
    of = folder(str(path))
    if of is not None and of == folder(CHECKED):
        return presets()
    cases = _read(case_file(path)) if of is None else _of_paper(of)
    for name in cases:
        if name in presets():
            raise InputError(f"cases.{name}", name, "a name that no built-in case has")
    return cases


def _of_paper(path: Path) -> dict[str, Case]:
    cases = {
        name: replace(case, published=case.published or name)
        for name, case in _read(path / CASES, *OF_PAPER).items()
    }
    paper = read_paper(path, list(dict.fromkeys(case.published for case in cases.values())))
    return {name: replace(case, paper=paper) for name, case in cases.items()}


def _read(path: Path, *more: str) -> dict[str, Case]:
    """Return the cases of a file; they have the keys `more` beside the usual ones."""
    data = read_toml(path, hint=f", or one that comes along: {', '.join(names())}")
    Given("the file", data, ("materials", "rods", "mechanisms", "cases"))

    def tables(key: str) -> Table:
        found = data.get(key, {})
        if not isinstance(found, dict) or not all(isinstance(t, dict) for t in found.values()):
            raise InputError(key, found, f"tables called [{key}.NAME]")
        return found

    materials = {
        name: _material(Given(f"materials.{name}", table, MATERIAL))
        for name, table in tables("materials").items()
    }
    rods = {
        name: _section_rod(Given(f"rods.{name}", table, ROD), materials)
        for name, table in tables("rods").items()
    }
    mechanisms = {
        "paper": Mechanism.paper(),
        "paper-printed-inertia": Mechanism.paper(inertia="printed"),
    }
    for name, table in tables("mechanisms").items():
        own = isinstance(table.get("limbs"), list)
        where = f"mechanisms.{name}"
        mechanisms[name] = _of_chains(table, where, rods) if own else _of_rods(table, where)
    cases = {
        name: _case(name, table, mechanisms, str(path), more)
        for name, table in tables("cases").items()
    }
    if not cases:
        raise InputError("case_file", str(path), "at least one [cases.NAME] table")
    return cases


def _case(name: str, table: Table, mechanisms: Table, source: str, more: tuple[str, ...]) -> Case:
    keys = ("mechanism", *SHORT, "position_mm", "rotation", "model", "note", *more)
    given = Given(f"cases.{name}", table, keys)
    if "," in name:
        raise InputError(given.where, name, "a name without commas")
    mechanism, pose = given.one_of("mechanism", mechanisms), _pose(given)
    note = given.get("note") if "note" in given else f"{given.get('mechanism')} of {source}"
    theory = parse(str(given.get("model")), given.at("model"))
    published, title = (str(given.get(key)) for key in ("published", "title"))
    errata = tuple(map(str, given.get("errata")))
    return Case(name, mechanism, pose, str(note), theory, published, errata, title)


def _material(given: Given) -> Material:
    young, shear, density = map(given.number, MATERIAL)
    if not has_poisson(young, shear):
        stiff, soft = (float(given.get(key)) for key in MATERIAL[:2])
        raise InputError(given.at("shear_GPa"), soft, shear_range(stiff, "young_GPa"))
    return Material(young, shear, density)


def _section_rod(given: Given, known: Mapping[str, Material]) -> Rod:
    """Return a rod of a known material, round or by the constants of its section."""
    made_of = given.one_of("material", known)
    if "diameter_mm" in given:
        return Rod(made_of, Section.round(given.number("diameter_mm"), given.number("bore_mm")))
    kappas = given.get("shear_coefficients")
    section = Section(
        given.number("area_mm2"),
        given.pair("second_moments_mm4", "two numbers, Ix and Iy"),
        given.number("torsion_constant_mm4"),
        tuple(kappas) if isinstance(kappas, list) else kappas,
    )
    return Rod(made_of, section)


def _of_rods(table: Table, where: str) -> Mechanism:
    """Return a mechanism of R-P-S limbs: equal ones, or each of a [[mechanisms.NAME.limb]]."""
    regular = "base_radius_mm", "platform_radius_mm", "limbs", "heading_deg"
    shape = ("limb",) if "limb" in table else regular
    heavy = "platform_mass_kg", "platform_inertia_kg_m2"
    disc = "platform_radius_mm", "platform_thickness_mm"
    body = heavy if heavy[0] in table else (*disc[::-1], "inertia")
    given = Given(where, table, (*MATERIAL, "rod_diameter_mm", *shape, *body))
    steel = _material(given)
    if heavy[0] in given:
        mass = given.number(heavy[0])
        try:
            platform = Platform(mass, given.get(heavy[1]))
        except InputError as error:
            raise given.refused(heavy[1], error.expected) from None
    else:
        form = given.one_of("inertia", {"disc": Platform.disc, "printed": Platform.as_printed})
        platform = form(*map(given.number, disc), steel.density)
    if "limb" not in given:
        base, points = map(given.number, regular[:2])
        limbs = count(given.at("limbs"), given.get("limbs"), at_most=MOST_LIMBS)
        rod, heading = _round_rod(given, steel), given.number("heading_deg")
        return Mechanism.regular(base, points, rod, platform, limbs=limbs, heading=heading)
    some = given.many("limb", f"tables called [[{where}.limb]]")
    return Mechanism(tuple(_rps(limb, given, steel) for limb in some), platform)


def _round_rod(given: Given, steel: Material) -> Rod:
    return Rod.round(steel, given.number("rod_diameter_mm"))


def _rps(limb: Any, of: Given, steel: Material) -> Limb:
    keys = "base_mm", "axis", "platform_point_mm", "rod_diameter_mm"
    given = Given(of.at("limb"), limb, keys)
    rod = _round_rod(given if "rod_diameter_mm" in given else of, steel)
    axis = given.vector("axis", "a direction other than zero")
    if not any(axis):
        raise given.refused("axis", "a direction other than zero")
    return Limb.rps(given.metres("base_mm"), axis, given.metres("platform_point_mm"), rod)


def _of_chains(table: Table, where: str, rods: Mapping[str, Rod]) -> Mechanism:
    """Return a mechanism of chains of any kind, each of a [[mechanisms.NAME.limbs]]."""
    given = Given(where, table, ("platform", "payloads", "limbs"))
    limbs = [
        limb
        for k, one in enumerate(given.get("limbs"))
        for limb in _limbs(one, f"{where}.limbs[{k}]", rods)
    ]
    disc = "radius_mm", "thickness_mm", "density_kg_m3"
    body = Given(given.at("platform"), given.get("platform"), (*disc, *BODY))
    if "mass_kg" in body:
        mass, centre, tensor = _body(body, "mass_kg")
        platform = Platform(mass, tensor, centre=centre)
    else:
        platform = Platform.disc(*map(body.number, disc))
    for k, one in enumerate(given.many("payloads", f"tables called [[{where}.payloads]]")):
        load = Given(f"{where}.payloads[{k}]", one, BODY)
        platform = platform.carrying(*_body(load, "mass_kg"))
    return Mechanism(tuple(limbs), platform)


def _body(given: Given, mass: str) -> tuple[float, Three, Any]:
    return given.number(mass), given.metres("centre_mm"), given.tensor("inertia_kg_m2")


def _limbs(table: Any, where: str, rods: Mapping[str, Rod]) -> list[Limb]:
    keys = "copies", "base_mm", "platform_point_mm", "chain", "reference", "stroke_mm"
    given = Given(where, table, keys)
    base, stroke = given.metres("base_mm"), None
    items = given.many("chain", "a list of joints, rods, links and bodies")
    chain = tuple(_item(item, f"{where}.chain[{k}]", base, rods) for k, item in enumerate(items))
    reference = _direction(given, "reference", base)
    if "stroke_mm" in given:
        expected = "the least and the largest of two lengths in millimetres"
        stroke = given.pair("stroke_mm", expected)
        if not stroke[0] < stroke[1]:
            raise given.refused("stroke_mm", expected)
    limb = Limb(base, given.metres("platform_point_mm"), chain, reference, stroke)
    copies = count(given.at("copies"), given.get("copies"), at_most=1000)
    return [limb.turned(2 * math.pi * k / copies) if k else limb for k in range(copies)]


def _item(table: Any, where: str, base: Three, rods: Mapping[str, Rod]) -> Any:
    kind = next((key for key in ITEMS if isinstance(table, dict) and key in table), "joint")
    given = Given(where, table, (kind, *ITEMS[kind]))
    match kind:
        case "rod":
            return replace(given.one_of("rod", rods), length=given.number("length_mm"))
        case "link":
            return Link(given.number("length_mm"))
        case "body_kg":
            mass, centre, tensor = _body(given, kind)
            return Body(mass, tensor, centre, given.get("frame"))
    joint = _joint(given, base)
    rest, largest = _direction(given, "rest", base), given.number("largest_deg")
    if rest is not None:
        joint = replace(joint, rest=rest)
    if largest is None:
        return joint
    if not 0 < largest <= math.pi:
        raise given.refused("largest_deg", "degrees above 0 and at most 180")
    return replace(joint, largest=largest)


def _joint(given: Given, base: Three) -> Joint:
    name, frame, tilts = map(given.get, ("joint", "frame", "tilt_stiffness_Nm_rad"))
    if name not in JOINTS:
        raise given.refused("joint", f"one of {', '.join(JOINTS)}")
    if not isinstance(tilts, dict):
        raise given.refused("tilt_stiffness_Nm_rad", "stiffnesses by the x,y,z of their axes")
    axis, turning = _direction(given, "axis", base), given.number("stiffness_Nm_rad")
    rest = tuple(
        Freedom(
            "rotation",
            vector(given.where, about.split(","), "x,y,z of an axis"),
            frame,
            number(given.where, k, "a stiffness"),
        )
        for about, k in tilts.items()
    )
    match name:
        case "P":
            drive, slider = given.number("stiffness_N_m"), given.get("slider")
            return Joint.prismatic(axis, drive, slider=slider, rest=rest)
        case "S":
            return Joint.spherical(turning)
        case "fixed":
            return Joint(rest, name="fixed")
    if axis is None:
        raise given.refused("axis", "an axis of the joint")
    joint = (Joint.revolute if name == "R" else Joint.universal)(axis, frame, turning)
    return Joint((*joint.freedoms, *rest), name=joint.name)


def _direction(given: Given, key: str, base: Three) -> Three | None:
    """Return a direction, at a `base`, or None where there is none."""
    said = given.get(key)
    if said not in ("tangential", "radial"):
        expected = "'tangential', 'radial' or three numbers"
        return None if said is None else given.vector(key, expected)
    x, y, _ = base
    radius = math.hypot(x, y)
    if not radius:
        raise given.refused(key, "a base off the z axis, or three numbers")
    out = (x / radius, y / radius, 0.0)
    return out if said == "radial" else (-out[1], out[0], 0.0)


def _pose(given: Given) -> Pose:
    """Return the pose of a case: z, azimuth and tilt (torsion, x, y); x, y and torsion; x, y, z,
    yaw, pitch and roll; or position and rotation.
    """
    values = {name: given.number(key) for key, name in SHORT.items() if key in given}
    if "position_mm" in given:
        for key in SHORT:
            if key in given:
                raise InputError(given.where, key, "no other key of a pose beside position_mm")
        return Pose.at(given.metres("position_mm"), _rotation(given))
    if "rotation" in given:
        raise InputError(given.where, "rotation", "position_mm with it")
    if not {"x", "y"} <= {*values}:
        given.number("z_mm")  # refuses that there is none
    if abs(values.get("z", 0.0)) > LARGEST:
        raise given.refused("z_mm", f"at most {LARGEST * 1000:g} millimetres")
    return stated(values)


def _rotation(of: Given) -> Any:
    """Return a rotation matrix from an axis and an angle, or from yaw, pitch and roll [deg]."""
    if "rotation" not in of:
        return None
    from scipy.spatial.transform import Rotation  # rarely needed, and slow to load

    given = Given(of.at("rotation"), of.get("rotation"), ("axis", "angle_deg", *TURNS))
    if "axis" not in given:
        return Rotation.from_euler("ZYX", [*map(given.number, TURNS)]).as_matrix()
    axis = np.array(given.vector("axis", "three numbers"))
    turn = given.number("angle_deg") * axis / np.linalg.norm(axis)
    return Rotation.from_rotvec(turn).as_matrix()
