"""The regular workspace and the frequencies in it: Fig. 6, and the paper's statements on it.

Also maps over a plane of two of x, y and z, out to where the limits end: of hexapods and others.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from sys import float_info
from typing import Any

import numpy as np

from analytic import InputError, Limits
from analytic.model import Model
from analytic.workspace import heights
from harness.bench import Bench, label
from harness.case import Case
from harness.causes import exact_chain
from harness.compare import at
from harness.poses import cells, columns, headings
from harness.request import Option, Plan, Request, real
from harness.result import Result
from harness.rows import PLANE
from harness.signatures import Array, Figure
from harness.studies.workspace import checks
from harness.studies.workspace.map import Grid, Map, Plane, Region, limits_met, limits_said
from harness.tables import Number, Row, Table

BATCHED, OF_CHAINS, ONE_BY_ONE = (72, 15), (36, 8), (12, 4)
"""Azimuths and tilts of models that take all poses at once, of R-P-S limbs and of other chains, and
of those that take one."""
MANY = (72, 9)
"""Directions and steps of a plane, of models that run in this process; others have `ONE_BY_ONE`."""
LAYERS, MOST_LAYERS = 6, 50
MOST_POSES = 200_000
PLANES = "x,y", "x,z", "y,z"


def _grid(text: str) -> tuple[int, int]:
    found = re.fullmatch("([0-9]{1,8})x([0-9]{1,8})", text)
    azimuths, tilts = (int(part) for part in found.groups()) if found else (0, 0)
    if azimuths < 12 or tilts < 2:
        expected = (
            "AxT: azimuths, a multiple of the number of limbs from 12 on, and 2 tilts or more"
        )
        raise InputError("grid", text, expected)
    if azimuths * tilts > MOST_POSES:
        raise InputError("grid", text, f"at most {MOST_POSES} poses a layer")
    return azimuths, tilts


def _layers(text: str) -> Array:
    expected = f"up to {MOST_LAYERS} heights z in millimetres, by commas"
    height = real("layers", expected)
    values = sorted({height(part) for part in text.split(",")})
    if len(values) > MOST_LAYERS:
        raise InputError("layers", text, expected)
    return np.array(values) / 1000


def _plane(text: str) -> tuple[str, str]:
    if text not in PLANES:
        raise InputError("plane", text, f"one of {' '.join(PLANES)}")
    return text[0], text[2]


OUTPUT = "workspace"
TAKES = ("cases", "case_file", "modes", "model", "shear")
DEFAULTS = {"model": "timoshenko@exact", "modes": "1-3", "cases": "case1"}
OPTION = Option(
    "plane", "A,B", f"Map a plane of o's coordinates instead: {' '.join(PLANES)}.", None, _plane
)
LIMITS = (
    *(Option(f"length_{end}_mm", "L", f"{which} limb; default {usual}.", None,
             real(f"length_{end}_mm", "millimetres from 0", 0.0, unit=1e-3))
      for end, which, usual in (("min", "Shortest", 200), ("max", "Longest", 1000))),
    *(Option(f"{joint}_max_deg", "ANGLE",
             f"Largest angle of a limb from {what}; default 45 (none is printed).", None,
             real(f"{joint}_max_deg", "degrees above 0 and at most 180", float_info.min, 180.0,
                  np.pi / 180))
      for joint, what in (("spherical", "the platform's normal"), ("revolute", "the vertical"))),
)  # fmt: skip
OPTIONS = (
    Option("layers", "Z,Z", "Heights z [mm]; default six over the cone.", None, _layers),
    Option("grid", "AxT",
           "Azimuths x tilts; default 72x15, 36x8 for other chains, 12x4 for a simulator.", None,
           _grid),
    OPTION,
    *LIMITS,
)  # fmt: skip


@dataclass(frozen=True)
class Workspace(Result):
    """A map of one model over the regular workspace.

    Attributes: `map`, layer by layer, as drawn; `fine`: at every height of the profile where poses
    are cheap, on which the statements are checked; `shown` mode numbers.
    """

    map: Map[Grid]
    fine: Map[Grid]
    shown: tuple[int, ...]

    def records(self) -> Iterator[dict[str, Any]]:
        """Return one row a pose and mode: z, azimuth, tilt, whether it is at the rim, frequency."""
        return self.map.records(sorted(self.shown), self.map.grid.there)

    def tables(self) -> dict[str, Table]:
        """Return the layers, the azimuthal symmetry and the change with height."""
        return {
            "-layers": checks.region_table(self.map, self.shown),
            "-symmetry": checks.symmetry_table(self.fine, self.shown),
            "-height": checks.height_table(self.fine, self.shown),
        }

    def figures(self) -> dict[str, Figure]:
        """Return contours, surfaces, the region and ripple; none where nothing was solved."""
        if not np.isfinite(self.map.frequencies).any():
            return {}
        from harness.studies.workspace import figures

        return {
            "-contours": figures.contour_figure(self.map, self.shown),
            "-surfaces": figures.surface_figure(self.map, self.shown),
            "-region": figures.region_figure(self.map.grid),
            "-ripple": figures.ripple_figure(self.map, self.shown),
        }

    def sentences(self) -> list[str]:
        """Return the region and the paper's two statements in plain sentences."""
        region, *statements = checks.verdicts(self.fine, self.shown)
        return [region, *(f"{line} ({label(self.map.answers.model)})" for line in statements)]

    def rows(self) -> list[dict[str, Any]]:
        """Return the rows that the history keeps: one a pose and mode, a level platform once."""
        return self.map.answers.rows()

    def failures(self) -> dict[str, str]:
        """Return the poses without an answer, and why."""
        return self.fine.answers.failures | self.map.answers.failures


