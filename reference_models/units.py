"""Simulators solve in units of the robot: what they hold for small does not depend on its size.

Length, mass and time units are powers of two (the mass unit of four), so that nothing is rounded.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analytic.mechanism import (
    Body,
    Freedom,
    Item,
    Joint,
    Limb,
    Link,
    Material,
    Mechanism,
    Platform,
    Rod,
    Vector,
)
from analytic.modes import Modes
from analytic.pose import Pose, one_pose
from reference_models.chain_placement import stand
from reference_models.placement import place
from reference_models.protocol import ModelError

Array = NDArray[np.float64]
Tensor = tuple[Vector, Vector, Vector]
SLOWNESS = 2e-4
"""One over the speed of waves in steel [s/m]."""
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

        A limb without rods has the platform's mass, and steel's waves.
        """
        longest = int(np.argmax(lengths))
        L = float(lengths[longest])
        rods = mechanism.limbs[longest].rods
        mass, slowness = mechanism.platform.mass, SLOWNESS
        if rods:
            mass = sum(rod.material.density * rod.area for rod in rods) / len(rods) * L
            slowness = max(np.sqrt(rod.material.density / rod.material.young) for rod in rods)
        return cls(_power(2, L), _power(4, mass), _power(2, slow * L * slowness))

    def mechanism(self, given: Mechanism) -> Mechanism:
        """Return a mechanism, given in SI, in these units."""
        own = given.platform
        platform = Platform(
            own.mass / self.mass, self._inertia(own.inertia), own.form, self._place(own.centre)
        )
        return Mechanism(tuple(self._limb(limb) for limb in given.limbs), platform)

    def _limb(self, limb: Limb) -> Limb:
        chain = tuple(map(self._item, limb.chain))
        return replace(
            limb,
            base=self._place(limb.base),
            platform_point=self._place(limb.platform_point),
            chain=chain,
        )

    def _item(self, item: Item) -> Item:
        if isinstance(item, Joint):
            return replace(item, freedoms=tuple(map(self._freedom, item.freedoms)))
        if isinstance(item, Body):
            inertia, centre = self._inertia(item.inertia), self._place(item.centre)
            return Body(item.mass / self.mass, inertia, centre, item.frame)
        length = None if item.length is None else item.length / self.length
        if isinstance(item, Link):
            return Link(length)
        pressure = self.mass / (self.length * self.time**2)
        material = Material(
            item.material.young / pressure,
            item.material.shear / pressure,
            item.material.density * self.length**3 / self.mass,
        )
        own, four = item.section, self.length**4
        section = replace(
            own,
            area=own.area / self.length**2,
            second_moments=(own.second_moments[0] / four, own.second_moments[1] / four),
            torsion_constant=own.torsion_constant / four,
            diameter=None if own.diameter is None else own.diameter / self.length,
            bore=own.bore / self.length,
        )
        return Rod(material, section, length)

    def _freedom(self, freedom: Freedom) -> Freedom:
        unit = self.mass / self.time**2
        if freedom.kind == "rotation":
            unit *= self.length**2
        return replace(freedom, stiffness=freedom.stiffness / unit)

    def _inertia(self, given: Tensor) -> Tensor:
        moment = self.mass * self.length**2
        first, second, third = (_three([value / moment for value in row]) for row in given)
        return first, second, third

    def _place(self, given: Vector) -> Vector:
        return _three([x / self.length for x in given])

    def pose(self, given: Pose) -> Pose:
        """Return a pose, given in SI, in these units."""
        places = {name: getattr(given, name) for name in ("x", "y", "z")}
        scaled = {k: np.asarray(v) / self.length for k, v in places.items() if v is not None}
        return replace(given, **scaled)

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
    *,
    chains: bool = False,
) -> Modes:
    """Return what `solve(mechanism, pose, count)` finds, asked and answering in the robot's units.

    `slow` makes the time unit longer, and so the frequencies that `solve` finds greater; `chains`:
    whether `solve` takes limbs of any chain.
    Raises `InputError` for many poses or a pose out of reach, or limbs that `solve` does not take,
    `ModelError` where a joint of model `name` is open, and whatever `solve` raises.
    """
    one_pose(mechanism, pose)
    if chains:
        lengths = np.array([limb.length for limb in stand(mechanism, pose)[2]])
    else:
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
