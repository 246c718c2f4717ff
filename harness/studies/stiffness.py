"""Static stiffness at the platform: how much, of which part, and over any poses."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from analytic import InputError, Joint, Limits, Mechanism, Pose, Rod, Stiffness, stiffness
from harness.bench import Bench
from harness.case import Case
from harness.compare import cells as numbers
from harness.figures import COLOURS, panels
from harness.poses import cells, columns, headings, named, used
from harness.request import Option, Request
from harness.result import Result
from harness.signatures import Array, Figure
from harness.studies.workspace import MANY, OPTION
from harness.studies.workspace.map import Plane
from harness.tables import Number, Row, Table

TAKES = ("cases", "case_file", "shear")
LOADS = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
FORCE, MOMENT = 1e-6, 1e-3
"""N/um and kN m/rad in SI."""
MOST_POSES = 20_000
OPTIONS = (
    Option("poses", "SET", "Poses of a map, as `sweep` takes them; default none.", None, str),
    OPTION,
)
ROUNDING = 1e-10
"""An entry below this part of its diagonals' mean is none: rounding, another on every machine."""


class Map(NamedTuple):
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
    def shares(self) -> dict[Case, dict[str, tuple[int, Array]]]:
        """How many limbs have a part, and its share [%] of the compliance to each of `LOADS`, in
        the softest direction and about the softest axis (8,): by case and name, like parts as one.
        """
        return {case: _shares(case.mechanism, found) for case, found in self.found.items()}

    def records(self) -> Iterator[dict[str, Any]]:
        """Return one row a case, part and load alone: the compliance, and the part's share.

        Of a map one row a pose: where it is, and its softest direction's stiffness.
        """
        for case, found in self.found.items():
            whole = np.diag(found.compliance)
            for (limb, item, what), shares in zip(found.parts, found.shares, strict=True):
                for load, size, share in zip(LOADS, whole, shares, strict=True):
                    yield {
                        "case": case.name, "limb": limb, "item": item, "part": what, "load": load,
                        "compliance_m_n": size if load[0] == "F" else np.nan,
                        "compliance_rad_nm": size if load[0] == "M" else np.nan, "share": share,
                    }  # fmt: skip
        for one in self.maps:
            for pose, force, moment in zip(one.poses, one.force, one.moment, strict=True):
                yield {"case": one.case.name, **columns(pose),
                       "softest_n_m": force, "softest_nm_rad": moment}  # fmt: skip

    def tables(self) -> dict[str, Table]:
        """Return stiffness to each load, the shares of like parts, the matrices, and the maps."""
        rows: list[Row] = []
        for case, found in self.found.items():
            each = np.repeat([FORCE, MOMENT], 3) / np.diag(found.compliance)
            force, moment = (found.softest(turns=turns)[0] for turns in (False, True))
            rows.append((
                case.name, *numbers(each, 3), Number(FORCE * force), _softest(found),
                Number(MOMENT * moment), _softest(found, turns=True),
            ))  # fmt: skip
        heads: tuple[str, ...] = ("Case", *LOADS, "least", "along", "least turning", "about")
        about = (
            "N/um to a force at o alone, kN m/rad to a moment alone, the platform free to follow: "
            "1 / compliance; rods are sheared beams, for which one element is exact at rest"
        )
        tables = {"": Table("Static stiffness at the platform", heads, rows, [about])}
        rows = [
            (case.name, name, limbs, *numbers(share, 1))
            for case, parts in self.shares.items() for name, (limbs, share) in parts.items()
        ]  # fmt: skip
        heads = ("Case", "Part", "Limbs", *LOADS, "softest force", "softest moment")
        title = "Who gives way: share of the compliance [%]"
        tables["-parts"] = Table(title, heads, rows, ["every column of a case sums to 100"])
        rows = []
        for case, found in self.found.items():
            size = np.sqrt(np.diag(found.matrix))
            rounding = np.abs(found.matrix) < ROUNDING * np.outer(size, size)
            for load, row in zip(LOADS, np.where(rounding, 0.0, found.matrix), strict=True):
                rows.append((case.name, load, *(f"{value:.5g}" for value in row)))
        heads = ("Case", "", "x", "y", "z", "about x", "about y", "about z")
        about = "force [N] and moment [N m] at o for a unit displacement [m] and rotation [rad]"
        tables["-matrix"] = Table("Stiffness at the platform, global axes", heads, rows, [about])
        return tables | ({"-map": self._map()} if self.maps else {})

    def _map(self) -> Table:
        rows: list[Row] = []
        shown = used(one.poses for one in self.maps)
        for one in self.maps:
            for what, values in (("force", FORCE * one.force), ("moment", MOMENT * one.moment)):
                for word, k in (("least", values.argmin()), ("most", values.argmax())):
                    place = cells(columns(one.poses[int(k)]), shown)
                    rows.append((one.case.name, what, word, Number(float(values[k])), *place))
        heads = ("Case", "Softest", "", "[N/um], [kN m/rad]", *headings(shown))
        about = f"over {len(self.maps[0].force)} poses, the softest direction at each"
        return Table("Stiffness over the poses", heads, rows, [about])

    def figures(self) -> dict[str, Figure]:
        """Return every part's share of the softest compliance, and the maps."""
        title = "Share of the compliance in the softest direction"
        figure, grid = panels(title, 1, len(self.found), (4.2, 3.0))
        for axes, (case, parts) in zip(grid[0], self.shares.items(), strict=True):
            axes.barh(list(parts), [share[6] for _, share in parts.values()], color=COLOURS[0])
            middle, half = (len(parts) - 1) / 2, max(len(parts), 4) / 2  # one bar is no wall
            axes.set(xlim=(0, 100), ylim=(middle + half, middle - half), xlabel="share [%]")
            axes.set_title(case.heading, fontsize=10)
        return {"": figure} | ({"-map": _map_figure(self.maps)} if self.maps else {})

    def sentences(self) -> list[str]:
        """Return where each case is softest, and which part to stiffen first."""
        lines = []
        for case, found in self.found.items():
            share, first = max(
                ((share[6], name) for name, (_, share) in self.shares[case].items()),
                key=lambda one: one[0],
            )
            lines.append(
                f"{case.name} is softest along {_softest(found)} with "
                f"{FORCE * found.softest()[0]:.4g} N/um; {share:.0f} % of that is {first}: "
                "stiffen it first."
            )
        for one in self.maps:
            force = FORCE * one.force
            lines.append(
                f"Over {len(force)} poses {one.case.name} has {force.min():.4g} to "
                f"{force.max():.4g} N/um in its softest direction, least at "
                f"{named(one.poses[int(force.argmin())])}."
            )
        return lines


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


