"""Limbs of any chain in MJCF: rods as rigid segments, with springs wherever anything gives way.

Between two masses (segments, bodies, the platform) all that gives way at one point acts in series:
a joint's freedoms, and the half segments of the rods that end there. Compliances add up; what is
free stays free; in principal axes each is one hinge or slide with one spring.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from analytic.mechanism import Body, Joint, Link, Rod
from reference_models.chain_placement import Standing
from reference_models.mujoco.rig import text
from reference_models.series import Series

Array = NDArray[np.float64]

LIGHT = 1e-10
"""Mass and inertia of a body that stands for none, of its limb's: MuJoCo demands some."""
Spring = tuple[str, Array, float]
"""MuJoCo's kind of joint, its axis in the limb's axes (3,), its stiffness."""


@dataclass
class Gap:
    """What lies between two masses at a global `point` [m]: how it moves and how it turns."""

    point: Array
    shift: Series = field(default_factory=Series)
    turn: Series = field(default_factory=Series)

    def add_joint(self, joint: Joint, limb: Standing, R: Array) -> None:
        """Add a joint's freedoms; R is the platform's rotation."""
        self.shift = self.shift.joined(joint, "translation", limb, R)
        self.turn = self.turn.joined(joint, "rotation", limb, R)

    def add_rod(self, rod: Rod, length: float, side: str) -> None:
        """Add so much of a rod; `side` "before" where it ends here, "after" where it starts."""
        own, of = rod.section, rod.material
        Ix, Iy = own.second_moments
        stretch = length / (of.young * own.area)
        bend = length / np.array([of.young * Ix, of.young * Iy, of.shear * own.torsion_constant])
        for name, c in (("shift", np.diag([0.0, 0.0, stretch])), ("turn", np.diag(bend))):
            old: Series = getattr(self, name)
            parts = {"free": old.free, "before": old.before, "own": old.own, "after": old.after}
            parts[side] = parts[side] + c
            setattr(self, name, Series(**parts))

    @property
    def springs(self) -> list[Spring]:
        """All joints of MuJoCo that stand for it."""
        found: list[Spring] = []
        for kind, series in (("slide", self.shift), ("hinge", self.turn)):
            free, axes, c = series.apart()
            found += [(kind, axis, 0.0) for axis in free.T]
            found += [(kind, axis, float(1 / s)) for axis, s in zip(axes.T, c, strict=True)]
        return found


@dataclass(frozen=True)
class Mass:
    """A body of MuJoCo in the limb's axes, joined to the one before at `gap`.

    Attributes: its `name`; its origin `at` in global axes [m]; `mass`; `inertia` (3, 3) about and
    `centre` (3,) of its mass, in the limb's axes.
    """

    name: str
    at: Array
    gap: Gap
    mass: float
    inertia: Array
    centre: Array = field(default_factory=lambda: np.zeros(3))


@dataclass(frozen=True)
class End:
    """An end of a rod at a global `point`: on `body`, less the part `share` (3, 3, global axes) of
    the motion of `body` relative to `beside`.
    """

    point: Array
    body: str
    beside: str
    share: Array


@dataclass(frozen=True)
class Piece:
    """A rod or a link of the centre line from `begin` to `end` [m] along its limb.

    `bodies`, whose origins are on it, and its two `ends`.
    """

    begin: float
    end: float
    ends: tuple[End, End]
    bodies: tuple[str, ...] = ()


@dataclass(frozen=True)
class Segmented:
    """One limb of MuJoCo's bodies: the `masses` from the base on, and its centre line in `pieces`.

    `closed`, how its last body is held to the platform at A_i: "connect" at a point, or "weld".
    """

    limb: Standing
    masses: list[Mass]
    pieces: list[Piece]
    closed: str

    @property
    def last(self) -> str:
        """The body that is held to the platform."""
        return self.masses[-1].name if self.masses else "world"


