"""The parameters that a table of frequencies may be asked for, in the units of their names."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import hypot, pi
from typing import Any

import numpy as np

from analytic import Mechanism, Pose
from analytic.description import PRINTED, numbers, with_numbers
from harness.case import Case

UNITS = {
    "m": ("_mm", 1e-3), "rad": ("_deg", pi / 180), "Pa": ("_GPa", 1e9), "kg/m^3": ("_kg_m3", 1.0),
    "kg": ("_kg", 1.0), "kg m^2": ("_kg_m2", 1.0), "N/m": ("_N_m", 1.0),
    "N m/rad": ("_Nm_rad", 1.0),
}  # fmt: skip
"""Ends of names, and their SI values, by SI unit."""
INERTIAS = {"disc": "disc", "printed": PRINTED}
FOLLOWS = {"disc_radius_mm": "platform_radius_mm", "platform_density_kg_m3": "density_kg_m3"}
"""A disc ends where the joints are and is made of what the rods are made of, if it does at first
and nothing else is asked."""
LETTERS = {
    "z": "z", "azimuth": "phi", "tilt": "theta", "base_radius": "r1", "platform_radius": "r2",
    "disc_radius": "R", "platform_thickness": "h", "rod_diameter": "d", "young": "E",
    "density": "rho", "platform_density": "rho_p",
}  # fmt: skip
BOUNDS = {
    "z": (0.65, 1.6), "base_radius": (0.1, 2.0), "radius": (0.5, 2.0), "diameter": (0.6, 1.4),
    "bore": (0.6, 1.4), "length": (0.65, 1.6), "platform_density": (0.25, 4.0),
    "young": (0.5, 2.0), "density": (0.5, 2.0), "stiffness": (0.1, 10.0), "": (0.25, 4.0),
}  # fmt: skip
"""Default bounds as factors of what is given, by the ends of names; the first that fits."""
ANGLES = {"azimuth": 180.0, "tilt": 45.0, "torsion": 45.0}
"""Default bounds of angles [deg]: so far from zero, or from what is given if that is beyond."""
POSE = (*ANGLES, "x", "y", "z")


@dataclass(frozen=True)
class Parameter:
    """A number of a case: its `value`, and default bounds, in the unit of its name.

    `name` without that unit, whose SI value is `si`. What is `linear` may be zero or change its
    sign, and is fitted itself instead of its logarithm.
    """

    name: str
    value: float
    low: float
    high: float
    linear: bool
    si: float

    @property
    def posed(self) -> bool:
        """Whether it is of a pose, which may be another in each case."""
        return self.name in POSE


def split(name: str) -> tuple[str, str]:
    """Return a parameter's name without its unit, and that as text."""
    end = next(end for end, _ in UNITS.values() if name.endswith(end))
    return name.removesuffix(end), end[1:].replace("_", "/")


def letter(name: str) -> str:
    """Return what a parameter is called in a product of powers."""
    return LETTERS.get(split(name)[0], split(name)[0])


def parameters(case: Case) -> dict[str, Parameter]:
    """Return the numbers of a case by name with unit."""
    limbs = case.mechanism.limbs
    size = 500 * max(hypot(*limb.base) + hypot(*limb.platform_point) for limb in limbs)
    found = {}
    for name, number in numbers(case.mechanism, case.pose).items():
        end, si = UNITS[number.unit]
        value = number.value / si
        factors = next(pair for of, pair in BOUNDS.items() if name.endswith(of))
        low, high = sorted(factor * value for factor in factors)
        if name in (*ANGLES, "x", "y") or not value:
            reach = ANGLES.get(name, size)
            middle = 0.0 if name in ANGLES and abs(value) <= reach else value
            low, high = middle - reach, middle + reach
        linear = name in (*ANGLES, "x", "y") or value <= 0
        found[name + end] = Parameter(name, value, low, high, linear, si)
    return found


def changes(known: Mapping[str, Parameter], values: Mapping[str, Any]) -> dict[str, Any]:
    """Return in SI, by their names in `numbers`, the `values` that are not as they were."""
    moved = {name: p for name, p in known.items() if np.any(values[name] != p.value)}
    return {p.name: values[name] * p.si for name, p in moved.items()}


def described(case: Case, values: Mapping[str, float], form: str | None) -> tuple[Mechanism, Pose]:
    """Return the mechanism and the pose of a case with its parameters changed to `values`.

    `form` of a disc as `with_numbers` takes it.
    """
    return with_numbers(case.mechanism, case.pose, changes(parameters(case), values), form)
