"""The regular workspace and the frequencies in it: Fig. 6, and the paper's statements on it."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from sys import float_info
from typing import Any

import numpy as np

from analytic import InputError, Limits, Mechanism, Pose
from analytic.model import Model
from analytic.workspace import heights
from harness.bench import Bench, label
from harness.causes import exact_chain
from harness.poses import columns
from harness.request import Option, Plan, Request, real
from harness.result import Result
from harness.signatures import Array, Figure
from harness.studies.workspace.checks import (
    height_table,
    region_table,
    symmetry_table,
    verdicts,
)
from harness.studies.workspace.map import Grid, Region, WorkspaceMap, workspace_map
from harness.studies.workspace.plane import FEW, MANY, OPTION, Plane, PlaneMap, plane_map
from harness.tables import Table

BATCHED, OF_CHAINS, ONE_BY_ONE = (72, 15), (36, 8), (12, 4)
"""Azimuths and tilts of models that take all poses at once, of R-P-S limbs and of other chains, and
of those that take one."""
LAYERS, MOST_LAYERS = 6, 50
MOST_POSES = 200_000


def _grid(text: str) -> tuple[int, int]:
    azimuths, _, tilts = text.partition("x")
    good = all(part.isascii() and part.isdecimal() and len(part) < 9 for part in (azimuths, tilts))
    if not good or int(azimuths) < 12 or int(tilts) < 2:
        expected = (
            "AxT: azimuths, a multiple of the number of limbs from 12 on, and 2 tilts or more"
        )
        raise InputError("grid", text, expected)
    if int(azimuths) * int(tilts) > MOST_POSES:
        raise InputError("grid", text, f"at most {MOST_POSES} poses a layer")
    return int(azimuths), int(tilts)


def _layers(text: str) -> Array:
    expected = f"up to {MOST_LAYERS} heights z in millimetres, by commas"
    height = real("layers", expected)
    values = sorted({height(part) for part in text.split(",")})
    if len(values) > MOST_LAYERS:
        raise InputError("layers", text, expected)
    return np.array(values) / 1000


def _length(name: str, text: str) -> Option:
    return Option(name, "L", text, None, real(name, "millimetres from 0", 0.0, unit=1e-3))


def _angle(name: str, text: str) -> Option:
    said = f"Largest angle of a limb from {text}; default 45 (none is printed)."
    least, unit = float_info.min, np.pi / 180
    parse = real(name, "degrees above 0 and at most 180", least, 180.0, unit)
    return Option(name, "ANGLE", said, None, parse)


OUTPUT = "workspace"
TAKES = ("cases", "case_file", "modes", "model", "shear")
DEFAULTS = {"model": "timoshenko@exact", "modes": "1-3", "cases": "case1"}
OPTIONS = (
    Option("layers", "Z,Z", "Heights z [mm]; default six over the cone.", None, _layers),
    Option(
        "grid",
        "AxT",
        "Azimuths x tilts; default 72x15, 36x8 for other chains, 12x4 for a simulator.",
        None,
        _grid,
    ),
    OPTION,
    _length("length_min_mm", "Shortest limb; default 200."),
    _length("length_max_mm", "Longest limb; default 1000."),
    _angle("spherical_max_deg", "the platform's normal"),
    _angle("revolute_max_deg", "the vertical"),
)


@dataclass(frozen=True)
class Workspace(Result):
    """A map of one model over the regular workspace.

    Attributes: `map`, layer by layer, as drawn; `fine`: at every height of the profile where poses
    are cheap, on which the statements are checked; `shown` mode numbers.
    """

    map: WorkspaceMap
    fine: WorkspaceMap
    shown: tuple[int, ...]

    def records(self) -> Iterator[dict[str, Any]]:
        """Return one row a pose and mode: z, azimuth, tilt, whether it is at the rim, frequency."""
        data, grid = self.map, self.map.grid
        where = np.nonzero(np.isfinite(data.frequencies[..., 0]))
        poses = data.region.limits.held(grid.pose(*where))
        rim, found = grid.rim[where[0]] == where[2], data.frequencies[where]
        for mode in sorted(self.shown):
            for pose, last, f in zip(poses, rim.tolist(), found, strict=True):
                yield {"model": label(data.model), **columns(pose), "rim": last, "mode": mode,
                       "frequency_hz": f[mode - 1]}  # fmt: skip

    def tables(self) -> dict[str, Table]:
        """Return the layers, the azimuthal symmetry and the change with height."""
        return {
            "-layers": region_table(self.map.region, self.map, self.shown),
            "-symmetry": symmetry_table(self.fine, self.shown),
            "-height": height_table(self.fine, self.shown),
        }

    def figures(self) -> dict[str, Figure]:
        """Return contours, surfaces, the region and ripple; none where nothing was solved."""
        if not np.isfinite(self.map.frequencies).any():
            return {}
        from harness.studies.workspace import figures

        return {
            "-contours": figures.contour_figure(self.map, self.shown),
            "-surfaces": figures.surface_figure(self.map, self.shown),
            "-region": figures.region_figure(self.map.region, self.map.grid),
            "-ripple": figures.ripple_figure(self.map, self.shown),
        }

    def sentences(self) -> list[str]:
        """Return the region and the paper's two statements in plain sentences."""
        region, *statements = verdicts(self.map.region, self.fine, self.shown)
        return [region, *(f"{line} ({label(self.map.model)})" for line in statements)]

    def rows(self) -> list[dict[str, Any]]:
        """Return the rows that the history keeps: one a pose and mode of the map."""
        return self.map.rows()

    def failures(self) -> dict[str, str]:
        """Return the poses without an answer, and why."""
        return self.fine.answers.failures | self.map.answers.failures


