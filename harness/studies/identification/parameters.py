"""The parameters that a table of frequencies may be asked for, in the units of their names."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic import InputError, Material, Mechanism, Platform, Pose, Rod
from analytic.designs import Designs
from harness.cases import Case

Floats = NDArray[np.float64]
Values = Mapping[str, float | Floats]


@dataclass(frozen=True)
class Parameter:
    """What may be fitted: its `name` with unit, SI value of that unit, and default bounds.

    `low` and `high` are factors of the starting value, or for an angle values of their own.
    `letter` is what it is called in a product of powers.
    """

    name: str
    unit: float
    low: float
    high: float
    letter: str

    @property
    def angle(self) -> bool:
        """Whether it may be zero or negative, and is fitted itself instead of its logarithm."""
        return self.name.endswith("_deg")


DEGREE = float(np.pi / 180)
PARAMETERS = {
    parameter.name: parameter
    for parameter in (
        Parameter("z_mm", 1e-3, 0.65, 1.6, "z"),
        Parameter("azimuth_deg", DEGREE, -180.0, 180.0, "phi"),
        Parameter("tilt_deg", DEGREE, -45.0, 45.0, "theta"),
        Parameter("base_radius_mm", 1e-3, 0.1, 2.0, "r1"),
        Parameter("platform_radius_mm", 1e-3, 0.5, 2.0, "r2"),
        Parameter("disc_radius_mm", 1e-3, 0.5, 2.0, "R"),
        Parameter("platform_thickness_mm", 1e-3, 0.25, 4.0, "h"),
        Parameter("rod_diameter_mm", 1e-3, 0.6, 1.4, "d"),
        Parameter("young_GPa", 1e9, 0.5, 2.0, "E"),
        Parameter("density_kg_m3", 1.0, 0.5, 2.0, "rho"),
        Parameter("platform_density_kg_m3", 1.0, 0.25, 4.0, "rho_p"),
    )
}
POSE = ("z_mm", "azimuth_deg", "tilt_deg")
INERTIAS = {"disc": "disc", "printed": "Eq. 8 as printed"}


def starting_values(case: Case) -> dict[str, float]:
    """Return the parameters of a case's mechanism, in the units of their names.

    Raises `InputError` unless it has three equal limbs 120 degrees apart and a disc for a platform
    (or Eq. 8's), which is what these parameters describe.
    """
    mechanism = case.mechanism
    rod = mechanism.limbs[0].rod
    r1, r2 = (float(np.hypot(*p[0, :2])) for p in (mechanism.bases, mechanism.platform_points))
    same = Mechanism.regular(r1, r2, rod, mechanism.platform, heading=heading(mechanism))
    alike = len(mechanism.limbs) == 3 and all(
        np.allclose(getattr(same, name), getattr(mechanism, name), atol=1e-9)
        for name in ("bases", "axes", "platform_points")
    )
    if not alike or any(limb.rod != rod for limb in mechanism.limbs):
        raise InputError("table", case.name, "a mechanism of three equal limbs at 120 degrees")
    if mechanism.platform.form not in INERTIAS.values():
        raise InputError("table", case.name, "a mechanism whose platform is a disc")
    rho = rod.material.density
    return {
        "base_radius_mm": 1e3 * r1,
        "platform_radius_mm": 1e3 * r2,
        "disc_radius_mm": 1e3 * r2,
        "platform_thickness_mm": 1e3 * mechanism.platform.mass / (rho * np.pi * r2**2),
        "rod_diameter_mm": 1e3 * rod.diameter,
        "young_GPa": rod.material.young / 1e9,
        "density_kg_m3": rho,
        "platform_density_kg_m3": rho,
    }


def heading(mechanism: Mechanism) -> float:
    """Return the angle of the first limb [rad]."""
    x, y, _ = mechanism.limbs[0].base
    return float(np.arctan2(y, x))


def pose_values(case: Case) -> dict[str, float]:
    """Return a case's pose, in the units of the parameters' names."""
    pose = case.pose
    return {
        "z_mm": 1e3 * pose.z,
        "azimuth_deg": pose.azimuth / DEGREE,
        "tilt_deg": pose.tilt / DEGREE,
    }


def designs(values: Values, inertia: str, mirrored: bool) -> Designs:
    """Return mechanisms and poses from values in the units of their names, numbers or (N,).

    The platform is a disc of `disc_radius_mm` and `platform_thickness_mm`; with `inertia` "printed"
    its mass has Eq. 8's moments, m r2^2 about all axes.
    """
    si = {name: np.atleast_1d(value) * PARAMETERS[name].unit for name, value in values.items()}
    return Designs(
        si["z_mm"], si["azimuth_deg"], si["tilt_deg"], si["base_radius_mm"],
        si["platform_radius_mm"], si["rod_diameter_mm"], si["young_GPa"], si["density_kg_m3"],
        *_platform(si, inertia), mirrored,
    )  # fmt: skip


def described(values: Mapping[str, float], inertia: str, like: Mechanism) -> tuple[Mechanism, Pose]:
    """Return the one mechanism and pose that `designs` makes of numbers, with frames as stated.

    Its first limb's heading and its Poisson's ratio are those of `like`.
    """
    si = {name: value * PARAMETERS[name].unit for name, value in values.items()}
    young, poisson = si["young_GPa"], like.limbs[0].rod.material.poisson
    material = Material(young, young / (2 * (1 + poisson)), si["density_kg_m3"])
    mass, across, polar = _platform(si, inertia)
    mechanism = Mechanism.regular(
        si["base_radius_mm"],
        si["platform_radius_mm"],
        Rod(material, si["rod_diameter_mm"]),
        Platform.diagonal(mass, (across, across, polar), INERTIAS[inertia]),
        heading=heading(like),
    )
    return mechanism, Pose(si["z_mm"], si["azimuth_deg"], si["tilt_deg"])


def _platform(si: Mapping[str, Any], inertia: str) -> tuple[Any, Any, Any]:
    """Return its mass and its moments of inertia, across and polar, [kg, kg m^2]."""
    R, h = si["disc_radius_mm"], si["platform_thickness_mm"]
    mass = si["platform_density_kg_m3"] * np.pi * R**2 * h
    if inertia == "printed":
        return mass, mass * si["platform_radius_mm"] ** 2, mass * si["platform_radius_mm"] ** 2
    return mass, mass * (3 * R**2 + h**2) / 12, mass * R**2 / 2
