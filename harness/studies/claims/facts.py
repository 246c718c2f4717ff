"""What the verdicts on the paper's claims rest on: figures alone, in SI units unless named so."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness import published
from harness.presets import PAPER_MODEL
from reference_models import Named

Floats = NDArray[np.float64]
CASES = ("case1", "case2")
"""The two of Table I."""
PAPER = PAPER_MODEL
THEORIES = tuple(Named(name, None) for name in ("euler-bernoulli", "rayleigh", "timoshenko"))
EXACT, _, TIMOSHENKO = THEORIES
STEPS = range(1, 9)
"""Numbers of elements that are solved."""


def _matrices() -> dict[str, Any]:
    return tomllib.loads(published.text("equations.toml"))


@dataclass(frozen=True)
class Printed:
    """The paper's own numbers: Table I, the errors quoted with Fig. 3, times and blocks' widths.

    `matrices` by equation: "columns", and by "rows" each one's widths, as (a, b) for a s + b.
    """

    table: Mapping[tuple[str, str], tuple[float, ...]] = field(default_factory=published.table1)
    figure3: Mapping[tuple[str, int, int], float] = field(default_factory=published.figure3)
    cost: Mapping[str, float] = field(default_factory=published.cost)
    matrices: Mapping[str, Any] = field(default_factory=_matrices)


@dataclass(frozen=True)
class Beams:
    """The beam theories' f1-f6 [Hz] by (case, model), in the order of the paper's modes.

    `scan_z` (n,) and `scan` by case (n, 6): the paper's model over height at the case's angles.
    `lengths`: case name to shortest and longest limb.
    """

    hertz: Mapping[tuple[str, Named], Floats]
    scan_z: Floats
    scan: Mapping[str, Floats]
    lengths: Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class Reference:
    """A simulator's f1-f6 and their numerical uncertainty [Hz] by case, paired by shape."""

    label: str
    hertz: Mapping[str, Floats]
    uncertainty: Mapping[str, Floats]


@dataclass(frozen=True)
class Slender:
    """Both beam theories as rods grow stout: ratios d/L (n,), the last the printed one.

    `frequencies`: largest relative difference of f1-f6 over both cases, (n, 6) [%]; `stiffness`:
    that of the platform's static stiffness, (n,) [%].
    """

    ratios: Floats
    frequencies: Floats
    stiffness: Floats


@dataclass(frozen=True)
class Equations:
    """Residuals of Eqs. (1)-(22) as printed."""

    rotation: float  # largest of |R^T R - 1| and |det R - 1|, Eq. (1)
    phi_alone: float  # how far R turns for PHI alone [rad]
    theta_axis: float  # angle of R's axis from x for THETA alone [rad]
    beside_plane: float  # largest distance of an A_i from its joint's plane, Eq. (2) [m]
    lengths_apart: float  # largest difference of L_i, Eq. (3), from the model's [m]
    compatibility: float  # largest error of Eq. (10), relative to the arm
    freedoms: int  # of the platform with its actuators free
    # By s: coordinates of a rod, all of them, rank of the constraints, size of K of Eq. (22).
    sizes: Mapping[int, tuple[int, int, int, int]]
    headings: Floats  # turns of the base (n,) [rad]
    eq17: Floats  # smallest |denominator| over limbs and poses (n,)
    eq18: Floats
    axis_rise: float  # largest vertical component of a revolute axis
    axis_motion: float  # largest change of a revolute axis from pose to pose
    joints_open: float  # largest |C u| of a mode for unit largest motion
    multipliers_apart: float  # largest relative difference of f1-f6 from those with multipliers
    multipliers: int  # their number
    base_clamped: Mapping[str, Floats]  # relative change of f1-f6 by case if Phi_Bi = 0
    moments: Floats  # the printed platform's Jx, Jy, Jz over its mass [m^2]
    thickness: float  # h [m]


COST_STEPS = (1, 2, 3, 4, 8, 16, 32, 64)
"""Numbers of elements at which formulations are compared."""


@dataclass(frozen=True)
class Spent:
    """What a way takes for a pose.

    Attributes: `seconds` by round; `solves`, those of its eigen-solution, by call; `work` counted:
    operations of a formulation, coordinates of finite elements.
    """

    seconds: Floats
    solves: Floats
    work: float

    def over(self, other: "Spent") -> tuple[Floats, Floats, float]:
        """Return ratios to another: of seconds and of solves, call by call, and of work."""
        parts = []
        for own, its in ((self.seconds, other.seconds), (self.solves, other.solves)):
            calls = min(len(own), len(its))
            parts.append(own[-calls:] / its[-calls:])
        return parts[0], parts[1], self.work / other.work


@dataclass(frozen=True)
class Maps:
    """The regular workspace and f1-f3 of the paper's model in it."""

    ripple: Floats  # (3,): largest (max - min) / mean round a circle
    turned: float  # largest relative change under a turn from limb to limb
    period: float  # that turn [deg]
    steps: int  # steps from layer to layer
    rising: int  # those that do not fall
    z: Floats  # (n,) [m]
    level: Floats  # f1 of the level platform, (n,) [Hz]
    limit: float  # of the joints [deg]
    volumes: Mapping[float, tuple[float, float]]  # by limit: of cone, of all circles [rad^2 m]


_NONE: Any = None


@dataclass(frozen=True)
class Facts:
    """All of it; a group that was not measured is None, and no check that reads it is asked.

    `times` by formulation and elements; `fea_times` of a pose, the paper's model first, the
    stand-in for ANSYS next; solids take so much longer that they are timed once.
    """

    printed: Printed = field(default_factory=Printed)
    beams: Beams = _NONE
    fea: Reference = _NONE
    solid: Reference = _NONE
    slender: Slender = _NONE
    equations: Equations = _NONE
    times: Mapping[str, Mapping[int, Spent]] = _NONE
    fea_times: Mapping[str, Spent] = _NONE
    maps: Maps = _NONE
