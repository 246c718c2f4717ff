"""The numbers of a mechanism and its pose by name, and both with some of them changed.

Parts that are equal are one number: equal limbs, rods of one kind, a stiffness that both turns of a
joint share. Parts that differ are numbered in the order they come, as rod1_diameter, rod2_diameter.
"""

from collections.abc import Hashable, Iterator, Mapping
from dataclasses import dataclass, replace
from math import hypot, inf, isclose, pi, sqrt
from typing import Any

from analytic.mechanism import Body, Limb, Link, Material, Mechanism, Platform, Rod, Section
from analytic.pose import FIELDS, Pose

Place = tuple[Any, ...]
DISC = ("disc_radius", "platform_thickness", "platform_density")
PRINTED = "Eq. 8 as printed"
UNITS = {"metres": "m", "radians": "rad"}


@dataclass(frozen=True)
class Number:
    """A number of a description: its `value` in the SI `unit`.

    `places`: where in (mechanism, pose) it stands, by fields and places in tuples; none for the
    sizes of a disc, of which the platform is made.
    """

    value: float
    unit: str
    places: tuple[Place, ...] = ()


def numbers(mechanism: Mechanism, pose: Pose) -> dict[str, Number]:
    """Return the numbers of a mechanism at a pose by name.

    Of the pose; radii of the points B_i and A_i about z; of rods `diameter`, `bore` and `length`,
    `young` and `density`; lengths of links, masses of bodies, every finite `stiffness` of a joint;
    of a disc `DISC`, of any other platform its mass and moments of inertia.
    """
    names = ("z", "azimuth", "tilt", *(() if pose.x is None else ("torsion", "x", "y")))
    found = {n: Number(getattr(pose, n), UNITS[FIELDS[n]], ((1, n),)) for n in names}
    found |= _named(_radii(mechanism.limbs))
    items = _named(_items(mechanism.limbs))
    platform = mechanism.platform
    if platform.form in ("disc", PRINTED):
        densities = [rod.material.density for limb in mechanism.limbs for rod in limb.rods]
        radius, thickness, density = map(Number, _sizes(platform, densities), ("m", "m", "kg/m^3"))
        sizes = dict(zip(DISC, (radius, thickness, density), strict=True))
        return found | {n: sizes[n] for n in DISC[:2]} | items | {DISC[2]: density}
    found["platform_mass"] = Number(platform.mass, "kg", ((0, "platform", "mass"),))
    moments = [row[k] for k, row in enumerate(platform.inertia)]
    for k, axis in enumerate("xyz"):
        like = [j for j in range(3) if isclose(moments[j], moments[k])]
        if like[0] == k:
            places = tuple((0, "platform", "inertia", j, j) for j in like)
            found[f"platform_inertia_{axis}{axis}"] = Number(moments[k], "kg m^2", places)
    return found | items


def with_numbers(
    mechanism: Mechanism, pose: Pose, changes: Mapping[str, float], form: str | None = None
) -> tuple[Mechanism, Pose]:
    """Return a mechanism at a pose with some of its `numbers` changed, SI, Poisson's ratios kept.

    `form` of a disc: "disc", or what Eq. 8 makes of it; None: as it is. Raises `InputError` for
    what cannot be, and `KeyError` for a name that is none of its numbers.
    """
    known = numbers(mechanism, pose)
    tree: dict[Any, Any] = {}
    for name, value in changes.items():
        for place in known[name].places:
            node = tree
            for key in place[:-1]:
                node = node.setdefault(key, {})
            node[place[-1]] = value
    moved, there = _changed((mechanism, pose), tree)
    before = mechanism.platform.form
    of = (*DISC, "platform_radius") if PRINTED in (form, before) else DISC
    if DISC[0] in known and (form not in (None, before) or any(name in changes for name in of)):
        sizes = {name: number.value for name, number in known.items()} | dict(changes)
        mass, across, polar = disc(sizes, form or before)
        platform = Platform.diagonal(mass, (across, across, polar), form or before)
        moved = replace(moved, platform=platform)
    return moved, there


