"""What is possible but hardly meant: degrees for radians, GPa for Pa, millimetres for metres.

Units cannot be seen in numbers, but sizes that no mechanism has can. What is unlikely is warned of
where somebody states it; what is impossible is refused by the classes themselves.
"""

import warnings

import numpy as np

from analytic.mechanism import Material, Mechanism, Rod
from analytic.pose import Pose

SLOW, FAST = 10.0, 50_000.0
"""Speeds of sound sqrt(E / rho) [m/s]: rubber has 30, diamond 18,000."""
THIN = 1e-3
"""Diameter of a rod over its length: a wire, not a limb."""


class UnlikelyWarning(UserWarning):
    """A value that is possible, and hardly meant."""


def warn_of(mechanism: Mechanism, pose: Pose | None = None) -> None:
    """Warn of what is unlikely in SI units, one sentence a value; of lengths if there is a pose."""
    for sentence in unlikely(mechanism, pose):
        warnings.warn(sentence, UnlikelyWarning, stacklevel=3)


def unlikely(mechanism: Mechanism, pose: Pose | None = None) -> list[str]:
    """Return what is unlikely in SI units, one sentence a value."""
    rods = dict.fromkeys(rod for limb in mechanism.limbs for rod in limb.rods)
    said = [_material(steel) for steel in dict.fromkeys(rod.material for rod in rods)]
    size = float(np.abs(mechanism.bases).max() + np.abs(mechanism.platform_points).max())
    if pose is not None and size > 0:
        size = max(size, float(np.abs(np.asarray(pose.z)).max()))
        said += [_rod(rod, size) for rod in rods]
    return [sentence for sentence in said if sentence]


def _material(steel: Material) -> str:
    speed = float(np.sqrt(steel.young / steel.density))
    if SLOW <= speed <= FAST:
        return ""
    return (
        f"Material.young = {steel.young:g}, density = {steel.density:g}: sound would go at "
        f"{speed:.2g} m/s; are they in pascals and kg/m^3?"
    )


def _rod(rod: Rod, size: float) -> str:
    diameter = rod.section.diameter
    if diameter is None or diameter >= THIN * size:
        return ""
    return (
        f"Rod.diameter = {diameter:g}: less than a thousandth of the mechanism's {size:.2g} m; "
        "is it in metres?"
    )
