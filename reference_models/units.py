"""Simulators solve in units of the robot: what they hold for small does not depend on its size.

Length, mass and time units are powers of two (the mass unit of four), so that nothing is rounded.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analytic.mechanism import Limb, Material, Mechanism, Platform, Rod, Vector
from analytic.modes import Modes
from analytic.pose import Pose, one_pose
from reference_models.placement import place
from reference_models.protocol import ModelError

Array = NDArray[np.float64]
CLOSED = 1e-9
"""How far a joint may be open, relative to the longest limb."""


@dataclass(frozen=True)
class Units:
    """The units that numbers are given in: `length` [m], `mass` [kg], `time` [s]."""

    length: float
    mass: float
    time: float

    @classmethod
    def of(cls, mechanism: Mechanism, lengths: Array, slow: float = 1.0) -> "Units":
        """Return about the longest limb's length, its mass, and `slow` times the time that a wave
        takes along it.
        """
        longest = int(np.argmax(lengths))
        rod, L = mechanism.limbs[longest].rod, float(lengths[longest])
        mass = rod.material.density * rod.area * L
        time = L * np.sqrt(rod.material.density / rod.material.young)
        return cls(_power(2, L), _power(4, mass), _power(2, slow * time))

    def mechanism(self, given: Mechanism) -> Mechanism:
        """Return a mechanism, given in SI, in these units."""
        moment = self.mass * self.length**2
        xx, yy, zz = (_three([value / moment for value in row]) for row in given.platform.inertia)
        platform = Platform(given.platform.mass / self.mass, (xx, yy, zz), given.platform.form)
        return Mechanism(tuple(self._limb(limb) for limb in given.limbs), platform)

    def _limb(self, limb: Limb) -> Limb:
        pressure = self.mass / (self.length * self.time**2)
        material = limb.rod.material
        own = Material(
            material.young / pressure,
            material.shear / pressure,
            material.density * self.length**3 / self.mass,
        )
        base, point = (
            _three([x / self.length for x in place]) for place in (limb.base, limb.platform_point)
        )
        return Limb.rps(base, limb.axis, point, Rod.round(own, limb.rod.diameter / self.length))

    def pose(self, given: Pose) -> Pose:
        """Return a pose, given in SI, in these units."""
        return replace(given, z=np.asarray(given.z) / self.length)

    def modes(self, found: Modes) -> Modes:
        """Return modes, found in these units, in SI."""
        # A mode of unit modal mass: sum m u^2 + J turn^2 = 1.
        shift = 1 / np.sqrt(self.mass)
        turn = shift / self.length
        error = found.uncertainty
        return replace(
            found,
            frequencies=found.frequencies / self.time,
            platform=found.platform * np.repeat([shift, turn], 3),
            limbs=found.limbs * shift,
            residual=None if found.residual is None else found.residual * self.length,
            uncertainty=None if error is None else error / self.time,
        )


def in_robot_units(
    name: str,
    solve: Callable[[Mechanism, Pose, int], Modes],
    mechanism: Mechanism,
    pose: Pose,
    count: int,
    slow: float = 1.0,
) -> Modes:
    """Return what `solve(mechanism, pose, count)` finds, asked and answering in the robot's units.

    `slow` makes the time unit longer, and so the frequencies that `solve` finds greater.
    Raises `InputError` for many poses or a pose out of reach, `ModelError` where a joint of model
    `name` is open, and whatever `solve` raises.
    """
    one_pose(mechanism, pose)
    lengths = place(mechanism, pose).lengths
    units = Units.of(mechanism, lengths, slow)
    found = units.modes(solve(units.mechanism(mechanism), units.pose(pose), count))
    if found.residual is not None and not found.residual <= CLOSED * lengths.max():
        raise ModelError(
            f"{name}: joints are open by {found.residual:.1e} m, more than {CLOSED:.0e} of the "
            "longest limb; its frequencies are not those of the closed mechanism"
        )
    return found


def _power(base: int, size: float) -> float:
    """Return the power of `base` next to `size`."""
    return float(base) ** int(np.round(np.log(size) / np.log(base)))


def _three(values: list[float]) -> Vector:
    x, y, z = values
    return x, y, z
