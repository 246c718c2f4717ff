"""What the verdicts on the paper's claims rest on: figures alone, in SI units unless named so."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.presets import PAPER_MODEL
from reference_models import Named

Floats = NDArray[np.float64]
CASES = ("case1", "case2")
"""The two of Table I."""
PHI, THETA = np.radians([10.0, -12.0])
"""The angles of Case 2 [rad]."""
PAPER = PAPER_MODEL
EXACT, RAYLEIGH, TIMOSHENKO = (
    Named(name, None) for name in ("euler-bernoulli", "rayleigh", "timoshenko")
)
EFFECTS: dict[str, tuple[Named | None, Named | None]] = {
    "number of elements": (None, EXACT),
    "rotary inertia": (EXACT, RAYLEIGH),
    "shear": (RAYLEIGH, TIMOSHENKO),
    "Timoshenko to reference": (TIMOSHENKO, None),
}
"""Parts of an error: from one model to the next, from the theory (None) to the reference (None)."""


@dataclass(frozen=True)
class Printed:
    """The paper's own numbers: Table I, the errors quoted with Fig. 3, times and blocks' widths.

    `blocks` by equation: columns, and each row's widths, as (a, b) for a s + b.
    """

    table: Mapping[tuple[str, str], tuple[float, ...]]
    figure3: Mapping[tuple[str, int, int], float]
    cost: Mapping[str, float]
    columns: Mapping[str, tuple[int, int]]
    blocks: Mapping[str, Mapping[str, tuple[tuple[int, int], ...]]]


@dataclass(frozen=True)
class Beams:
    """The beam theories' f1-f6 [Hz] by (case, model), in the order of the paper's modes.

    `elements` s that were solved. `readings`: case name to (case of Table I, its f1-f6).
    `scan_z` (n,) and `scan` by case (n, 6): the paper's model over height at the case's angles.
    `heights`: case name to z. `lengths`: case name to shortest and longest limb.
    """

    elements: tuple[int, ...]
    hertz: Mapping[tuple[str, Named], Floats]
    readings: Mapping[str, tuple[str, Floats]]
    scan_z: Floats
    scan: Mapping[str, Floats]
    heights: Mapping[str, float]
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

    `first`: largest relative difference of f1 over both cases, (n,) [%]; `frequencies`: that of
    f1-f6; `stiffness`: that of the platform's static stiffness.
    """

    ratios: Floats
    first: Floats
    frequencies: Floats
    stiffness: Floats


@dataclass(frozen=True)
class Equations:
    """Residuals of Eqs. (1)-(22) as printed.

    Attributes:
        rotation: largest of |R^T R - 1| and |det R - 1|, Eq. (1).
        phi_alone: how far R turns for `PHI` alone [rad]; theta_axis: angle of its axis from x for
            `THETA` alone [rad].
        beside_plane: largest distance of an A_i from its revolute joint's plane, Eq. (2) [m].
        lengths_apart: largest difference of L_i, Eq. (3), from the model's [m].
        compatibility: largest error of Eq. (10) for small rotations, relative to the arm.
        freedoms: of the platform with its actuators free.
        sizes: by s, coordinates of a rod, all coordinates, rank of the joints' constraints, and
            the size of K of Eq. (22).
        headings: turns of the base (n,) [rad]; eq17, eq18: the smallest |denominator| of each over
            limbs and poses (n,).
        axis_rise, axis_motion: largest vertical component of a revolute axis, and its largest
            change from pose to pose.
        joints_open: largest |C u| of a mode for unit largest motion; multipliers_apart: largest
            relative difference of f1-f6 from the model with multipliers.
        multipliers: their number.
        base_clamped: relative change of f1-f6 by case if Phi_Bi = 0.
        moments: the printed platform's Jx, Jy, Jz over its mass [m^2]; thickness h [m].
    """

    rotation: float
    phi_alone: float
    theta_axis: float
    beside_plane: float
    lengths_apart: float
    compatibility: float
    freedoms: int
    sizes: Mapping[int, tuple[int, int, int, int]]
    headings: Floats
    eq17: Floats
    eq18: Floats
    axis_rise: float
    axis_motion: float
    joints_open: float
    multipliers_apart: float
    multipliers: int
    base_clamped: Mapping[str, Floats]
    moments: Floats
    thickness: float


@dataclass(frozen=True)
class Times:
    """Seconds of one pose in each round (n,): the paper's way and both ways with multipliers."""

    own: Floats
    null_space: Floats
    saddle_point: Floats


@dataclass(frozen=True)
class FeaTimes:
    """Seconds of one pose in each round (n,): the paper's way, and finite elements by label.

    The stand-in for ANSYS comes first; solids take so much longer that they are timed once.
    """

    own: Floats
    fea: Mapping[str, Floats]


@dataclass(frozen=True)
class Maps:
    """The regular workspace and f1-f3 in it.

    `model`, by which they are; `ripple` (3,): largest (max - min) / mean round a circle; `turned`:
    largest relative change under a turn from limb to limb, by `period` [deg]; `steps`, `rising`:
    steps from layer to layer, and those that do not fall; `z` (n,) [m] and `level` (n,): f1
    of the level platform; `volumes`: joint limit [deg] to the volumes of cone and of all circles
    [rad^2 m]; `limit` [deg] of the maps.
    """

    model: str
    ripple: Floats
    turned: float
    period: float
    steps: int
    rising: int
    z: Floats
    level: Floats
    volumes: Mapping[float, tuple[float, float]]
    limit: float


_NONE: Any = None


@dataclass(frozen=True)
class Facts:
    """All of it; a group that was not measured is None, and no check that reads it is asked."""

    printed: Printed
    beams: Beams = _NONE
    fea: Reference = _NONE
    solid: Reference = _NONE
    slender: Slender = _NONE
    equations: Equations = _NONE
    times: Times = _NONE
    fea_times: FeaTimes = _NONE
    maps: Maps = _NONE


GROUPS = ("beams", "fea", "solid", "slender", "equations", "times", "fea_times", "maps")
"""The groups of `Facts` that have to be measured, in the order in which they are."""
