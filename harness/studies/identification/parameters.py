"""The numbers of a mechanism and its pose that a table of frequencies may be asked for, by name.

The end of a name is its unit. Parts that are equal are one parameter: equal limbs, rods of one
kind, a stiffness that both turns of a joint share.
"""

from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import hypot, inf, isclose, pi, sqrt
from typing import Any

import numpy as np

from analytic import Body, Link, Material, Mechanism, Platform, Pose, Rod, Section
from harness.case import Case

UNITS = {"mm": 1e-3, "deg": pi / 180, "GPa": 1e9, "kg_m3": 1.0, "kg_m2": 1.0, "kg": 1.0,
         "N_m": 1.0, "Nm_rad": 1.0}  # fmt: skip
"""SI values of the units at the ends of names."""
INERTIAS = {"disc": "disc", "printed": "Eq. 8 as printed"}
DISC = ("disc_radius_mm", "platform_thickness_mm", "platform_density_kg_m3")
FOLLOWS = {"disc_radius_mm": "platform_radius_mm", "platform_density_kg_m3": "density_kg_m3"}
"""A disc ends where the joints are and is made of what the rods are made of, if it does at first
and nothing else is asked."""
LETTERS = {
    "z_mm": "z", "azimuth_deg": "phi", "tilt_deg": "theta", "base_radius_mm": "r1",
    "platform_radius_mm": "r2", "disc_radius_mm": "R", "platform_thickness_mm": "h",
    "rod_diameter_mm": "d", "young_GPa": "E", "density_kg_m3": "rho",
    "platform_density_kg_m3": "rho_p",
}  # fmt: skip
BOUNDS = {
    "z_mm": (0.65, 1.6), "base_radius_mm": (0.1, 2.0), "radius_mm": (0.5, 2.0),
    "diameter_mm": (0.6, 1.4), "bore_mm": (0.6, 1.4), "length_mm": (0.65, 1.6),
    "platform_density_kg_m3": (0.25, 4.0), "young_GPa": (0.5, 2.0), "density_kg_m3": (0.5, 2.0),
    "N_m": (0.1, 10.0), "Nm_rad": (0.1, 10.0), "": (0.25, 4.0),
}  # fmt: skip
"""Default bounds as factors of what is given, by the ends of names; the first that fits."""
ANGLES = {"azimuth_deg": 180.0, "tilt_deg": 45.0, "torsion_deg": 45.0}
"""Default bounds of angles: so far from zero, or from what is given if that is beyond."""
LINEAR = (*ANGLES, "x_mm", "y_mm")

Path = tuple[Any, ...]


@dataclass(frozen=True)
class Parameter:
    """A number of a case: its `value`, and default bounds, in the unit of its name.

    `linear`: it may be zero or change its sign, and is fitted itself instead of its logarithm.
    `paths`: where in (mechanism, pose) it stands, by fields and places in tuples.
    """

    value: float
    low: float
    high: float
    linear: bool
    paths: tuple[Path, ...] = ()


def unit(name: str) -> str:
    """Return the unit that a parameter's name ends with."""
    return next(end for end in UNITS if name.endswith(f"_{end}"))


def letter(name: str) -> str:
    """Return what a parameter is called in a product of powers."""
    return LETTERS.get(name) or name.removesuffix(f"_{unit(name)}")


