"""Static stiffness at the platform: how much, of which part, and over any poses."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from analytic import InputError, Joint, Limits, Mechanism, Pose, Rod, Stiffness, stiffness
from harness.bench import Bench
from harness.case import Case
from harness.compare import cells as numbers
from harness.figures import COLOURS, panels
from harness.plan import Plan
from harness.poses import cells, columns, headings, named, used
from harness.request import Option, Request
from harness.result import Result
from harness.signatures import Array, Figure
from harness.studies.workspace.plane import MANY, OPTION, Plane
from harness.tables import Cell, Number, Table

TAKES = ("cases", "case_file", "shear")
LOADS = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
SHOWN = np.repeat([1e-6, 1e-3], 3)
"""N/um and kN m/rad in SI."""
MOST_POSES = 20_000
OPTIONS = (
    Option("poses", "SET", "Poses of a map, as `sweep` takes them; default none.", None, str),
    OPTION,
)

ROUNDING = 1e-10
"""An entry below this part of its diagonals' mean is none: rounding, another on every machine."""


@dataclass(frozen=True)
class Map:
    """The least stiffness of a case's mechanism to a force (n,) [N/m] and a moment [N m/rad].

    `plane`, if `poses` are those wanted of one.
    """

    case: Case
    poses: Pose
    force: Array
    moment: Array
    plane: Plane | None = None


