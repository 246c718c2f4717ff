"""The rigid moving platform, with what it carries."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analytic.errors import number, vector
from analytic.rod import Tensor, Vector, inertia_tensor


@dataclass(frozen=True)
class Platform:
    """The rigid moving platform: `mass` [kg], `inertia` and `centre` in the moving frame.

    `inertia` [kg m^2] is about the `centre` of mass [m], which by default is o: a symmetric,
    positive definite 3 x 3 tensor given as three rows of three numbers. `form` says in words where
    it comes from. Raises `InputError` for what no body has.
    """

    mass: float
    inertia: Tensor
    form: str = "given"
    centre: Vector = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        number("Platform.mass", self.mass, "a positive number of kilograms", positive=True)
        object.__setattr__(self, "inertia", inertia_tensor("Platform.inertia", self.inertia))
        centre = vector("Platform.centre", self.centre, "three finite coordinates in metres")
        object.__setattr__(self, "centre", centre)

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

    def carrying(
        self, mass: float, centre: Vector = (0.0, 0.0, 0.0), inertia: Tensor | None = None
    ) -> "Platform":
        """Return this platform with a payload of `mass` [kg] at `centre` [m] fixed to it.

        `inertia` of the payload about its own centre [kg m^2]; None: a point.
        """
        number("payload mass", mass, "a positive number of kilograms", positive=True)
        place = np.array(vector("payload centre", centre, "three finite coordinates in metres"))
        own = np.zeros((3, 3))
        if inertia is not None:
            own = np.array(inertia_tensor("payload inertia", inertia))
        total = self.mass + mass
        both = (self.mass * np.array(self.centre) + mass * place) / total
        tensor = np.array(self.inertia) + own
        for m, at in ((self.mass, np.array(self.centre)), (mass, place)):
            d = at - both
            tensor = tensor + m * (d @ d * np.eye(3) - np.outer(d, d))
        first, second, third = tensor.tolist()
        x, y, z = both.tolist()
        rows = (tuple(first), tuple(second), tuple(third))
        return Platform(total, rows, "with a payload", (x, y, z))

    @property
    def mass_matrix(self) -> NDArray[np.float64]:
        """M about o in the moving frame, (6, 6): Eq. (7), with the centre of mass anywhere."""
        return body_mass(self.mass, np.array(self.inertia), np.array(self.centre))


def body_mass(
    mass: float, inertia: NDArray[np.float64], centre: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return a rigid body's mass matrix (6, 6) about a point from which `centre` (3,) is [m].

    `inertia` (3, 3) about the centre of mass [kg m^2].
    """
    x, y, z = centre
    lever = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    M = np.zeros((6, 6))
    M[:3, :3] = mass * np.eye(3)
    M[:3, 3:], M[3:, :3] = -mass * lever, mass * lever
    M[3:, 3:] = inertia - mass * lever @ lever
    return M


def _disc_mass(radius: float, thickness: float, density: float) -> float:
    number("Platform radius", radius, "a positive number of metres", positive=True)
    number("Platform thickness", thickness, "a positive number of metres", positive=True)
    number("Platform density", density, "a positive kg/m^3", positive=True)
    return density * math.pi * radius**2 * thickness