def parameters(case: Case) -> dict[str, Parameter]:
    """Return the numbers of a case by name."""
    mechanism, pose = case.mechanism, case.pose
    size = 500 * max(hypot(*limb.base) + hypot(*limb.platform_point) for limb in mechanism.limbs)
    found: dict[str, Parameter] = {}

    def add(name: str, value: float, *paths: Path) -> None:
        value /= UNITS[unit(name)]
        factors = next(pair for end, pair in BOUNDS.items() if name.endswith(end))
        low, high = sorted(factor * value for factor in factors)
        if name in LINEAR or not value:
            reach = ANGLES.get(name, size)
            middle = value if abs(value) > reach or name not in ANGLES else 0.0
            low, high = middle - reach, middle + reach
        linear = name in LINEAR or value <= 0
        found[name] = Parameter(value, low, high, linear, paths)

    more = () if pose.x is None else ("torsion_deg", "x_mm", "y_mm")
    for name in ("z_mm", "azimuth_deg", "tilt_deg", *more):
        field = name.rpartition("_")[0]
        add(name, getattr(pose, field), (1, field))
    for own, value, paths in _numbered(_radii(mechanism)):
        add(own, value, *paths)
    items, platform = list(_numbered(_items(mechanism))), mechanism.platform
    if disc(mechanism):
        rods = (rod for limb in mechanism.limbs for rod in limb.rods)
        radius, thickness, density = _sizes(platform, [rod.material.density for rod in rods])
        add(DISC[0], radius)
        add(DISC[1], thickness)
        items.append((DISC[2], density, []))
    else:
        add("platform_mass_kg", platform.mass, (0, "platform", "mass"))
        moments = [row[k] for k, row in enumerate(platform.inertia)]
        for k, axis in enumerate("xyz"):
            like = [j for j in range(3) if isclose(moments[j], moments[k], rel_tol=1e-9)]
            if like[0] == k:
                paths = [(0, "platform", "inertia", j, j) for j in like]
                add(f"platform_inertia_{axis}{axis}_kg_m2", moments[k], *paths)
    for own, value, paths in items:
        add(own, value, *paths)
    return found


def described(
    case: Case, values: Mapping[str, float], inertia: str = "disc"
) -> tuple[Mechanism, Pose]:
    """Return the mechanism and the pose of a case with its parameters changed to `values`.

    A platform of `DISC` is a disc, or with `inertia` "printed" what Eq. 8 makes of one. Poisson's
    ratios stay. Raises `InputError` for what cannot be.
    """
    tree: dict[Any, Any] = {}
    for name, p in parameters(case).items():
        for path in p.paths if values[name] != p.value else ():
            node = tree
            for key in path[:-1]:
                node = node.setdefault(key, {})
            node[path[-1]] = values[name] * UNITS[unit(name)]
    mechanism, pose = _changed((case.mechanism, case.pose), tree)
    if disc(case.mechanism):
        mass, across, polar = body(values, inertia)
        platform = Platform.diagonal(mass, (across, across, polar), INERTIAS[inertia])
        moved = abs(mass / mechanism.platform.mass - 1) > 1e-12 or not np.allclose(
            platform.inertia, mechanism.platform.inertia, rtol=1e-12, atol=0
        )
        if moved:
            mechanism = replace(mechanism, platform=platform)
    return mechanism, pose


def _changed(thing: Any, tree: Any) -> Any:
    """Return `thing` with what `tree` says of its fields, or of its places if it is a tuple."""
    if not isinstance(tree, dict):
        return tree
    if "radius" in tree:
        x, y, z = thing
        grown = tree["radius"] / hypot(x, y)
        return x * grown, y * grown, z
    if isinstance(thing, tuple):
        return tuple(_changed(one, tree.get(k, one)) for k, one in enumerate(thing))
    new = {key: _changed(getattr(thing, key), below) for key, below in tree.items()}
    if isinstance(thing, Section):
        return Section.round(**{"diameter": thing.diameter, "bore": thing.bore} | new)
    if isinstance(thing, Material) and "young" in new:
        new["shear"] = thing.shear * new["young"] / thing.young
    return replace(thing, **new)


def body(values: Mapping[str, Any], inertia: str) -> tuple[Any, Any, Any]:
    """Return the mass of a disc [kg], and its moments across and polar [kg m^2].

    With `inertia` "printed" it has Eq. 8's moments, m r2^2 about all axes.
    """
    R, h, density = (values[name] * UNITS[unit(name)] for name in DISC)
    mass = density * pi * R**2 * h
    if inertia == "printed":
        moment = mass * (values["platform_radius_mm"] / 1e3) ** 2
        return mass, moment, moment
    return mass, mass * (3 * R**2 + h**2) / 12, mass * R**2 / 2


def _sizes(platform: Platform, densities: Sequence[float]) -> tuple[float, float, float]:
    """Return the radius, the thickness and the density of a disc, one of `densities` if it can be.

    Eq. 8 does not tell the last two apart: then it is the first.
    """
    printed = platform.form == INERTIAS["printed"]
    squared = (1 if printed else 2) * platform.inertia[2][2] / platform.mass
    thin = sqrt(max(12 * platform.inertia[0][0] / platform.mass - 3 * squared, 0.0))
    surface = platform.mass / (pi * squared)
    for density in densities:
        if printed or isclose(surface / density, thin, rel_tol=1e-6):
            return sqrt(squared), surface / density, density
    return sqrt(squared), thin, surface / thin