@dataclass(frozen=True)
class PlaneMap(Result):
    """A `map` of one model over a plane; `shown` mode numbers."""

    map: Map[Plane]
    shown: tuple[int, ...]

    def records(self) -> Iterator[dict[str, Any]]:
        """Return one row a mode and pose: where it is, whether it is at the rim, frequency."""
        return self.map.records(self.shown, self.map.grid.wanted)

    def tables(self) -> dict[str, Table]:
        """Return where each mode is lowest and highest, and what ends the plane."""
        plane, model = self.map.grid, label(self.map.answers.model)
        shown, rows = [f"{name}_m" for name in plane.names], list[Row]()
        for mode in self.shown:
            f = self.map.frequencies[..., mode - 1]
            for word, find in (("lowest", np.nanargmin), ("highest", np.nanargmax)):
                if np.isfinite(f).any():
                    k, j = np.unravel_index(find(f), f.shape)
                    place = cells(columns(plane.poses[int(k), int(j)]), shown)
                    rows.append((f"f{mode}", word, Number(f[k, j], 3), *place))
        ends, held = plane.far[:, -1], (plane.mechanism, plane.limits)
        met = limits_met(*held, plane.poses[int(ends.argmin()), -1])
        nearest = f"nearest end, {1000 * ends.min():.2f} mm away: {met}"
        title = f"{plane.case.name} over {' and '.join(plane.names)}: {model}"
        heads = ("Mode", "", "f [Hz]", *headings(shown))
        return {"": Table(title, heads, rows, (limits_said(*held), nearest, checks.ORDER))}

    def figures(self) -> dict[str, Figure]:
        """Return contours, a panel a mode, each with its own scale; none without an answer."""
        if not np.isfinite(self.map.frequencies).any():
            return {}
        from harness.studies.workspace.figures import plane_figure

        return {"": plane_figure(self.map, self.shown)}

    def sentences(self) -> list[str]:
        """Return the reach, and the range of every mode."""
        plane, f = self.map.grid, at(self.map.frequencies, self.shown)
        ends = 1000 * plane.far[:, -1]
        reach = (
            f"In the plane of {' and '.join(plane.names)} the platform of {plane.case.name} "
            f"reaches {ends.min():.1f} to {ends.max():.1f} mm from its pose, all else as there."
        )
        if not np.isfinite(f).any():
            return [reach]
        found = zip(self.shown, np.nanmin(f, axis=(0, 1)), np.nanmax(f, axis=(0, 1)), strict=True)
        ranges = ", ".join(f"f{mode} {low:.2f} to {high:.2f} Hz" for mode, low, high in found)
        return [reach, f"There {label(self.map.answers.model)} finds {ranges}."]

    def rows(self) -> list[dict[str, Any]]:
        """Return one row a pose and mode for the history."""
        return self.map.answers.rows(PLANE)

    def failures(self) -> dict[str, str]:
        """Return the poses without an answer, and why."""
        return self.map.answers.failures


