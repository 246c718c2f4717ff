"""The same mechanism said differently: whatever a model answers must be the same, but for rounding.

The spread of the answers is the model's numerical noise, measured rather than assumed.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analytic import Limb, Material, Mechanism, Platform, Pose
from analytic.mechanism import Vector
from harness.models import Model


@dataclass(frozen=True)
class Equivalent:
    """A change that leaves the problem as it was, its frequencies multiplied by `factor`."""

    name: str
    change: Callable[[Mechanism, Pose], tuple[Mechanism, Pose]]
    factor: float = 1.0


def renumbered(mechanism: Mechanism, pose: Pose) -> tuple[Mechanism, Pose]:
    """Return the mechanism with its first limb last."""
    first, *others = mechanism.limbs
    return Mechanism((*others, first), mechanism.platform), pose


def turned(angle: float) -> Callable[[Mechanism, Pose], tuple[Mechanism, Pose]]:
    """Return the change to axes turned by -`angle` [rad] about z: mechanism and azimuth turn."""
    c, s = np.cos(angle), np.sin(angle)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])

    def change(mechanism: Mechanism, pose: Pose) -> tuple[Mechanism, Pose]:
        limbs = tuple(
            Limb(
                _vector(R @ np.array(limb.base)),
                _vector(R @ np.array(limb.axis)),
                _vector(R @ np.array(limb.platform_point)),
                limb.rod,
            )
            for limb in mechanism.limbs
        )
        body = mechanism.platform
        inertia = R @ np.array(body.inertia) @ R.T
        x, y, z = (_vector(row) for row in (inertia + inertia.T) / 2)
        platform = Platform(body.mass, (x, y, z), body.form)
        return Mechanism(limbs, platform), Pose(pose.z, pose.azimuth + angle, pose.tilt)

    return change


def in_time_unit(factor: float) -> Callable[[Mechanism, Pose], tuple[Mechanism, Pose]]:
    """Return the change to a time unit of `factor` seconds: moduli are 1/s^2, frequencies 1/s."""
    return with_material(
        lambda m: Material(m.young * factor**2, m.shear * factor**2, m.density)
    )  # fmt: skip


def in_mass_unit(factor: float) -> Callable[[Mechanism, Pose], tuple[Mechanism, Pose]]:
    """Return the change to a mass unit of 1/`factor` kg: moduli, densities and the platform's."""

    def change(mechanism: Mechanism, pose: Pose) -> tuple[Mechanism, Pose]:
        scaled, _ = with_material(
            lambda m: Material(m.young * factor, m.shear * factor, m.density * factor)
        )(mechanism, pose)
        body = mechanism.platform
        x, y, z = (_vector(row) for row in factor * np.array(body.inertia))
        return replace(scaled, platform=Platform(body.mass * factor, (x, y, z), body.form)), pose

    return change


def in_length_unit(factor: float) -> Callable[[Mechanism, Pose], tuple[Mechanism, Pose]]:
    """Return the change to a length unit of 1/`factor` metres: E [kg/(m s^2)], rho [kg/m^3]."""

    def change(mechanism: Mechanism, pose: Pose) -> tuple[Mechanism, Pose]:
        scaled, _ = with_material(
            lambda m: Material(m.young / factor, m.shear / factor, m.density / factor**3)
        )(mechanism, pose)
        limbs = tuple(
            Limb(
                _vector(factor * np.array(limb.base)),
                limb.axis,
                _vector(factor * np.array(limb.platform_point)),
                replace(limb.rod, diameter=factor * limb.rod.diameter),
            )
            for limb in scaled.limbs
        )
        body = mechanism.platform
        x, y, z = (_vector(row) for row in factor**2 * np.array(body.inertia))
        platform = Platform(body.mass, (x, y, z), body.form)
        return Mechanism(limbs, platform), replace(pose, z=factor * pose.z)

    return change


def with_material(
    change: Callable[[Material], Material],
) -> Callable[[Mechanism, Pose], tuple[Mechanism, Pose]]:
    """Return the change of every limb's material."""

    def changed(mechanism: Mechanism, pose: Pose) -> tuple[Mechanism, Pose]:
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
    Equivalent("time unit 1.7 s", in_time_unit(1.7), 1.7),
)


def noise(
    model: Model,
    mechanism: Mechanism,
    pose: Pose,
    frequencies: NDArray[np.float64],
    spare: int,
    equivalents: tuple[Equivalent, ...] = EQUIVALENTS,
) -> NDArray[np.float64]:
    """Return the largest relative deviation of each of `frequencies` (m,) among `equivalents`.

    `frequencies` are the model's own at this pose; `spare`: modes solved for beyond them.
    """
    found = np.zeros(len(frequencies))
    for equivalent in equivalents:
        changed = equivalent.change(mechanism, pose)
        modes = model.modes(*changed, len(frequencies) + spare)
        again = modes.frequencies[: len(frequencies)] / equivalent.factor
        found = np.maximum(found, np.abs(again / frequencies - 1))
    return found


def _vector(values: NDArray[np.float64]) -> Vector:
    x, y, z = values.tolist()
    return x, y, z
