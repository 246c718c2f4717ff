"""The manipulator in MJCF, all but its rods: platform, hinges, and where each limb goes."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.mechanism import Mechanism, Rod
from analytic.pose import Pose
from reference_models.placement import place

Array = NDArray[np.float64]

STEP = 1e-5
"""Displacement of the differences that give K, relative to the shortest limb [m or rad]."""
STILL = 1e-7
"""Mass and inertia of a hinge body relative to its limb's: MuJoCo demands some, and only the rod
should have any."""


HEAD = (
    '<mujoco><option gravity="0 0 0" jacobian="dense" integrator="Euler">'
    '<flag contact="disable"/></option>'
)


@dataclass(frozen=True)
class Limb:
    """One limb at a pose: `rod` from `base` B_i, `length` [m] along the unit vector `along`.

    `axis` is the revolute axis, made perpendicular to `along`; `point` is A_i in the moving frame.
    """

    rod: Rod
    base: Array
    along: Array
    axis: Array
    length: float
    point: Array

    @property
    def tip(self) -> Array:
        """Where the rod ends, global frame [m]."""
        return self.base + self.length * self.along

    @property
    def line_density(self) -> float:
        """Mass per length, rho A [kg/m]."""
        return self.rod.material.density * self.rod.area


@dataclass(frozen=True)
class Rods:
    """What a kind of rod adds to the rig, in MJCF; one text a limb.

    `inside` goes into the hinge body `B<i>` (frame at B_i, x along the limb, y the revolute axis),
    `beside` into the world after it; `tip_mass` [kg] rides on the platform at A_i; `rest` is the
    remainder of the document. `bodies` names the bodies of the vertices of each limb, from B_i to
    A_i: their origins are the vertices (that of the last is A_i, whatever its body). `amend` puts
    right, in the compiled model, what the compiler cannot say exactly.
    """

    inside: list[str]
    beside: list[str]
    tip_mass: list[float]
    rest: str
    bodies: list[list[str]]
    amend: Callable[[Any], None] = lambda model: None


def limbs_of(mechanism: Mechanism, pose: Pose) -> list[Limb]:
    """Return the limbs at `pose`; raises `InputError` where a joint cannot close."""
    placed = place(mechanism, pose)
    return [
        Limb(
            limb.rod,
            np.array(limb.base),
            placed.along[i],
            placed.about[i],
            float(placed.lengths[i]),
            np.array(limb.platform_point),
        )
        for i, limb in enumerate(mechanism.limbs)
    ]


def document(mechanism: Mechanism, pose: Pose, limbs: list[Limb], rods: Rods) -> str:
    """Return the MJCF text: the platform (free, its frame at o), then limb after limb."""
    placed = place(mechanism, pose)
    o, R = placed.centre, placed.rotation
    tips = (
        f'<site name="A{i}" pos="{text(limb.point)}"/>'
        + (f'<body pos="{text(limb.point)}">{inertial(mass, 0.0)}</body>' if mass else "")
        for i, (limb, mass) in enumerate(zip(limbs, rods.tip_mass, strict=True))
    )
    hinges = (_hinge(i, limb, rods) for i, limb in enumerate(limbs))
    platform = platform_body(mechanism, o, R, "".join(tips))
    return f"{HEAD}<worldbody>{platform}{''.join(hinges)}</worldbody>{rods.rest}</mujoco>"


def platform_body(mechanism: Mechanism, o: Array, R: Array, inside: str) -> str:
    """Return the platform in MJCF, free, its frame at o turned by R, with what is `inside` it."""
    platform = mechanism.platform
    J = np.array(platform.inertia) + surplus(mechanism) * np.eye(3)
    full = J[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    return (
        f'<body name="platform" pos="{text(o)}" xyaxes="{text(R[:, 0], R[:, 1])}"><freejoint/>'
        f'<inertial pos="{text(np.array(platform.centre))}" mass="{text(platform.mass)}" '
        f'fullinertia="{text(full)}"/>{inside}</body>'
    )


def surplus(mechanism: Mechanism) -> float:
    """Return what `platform_body` adds to the platform's moments, to be taken off once compiled.

    The compiler refuses principal moments with A + B < C, even where a flat plate's differ from
    A + B = C by rounding; with tr J on each the axes are the same and the rule is met.
    """
    return float(np.trace(np.array(mechanism.platform.inertia)))


def _hinge(i: int, limb: Limb, rods: Rods) -> str:
    mass = STILL * limb.line_density * limb.length
    return (
        f'<body name="B{i}" pos="{text(limb.base)}" xyaxes="{text(limb.along, limb.axis)}">'
        f'<joint type="hinge" axis="0 1 0"/>{inertial(mass, mass * limb.length**2 / 3)}'
        f"{rods.inside[i]}</body>{rods.beside[i]}"
    )


def text(*numbers: Array | float) -> str:
    """Return numbers for an attribute, to the last bit."""
    return " ".join(repr(float(x)) for group in numbers for x in np.ravel(group))


def inertial(mass: float, moment: float) -> str:
    """Return a body's mass, at its origin, and three equal moments of inertia."""
    return (
        f'<inertial pos="0 0 0" mass="{text(mass)}" diaginertia="{text(moment, moment, moment)}"/>'
    )
