"""What a limb is made of between its joints: materials, sections, rods, links and bodies."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from analytic.errors import InputError, number, vector

Vector = tuple[float, float, float]
Tensor = tuple[Vector, Vector, Vector]

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
METRES = f"a positive number of metres, {SMALLEST:g} to {LARGEST:g}"


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
class Section:
    """A rod's section, about its principal axes x and y.

    Attributes: `area` A [m^2]; `second_moments` (Ix, Iy) about x and y [m^4]: bending that moves
    the rod along x turns its sections about y; Saint-Venant's `torsion_constant` J [m^4];
    `shear_coefficients` (kappa of shear along x, along y), None for those of the theory, which
    knows round sections alone; `diameter` and `bore` of a round one [m], None and 0 of others.
    Raises `InputError` for what is not positive, or a J above Ix + Iy, which no section has.
    """

    area: float
    second_moments: tuple[float, float]
    torsion_constant: float
    shear_coefficients: tuple[float, float] | None = None
    diameter: float | None = None
    bore: float = 0.0

    def __post_init__(self) -> None:
        number("Section.area", self.area, "a positive area in m^2", positive=True)
        two = "two positive second moments of area in m^4"
        object.__setattr__(
            self, "second_moments", _two("Section.second_moments", self.second_moments, two)
        )
        J = number("Section.torsion_constant", self.torsion_constant, "positive m^4", positive=True)
        if sum(self.second_moments) * (1 + ROUNDED) < J:
            raise InputError("Section.torsion_constant", J, "at most Ix + Iy, as any section has")
        if self.shear_coefficients is not None:
            name = "Section.shear_coefficients"
            both = _two(name, self.shear_coefficients, "two positive shear coefficients")
            object.__setattr__(self, "shear_coefficients", both)

    @classmethod
    def round(cls, diameter: float, bore: float = 0.0) -> "Section":
        """Return a round section of `diameter` with a concentric hole of diameter `bore` [m].

        A = pi (d^2 - b^2) / 4, Ix = Iy = pi (d^4 - b^4) / 64 and J = 2 Ix.
        """
        d = number("diameter", diameter, METRES, positive=True)
        if not SMALLEST <= d <= LARGEST:
            raise InputError("diameter", diameter, METRES)
        b = number("bore", bore, "a number of metres from 0 to less than the diameter")
        if not 0 <= b < d:
            raise InputError("bore", bore, f"from 0 to less than the diameter {d:g} m")
        second = math.pi * (d**4 - b**4) / 64
        return cls(math.pi * (d**2 - b**2) / 4, (second, second), 2 * second, None, d, b)

    @property
    def polar_moment(self) -> float:
        """Ix + Iy [m^4], of which rotary inertia in torsion is made; `torsion_constant` is not."""
        return self.second_moments[0] + self.second_moments[1]


def _two(name: str, values: Any, expected: str) -> tuple[float, float]:
    try:
        first, second = values
    except (TypeError, ValueError):
        raise InputError(name, values, expected) from None
    return (
        number(name, first, expected, positive=True),
        number(name, second, expected, positive=True),
    )


@dataclass(frozen=True)
class Rod:
    """An elastic rod of one material and one section, straight along its limb.

    `section` is a `Section`, or the diameter of a solid round one [m]; `length` [m], None for what
    the pose leaves.
    """

    material: Material
    section: Section
    length: float | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.material, Material):
            raise InputError("Rod.material", self.material, "a Material")
        if not isinstance(self.section, Section):
            d = number("Rod.diameter", self.section, METRES, positive=True)
            if not SMALLEST <= d <= LARGEST:
                raise InputError("Rod.diameter", d, METRES)
            object.__setattr__(self, "section", Section.round(d))
        if self.length is not None:
            number("Rod.length", self.length, METRES, positive=True)

    @classmethod
    def round(cls, material: Material, diameter: float, bore: float = 0.0) -> "Rod":
        """Return a round rod of `diameter`, with a hole of diameter `bore` [m]."""
        return cls(material, Section.round(diameter, bore))

    @property
    def diameter(self) -> float:
        """The diameter d of a solid round rod [m]; raises `InputError` for any other section."""
        if self.section.diameter is None or self.section.bore:
            raise InputError("rod", self.section, "a solid round section")
        return self.section.diameter

    @property
    def area(self) -> float:
        """Cross-section A [m^2]; pi d^2 / 4 of a solid round rod."""
        return self.section.area

    @property
    def second_moment(self) -> float:
        """Second moment of area I of a round rod about any diameter [m^4]; pi d^4 / 64 if solid."""
        if self.section.diameter is None:
            raise InputError("rod", self.section, "a round section")
        return self.section.second_moments[0]

    @property
    def polar_moment(self) -> float:
        """Polar moment of area Ix + Iy [m^4]."""
        return self.section.polar_moment


@dataclass(frozen=True)
class Link:
    """A rigid link without mass along the limb; `length` [m], None for what the pose leaves."""

    length: float | None = None

    def __post_init__(self) -> None:
        if self.length is not None:
            number("Link.length", self.length, METRES, positive=True)


@dataclass(frozen=True)
class Body:
    """A rigid body in a limb: a slider, a nut, a motor.

    Attributes: `mass` [kg]; `inertia` about its centre of mass, a 3 x 3 tensor [kg m^2]; `centre`
    of mass from where it stands in the chain [m]; both in the axes of `frame`: "base", "limb", or
    "global": as "base", but not turned with a limb that is (see `Limb.turned`).
    """

    mass: float
    inertia: Tensor
    centre: Vector = (0.0, 0.0, 0.0)
    frame: str = "base"

    def __post_init__(self) -> None:
        number("Body.mass", self.mass, "a positive number of kilograms", positive=True)
        object.__setattr__(self, "inertia", inertia_tensor("Body.inertia", self.inertia))
        centre = vector("Body.centre", self.centre, "three finite coordinates in metres")
        object.__setattr__(self, "centre", centre)
        if self.frame not in ("base", "limb", "global"):
            raise InputError("Body.frame", self.frame, "'base', 'limb' or 'global'")


def inertia_tensor(name: str, given: Any) -> Tensor:
    """Return `given` as a symmetric, positive definite tensor that a body can have, or refuse.

    A tensor asymmetric by rounding is made symmetric. Raises `InputError` for any other, and for a
    principal moment above the sum of the others.
    """
    expected = "a symmetric, positive definite 3 x 3 inertia tensor in kg m^2"
    try:
        rows = tuple(vector(name, row, expected) for row in given)
    except TypeError:
        raise InputError(name, given, expected) from None
    tensor = np.array(rows)
    if tensor.shape != (3, 3):
        raise InputError(name, given, expected)
    size = float(np.abs(tensor).max())
    if np.abs(tensor - tensor.T).max() > ROUNDED * size:
        raise InputError(name, given, expected)
    if (tensor != tensor.T).any():
        tensor = (tensor + tensor.T) / 2
        rows = tuple(vector(name, row, expected) for row in tensor.tolist())
    moments = np.linalg.eigvalsh(tensor)
    if not moments[0] > 0:
        raise InputError(name, given, expected)
    if moments[0] + moments[1] < moments[2] * (1 - ROUNDED):
        own = ", ".join(f"{moment:g}" for moment in moments)
        raise InputError(
            name,
            given,
            f"principal moments of which none exceeds the sum of the others, not {own}",
        )
    first, second, third = rows
    return first, second, third
