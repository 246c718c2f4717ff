"""The same mechanism said differently: whatever a model answers must be the same, but for rounding.

The spread of the answers is the model's numerical noise, measured rather than assumed.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic import Body, Joint, Limb, Link, Material, Mechanism, Pose, Rod, Section
from analytic.mechanism import Item, Vector
from analytic.model import Model
from harness.bench import SPARE, Bench
from harness.poses import turn, turned
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
    R, stiffness = turn(2, angle), mass * time**2

    def longer(values: Vector) -> Vector:
        x, y, z = (length * np.array(values)).tolist()
        return x, y, z

    def tensor(values: Any, axes: Any) -> Any:
        found = mass * length**2 * (axes @ np.array(values) @ axes.T)
        return tuple(tuple(row) for row in ((found + found.T) / 2).tolist())

    def steel(m: Material) -> Material:
        modulus = mass * time**2 / length
        return Material(m.young * modulus, m.shear * modulus, m.density * mass / length**3)

    def section(s: Section) -> Section:
        if s.diameter is not None:
            return Section.round(length * s.diameter, length * s.bore)
        first, second = s.second_moments
        moments = length**4 * first, length**4 * second
        return Section(length**2 * s.area, moments, length**4 * s.torsion_constant,
                       s.shear_coefficients)  # fmt: skip

    def item(i: Item) -> Item:
        if isinstance(i, Joint):
            kept = (
                replace(f, stiffness=f.stiffness * stiffness
                        * (length**2 if f.kind == "rotation" else 1.0))
                for f in i.freedoms
            )  # fmt: skip
            return replace(i, freedoms=tuple(kept))
        if isinstance(i, Body):
            return Body(mass * i.mass, tensor(i.inertia, np.eye(3)), longer(i.centre), i.frame)
        own = None if i.length is None else length * i.length
        if isinstance(i, Link):
            return Link(own)
        return Rod(i.material, section(i.section), own)

    def change(mechanism: Mechanism, pose: Pose) -> Changed:
        limbs = []
        for one in mechanism.limbs:
            # Bodies in global axes turn with the axes too.
            fixed = (replace(i, frame="base") if isinstance(i, Body) and i.frame == "global" else i
                     for i in one.chain)  # fmt: skip
            limb = replace(one, chain=tuple(fixed)).turned(angle)
            chain = tuple(map(item, limb.chain))
            limbs.append(Limb(longer(limb.base), longer(limb.platform_point), chain,
                              limb.reference))  # fmt: skip
        body = mechanism.platform
        x, y, z = (R @ np.array(longer(body.centre))).tolist()
        platform = replace(
            body, inertia=tensor(body.inertia, R), mass=mass * body.mass, centre=(x, y, z)
        )
        said, _ = with_material(steel)(Mechanism(tuple(limbs), platform), pose)
        return said, turned(pose, angle, length)

    return change


def with_material(change: Callable[[Material], Material]) -> Change:
    """Return the change of every limb's material."""

    def changed(mechanism: Mechanism, pose: Pose) -> Changed:
        limbs = tuple(
            replace(limb, chain=tuple(
                replace(i, material=change(i.material)) if isinstance(i, Rod) else i
                for i in limb.chain
            ))
            for limb in mechanism.limbs
        )  # fmt: skip
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