@dataclass(frozen=True)
class Stiffnesses(Result):
    """The static stiffness `found` at every case, and of one mechanism the `maps` over poses."""

    found: dict[Case, Stiffness]
    maps: tuple[Map, ...]

    @cached_property
    def parts(self) -> dict[Case, dict[str, list[int]]]:
        """Like parts of every case by name, and which they are in `Stiffness`: equal items at the
        same place of equal chains."""
        return {case: _parts(case.mechanism, found) for case, found in self.found.items()}

    def records(self) -> Iterator[dict[str, Any]]:
        """Return one row a case, part and load alone: the compliance, and the part's share.

        Of a map one row a pose: where it is, and its softest direction's stiffness.
        """
        for case, found in self.found.items():
            whole = np.diag(found.compliance)
            for (limb, item, what), shares in zip(found.parts, found.shares, strict=True):
                for k, load in enumerate(LOADS):
                    unit = "m_n" if k < 3 else "rad_nm"
                    yield {
                        "case": case.name, "limb": limb, "item": item, "part": what, "load": load,
                        "compliance_m_n": whole[k] if unit == "m_n" else np.nan,
                        "compliance_rad_nm": whole[k] if unit == "rad_nm" else np.nan,
                        "share": shares[k],
                    }  # fmt: skip
        for one in self.maps:
            for pose, force, moment in zip(one.poses, one.force, one.moment, strict=True):
                yield {"case": one.case.name, **columns(pose),
                       "softest_n_m": force, "softest_nm_rad": moment}  # fmt: skip

    def tables(self) -> dict[str, Table]:
        """Return stiffness to each load, the shares of like parts, the matrices, and the maps."""
        tables = {"": self._summary(), "-parts": self._shares(), "-matrix": self._matrices()}
        return tables | ({"-map": self._map()} if self.maps else {})

    def _summary(self) -> Table:
        rows = tuple(
            (case.name, *numbers(SHOWN / np.diag(found.compliance), 3),
             Number(1e-6 * found.softest()[0], 3), _softest(found),
             Number(1e-3 * found.softest(turns=True)[0], 3), _softest(found, turns=True))
            for case, found in self.found.items()
        )  # fmt: skip
        heads = ("Case", *LOADS, "least", "along", "least turning", "about")
        notes = (
            "N/um to a force at o alone, kN m/rad to a moment alone, the platform free to follow: "
            "1 / compliance; rods are sheared beams, for which one element is exact at rest",
        )
        return Table("Static stiffness at the platform", heads, rows, notes)

    def _shares(self) -> Table:
        rows: list[tuple[Cell, ...]] = []
        for case, found in self.found.items():
            soft, turning = found.softest()[2], found.softest(turns=True)[2]
            every = 100 * np.column_stack([found.shares, soft, turning])
            for name, which in self.parts[case].items():
                limbs = len({found.parts[k][0] for k in which})
                rows.append((case.name, name, limbs, *numbers(every[which].sum(axis=0), 1)))
        heads = ("Case", "Part", "Limbs", *LOADS, "softest force", "softest moment")
        notes = ("every column of a case sums to 100",)
        return Table("Who gives way: share of the compliance [%]", heads, tuple(rows), notes)

    def _matrices(self) -> Table:
        rows = tuple(
            (case.name, load, *(f"{value:.5g}" for value in row))
            for case, found in self.found.items()
            for load, row in zip(LOADS, _without_rounding(found.matrix).tolist(), strict=True)
        )
        heads = ("Case", "", "x", "y", "z", "about x", "about y", "about z")
        notes = ("force [N] and moment [N m] at o for a unit displacement [m] and rotation [rad]",)
        return Table("Stiffness at the platform, global axes", heads, rows, notes)

    def _map(self) -> Table:
        rows: list[tuple[Cell, ...]] = []
        shown = used(one.poses for one in self.maps)
        for one in self.maps:
            for what, values, unit in (("force", one.force, 1e-6), ("moment", one.moment, 1e-3)):
                for word, k in (("least", values.argmin()), ("most", values.argmax())):
                    place = cells(columns(one.poses[int(k)]), shown)
                    number = Number(unit * float(values[k]), 3)
                    rows.append((one.case.name, what, word, number, *place))
        heads = ("Case", "Softest", "", "[N/um], [kN m/rad]", *headings(shown))
        about = f"over {len(self.maps[0].force)} poses, the softest direction at each"
        return Table("Stiffness over the poses", heads, tuple(rows), (about,))

    def figures(self) -> dict[str, Figure]:
        """Return every part's share of the softest compliance, and the maps."""
        figure, grid = panels(
            "Share of the compliance in the softest direction", 1, len(self.found), (4.2, 3.0)
        )
        for axes, (case, found) in zip(grid[0], self.found.items(), strict=True):
            sizes = _sizes(found, self.parts[case])
            axes.barh(list(sizes), list(sizes.values()), color=COLOURS[0])
            middle, half = (len(sizes) - 1) / 2, max(len(sizes), 4) / 2  # one bar is no wall
            axes.set(xlim=(0, 100), ylim=(middle + half, middle - half), xlabel="share [%]")
            axes.set_title(case.heading, fontsize=10)
        return {"": figure} | ({"-map": _map_figure(self.maps)} if self.maps else {})

    def sentences(self) -> list[str]:
        """Return where each case is softest, and which part to stiffen first."""
        lines = []
        for case, found in self.found.items():
            sizes = _sizes(found, self.parts[case])
            first = max(sizes, key=lambda name: sizes[name])
            lines.append(
                f"{case.name} is softest along {_softest(found)} with "
                f"{1e-6 * found.softest()[0]:.4g} N/um; {sizes[first]:.0f} % of that is {first}: "
                "stiffen it first."
            )
        for one in self.maps:
            k = int(one.force.argmin())
            lines.append(
                f"Over {len(one.force)} poses {one.case.name} has {1e-6 * one.force.min():.4g} to "
                f"{1e-6 * one.force.max():.4g} N/um in its softest direction, least at "
                f"{named(one.poses[k])}."
            )
        return lines


def _sizes(found: Stiffness, parts: Mapping[str, list[int]]) -> dict[str, float]:
    """Return the share of like parts in the softest compliance [%]."""
    return {name: 100 * float(found.softest()[2][which].sum()) for name, which in parts.items()}


def _softest(found: Stiffness, *, turns: bool = False) -> str:
    """Return the softest direction in words, or which ones where several are equally soft."""
    block = slice(3, 6) if turns else slice(0, 3)
    values, vectors = np.linalg.eigh(found.compliance[block, block])
    alike = int((values > (1 - ROUNDING) * values[-1]).sum())
    if alike == 1:
        return _direction(found.softest(turns=turns)[1])
    across = vectors[:, 0] * np.sign(vectors[np.abs(vectors[:, 0]).argmax(), 0])
    return f"any direction across {_direction(across)}" if alike == 2 else "any direction"


def _direction(unit: Array) -> str:
    """Return a direction in words; -0 is 0."""
    return "(" + ", ".join(f"{value + 0.0:.2f}" for value in np.round(unit, 2)) + ")"