def _shares(mechanism: Mechanism, found: Stiffness) -> dict[str, tuple[int, Array]]:
    """Return `Stiffnesses.shares` of a case; alike are equal items at the same place of chains."""
    softest = [found.softest(turns=turns)[2] for turns in (False, True)]
    shares = 100 * np.column_stack([found.shares, *softest])
    groups: dict[tuple[int, str], list[int]] = {}
    for k, (limb, item, what) in enumerate(found.parts):
        name = part_name(item, what, mechanism.limbs[limb - 1].chain[item - 1])
        groups.setdefault((item, name), []).append(k)
    return {
        name: (len({found.parts[k][0] for k in which}), shares[which].sum(axis=0))
        for (_, name), which in sorted(groups.items())
    }


def part_name(item: int, what: str, thing: object) -> str:
    """Return what a part of a chain is called: its kind, its size, and its place from the base."""
    if isinstance(thing, Joint):
        what = f"{what} joint"
    elif isinstance(thing, Rod) and (d := thing.section.diameter) is not None:
        bore = thing.section.bore
        what = f"rod of {1000 * d:g}{f'/{1000 * bore:g}' if bore else ''} mm"
    return f"{what} (item {item})"


def _map_figure(maps: tuple[Map, ...]) -> Figure:
    from harness.studies.workspace.figures import over_plane

    figure, grid = panels("Stiffness in the softest direction", 1, len(maps), (4.6, 3.4))
    for axes, one in zip(grid[0], maps, strict=True):
        axes.set_title(one.case.heading, fontsize=10)
        if one.plane:
            drawn = over_plane(axes, one.plane, FORCE * one.plane.spread(one.force))
            figure.colorbar(drawn, ax=axes, label="[N/um]")
            continue
        lean = np.degrees(np.arccos(np.clip(one.poses.rotation[..., 2, 2], -1, 1)))
        dots = axes.scatter(1000 * one.poses.z, FORCE * one.force, c=lean, s=9, cmap="viridis")
        axes.set(xlabel="height $z$ [mm]", ylabel="[N/um]")
        axes.grid(alpha=0.25)
        figure.colorbar(dots, label="lean of the platform [deg]")
    return figure


def mapped(
    case: Case, poses: Pose, shear: str | float, bench: Bench, plane: Plane | None = None
) -> Map:
    """Return the least stiffness of a case's mechanism at `poses` (an array of them)."""
    softest = []
    bench.listener.expect(len(poses))
    for pose in poses:
        found = stiffness(case.mechanism, pose, shear=shear)
        softest.append([found.softest()[0], found.softest(turns=True)[0]])
        bench.listener.done(f"stiffness at {named(pose)}")
    force, moment = np.array(softest).T
    return Map(case, poses, force, moment, plane)


def run(request: Request, bench: Bench) -> Stiffnesses:
    """Return the static 6 x 6 stiffness at the platform, and the share of each part in it.

    Of every joint, drive and rod: which to stiffen first. With --poses also the softest direction's
    stiffness over a set of poses, of every case's mechanism; with --plane over two of x, y and z
    about every case's pose, out to where the limits end.
    """
    shear = dict(request.theory.settings).get("shear", "cowper")
    found = {case: stiffness(case.mechanism, case.pose, shear=shear) for case in request.cases}
    text, names = (request.options.get(option.name) for option in OPTIONS)
    if text is not None and names is not None:
        raise InputError("poses", text, "no poses beside a plane")
    maps: list[Map] = []
    if text is not None:
        from harness.sweep.pose_sets import pose_set

        first = {case.mechanism: case for case in request.cases[::-1]}
        for case in reversed(first.values()):
            poses = pose_set(text, case.mechanism)
            if len(poses) > MOST_POSES:
                raise InputError("poses", text, f"at most {MOST_POSES} poses")
            maps.append(mapped(case, poses, shear, bench))
    if names is not None:
        for case in request.cases:
            plane = Plane.of(case, names, Limits(), *MANY)
            maps.append(mapped(case, plane.poses[plane.wanted], shear, bench, plane))
    return Stiffnesses(found, tuple(maps))