def whole(
    region: Region, model: Model, count: int, bench: Bench, size: tuple[int, int] = BATCHED
) -> Map[Grid]:
    """Return the frequencies at all heights of a region: what the statements are checked on."""
    return Map.of(Grid.of(region, region.circles.z, *size), model, count, bench)


def run(request: Request, bench: Bench) -> Workspace | PlaneMap:
    """Return the frequencies of the model over the regular workspace of the first case's mechanism.

    The paper's own model is euler-bernoulli@3. Modes are numbered by order. With --plane, over two
    of x, y and z about the case's pose instead, for robots that move so: --grid is then directions
    x steps, by default 72x9, or 12x4 for a simulator.
    """
    if len({case.mechanism for case in request.cases}) != 1:
        said = ", ".join(case.name for case in request.cases)
        raise InputError("cases", said, "one case, whose mechanism is mapped")
    options, model, case, count = request.options, request.theory, request.cases[0], request.count
    mechanism, limits = case.mechanism, _limits(case, options)
    isolated, layers, size = model.info().isolated, options.get("layers"), options.get("grid")
    if (names := options.get(OPTION.name)) is not None:
        if layers is not None:
            raise InputError("layers", "heights", "none beside a plane")
        plane = Plane.of(case, names, limits, *(size or (ONE_BY_ONE if isolated else MANY)))
        return PlaneMap(Map.of(plane, model, count, bench), request.shown)
    if layers is not None:
        bottom, top = heights(mechanism, limits, case.pose.z)
        if not ((layers >= bottom) & (layers <= top)).all():
            said = ",".join(f"{1000 * z:g}" for z in layers)
            expected = f"heights from {1000 * bottom:.1f} to {1000 * top:.1f} mm"
            raise InputError("layers", said, expected)
    region, limbs = Region.of(mechanism, limits, case.pose.z), len(mechanism.limbs)
    # Of other chains some poses are solved one by one.
    usual = ONE_BY_ONE if isolated else BATCHED if mechanism.simple else OF_CHAINS
    azimuths, tilts = size or (limbs * -(-usual[0] // limbs), usual[1])
    if azimuths % limbs:
        expected = f"AxT with azimuths a multiple of the {limbs} limbs"
        raise InputError("grid", f"{azimuths}x{tilts}", expected)
    z = region.layers(LAYERS) if layers is None else layers
    fine = drawn = Map.of(Grid.of(region, z, azimuths, tilts), model, count, bench)
    if mechanism.simple and not isolated:
        # A batch is cheap enough to check the statements at every height, not only those drawn.
        fine = whole(region, model, count, bench, (azimuths, tilts))
    return Workspace(drawn, fine, request.shown)


def _limits(case: Case, options: Mapping[str, Any]) -> Limits:
    """Return the limits that are asked for, at the case's torsion, and x and y if it has them."""
    given = {one.name: options[one.name] for one in LIMITS if options.get(one.name) is not None}
    if given and case.mechanism.limited:
        raise InputError(
            next(iter(given)), "a limit", "none beside the limits that the mechanism states"
        )
    usual, pose = Limits(), case.pose
    low = given.get("length_min_mm", usual.length_min)
    high = given.get("length_max_mm", usual.length_max)
    if high <= low:
        expected = f"more than length_min_mm = {1000 * low:g}"
        raise InputError("length_max_mm", 1000 * high, expected)
    asked = {name.rpartition("_")[0]: value for name, value in given.items()}
    return Limits(**asked, torsion=pose.torsion, x=pose.x, y=pose.y)


def jobs(plan: Plan) -> dict[str, Request]:
    """Return what the main job asks: the exact model of the richest theory, the first mechanism.

    Where its pose says x and y, a map over them first: not every platform tilts.
    """
    richest = (*exact_chain(plan.theory)[-1:], plan.theory)[0]
    one = plan.request(cases=plan.cases[:1], theory=richest, shown=(1, 2, 3))
    over = {"workspace-plane": one.with_(options={OPTION.name: ("x", "y")}), "workspace": one}
    return over if plan.cases[0].pose.x is not None else {"workspace": one}