def disc(numbers: Mapping[str, Any], form: str = "disc") -> tuple[Any, Any, Any]:
    """Return the mass of a disc [kg], and its moments across and polar [kg m^2], from `numbers`.

    As `PRINTED` it has Eq. 8's moments, m r2^2 about all axes. Numbers may be arrays.
    """
    R, h, density = (numbers[name] for name in DISC)
    mass = density * pi * R**2 * h
    if form == PRINTED:
        moment = mass * numbers.get("platform_radius", R) ** 2
        return mass, moment, moment
    return mass, mass * (3 * R**2 + h**2) / 12, mass * R**2 / 2


def _sizes(platform: Platform, densities: list[float]) -> tuple[float, float, float]:
    """Return a disc's radius, thickness and density: one of `densities` if it can be.

    Eq. 8 does not tell the last two apart: then it is the first, or 1 m thick.
    """
    printed = platform.form == PRINTED
    squared = (1 if printed else 2) * platform.inertia[2][2] / platform.mass
    surface = platform.mass / (pi * squared)
    thin = sqrt(max(12 * platform.inertia[0][0] / platform.mass - 3 * squared, 0.0))
    for density in densities:
        if printed or isclose(surface / density, thin, rel_tol=1e-6):
            return sqrt(squared), surface / density, density
    thin = 1.0 if printed else thin
    return sqrt(squared), thin, surface / thin


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


Found = tuple[str, str, Hashable, Number]
"""What a number is of, its name there, what makes it one of several, and itself."""


def _radii(limbs: tuple[Limb, ...]) -> Iterator[Found]:
    for stem, field in (("base", "base"), ("platform", "platform_point")):
        for i, limb in enumerate(limbs):
            radius = hypot(*getattr(limb, field)[:2])
            if radius > 0:
                place = (0, "limbs", i, field, "radius")
                yield stem, "radius", f"{radius:.9g}", Number(radius, "m", (place,))


def _items(limbs: tuple[Limb, ...]) -> Iterator[Found]:
    for at, item in (
        ((0, "limbs", i, "chain", k), item)
        for i, limb in enumerate(limbs)
        for k, item in enumerate(limb.chain)
    ):
        if isinstance(item, Rod) and item.section.diameter is not None:
            for name in ("diameter", "bore"):
                if size := getattr(item.section, name):
                    yield "rod", name, item, Number(size, "m", ((*at, "section", name),))
        if isinstance(item, (Rod, Link)) and item.length is not None:
            stem = "rod" if isinstance(item, Rod) else "link"
            yield stem, "length", item, Number(item.length, "m", ((*at, "length"),))
        if isinstance(item, Rod):
            for name, unit in (("young", "Pa"), ("density", "kg/m^3")):
                value, place = getattr(item.material, name), (*at, "material", name)
                yield "material", name, item.material, Number(value, unit, (place,))
        elif isinstance(item, Body):
            yield "body", "mass", item.mass, Number(item.mass, "kg", ((*at, "mass"),))
        elif not isinstance(item, Link):
            for j, f in enumerate(item.freedoms):
                unit = "N m/rad" if f.kind == "rotation" else "N/m"
                own = Number(f.stiffness, unit, ((*at, "freedoms", j, "stiffness"),))
                if 0 < f.stiffness < inf:
                    yield item.name, "stiffness", (f.kind, f.stiffness), own


def _named(found: Iterator[Found]) -> dict[str, Number]:
    """Return numbers by name: things that differ are numbered, with all that is theirs."""
    kinds: dict[str, list[Hashable]] = {}
    same: dict[tuple[str, str, Hashable], list[Number]] = {}
    for stem, what, which, number in found:
        same.setdefault((stem, what, which), []).append(number)
        if which not in kinds.setdefault(stem, []):
            kinds[stem].append(which)
    result = {}
    for (stem, what, which), some in same.items():
        mark = kinds[stem].index(which) + 1 if len(kinds[stem]) > 1 else ""
        places = tuple(place for one in some for place in one.places)
        name = f"{stem}{mark}_{what}".removeprefix("material_")
        result[name] = replace(some[0], places=places)
    return result