def _parts(mechanism: Mechanism, found: Stiffness) -> dict[str, list[int]]:
    groups: dict[tuple[int, str], list[int]] = {}
    for k, (limb, item, what) in enumerate(found.parts):
        thing = mechanism.limbs[limb - 1].chain[item - 1]
        groups.setdefault((item, part_name(item, what, thing)), []).append(k)
    return {name: which for (_, name), which in sorted(groups.items())}


def part_name(item: int, what: str, thing: object) -> str:
    """Return what a part of a chain is called: its kind, its size, and its place from the base."""
    if not isinstance(thing, Rod):
        kind = f"{what} joint" if isinstance(thing, Joint) else what
        return f"{kind} (item {item})"
    d, bore = thing.section.diameter, thing.section.bore
    if d is None:
        return f"rod (item {item})"
    size = f"{1000 * d:g}/{1000 * bore:g}" if bore else f"{1000 * d:g}"
    return f"rod of {size} mm (item {item})"


def _map_figure(maps: tuple[Map, ...]) -> Figure:
    figure, grid = panels("Stiffness in the softest direction", 1, len(maps), (4.6, 3.4))
    for axes, one in zip(grid[0], maps, strict=True):
        axes.set_title(one.case.heading, fontsize=10)
        if one.plane:
            drawn = one.plane.filled(axes, 1e-6 * one.plane.spread(one.force))
            figure.colorbar(drawn, ax=axes, label="[N/um]")
            continue
        lean = np.degrees(np.arccos(np.clip(one.poses.rotation[..., 2, 2], -1, 1)))
        dots = axes.scatter(1000 * one.poses.z, 1e-6 * one.force, c=lean, s=9, cmap="viridis")
        axes.set(xlabel="height $z$ [mm]", ylabel="[N/um]")
        axes.grid(alpha=0.25)
        figure.colorbar(dots, label="lean of the platform [deg]")
    return figure


def mapped(
    case: Case, poses: Pose, shear: str | float, bench: Bench, plane: Plane | None = None
) -> Map:
    """Return the least stiffness of a case's mechanism at `poses` (an array of them)."""
    softest = np.empty((2, len(poses)))
    bench.listener.expect(len(poses))
    for k, pose in enumerate(poses):
        found = stiffness(case.mechanism, pose, shear=shear)
        softest[:, k] = found.softest()[0], found.softest(turns=True)[0]
        bench.listener.done(f"stiffness at {named(pose)}")
    return Map(case, poses, softest[0], softest[1], plane)


def run(request: Request, bench: Bench) -> Stiffnesses:
    """Return the static 6 x 6 stiffness at the platform, and the share of each part in it.

    Of every joint, drive and rod: which to stiffen first. With --poses also the softest direction's
    stiffness over a set of poses, of every case's mechanism; with --plane over two of x, y and z
    about every case's pose, out to where the limits end.
    """
    shear = dict(request.theory.settings).get("shear", "cowper")
    found = {case: stiffness(case.mechanism, case.pose, shear=shear) for case in request.cases}
    maps: list[Map] = []
    if (text := request.options.get("poses")) is not None:
        from harness.sweep.pose_sets import pose_set

        for case in {case.mechanism: case for case in request.cases[::-1]}.values():
            poses = pose_set(text, case.mechanism)
            if len(poses) > MOST_POSES:
                raise InputError("poses", text, f"at most {MOST_POSES} poses")
            maps.append(mapped(case, poses, shear, bench))
    if (names := request.options.get(OPTION.name)) is not None:
        if text is not None:
            raise InputError("poses", text, "no poses beside a plane")
        for case in request.cases[::-1]:
            plane = Plane.of(case, names, Limits(), *MANY)
            maps.append(mapped(case, plane.poses[plane.wanted], shear, bench, plane))
    return Stiffnesses(found, tuple(maps[::-1]))


def jobs(plan: Plan) -> dict[str, Request]:
    """Return what the main job asks: every case."""
    return {"stiffness": plan.request()}


def _without_rounding(matrix: Array) -> Array:
    diagonal = np.sqrt(np.diag(matrix))
    return np.where(np.abs(matrix) < ROUNDING * np.outer(diagonal, diagonal), 0.0, matrix)
