"""What a manipulator is made of: materials, rods, platform and limbs, in SI units."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from analytic.errors import InputError, count, number, vector

Vector = tuple[float, float, float]

ROUNDED = 1e-12
"""A smaller relative difference of moments of inertia is rounding."""
SMALLEST, LARGEST = 1e-9, 1e9
"""Sizes and diameters in metres that are answered: beyond, powers of them leave the numbers."""
SLENDEREST = 5e4
"""Most diameters of a limb's length: what bends is then 1e-11 of what stretches, and beyond, the
last digits of assembled stiffness are rounding."""
STIFFNESS, DENSITY = (1e-30, 1e30), (1e-30, 1e30)
"""Moduli [Pa] and densities [kg/m^3] that are answered, for the same reason."""
STIFFEST_SHEAR = 1e6
"""Largest G / E: Poisson's ratio is then -1 but for 5e-7."""
MOST_LIMBS = 1000
"""Most limbs of a regular mechanism."""


@dataclass(frozen=True)
class Material:
    """A linear elastic, isotropic material.

    Attributes: `young` E [Pa], `shear` modulus G [Pa], `density` rho [kg/m^3].
    Raises `InputError` unless all are positive and -1 < E / 2G - 1 < 0.5: G is more than a third of
    E, and less than a million times E, below which nothing is made.
    """

    young: float
    shear: float
    density: float

    def __post_init__(self) -> None:
        for name, unit, (low, high) in (
            ("young", "pascals", STIFFNESS),
            ("shear", "pascals", STIFFNESS),
            ("density", "kg/m^3", DENSITY),
        ):
            given, expected = getattr(self, name), f"a positive number of {unit}, {low} to {high}"
            if not low <= number(f"Material.{name}", given, expected) <= high:
                raise InputError(f"Material.{name}", given, expected)
        if not has_poisson(self.young, self.shear):
            raise InputError("Material.shear", self.shear, shear_range(self.young, "young"))

    @property
    def poisson(self) -> float:
        """Poisson's ratio, E / 2G - 1."""
        return self.young / (2 * self.shear) - 1


def has_poisson(young: float, shear: float) -> bool:
    """Return whether an isotropic material can have these moduli, of one unit."""
    return young / 3 < shear < STIFFEST_SHEAR * young


def shear_range(young: float, name: str) -> str:
    """Return what was expected of a shear modulus beside Young's, called `name`."""
    return f"more than a third of {name} = {young:g}, and less than {STIFFEST_SHEAR:g} times that"


@dataclass(frozen=True)
class Rod:
    """A solid round rod of one material; `diameter` d [m]. Its length follows from the pose."""

    material: Material
    diameter: float

    def __post_init__(self) -> None:
        if not isinstance(self.material, Material):
            raise InputError("Rod.material", self.material, "a Material")
        expected = f"a positive number of metres, {SMALLEST:g} to {LARGEST:g}"
        diameter = number("Rod.diameter", self.diameter, expected, positive=True)
        if not SMALLEST <= diameter <= LARGEST:
            raise InputError("Rod.diameter", self.diameter, expected)

    @property
    def area(self) -> float:
        """Cross-section A = pi d^2 / 4 [m^2]."""
        return math.pi * self.diameter**2 / 4

    @property
    def second_moment(self) -> float:
        """Second moment of area I = pi d^4 / 64 about any diameter [m^4]."""
        return math.pi * self.diameter**4 / 64

    @property
    def polar_moment(self) -> float:
        """Polar moment of area J = 2 I [m^4]."""
        return 2 * self.second_moment


