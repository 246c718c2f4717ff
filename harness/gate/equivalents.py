"""The same mechanism said differently: whatever a model answers must be the same, but for rounding.

The spread of the answers is the model's numerical noise, measured rather than assumed.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic import Material, Mechanism, Platform, Pose
from analytic.mechanism import Vector
from analytic.model import Model
from harness.bench import SPARE, Bench
from harness.workers import Failure

Changed = tuple[Mechanism, Pose]
Change = Callable[[Mechanism, Pose], Changed]


@dataclass(frozen=True)
class Equivalent:
    """A change that leaves the problem as it was, its frequencies multiplied by `factor`."""

    name: str
    change: Change
    factor: float = 1.0


def renumbered(mechanism: Mechanism, pose: Pose) -> Changed:
    """Return the mechanism with its first limb last."""
    first, *others = mechanism.limbs
    return replace(mechanism, limbs=(*others, first)), pose


def turned(angle: float) -> Change:
    """Return the change to axes turned by -`angle` [rad] about z: mechanism and azimuth turn."""
    c, s = np.cos(angle), np.sin(angle)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])

    def about_z(vector: Vector) -> Vector:
        return _vector(R @ np.array(vector))

    def change(mechanism: Mechanism, pose: Pose) -> Changed:
        limbs = tuple(
            replace(
                limb,
                base=about_z(limb.base),
                axis=about_z(limb.axis),
                platform_point=about_z(limb.platform_point),
            )
            for limb in mechanism.limbs
        )
        inertia = R @ np.array(mechanism.platform.inertia) @ R.T
        platform = _with_inertia(mechanism.platform, (inertia + inertia.T) / 2)
        same = replace(mechanism, limbs=limbs, platform=platform)
        return same, replace(pose, azimuth=pose.azimuth + angle)

    return change


def in_units(length: float = 1.0, mass: float = 1.0, time: float = 1.0) -> Change:
    """Return the change to units of 1 / `length` m, 1 / `mass` kg and `time` s.

    E [kg / m s^2] and rho [kg / m^3] change with all three, the platform with mass and length.
    """

    def change(mechanism: Mechanism, pose: Pose) -> Changed:
        def moved(point: Vector) -> Vector:
            return _vector(length * np.array(point))

        def steel(m: Material) -> Material:
            modulus = mass * time**2 / length
            return Material(m.young * modulus, m.shear * modulus, m.density * mass / length**3)

        limbs = tuple(
            replace(
                limb,
                base=moved(limb.base),
                platform_point=moved(limb.platform_point),
                rod=replace(limb.rod, diameter=length * limb.rod.diameter),
            )
            for limb in mechanism.limbs
        )
        body = mechanism.platform
        inertia = mass * length**2 * np.array(body.inertia)
        platform = replace(_with_inertia(body, inertia), mass=mass * body.mass)
        scaled, _ = with_material(steel)(replace(mechanism, limbs=limbs, platform=platform), pose)
        return scaled, replace(pose, z=length * pose.z)

    return change


def with_material(change: Callable[[Material], Material]) -> Change:
    """Return the change of every limb's material."""

    def changed(mechanism: Mechanism, pose: Pose) -> Changed:
        limbs = tuple(
            replace(limb, rod=replace(limb.rod, material=change(limb.rod.material)))
            for limb in mechanism.limbs
        )
        return replace(mechanism, limbs=limbs), pose

    return changed


EQUIVALENTS = (
    Equivalent("limbs renumbered", renumbered),
    Equivalent("axes turned by 57.3 deg", turned(1.0)),
    Equivalent("axes turned by -131.8 deg", turned(-2.3)),
    # Not a power of two: every digit changes, also those that a program prints.
    Equivalent("time unit 1.7 s", in_units(time=1.7), 1.7),
)
UNITS = (
    *EQUIVALENTS,
    Equivalent("mass unit 1/0.3 kg", in_units(mass=0.3)),
    Equivalent("lengths in mm", in_units(length=1000.0)),
)


def noise(
    bench: Bench,
    model: Model,
    mechanism: Mechanism,
    pose: Pose,
    frequencies: NDArray[np.float64],
    equivalents: Sequence[Equivalent] = EQUIVALENTS,
) -> NDArray[np.float64]:
    """Return the largest relative deviation of each of `frequencies` (m,) among `equivalents`.

    `frequencies` are the model's own at this pose. Infinite where the model fails at one of them.
    """
    found = np.zeros(len(frequencies))
    for equivalent in equivalents:
        again = answer(bench, model, *equivalent.change(mechanism, pose), len(frequencies))
        if again is None:
            return np.full(len(frequencies), np.inf)
        found = np.maximum(found, relative(again / equivalent.factor, frequencies))
    return found


def relative(value: Any, against: Any) -> NDArray[np.float64]:
    """Return |value / against - 1|; of two zeros, the frequencies of one free motion, 0."""
    a, b = np.broadcast_arrays(np.asarray(value, dtype=float), np.asarray(against, dtype=float))
    off = np.where(a == b, 0.0, np.inf)
    np.divide(np.abs(a - b), np.abs(b), out=off, where=b != 0)
    return off


def answer(
    bench: Bench, model: Model, mechanism: Mechanism, pose: Pose, count: int
) -> NDArray[np.float64] | None:
    """Return the `count` lowest frequencies [Hz], or None where the model fails."""
    modes = bench.solve(model, mechanism, pose, count + SPARE)
    return None if isinstance(modes, Failure) else modes.frequencies[:count]


def _with_inertia(body: Platform, inertia: NDArray[np.float64]) -> Platform:
    x, y, z = (_vector(row) for row in inertia)
    return replace(body, inertia=(x, y, z))


def _vector(values: NDArray[np.float64]) -> Vector:
    x, y, z = values.tolist()
    return x, y, z
