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
from functools import cache
from pathlib import Path
from typing import Any

from analytic import InputError, Limb, Material, Mechanism, Platform, Rod
from analytic.errors import count, vector
from analytic.mechanism import LARGEST, MOST_LIMBS, SMALLEST
from harness.case import Case
from harness.chain_file import (
    MATERIAL,
    POSE,
    chain_mechanism,
    material,
    materials,
    read_pose,
    rods,
)
from harness.paper import CASES, CHECKED, case_file, folder, names, read_paper
from harness.toml_table import Given
from reference_models import parse

Table = dict[str, Any]
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
    Given("the file", data, ("materials", "rods", "mechanisms", "cases"))
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
    given = Given(f"cases.{name}", table, ("mechanism", *POSE, "model", "note", *more))
    if "," in name:
        raise InputError(given.where, name, "a name without commas")
    mechanism = given.one_of("mechanism", mechanisms, "paper")
    z = given.get("z_mm", 0.0)
    if isinstance(z, (int, float)) and abs(z) > LARGEST * 1000:
        raise given.refused("z_mm", f"at most {LARGEST * 1000:g} millimetres")
    pose = read_pose(given)
    note = str(given.get("note", f"{given.get('mechanism', 'paper')} of {source}"))
    theory = parse(str(given.get("model", "euler-bernoulli")), given.at("model"))
    published, title = (str(given.get(key, "")) for key in ("published", "title"))
    errata = tuple(map(str, given.get("errata", ())))
    return Case(name, mechanism, pose, note, theory, published, errata, title)


def _mechanism(table: Table, where: str) -> Mechanism:
    regular = "base_radius_mm", "platform_radius_mm", "limbs", "heading_deg"
    shape = ("limb",) if "limb" in table else regular
    heavy = "platform_mass_kg", "platform_inertia_kg_m2"
    disc = "platform_thickness_mm", "platform_radius_mm", "inertia"
    body = heavy if "platform_mass_kg" in table else disc
    given = Given(where, table, (*MATERIAL, "rod_diameter_mm", *shape, *body))
    steel = material(given)
    platform = _platform(given, steel)
    if "limb" in given:
        limbs = given.get("limb")
        if not isinstance(limbs, list) or not limbs:
            raise given.refused("limb", f"tables called [[{where}.limb]]")
        return Mechanism(tuple(_limb(limb, given, steel) for limb in limbs), platform)
    base, points = (given.number(key, positive=True) for key in regular[:2])
    number = count(given.at("limbs"), given.get("limbs", 3), at_most=MOST_LIMBS)
    heading = given.number("heading_deg", 0.0)
    rod = _rod(given, steel)
    return Mechanism.regular(base, points, rod, platform, limbs=number, heading=heading)


def _rod(given: Given, steel: Material) -> Rod:
    within = 1000 * SMALLEST, 1000 * LARGEST
    return Rod.round(steel, given.number("rod_diameter_mm", positive=True, within=within))


def _platform(given: Given, steel: Material) -> Platform:
    if "platform_mass_kg" in given:
        key, mass = "platform_inertia_kg_m2", given.number("platform_mass_kg", positive=True)
        try:
            return Platform(mass, given.get(key))
        except InputError as error:
            raise given.refused(key, error.expected) from None
    forms = {"disc": Platform.disc, "printed": Platform.as_printed}
    form: Callable[..., Platform] = given.one_of("inertia", forms, "disc")
    sizes = "platform_radius_mm", "platform_thickness_mm"
    return form(*(given.number(key, positive=True) for key in sizes), steel.density)


def _limb(limb: Any, of: Given, steel: Material) -> Limb:
    keys = "base_mm", "axis", "platform_point_mm", "rod_diameter_mm"
    given = Given(of.at("limb"), limb, keys)
    rod = _rod(given if "rod_diameter_mm" in given else of, steel)
    axis = vector(given.at("axis"), given.get("axis"), "a direction other than zero")
    if not any(axis):
        raise given.refused("axis", "a direction other than zero")
    return Limb.rps(given.metres("base_mm"), axis, given.metres("platform_point_mm"), rod)
