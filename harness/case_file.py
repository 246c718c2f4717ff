"""Users' own cases, from a TOML file: degrees, millimetres and gigapascals, as the keys say.

[mechanisms.light]
base_radius_mm = 300
platform_radius_mm = 200
platform_thickness_mm = 20
rod_diameter_mm = 60
young_GPa = 200
shear_GPa = 77
density_kg_m3 = 7820

[cases.low]
mechanism = "light"
z_mm = 400
azimuth_deg = 10
tilt_deg = -12
"""

import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from analytic import InputError, Limb, Material, Mechanism, Platform, Pose, Rod
from analytic.errors import number, vector
from harness.cases import PRESETS, Case
from harness.paper import CASES, folder, names, read_paper, read_table
from reference_models import parse

Table = dict[str, Any]


def load_cases(path: Path) -> dict[str, Case]:
    """Return the cases of `path` by name; raises `InputError` naming the key that is wrong.

    `path`: a file, the folder of a paper, or the name of one that is shipped.
    """
    of = folder(str(path))
    if of is not None:
        cases, paper = load_cases(of / CASES), read_paper(of)
        printed = read_table(of, list(cases))
        return {k: replace(one, paper=paper, printed=printed[k]) for k, one in cases.items()}
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        reason = error.strerror or str(error)
        shipped = f", or a paper: {', '.join(names())}"
        raise InputError("case_file", str(path), f"a readable file ({reason}){shipped}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError("case_file", str(path), f"a TOML file ({error})") from None
    _only(data, "the file", "mechanisms", "cases")
    mechanisms = {
        "paper": Mechanism.paper(),
        "paper-printed-inertia": Mechanism.paper(inertia="printed"),
    }
    for name, table in _tables(data, "mechanisms").items():
        mechanisms[name] = _mechanism(table, f"mechanisms.{name}")
    cases = {
        name: _case(name, table, mechanisms, str(path))
        for name, table in _tables(data, "cases").items()
    }
    if not cases:
        raise InputError("case_file", str(path), "at least one [cases.NAME] table")
    return cases


def _tables(data: Table, key: str) -> dict[str, Table]:
    tables = data.get(key, {})
    if not isinstance(tables, dict) or not all(isinstance(t, dict) for t in tables.values()):
        raise InputError(key, tables, f"tables called [{key}.NAME]")
    return tables


def _only(table: Table, where: str, *keys: str) -> None:
    for key in table:
        if key not in keys:
            raise InputError(where, key, f"only the keys {', '.join(keys)}")


def _get(table: Table, where: str, key: str, default: float | None = None) -> float:
    if key not in table and default is not None:
        return default
    return number(f"{where}.{key}", table.get(key), "a finite number")


def _case(name: str, table: Table, mechanisms: dict[str, Mechanism], source: str) -> Case:
    where = f"cases.{name}"
    _only(table, where, "mechanism", "z_mm", "azimuth_deg", "tilt_deg", "model", "note")
    if name in PRESETS or "," in name:
        raise InputError(where, name, "a name without commas that no built-in case has")
    mechanism = table.get("mechanism", "paper")
    if mechanism not in mechanisms:
        raise InputError(f"{where}.mechanism", mechanism, f"one of {', '.join(mechanisms)}")
    pose = Pose(
        _get(table, where, "z_mm") / 1000,
        np.radians(_get(table, where, "azimuth_deg", 0.0)),
        np.radians(_get(table, where, "tilt_deg", 0.0)),
    )
    note = str(table.get("note", f"{mechanism} of {source}"))
    theory = parse(str(table.get("model", "euler-bernoulli")), f"{where}.model")
    return Case(name, mechanisms[mechanism], pose, note, theory)


def _mechanism(table: Table, where: str) -> Mechanism:
    shape = (
        ("limb",)
        if "limb" in table
        else ("base_radius_mm", "platform_radius_mm", "limbs", "heading_deg")
    )
    body = (
        ("platform_mass_kg", "platform_inertia_kg_m2")
        if "platform_mass_kg" in table
        else ("platform_thickness_mm", "platform_radius_mm", "inertia")
    )
    _only(table, where, "young_GPa", "shear_GPa", "density_kg_m3", "rod_diameter_mm", *shape, *body)
    material = Material(
        _get(table, where, "young_GPa") * 1e9,
        _get(table, where, "shear_GPa") * 1e9,
        _get(table, where, "density_kg_m3"),
    )
    platform = _platform(table, where, material)
    if "limb" in table:
        return Mechanism(
            tuple(_limb(limb, f"{where}.limb", table, material) for limb in table["limb"]), platform
        )
    limbs = table.get("limbs", 3)
    return Mechanism.regular(
        _get(table, where, "base_radius_mm") / 1000,
        _get(table, where, "platform_radius_mm") / 1000,
        Rod(material, _get(table, where, "rod_diameter_mm") / 1000),
        platform,
        limbs=limbs,
        heading=float(np.radians(_get(table, where, "heading_deg", 0.0))),
    )


def _platform(table: Table, where: str, material: Material) -> Platform:
    if "platform_mass_kg" in table:
        return Platform(
            _get(table, where, "platform_mass_kg"), table.get("platform_inertia_kg_m2", ())
        )
    forms = {"disc": Platform.disc, "printed": Platform.as_printed}
    form = table.get("inertia", "disc")
    if form not in forms:
        raise InputError(f"{where}.inertia", form, "'disc' or 'printed'")
    return forms[form](
        _get(table, where, "platform_radius_mm") / 1000,
        _get(table, where, "platform_thickness_mm") / 1000,
        material.density,
    )


def _limb(limb: Any, where: str, table: Table, material: Material) -> Limb:
    if not isinstance(limb, dict):
        raise InputError(where, limb, f"tables called [[{where}]]")
    _only(limb, where, "base_mm", "axis", "platform_point_mm", "rod_diameter_mm")
    diameter = _get({**table, **limb}, where, "rod_diameter_mm")

    def metres(key: str) -> tuple[float, float, float]:
        x, y, z = vector(f"{where}.{key}", limb.get(key), "three coordinates in millimetres")
        return x / 1000, y / 1000, z / 1000

    return Limb(
        metres("base_mm"),
        limb.get("axis", ()),
        metres("platform_point_mm"),
        Rod(material, diameter / 1000),
    )