def disc(mechanism: Mechanism) -> bool:
    """Whether the numbers of its platform are those of a disc."""
    return mechanism.platform.form == "disc" or regular(mechanism)


def regular(mechanism: Mechanism) -> bool:
    """Whether it has three equal R-P-S limbs 120 degrees apart, and a disc (or Eq. 8's)."""
    if not mechanism.simple or mechanism.platform.form not in INERTIAS.values():
        return False
    rod = mechanism.limbs[0].rod
    r1, r2 = (float(hypot(*p[0, :2])) for p in (mechanism.bases, mechanism.platform_points))
    if len(mechanism.limbs) != 3 or not r1 or not r2:
        return False
    same = Mechanism.regular(r1, r2, rod, mechanism.platform, heading=heading(mechanism))
    return all(limb.rod == rod for limb in mechanism.limbs) and all(
        np.allclose(getattr(same, name), getattr(mechanism, name), atol=1e-9)
        for name in ("bases", "axes", "platform_points")
    )


def heading(mechanism: Mechanism) -> float:
    """Return the angle of the first limb [rad]."""
    x, y, _ = mechanism.limbs[0].base
    return float(np.arctan2(y, x))


Found = tuple[str, str, Hashable, float, Path]
"""What a number is of, its name there, what makes it one of several, its value, and where."""


def _radii(mechanism: Mechanism) -> Iterator[Found]:
    for stem, field in (("base", "base"), ("platform", "platform_point")):
        for i, limb in enumerate(mechanism.limbs):
            radius = hypot(*getattr(limb, field)[:2])
            if radius > 1e-9:
                yield stem, "radius_mm", f"{radius:.9g}", radius, (0, "limbs", i, field, "radius")


def _items(mechanism: Mechanism) -> Iterator[Found]:
    for i, limb in enumerate(mechanism.limbs):
        for k, item in enumerate(limb.chain):
            at = (0, "limbs", i, "chain", k)
            if isinstance(item, (Rod, Link)):
                stem = "rod" if isinstance(item, Rod) else "link"
                section = item.section if isinstance(item, Rod) else None
                sizes = [
                    ("diameter_mm", section and section.diameter, (*at, "section", "diameter")),
                    ("bore_mm", section and section.bore, (*at, "section", "bore")),
                    ("length_mm", item.length, (*at, "length")),
                ]
                for what, size, place in sizes:
                    if size:
                        yield stem, what, item, size, place
                for what, name in (("young_GPa", "young"), ("density_kg_m3", "density")):
                    if isinstance(item, Rod):
                        value, place = getattr(item.material, name), (*at, "material", name)
                        yield "material", what, item.material, value, place
            elif isinstance(item, Body):
                yield "body", "mass_kg", item.mass, item.mass, (*at, "mass")
            else:
                for j, f in enumerate(item.freedoms):
                    end = "Nm_rad" if f.kind == "rotation" else "N_m"
                    if 0 < f.stiffness < inf:
                        place = (*at, "freedoms", j, "stiffness")
                        yield item.name, f"stiffness_{end}", f.stiffness, f.stiffness, place


def _numbered(found: Iterator[Found]) -> Iterator[tuple[str, float, list[Path]]]:
    """Yield names, values and places: things that differ are numbered in the order they come."""
    places: dict[tuple[str, str, Hashable], list[Path]] = {}
    values: dict[tuple[str, str, Hashable], float] = {}
    kinds: dict[str, dict[Hashable, None]] = {}
    for stem, what, which, value, path in found:
        key = stem, what, which
        places.setdefault(key, []).append(path)
        values.setdefault(key, value)
        kinds.setdefault(_kind(stem, what), {}).setdefault(which)
    for key, paths in places.items():
        stem, what, which = key
        order = list(kinds[_kind(stem, what)])
        number = str(order.index(which) + 1) if len(order) > 1 else ""
        name = f"{stem}{number}_{what}".removeprefix("material_")
        yield name, values[key], paths


def _kind(stem: str, what: str) -> str:
    """Return among which things one is numbered: all sizes of a rod have its number."""
    return f"{stem}_{what}" if what.startswith("stiffness") else stem
