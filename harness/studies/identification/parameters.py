"""The parameters that a table of frequencies may be asked for, in the units of their names."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from analytic import InputError, Material, Mechanism, Platform, Pose, Rod
from analytic.designs import Designs
from harness.case import Case

DEGREE = float(np.pi / 180)
POSE = ("z_mm", "azimuth_deg", "tilt_deg")
INERTIAS = {"disc": "disc", "printed": "Eq. 8 as printed"}


@dataclass(frozen=True)
class Parameter:
    """What may be fitted: the SI value of its unit, and default bounds.

    `low` and `high` are factors of the starting value, or for an angle values of their own.
    `letter` is what it is called in a product of powers. An `angle` may be zero or negative, and is
    fitted itself instead of its logarithm.
    """

    unit: float
    low: float
    high: float
    letter: str
    angle: bool = False


PARAMETERS = {
    "z_mm": Parameter(1e-3, 0.65, 1.6, "z"),
    "azimuth_deg": Parameter(DEGREE, -180.0, 180.0, "phi", angle=True),
    "tilt_deg": Parameter(DEGREE, -45.0, 45.0, "theta", angle=True),
    "base_radius_mm": Parameter(1e-3, 0.1, 2.0, "r1"),
    "platform_radius_mm": Parameter(1e-3, 0.5, 2.0, "r2"),
    "disc_radius_mm": Parameter(1e-3, 0.5, 2.0, "R"),
    "platform_thickness_mm": Parameter(1e-3, 0.25, 4.0, "h"),
    "rod_diameter_mm": Parameter(1e-3, 0.6, 1.4, "d"),
    "young_GPa": Parameter(1e9, 0.5, 2.0, "E"),
    "density_kg_m3": Parameter(1.0, 0.5, 2.0, "rho"),
    "platform_density_kg_m3": Parameter(1.0, 0.25, 4.0, "rho_p"),
}


def starting_values(case: Case) -> dict[str, float]:
    """Return the parameters of a case's mechanism and pose.

    Raises `InputError` unless it has three equal limbs 120 degrees apart and a disc for a platform
    (or Eq. 8's), which is what these parameters describe.
    """
    mechanism, pose = case.mechanism, case.pose
    for limb in mechanism.limbs:
        if not limb.simple:
            found = f"{case.name}, of {limb.described} limbs"
            raise InputError("table", found, "a mechanism of R-P-S limbs of one solid round rod")
    rod, platform = mechanism.limbs[0].rod, mechanism.platform
    r1, r2 = (float(np.hypot(*p[0, :2])) for p in (mechanism.bases, mechanism.platform_points))
    same = Mechanism.regular(r1, r2, rod, platform, heading=heading(mechanism))
    alike = len(mechanism.limbs) == 3 and all(
        np.allclose(getattr(same, name), getattr(mechanism, name), atol=1e-9)
        for name in ("bases", "axes", "platform_points")
    )
    if not alike or any(limb.rod != rod for limb in mechanism.limbs):
        raise InputError("table", case.name, "a mechanism of three equal limbs at 120 degrees")
    if platform.form not in INERTIAS.values():
        raise InputError("table", case.name, "a mechanism whose platform is a disc")
    rho = rod.material.density
    return {
        "z_mm": 1e3 * pose.z,
        "azimuth_deg": pose.azimuth / DEGREE,
        "tilt_deg": pose.tilt / DEGREE,
        "base_radius_mm": 1e3 * r1,
        "platform_radius_mm": 1e3 * r2,
        "disc_radius_mm": 1e3 * r2,
        "platform_thickness_mm": 1e3 * platform.mass / (rho * np.pi * r2**2),
        "rod_diameter_mm": 1e3 * rod.diameter,
        "young_GPa": rod.material.young / 1e9,
        "density_kg_m3": rho,
        "platform_density_kg_m3": rho,
    }


def heading(mechanism: Mechanism) -> float:
    """Return the angle of the first limb [rad]."""
    x, y, _ = mechanism.limbs[0].base
    return float(np.arctan2(y, x))


def designs(values: Mapping[str, Any], inertia: str, mirrored: bool) -> Designs:
    """Return mechanisms and poses from values (N,) of all parameters."""
    si, mass, across, polar = _si(values, inertia)
    return Designs(
        si["z_mm"], si["azimuth_deg"], si["tilt_deg"], si["base_radius_mm"],
        si["platform_radius_mm"], si["rod_diameter_mm"], si["young_GPa"], si["density_kg_m3"],
        mass, across, polar, mirrored,
    )  # fmt: skip


def described(values: Mapping[str, float], inertia: str, like: Mechanism) -> tuple[Mechanism, Pose]:
    """Return the one mechanism and pose that `designs` makes of numbers, with frames as stated.

    Its first limb's heading and its Poisson's ratio are those of `like`.
    """
    si, mass, across, polar = _si(values, inertia)
    young, poisson = si["young_GPa"], like.limbs[0].rod.material.poisson
    material = Material(young, young / (2 * (1 + poisson)), si["density_kg_m3"])
    mechanism = Mechanism.regular(
        si["base_radius_mm"],
        si["platform_radius_mm"],
        Rod.round(material, si["rod_diameter_mm"]),
        Platform.diagonal(mass, (across, across, polar), INERTIAS[inertia]),
        heading=heading(like),
    )
    return mechanism, Pose(*(si[name] for name in POSE))


def _si(values: Mapping[str, Any], inertia: str) -> tuple[dict[str, Any], Any, Any, Any]:
    """Return `values` in SI; the platform's mass, and its moments across and polar [kg m^2].

    It is a disc; with `inertia` "printed" it has Eq. 8's moments, m r2^2 about all axes.
    """
    si = {name: value * PARAMETERS[name].unit for name, value in values.items()}
    R, h = si["disc_radius_mm"], si["platform_thickness_mm"]
    mass = si["platform_density_kg_m3"] * np.pi * R**2 * h
    if inertia == "printed":
        return si, mass, mass * si["platform_radius_mm"] ** 2, mass * si["platform_radius_mm"] ** 2
    return si, mass, mass * (3 * R**2 + h**2) / 12, mass * R**2 / 2
