"""What a manipulator is made of: limbs as chains, a platform, in SI units."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from analytic.errors import InputError, count, number, vector
from analytic.joint import Freedom, Joint, direction
from analytic.platform import Platform
from analytic.rod import (
    DENSITY,
    LARGEST,
    SLENDEREST,
    SMALLEST,
    STIFFNESS,
    Body,
    Link,
    Material,
    Rod,
    Section,
    Vector,
    has_poisson,
    shear_range,
)

__all__ = [
    "DENSITY", "LARGEST", "MOST_LIMBS", "SLENDEREST", "SMALLEST", "STIFFNESS", "Body", "Freedom",
    "Item", "Joint", "Limb", "Link", "Material", "Mechanism", "Platform", "Rod", "Section",
    "Vector", "has_poisson", "shear_range",
]  # fmt: skip

Item = Joint | Rod | Link | Body

MOST_LIMBS = 1000
"""Most limbs of a regular mechanism."""


@dataclass(frozen=True)
class Limb:
    """A chain of joints, rods, rigid links and bodies from the base to the platform.

    Attributes: `base` B_i, where it starts, in the global frame [m]; `platform_point` A_i, where it
    ends, in the moving frame [m]; the `chain` from B_i to A_i; `reference`, a global direction: of
    the limb's axes, z runs along it and y is `reference` without its part along z. By default it is
    the axis of the first turn in base axes, or else the tangent at the base.
    All of a chain lies on one line. Of it exactly one thing adapts to the pose: a rod or a link
    without length, or a slider. `stroke`: the least and the largest length of that, or place of the
    slider from B_i along its axis, where the workspace ends [m]; None: any.
    Raises `InputError` for any other chain.
    """

    base: Vector
    platform_point: Vector
    chain: tuple[Item, ...]
    reference: Vector | None = None
    stroke: tuple[float, float] | None = field(default=None, compare=False, repr=False)

    def __post_init__(self) -> None:
        if self.stroke is not None:
            expected = "the least and the largest of two lengths in metres"
            try:
                low, high = (number("Limb.stroke", value, expected) for value in self.stroke)
            except (TypeError, ValueError):
                raise InputError("Limb.stroke", self.stroke, expected) from None
            if not low < high:
                raise InputError("Limb.stroke", self.stroke, expected)
            object.__setattr__(self, "stroke", (low, high))
        three_metres = "three finite coordinates in metres"
        object.__setattr__(self, "base", vector("Limb.base", self.base, three_metres))
        point = vector("Limb.platform_point", self.platform_point, three_metres)
        object.__setattr__(self, "platform_point", point)
        chain = tuple(self.chain) if isinstance(self.chain, Iterable) else ()
        if not chain or not all(isinstance(item, (Joint, Rod, Link, Body)) for item in chain):
            raise InputError("Limb.chain", self.chain, "joints, rods, links and bodies in a row")
        if not any(isinstance(item, (Rod, Link)) for item in chain):
            raise InputError("Limb.chain", self.chain, "at least one rod or link")
        object.__setattr__(self, "chain", chain)
        sliders = [bool(isinstance(item, Joint) and item.slider) for item in chain]
        if any(sliders[1:]):
            raise InputError("Limb.chain", self.chain, "a slider at the base, first in its chain")
        adapting = sum(sliders) + sum(
            isinstance(item, (Rod, Link)) and item.length is None for item in chain
        )
        if adapting != 1:
            raise InputError(
                "Limb.chain",
                self.described,
                f"one thing that adapts, a rod without length or a slider, not {adapting}",
            )
        if self.reference is not None:
            object.__setattr__(self, "reference", direction("Limb.reference", self.reference))

    @classmethod
    def rps(cls, base: Vector, axis: Vector, platform_point: Vector, rod: Rod) -> "Limb":
        """Return an R-P-S limb with its actuator locked: the paper's.

        `axis` of its revolute joint is a global direction; the `rod` takes its length from the
        pose.
        """
        unit = direction("Limb.axis", axis)
        if not isinstance(rod, Rod):
            raise InputError("Limb.rod", rod, "a Rod")
        return cls(base, platform_point, (Joint.revolute(unit), rod, Joint.spherical()))

    @property
    def described(self) -> str:
        """The chain in words, as "U-rod-P-rod-S"."""
        names = {Rod: "rod", Link: "link", Body: "body"}
        return "-".join(
            item.name if isinstance(item, Joint) else names[type(item)] for item in self.chain
        )

    @cached_property
    def towards(self) -> Vector:
        """`reference`, or what stands for it, a unit vector in global axes."""
        if self.reference is not None:
            return self.reference
        for item in self.chain:
            if isinstance(item, Rod):
                break
            for freedom in item.freedoms if isinstance(item, Joint) and item.name != "S" else ():
                if (freedom.kind, freedom.frame, freedom.across) == ("rotation", "base", False):
                    return freedom.axis
        return self._tangent

    @property
    def _tangent(self) -> Vector:
        x, y, _ = self.base
        radius = math.hypot(x, y)
        return (-y / radius, x / radius, 0.0) if radius > 0 else (0.0, 1.0, 0.0)

    @cached_property
    def simple(self) -> bool:
        """Whether this is an ideal R-P-S limb of one rod, as in the paper."""
        if len(self.chain) != 3:
            return False
        first, rod, last = self.chain
        return (
            isinstance(first, Joint)
            and isinstance(rod, Rod)
            and last == Joint.spherical()
            and rod.length is None
            and rod.section.diameter is not None
            and not rod.section.bore
            and not first.slider
            # Not by making one: an axis of length 1 made so again may differ in its last bit.
            and [(f.kind, f.frame, f.stiffness, f.across) for f in first.freedoms]
            == [("rotation", "base", 0.0, False)]
        )

    def _of_rps(self) -> tuple[Vector, Rod]:
        if not self.simple:
            raise InputError("limb", self.described, "an ideal R-rod-S limb of one solid round rod")
        first, rod, _ = self.chain
        assert isinstance(first, Joint)
        assert isinstance(rod, Rod)
        return first.freedoms[0].axis, rod

    @property
    def axis(self) -> Vector:
        """The unit revolute axis of an R-P-S limb; raises `InputError` for any other."""
        return self._of_rps()[0]

    @property
    def rod(self) -> Rod:
        """The one rod of an R-P-S limb; raises `InputError` for any other."""
        return self._of_rps()[1]

    def with_rod(self, rod: Rod) -> "Limb":
        """Return this R-P-S limb with another rod."""
        return Limb.rps(self.base, self.axis, self.platform_point, rod)

    @property
    def rods(self) -> tuple[Rod, ...]:
        """The rods of the chain, from the base on."""
        return tuple(item for item in self.chain if isinstance(item, Rod))

    def turned(self, angle: float) -> "Limb":
        """Return this limb turned by `angle` about the global z axis [rad], platform and all."""
        c, s = math.cos(angle), math.sin(angle)

        def turn(v: Vector) -> Vector:
            return (c * v[0] - s * v[1], s * v[0] + c * v[1], v[2])

        def freedom(f: Freedom) -> Freedom:
            return f if f.frame == "limb" else replace(f, axis=turn(f.axis))

        def item(i: Item) -> Item:
            if isinstance(i, Joint):
                # A ball has no axes to turn.
                same = i == Joint.spherical(i.freedoms[0].stiffness if i.freedoms else 0.0)
                kept = i.freedoms if same else tuple(map(freedom, i.freedoms))
                return replace(i, freedoms=kept, rest=turn(i.rest))
            if isinstance(i, Body) and i.frame == "base":
                R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
                x, y, z = (tuple(row) for row in (R @ np.array(i.inertia) @ R.T).tolist())
                return Body(i.mass, (x, y, z), turn(i.centre), i.frame)
            return i

        reference = None if self.reference is None else turn(self.reference)
        chain = tuple(map(item, self.chain))
        return Limb(turn(self.base), turn(self.platform_point), chain, reference, self.stroke)


@dataclass(frozen=True)
class Mechanism:
    """A rigid platform on any number of limbs. Nothing here is special to three."""

    limbs: tuple[Limb, ...]
    platform: Platform

    def __post_init__(self) -> None:
        limbs = tuple(self.limbs) if isinstance(self.limbs, Iterable) else ()
        if not limbs or not all(isinstance(limb, Limb) for limb in limbs):
            raise InputError("Mechanism.limbs", self.limbs, "at least one Limb")
        object.__setattr__(self, "limbs", limbs)
        if not isinstance(self.platform, Platform):
            raise InputError("Mechanism.platform", self.platform, "a Platform")

    def __hash__(self) -> int:
        """Return a hash of where the limbs are alone: of every item it takes longer than a pose."""
        places = ((*limb.base, *limb.platform_point) for limb in self.limbs)
        return hash((self.platform.mass, *places))

    @classmethod
    def regular(
        cls,
        base_radius: float,
        platform_radius: float,
        rod: Rod,
        platform: Platform,
        *,
        limbs: int = 3,
        heading: float = 0.0,
    ) -> "Mechanism":
        """Return equal limbs at equal angles about z, the first at `heading` [rad].

        B_i and A_i lie on circles of `base_radius` and `platform_radius` [m]; each revolute axis
        is tangential, in the base plane (Section 2).
        """
        r1 = number("base_radius", base_radius, "a positive number of metres", positive=True)
        r2 = number(
            "platform_radius", platform_radius, "a positive number of metres", positive=True
        )
        number("heading", heading, "a finite angle in radians")
        angles = (
            heading + 2 * math.pi * np.arange(count("limbs", limbs, at_most=MOST_LIMBS)) / limbs
        )
        return cls(
            tuple(
                Limb.rps(
                    base=(r1 * math.cos(a), r1 * math.sin(a), 0.0),
                    axis=(-math.sin(a), math.cos(a), 0.0),
                    platform_point=(r2 * math.cos(a), r2 * math.sin(a), 0.0),
                    rod=rod,
                )
                for a in angles.tolist()
            ),
            platform,
        )

    @classmethod
    def paper(cls, *, inertia: str = "disc", heading: float = 0.0) -> "Mechanism":
        """Return the 3-RPS manipulator of Section 2, with its printed parameters.

        E = 200 GPa, G = 77 GPa, rho = 7820 kg/m^3, d = 100 mm, h = 20 mm, r1 = 0.3 m, r2 = 0.2 m.
        `inertia` is "disc" (the body as described) or "printed" (Eq. 8). `heading` turns the
        limbs about z [rad].
        """
        forms = {"disc": Platform.disc, "printed": Platform.as_printed}
        if not isinstance(inertia, str) or inertia not in forms:
            raise InputError("inertia", inertia, "'disc' or 'printed'")
        steel = Material(young=200e9, shear=77e9, density=7820.0)
        platform = forms[inertia](0.2, 0.02, steel.density)
        return cls.regular(0.3, 0.2, Rod.round(steel, 0.1), platform, heading=heading)

    @cached_property
    def bases(self) -> NDArray[np.float64]:
        """The points B_i, global frame, shape (n, 3) [m]."""
        return _constant(limb.base for limb in self.limbs)

    @cached_property
    def axes(self) -> NDArray[np.float64]:
        """The unit revolute axes, global frame, shape (n, 3)."""
        return _constant(limb.axis for limb in self.limbs)

    @cached_property
    def platform_points(self) -> NDArray[np.float64]:
        """The points A_i, moving frame, shape (n, 3) [m]."""
        return _constant(limb.platform_point for limb in self.limbs)

    @cached_property
    def placements(self) -> list[tuple[Vector, Vector, Vector]]:
        """B_i, the revolute axis and A_i of every limb: rows of `bases`, `axes` and the points."""
        return [(limb.base, limb.axis, limb.platform_point) for limb in self.limbs]

    @cached_property
    def simple(self) -> bool:
        """Whether all limbs are the paper's, and o is the platform's centre of mass."""
        return all(limb.simple for limb in self.limbs) and not any(self.platform.centre)

    @property
    def limited(self) -> bool:
        """Whether it says itself where its workspace ends: strokes, or largest angles of joints."""
        joints = (i for limb in self.limbs for i in limb.chain if isinstance(i, Joint))
        return any(limb.stroke for limb in self.limbs) or any(j.largest for j in joints)

    @cached_property
    def longest(self) -> NDArray[np.float64]:
        """The lengths up to which the limbs are answered, shape (n,) [m]."""
        return np.array([SLENDEREST * limb.rod.diameter for limb in self.limbs])

    @cached_property
    def across(self) -> NDArray[np.float64]:
        """The pseudo-inverse of the axes' x and y, shape (2, n): solves Eq. (2) for o."""
        return np.asarray(np.linalg.pinv(self.axes[:, :2], rcond=1e-9))


def _constant(rows: Iterable[Vector]) -> NDArray[np.float64]:
    array = np.array(list(rows))
    array.flags.writeable = False
    return array
