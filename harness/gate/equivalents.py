"""The same mechanism said differently: whatever a model answers must be the same, but for rounding.

The spread of the answers is the model's numerical noise, measured rather than assumed.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic import Body, Mechanism, Pose
from analytic.mechanism import Item
from analytic.model import Model
from harness.bench import SPARE, Bench
from harness.poses import turn, turned
from harness.workers import Failure
from reference_models.units import Units

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


def turned_axes(angle: float) -> Change:
    """Return the change to axes turned by -`angle` [rad] about z."""
    R = turn(2, angle)

    def item(i: Item) -> Item:  # a body in global axes turns with them too
        return replace(i, frame="base") if isinstance(i, Body) and i.frame == "global" else i

    def change(mechanism: Mechanism, pose: Pose) -> Changed:
        limbs = tuple(
            replace(limb, chain=tuple(map(item, limb.chain))).turned(angle)
            for limb in mechanism.limbs
        )
        body = mechanism.platform
        inertia, (x, y, z) = R @ np.array(body.inertia) @ R.T, (R @ np.array(body.centre)).tolist()
        first, second, third = (tuple(row) for row in ((inertia + inertia.T) / 2).tolist())
        platform = replace(body, inertia=(first, second, third), centre=(x, y, z))
        return Mechanism(limbs, platform), turned(pose, angle)

    return change


def in_units(length: float = 1.0, mass: float = 1.0, time: float = 1.0) -> Change:
    """Return the change to units of `length` [m], `mass` [kg] and `time` [s]."""
    units = Units(length, mass, time)
    return lambda mechanism, pose: (units.mechanism(mechanism), units.pose(pose))


EQUIVALENTS = (
    Equivalent("limbs renumbered", renumbered),
    Equivalent("axes turned by 57.3 deg", turned_axes(1.0)),
    Equivalent("axes turned by -131.8 deg", turned_axes(-2.3)),
    # Not a power of two: every digit changes, also those that a program prints.
    Equivalent("time unit 1.7 s", in_units(time=1.7), 1.7),
)
UNITS = (
    *EQUIVALENTS,
    Equivalent("mass unit 1/0.3 kg", in_units(mass=1 / 0.3)),
    Equivalent("lengths in mm", in_units(length=1e-3)),
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