def segmented(limb: Standing, R: Array, elements: int, *, rotary: bool) -> Segmented:
    """Return a limb whose rods are `elements` segments; `rotary`: with the sections' inertia.

    A segment has the mass and, about its axis, the moment of inertia of so much rod, and about its
    diameters that of a line, or with `rotary` that of the rod.
    """
    z, name = limb.frame[:, 2], f"L{limb.number}"
    light = LIGHT * limb.mass
    no_inertia = light * limb.length**2 * np.eye(3)
    masses: list[Mass] = []
    pieces: list[Piece] = []
    open_rods: list[tuple[float, float, tuple[str, ...], End]] = []
    gap = Gap(limb.starts[0])

    def last() -> str:
        return masses[-1].name if masses else "world"

    def at_end(after: str) -> None:
        """Finish the rod that ended at the gap, now that the body `after` it is known."""
        if open_rods:
            begin, end, bodies, start = open_rods.pop()
            share = limb.frame @ gap.shift.shares()[0] @ limb.frame.T
            pieces.append(Piece(begin, end, (start, End(gap.point, last(), after, share)), bodies))

    def add(mass: Mass) -> None:
        at_end(mass.name)
        masses.append(mass)

    for k, item in enumerate(limb.limb.chain):
        start, stop = limb.starts[k : k + 2]
        begin, end = (float((x - limb.starts[0]) @ z) for x in (start, stop))
        if isinstance(item, Joint):
            gap.add_joint(item, limb, R)
        elif isinstance(item, Body):
            axes = np.eye(3) if item.frame == "limb" else limb.frame.T
            inertia = axes @ np.array(item.inertia) @ axes.T
            add(Mass(f"{name}_{k}", start, gap, item.mass, inertia, axes @ np.array(item.centre)))
            gap = Gap(start)
        elif isinstance(item, Link):
            if gap.springs:
                add(Mass(f"{name}_{k}", start, gap, light, no_inertia))
            rigid = np.zeros((3, 3))
            ends = (End(start, last(), last(), rigid), End(stop, last(), last(), rigid))
            pieces.append(Piece(begin, end, ends))
            gap = Gap(stop)
        else:
            h = (end - begin) / elements
            names = tuple(f"{name}_{k}_{j}" for j in range(elements))
            gap.add_rod(item, h / 2, "after")
            share = limb.frame @ gap.shift.shares()[1] @ limb.frame.T
            first = End(start, names[0], last(), share)
            mass, inertia = _segment(item, h, rotary=rotary)
            for j in range(elements):
                add(Mass(names[j], start + (j + 0.5) * h * z, gap, mass, inertia))
                gap = Gap(start + (j + 1) * h * z)
                gap.add_rod(item, h if j < elements - 1 else h / 2, "before")
            open_rods.append((begin, end, names, first))
    at_end("platform")
    closed = "connect" if gap.turn.all_free else "weld"
    if closed == "connect":
        gap = Gap(gap.point, gap.shift)
    if gap.springs:
        masses.append(Mass(f"{name}_tip", gap.point, gap, light, no_inertia))
    return Segmented(limb, masses, pieces, closed)


def _segment(rod: Rod, h: float, *, rotary: bool) -> tuple[float, Array]:
    rho, own = rod.material.density, rod.section
    mass = rho * own.area * h
    about = np.array([*own.second_moments, own.polar_moment]) * rho * h
    line = mass * h**2 / 12 * np.array([1.0, 1.0, 0.0])
    return mass, np.diag(line + about * np.array([rotary, rotary, 1.0]))


def written(limb: Segmented) -> str:
    """Return the limb in MJCF, each body within the one before.

    Inertia has its trace added to all three moments, see `rig.surplus`.
    """
    frame = limb.limb.frame
    inside = ""
    for k in reversed(range(len(limb.masses) + 1)):
        if k == len(limb.masses):
            inside = _site(limb) if limb.masses else ""
            continue
        mass = limb.masses[k]
        if k:
            place = f'pos="{text(frame.T @ (mass.at - limb.masses[k - 1].at))}"'
        else:
            place = f'pos="{text(mass.at)}" xyaxes="{text(frame[:, 0], frame[:, 1])}"'
        point = frame.T @ (mass.gap.point - mass.at)
        joints = (
            f'<joint type="{kind}" axis="{text(axis)}" stiffness="{text(stiffness)}" '
            f'pos="{text(point)}"/>'
            for kind, axis, stiffness in mass.gap.springs
        )
        J = mass.inertia + np.trace(mass.inertia) * np.eye(3)
        inside = (
            f'<body name="{mass.name}" {place}>{"".join(joints)}<inertial '
            f'pos="{text(mass.centre)}" mass="{text(mass.mass)}" '
            f'fullinertia="{text(J[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]])}"/>{inside}</body>'
        )
    return inside or _site(limb)


def _site(limb: Segmented) -> str:
    """Return where the last body (or the world) is held to the platform."""
    tip, frame = limb.limb.starts[-1], limb.limb.frame
    if limb.masses:
        return (
            f'<site name="T{limb.limb.number}" pos="{text(frame.T @ (tip - limb.masses[-1].at))}"/>'
        )
    axes = text(frame[:, 0], frame[:, 1])
    return f'<site name="T{limb.limb.number}" pos="{text(tip)}" xyaxes="{axes}"/>'


def closures(limbs: Iterable[Segmented]) -> str:
    """Return the equality constraints that hold the limbs to the platform."""
    return "".join(
        f'<{limb.closed} site1="T{limb.limb.number}" site2="A{limb.limb.number}"/>'
        for limb in limbs
    )