def workspace(
    region: Region,
    model: Model,
    shown: tuple[int, ...],
    bench: Bench,
    layers: Array | None = None,
    size: tuple[int, int] | None = None,
) -> Workspace:
    """Return the map of `model` over a region: `layers` of heights [m], `size` azimuths x tilts."""
    limbs, isolated = len(region.mechanism.limbs), model.info().isolated
    simple = region.mechanism.simple
    # Of other chains some poses are solved one by one.
    usual = ONE_BY_ONE if isolated else BATCHED if simple else OF_CHAINS
    azimuths, tilts = size or (limbs * -(-usual[0] // limbs), usual[1])
    if azimuths % limbs:
        expected = f"AxT with azimuths a multiple of the {limbs} limbs"
        raise InputError("grid", f"{azimuths}x{tilts}", expected)
    z = region.layers(LAYERS) if layers is None else layers
    drawn = workspace_map(region, Grid.of(region, z, azimuths, tilts), model, max(shown), bench)
    if isolated or not simple:
        return Workspace(drawn, drawn, shown)
    # A batch is cheap enough to check the statements at every height, not only those drawn.
    return Workspace(drawn, whole(region, model, max(shown), bench, (azimuths, tilts)), shown)


def whole(
    region: Region, model: Model, count: int, bench: Bench, size: tuple[int, int] = BATCHED
) -> WorkspaceMap:
    """Return the frequencies at all heights of a region: what the statements are checked on."""
    return workspace_map(region, Grid.of(region, region.circles.z, *size), model, count, bench)


def run(request: Request, bench: Bench) -> Workspace | PlaneMap:
    """Return the frequencies of the model over the regular workspace of the first case's mechanism.

    The paper's own model is euler-bernoulli@3. Modes are numbered by order. With --plane, over two
    of x, y and z about the case's pose instead, for robots that move so: --grid is then directions
    x steps, by default 72x9, or 12x4 for a simulator.
    """
    if len({case.mechanism for case in request.cases}) != 1:
        said = ", ".join(case.name for case in request.cases)
        raise InputError("cases", said, "one case, whose mechanism is mapped")
    options, mechanism = request.options, request.cases[0].mechanism
    pose, limits = request.cases[0].pose, _limits(mechanism, request.cases[0].pose, options)
    layers = options.get("layers")
    if (names := options.get(OPTION.name)) is not None:
        if layers is not None:
            raise InputError("layers", "heights", "none beside a plane")
        size = options.get("grid") or (FEW if request.theory.info().isolated else MANY)
        where = Plane.of(request.cases[0], names, limits, *size)
        return plane_map(where, request.theory, request.shown, bench)
    if layers is not None:
        bottom, top = heights(mechanism, limits, pose.z)
        if not ((layers >= bottom) & (layers <= top)).all():
            said = ",".join(f"{1000 * z:g}" for z in layers)
            raise InputError(
                "layers", said, f"heights from {1000 * bottom:.1f} to {1000 * top:.1f} mm"
            )
    region = Region.of(mechanism, limits, pose.z)
    return workspace(region, request.theory, request.shown, bench, layers, options.get("grid"))


def _limits(mechanism: Mechanism, pose: Pose, options: Mapping[str, Any]) -> Limits:
    """Return the limits that are asked for, at the case's torsion, and x and y if it has them."""
    names = {
        "length_min": "length_min_mm", "length_max": "length_max_mm",
        "spherical_max": "spherical_max_deg", "revolute_max": "revolute_max_deg",
    }  # fmt: skip
    given = {k: options[name] for k, name in names.items() if options.get(name) is not None}
    if given and mechanism.limited:
        name = names[next(iter(given))]
        raise InputError(name, "a limit", "none beside the limits that the mechanism states")
    usual = Limits()
    low = given.get("length_min", usual.length_min)
    high = given.get("length_max", usual.length_max)
    if high <= low:
        expected = f"more than length_min_mm = {1000 * low:g}"
        raise InputError("length_max_mm", 1000 * high, expected)
    return Limits(**given, torsion=pose.torsion, x=pose.x, y=pose.y)


def jobs(plan: Plan) -> dict[str, Request]:
    """Return what the main job asks: the exact model of the richest theory, the first mechanism.

    Where its pose says x and y, a map over them first: not every platform tilts.
    """
    richest = (*exact_chain(plan.theory)[-1:], plan.theory)[0]
    one = plan.request(cases=plan.cases[:1], theory=richest, shown=(1, 2, 3))
    if plan.cases[0].pose.x is None:
        return {"workspace": one}
    return {"workspace-plane": one.with_(options={OPTION.name: ("x", "y")}), "workspace": one}