@dataclass(frozen=True)
class Platform:
    """The rigid moving platform: `mass` [kg], `inertia` about o in the moving frame [kg m^2].

    `inertia` is a symmetric, positive definite 3 x 3 tensor given as three rows of three numbers;
    a tensor asymmetric by rounding is made symmetric. `form` says in words where it comes from.
    Raises `InputError` for any other, and for a principal moment above the sum of the others, which
    no body has.
    """

    mass: float
    inertia: tuple[Vector, Vector, Vector]
    form: str = "given"

    def __post_init__(self) -> None:
        number("Platform.mass", self.mass, "a positive number of kilograms", positive=True)
        expected = "a symmetric, positive definite 3 x 3 inertia tensor in kg m^2"
        try:
            rows = tuple(vector("Platform.inertia", row, expected) for row in self.inertia)
        except TypeError:
            raise InputError("Platform.inertia", self.inertia, expected) from None
        tensor = np.array(rows)
        if tensor.shape != (3, 3):
            raise InputError("Platform.inertia", self.inertia, expected)
        size = float(np.abs(tensor).max())
        if np.abs(tensor - tensor.T).max() > ROUNDED * size:
            raise InputError("Platform.inertia", self.inertia, expected)
        if (tensor != tensor.T).any():
            tensor = (tensor + tensor.T) / 2
            rows = tuple(vector("Platform.inertia", row, expected) for row in tensor.tolist())
        moments = np.linalg.eigvalsh(tensor)
        if not moments[0] > 0:
            raise InputError("Platform.inertia", self.inertia, expected)
        if moments[0] + moments[1] < moments[2] * (1 - ROUNDED):
            own = ", ".join(f"{moment:g}" for moment in moments)
            raise InputError(
                "Platform.inertia",
                self.inertia,
                f"principal moments of which none exceeds the sum of the others, not {own}",
            )
        object.__setattr__(self, "inertia", rows)

    @classmethod
    def diagonal(cls, mass: float, moments: Vector, form: str = "given") -> "Platform":
        """Return a platform whose moving frame is its principal frame."""
        x, y, z = vector("moments", moments, "three positive moments of inertia in kg m^2")
        return cls(mass, ((x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z)), form)

    @classmethod
    def disc(cls, radius: float, thickness: float, density: float) -> "Platform":
        """Return a uniform disc whose middle plane holds o and the points A_i.

        Jx = Jy = m (3 r^2 + h^2) / 12 and Jz = m r^2 / 2.
        """
        mass = _disc_mass(radius, thickness, density)
        across = mass * (3 * radius**2 + thickness**2) / 12
        return cls.diagonal(mass, (across, across, mass * radius**2 / 2), "disc")

    @classmethod
    def as_printed(cls, radius: float, thickness: float, density: float) -> "Platform":
        """Return the inertia of Eq. (8): the disc's mass, and m r2^2 about all three axes."""
        mass = _disc_mass(radius, thickness, density)
        moment = mass * radius**2
        return cls.diagonal(mass, (moment, moment, moment), "Eq. 8 as printed")


def _disc_mass(radius: float, thickness: float, density: float) -> float:
    number("Platform radius", radius, "a positive number of metres", positive=True)
    number("Platform thickness", thickness, "a positive number of metres", positive=True)
    number("Platform density", density, "a positive kg/m^3", positive=True)
    return density * math.pi * radius**2 * thickness


@dataclass(frozen=True)
class Limb:
    """One R-P-S chain with its actuator locked.

    Attributes: `base` B_i in the global frame [m]; `axis` of its revolute joint, a global
    direction (normalised here); `platform_point` A_i in the moving frame [m]; the `rod` between.
    """

    base: Vector
    axis: Vector
    platform_point: Vector
    rod: Rod

    def __post_init__(self) -> None:
        three_metres = "three finite coordinates in metres"
        object.__setattr__(self, "base", vector("Limb.base", self.base, three_metres))
        point = vector("Limb.platform_point", self.platform_point, three_metres)
        object.__setattr__(self, "platform_point", point)
        axis = vector("Limb.axis", self.axis, "a direction other than zero")
        length = math.hypot(*axis)
        if length == 0:
            raise InputError("Limb.axis", self.axis, "a direction other than zero")
        x, y, z = axis
        object.__setattr__(self, "axis", (x / length, y / length, z / length))
        if not isinstance(self.rod, Rod):
            raise InputError("Limb.rod", self.rod, "a Rod")


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
                Limb(
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
        return cls.regular(0.3, 0.2, Rod(steel, 0.1), platform, heading=heading)

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
