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

import re
import tomllib
from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from analytic import InputError, Limb, Material, Mechanism, Platform, Rod
from analytic.errors import count, vector
from analytic.mechanism import (
    DENSITY,
    LARGEST,
    MOST_LIMBS,
    SMALLEST,
    STIFFNESS,
    has_poisson,
    shear_range,
)
from harness.case import Case
from harness.chain_file import (
    POSE,
    chain_mechanism,
    get,
    materials,
    one_of,
    only,
    read_pose,
    rods,
)
from harness.paper import CASES, CHECKED, case_file, folder, names, read_paper
from reference_models import parse

Table = dict[str, Any]
_size = partial(get, positive=True)
OF_PAPER = ("published", "errata", "title")
"""The keys that a case of a paper may have beside those of every case."""
DIGITS = 4300
"""Digits of a whole number that Python reads at most."""


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
    try:
        text = path.read_text(encoding="utf-8-sig")
        data = tomllib.loads(text)
    except OSError as error:
        reason = error.strerror or str(error)
        shipped = f", or one that comes along: {', '.join(names())}"
        raise InputError("case_file", str(path), f"a readable file ({reason}){shipped}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError("case_file", str(path), f"a TOML file ({error})") from None
    except ValueError:
        where = _line(text, lambda line: max(map(len, re.findall(r"[\d_]+", line)), default=0))
        raise InputError("case_file", str(path), f"at most {DIGITS} digits in {where}") from None
    except RecursionError:
        where = _line(text, lambda line: line.count("[") + line.count("{"))
        raise InputError("case_file", str(path), f"fewer brackets in {where}") from None
    only(data, "the file", "materials", "rods", "mechanisms", "cases")
    known = rods(_tables(data, "rods"), materials(_tables(data, "materials")))
    mechanisms = {
        "paper": Mechanism.paper(),
        "paper-printed-inertia": Mechanism.paper(inertia="printed"),
    }
    for name, table in _tables(data, "mechanisms").items():
        own = isinstance(table.get("limbs"), list)
        where = f"mechanisms.{name}"
        mechanisms[name] = chain_mechanism(table, where, known) if own else _mechanism(table, where)
    cases = {
        name: _case(name, table, mechanisms, str(path), more)
        for name, table in _tables(data, "cases").items()
    }
    if not cases:
        raise InputError("case_file", str(path), "at least one [cases.NAME] table")
    return cases


def _line(text: str, size: Callable[[str], int]) -> str:
    """Return the number of the line of the largest `size`, and the key that it gives."""
    lines = text.splitlines()
    worst = max(range(len(lines)), key=lambda k: size(lines[k]))
    return f"{lines[worst].partition('=')[0].strip()[:40]} of line {worst + 1}"


def _tables(data: Table, key: str) -> dict[str, Table]:
    tables = data.get(key, {})
    if not isinstance(tables, dict) or not all(isinstance(t, dict) for t in tables.values()):
        raise InputError(key, tables, f"tables called [{key}.NAME]")
    return tables


def _case(
    name: str, table: Table, mechanisms: dict[str, Mechanism], source: str, more: tuple[str, ...]
) -> Case:
    where = f"cases.{name}"
    only(table, where, "mechanism", *POSE, "model", "note", *more)
    if "," in name:
        raise InputError(where, name, "a name without commas")
    mechanism = table.get("mechanism", "paper")
    there = one_of(mechanism, f"{where}.mechanism", mechanisms)
    z = table.get("z_mm", 0.0)
    if isinstance(z, (int, float)) and abs(z) > LARGEST * 1000:
        raise InputError(f"{where}.z_mm", z, f"at most {LARGEST * 1000:g} millimetres")
    pose = read_pose(table, where)
    note = str(table.get("note", f"{mechanism} of {source}"))
    theory = parse(str(table.get("model", "euler-bernoulli")), f"{where}.model")
    published, title = (str(table.get(key, "")) for key in ("published", "title"))
    errata = tuple(map(str, table.get("errata", ())))
    return Case(name, there, pose, note, theory, published, errata, title)


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
    only(table, where, "young_GPa", "shear_GPa", "density_kg_m3", "rod_diameter_mm", *shape, *body)
    material = _material(table, where)
    platform = _platform(table, where, material)
    if "limb" in table:
        limbs = table["limb"]
        if not isinstance(limbs, list) or not limbs:
            raise InputError(f"{where}.limb", limbs, f"tables called [[{where}.limb]]")
        return Mechanism(
            tuple(_limb(limb, f"{where}.limb", table, material) for limb in limbs), platform
        )
    return Mechanism.regular(
        _size(table, where, "base_radius_mm") / 1000,
        _size(table, where, "platform_radius_mm") / 1000,
        _rod(table, where, material),
        platform,
        limbs=count(f"{where}.limbs", table.get("limbs", 3), at_most=MOST_LIMBS),
        heading=float(np.radians(get(table, where, "heading_deg", 0.0))),
    )


def _material(table: Table, where: str) -> Material:
    """Return the material, refused in the file's own keys and units."""
    keys = ("young_GPa", "shear_GPa", "density_kg_m3")
    young, shear, density = (_size(table, where, key) for key in keys)
    for key, value, (low, high) in (
        ("young_GPa", young, (STIFFNESS[0] / 1e9, STIFFNESS[1] / 1e9)),
        ("shear_GPa", shear, (STIFFNESS[0] / 1e9, STIFFNESS[1] / 1e9)),
        ("density_kg_m3", density, DENSITY),
    ):
        if not low <= value <= high:
            raise InputError(f"{where}.{key}", value, f"{low:g} to {high:g}")
    if not has_poisson(young, shear):
        raise InputError(f"{where}.shear_GPa", shear, shear_range(young, "young_GPa"))
    return Material(young * 1e9, shear * 1e9, density)


def _rod(table: Table, where: str, material: Material) -> Rod:
    diameter = _size(table, where, "rod_diameter_mm")
    if not SMALLEST <= diameter / 1000 <= LARGEST:
        low, high = 1000 * SMALLEST, 1000 * LARGEST
        raise InputError(f"{where}.rod_diameter_mm", diameter, f"{low:g} to {high:g} millimetres")
    return Rod.round(material, diameter / 1000)


def _platform(table: Table, where: str, material: Material) -> Platform:
    if "platform_mass_kg" in table:
        key = f"{where}.platform_inertia_kg_m2"
        mass, inertia = _size(table, where, "platform_mass_kg"), table.get("platform_inertia_kg_m2")
        try:
            return Platform(mass, inertia)  # type: ignore[arg-type]
        except InputError as error:
            raise InputError(key, inertia, error.expected) from None
    forms = {"disc": Platform.disc, "printed": Platform.as_printed}
    form: Callable[..., Platform] = one_of(table.get("inertia", "disc"), f"{where}.inertia", forms)
    return form(
        _size(table, where, "platform_radius_mm") / 1000,
        _size(table, where, "platform_thickness_mm") / 1000,
        material.density,
    )


def _limb(limb: Any, where: str, table: Table, material: Material) -> Limb:
    if not isinstance(limb, dict):
        raise InputError(where, limb, f"tables called [[{where}]]")
    only(limb, where, "base_mm", "axis", "platform_point_mm", "rod_diameter_mm")
    rod = _rod({**table, **limb}, where, material)

    def metres(key: str) -> tuple[float, float, float]:
        x, y, z = vector(f"{where}.{key}", limb.get(key), "three coordinates in millimetres")
        return x / 1000, y / 1000, z / 1000

    axis = vector(f"{where}.axis", limb.get("axis"), "a direction other than zero")
    if not any(axis):
        raise InputError(f"{where}.axis", limb["axis"], "a direction other than zero")
    return Limb.rps(metres("base_mm"), axis, metres("platform_point_mm"), rod)
