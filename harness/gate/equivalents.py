"""The same mechanism said differently: whatever a model answers must be the same, but for rounding.

The spread of the answers is the model's numerical noise, measured rather than assumed.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic import Limb, Material, Mechanism, Pose, Rod
from analytic.mechanism import Vector
from analytic.model import Model
from harness.bench import SPARE, Bench
from harness.workers import Failure

Floats = NDArray[np.float64]
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


def restated(
    angle: float = 0.0, length: float = 1.0, mass: float = 1.0, time: float = 1.0
) -> Change:
    """Return the change to axes turned by -`angle` [rad] about z, and to other units.

    The units are 1 / `length` m, 1 / `mass` kg and `time` s. E [kg / m s^2] and rho [kg / m^3]
    change with all three, the platform with mass and length.
    """
    c, s = np.cos(angle), np.sin(angle)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])

    def vector(values: Any) -> Vector:
        x, y, z = (R @ np.array(values)).tolist()
        return x, y, z

    def steel(m: Material) -> Material:
        modulus = mass * time**2 / length
        return Material(m.young * modulus, m.shear * modulus, m.density * mass / length**3)

    def change(mechanism: Mechanism, pose: Pose) -> Changed:
        limbs = tuple(
            Limb.rps(
                vector(length * np.array(limb.base)),
                vector(limb.axis),
                vector(length * np.array(limb.platform_point)),
                Rod.round(limb.rod.material, length * limb.rod.diameter),
            )
            for limb in mechanism.limbs
        )
        body = mechanism.platform
        inertia = mass * length**2 * (R @ np.array(body.inertia) @ R.T)
        x, y, z = (tuple(row) for row in ((inertia + inertia.T) / 2).tolist())
        platform = replace(body, inertia=(x, y, z), mass=mass * body.mass)
        said, _ = with_material(steel)(replace(mechanism, limbs=limbs, platform=platform), pose)
        return said, replace(pose, z=length * pose.z, azimuth=pose.azimuth + angle)

    return change


def with_material(change: Callable[[Material], Material]) -> Change:
    """Return the change of every limb's material."""

    def changed(mechanism: Mechanism, pose: Pose) -> Changed:
        limbs = tuple(
            limb.with_rod(replace(limb.rod, material=change(limb.rod.material)))
            for limb in mechanism.limbs
        )
        return replace(mechanism, limbs=limbs), pose

    return changed


EQUIVALENTS = (
    Equivalent("limbs renumbered", renumbered),
    Equivalent("axes turned by 57.3 deg", restated(angle=1.0)),
    Equivalent("axes turned by -131.8 deg", restated(angle=-2.3)),
    # Not a power of two: every digit changes, also those that a program prints.
    Equivalent("time unit 1.7 s", restated(time=1.7), 1.7),
)
UNITS = (
    *EQUIVALENTS,
    Equivalent("mass unit 1/0.3 kg", restated(mass=0.3)),
    Equivalent("lengths in mm", restated(length=1000.0)),
)


def noise(
    bench: Bench,
    model: Model,
    mechanism: Mechanism,
    pose: Pose,
    f: Floats,
    equivalents: Sequence[Equivalent] = EQUIVALENTS,
) -> Floats:
    """Return the largest relative deviation among `equivalents` of a model's own `f` (m,).

    Infinite where the model fails at one of them.
    """
    again = [
        answer(bench, model, *one.change(mechanism, pose), len(f)) / one.factor
        for one in equivalents
    ]
    return np.asarray(relative(again, f).max(axis=0))


def relative(value: Any, against: Any) -> Floats:
    """Return |value / against - 1|; of two zeros, the frequencies of one free motion, 0."""
    a, b = np.broadcast_arrays(np.asarray(value, dtype=float), np.asarray(against, dtype=float))
    off = np.where(a == b, 0.0, np.inf)
    np.divide(np.abs(a - b), np.abs(b), out=off, where=b != 0)
    return off


def answer(bench: Bench, model: Model, mechanism: Mechanism, pose: Pose, count: int) -> Floats:
    """Return the `count` lowest frequencies [Hz]; infinite where the model fails."""
    modes = bench.solve(model, mechanism, pose, count + SPARE)
    return np.full(count, np.inf) if isinstance(modes, Failure) else modes.frequencies[:count]
