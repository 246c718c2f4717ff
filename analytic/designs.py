"""Natural frequencies of many mechanisms a call: what `condensed_frequencies` is to poses.

Frequencies of limbs of one material and diameter scale as sqrt(E / rho) / d when every length
scales with d, masses with rho d^3 and moments of inertia with rho d^5. So every design is brought
to rods of 1 m, 1 Pa and 1 kg/m^3: all share one rod, and its tables.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from analytic.condensed import CHUNK, condensed_frequencies, lowest
from analytic.description import PRINTED, disc, numbers, with_numbers
from analytic.errors import InputError, NotCertifiedError, count, number
from analytic.kinematics import limbs_of
from analytic.mechanism import Material, Mechanism, Platform, Rod
from analytic.pose import CLOSURE, Pose, closure, leaned
from analytic.reduced import constants
from analytic.theory import Theory

Floats = NDArray[np.float64]

SPAN = 2**1.5
"""Longest over shortest limb that one table serves; each octave of lengths has a table."""

LEVELS = 2
"""Tables tried before bisection: few designs need more, and tables cost more than they do."""


@dataclass(frozen=True)
class Designs:
    """N mechanisms of three equal limbs 120 degrees apart, each at a pose; arrays of shape (N,).

    Attributes: `z` [m], `azimuth`, `tilt` [rad] as in `Pose`; `base_radius`, `platform_radius` of
    the points B_i and A_i, `diameter` of the rods [m]; `young` [Pa] and `density` [kg/m^3] of the
    rods; the platform's `mass` [kg] and moments of inertia `across` (x and y) and `polar` (z)
    [kg m^2]. Scalars stand for N equal values. `mirrored` is no mechanism but a slip that a table
    may betray: limbs of the right length, whose frames lean from the vertical to the wrong side;
    only a tilted platform shows it.
    Raises `InputError` for shapes that do not match, numbers that are not finite, or anything but
    angles not above zero.
    """

    z: Floats
    azimuth: Floats
    tilt: Floats
    base_radius: Floats
    platform_radius: Floats
    diameter: Floats
    young: Floats
    density: Floats
    mass: Floats
    across: Floats
    polar: Floats
    mirrored: bool = False

    def __post_init__(self) -> None:
        names = [field.name for field in fields(self) if field.name != "mirrored"]
        given = [np.asarray(getattr(self, name), dtype=float) for name in names]
        try:
            shaped = np.broadcast_arrays(*given, np.empty(1))
        except ValueError:
            raise InputError("Designs", [x.shape for x in given], "matching shapes") from None
        for name, value in zip(names, shaped[:-1], strict=True):
            bad = ~np.isfinite(value)
            if name not in ("azimuth", "tilt"):
                bad |= value <= 0
            if value.ndim != 1 or bad.any():
                wrong = value if value.ndim != 1 else value[bad][0]
                raise InputError(f"Designs.{name}", wrong, "finite numbers above zero, shape (N,)")
            object.__setattr__(self, name, value)

    def __len__(self) -> int:
        return len(self.z)

    @classmethod
    def of(cls, numbers: Mapping[str, Any], form: str = "disc", *, mirrored: bool = False) -> Self:
        """Return designs from the `description.numbers` of regular mechanisms, or arrays of them.

        `form`: what is made of their discs, as `description.disc` has it.
        """
        names = ("z", "azimuth", "tilt", "base_radius", "platform_radius", "rod_diameter",
                 "young", "density")  # fmt: skip
        values = [numbers[name] for name in names]
        return cls(*[*values, *disc(numbers, form), mirrored])

    @property
    def groups(self) -> dict[str, Floats]:
        """What their frequencies are seen to depend on most, by name, (N,).

        L is the length of a limb without tilt, m and Jz the platform's mass and polar moment.
        """
        r1, r2, d = self.base_radius, self.platform_radius, self.diameter
        L = np.hypot(self.z, r1 - r2)
        return {
            "d / L^2 [1/m]": d / L**2,
            "L [m]": L,
            "d / L": d / L,
            "r1 / L": r1 / L,
            "r2 / L": r2 / L,
            "(r2 - r1) / L": (r2 - r1) / L,
            "Jz / (m r2^2)": self.polar / (self.mass * r2**2),
            "m / (three limbs)": self.mass / (3 * self.density * np.pi / 4 * d**2 * L),
            "r2 sin(theta) / L": r2 * np.abs(np.sin(self.tilt)) / L,
        }


def varied_frequencies(
    mechanism: Mechanism,
    pose: Pose,
    changes: Mapping[str, Any],
    elements: int | None = None,
    *,
    beam: str = "euler-bernoulli",
    shear: str | float = "cowper",
    modes: int = 6,
    form: str = "disc",
    mirrored: bool = False,
) -> Floats:
    """Return the `modes` lowest frequencies [Hz] of mechanisms that differ in some numbers, (N, m).

    `changes`: values (N,) of some of the `description.numbers` of `mechanism` at `pose`, SI. Those
    of `regular` mechanisms are solved in one call, with discs of `form` and frames `mirrored` as in
    `Designs`; others one by one. NaN where there can be no such mechanism. `elements`, `beam`,
    `shear` as in `condensed_frequencies`.
    """
    if regular(mechanism) and pose.x is None:
        given = {name: number.value for name, number in numbers(mechanism, pose).items()}
        designs = Designs.of(given | dict(changes), form, mirrored=mirrored)
        poisson = mechanism.limbs[0].rod.material.poisson
        return design_frequencies(
            designs, elements, beam=beam, shear=shear, poisson=poisson,
            heading=heading(mechanism), modes=modes,
        )  # fmt: skip
    rows = np.stack(np.broadcast_arrays(np.zeros(1), *changes.values()), axis=-1)[:, 1:]
    found = np.full((len(rows), modes), np.nan)
    for row, values in enumerate(rows.tolist()):
        try:
            there = with_numbers(mechanism, pose, dict(zip(changes, values, strict=True)))
            found[row] = condensed_frequencies(
                *there, elements, beam=beam, shear=shear, count=modes
            )
        except (InputError, NotCertifiedError, np.linalg.LinAlgError, ArithmeticError):
            continue
    return found


def regular(mechanism: Mechanism) -> bool:
    """Whether a mechanism is one of `Designs`, its platform a disc, or what Eq. 8 makes of one."""
    if not mechanism.simple or mechanism.platform.form not in ("disc", PRINTED):
        return False
    r1, r2 = (float(np.hypot(*p[0, :2])) for p in (mechanism.bases, mechanism.platform_points))
    rod, first = mechanism.limbs[0].rod, heading(mechanism)
    if len(mechanism.limbs) != 3 or not r1 or not r2:
        return False
    same = Mechanism.regular(r1, r2, rod, mechanism.platform, heading=first)
    return all(limb.rod == rod for limb in mechanism.limbs) and all(
        np.allclose(getattr(same, name), getattr(mechanism, name), atol=1e-9)
        for name in ("bases", "axes", "platform_points")
    )


def heading(mechanism: Mechanism) -> float:
    """Return the angle of the first limb's base about z [rad]."""
    x, y, _ = mechanism.limbs[0].base
    return float(np.arctan2(y, x))


def design_frequencies(
    designs: Designs,
    elements: int | None = None,
    *,
    beam: str = "euler-bernoulli",
    shear: str | float = "cowper",
    poisson: float = 0.3,
    heading: float = 0.0,
    modes: int = 6,
) -> Floats:
    """Return the `modes` lowest frequencies [Hz] of every design, shape (N, modes).

    `elements`, `beam`, `shear` as in `condensed_frequencies`, and as exact. `poisson` is E / 2G - 1
    of all rods, which shear and torsion need; `heading` the angle of the first limb [rad].
    """
    number("poisson", poisson, "a finite number")
    count("modes", modes)
    steel = Material(1.0, 1 / (2 * (1 + poisson)), 1.0)
    unit = Mechanism.regular(
        1.0, 1.0, Rod.round(steel, 1.0), Platform.diagonal(1.0, (1.0, 1.0, 1.0)), heading=heading
    )
    known = constants(unit, Theory(beam, shear))
    lengths, vectors = _geometry(designs, unit)
    result = np.empty((len(designs), modes))
    for rows, span in _alike(lengths):
        result[rows] = lowest(
            known, lengths[rows], vectors[rows], elements, modes, span=span, levels=2
        )
    speed = np.sqrt(designs.young / designs.density) / designs.diameter
    return np.asarray(np.sqrt(np.maximum(result, 0)) * (speed / (2 * np.pi))[:, None])


def _geometry(designs: Designs, unit: Mechanism) -> tuple[Floats, Floats]:
    """Return lengths (N, 3) and vectors a_k (N, 9, 6) as `reduced.geometry`, in diameters.

    `unit` is the mechanism whose radii are 1.
    """
    d, out = designs.diameter, unit.platform_points
    r1, r2 = (
        (radius / d)[:, None, None] * out
        for radius in (designs.base_radius, designs.platform_radius)
    )
    R = leaned(designs.azimuth, designs.tilt)
    held = closure(unit, r1, r2, designs.z / d, R)
    limbs = limbs_of(unit.axes, held)
    if limbs.lengths.min(initial=1.0) <= CLOSURE or (np.abs(held.off_plane) > 1e-6).any():
        raise InputError("designs", "a limb", "limbs of some length, in their joints' planes")
    if designs.mirrored:
        y, z = limbs.frames[..., 1], limbs.frames[..., 2]
        z = z - 2 * (z * out).sum(axis=-1, keepdims=True) * out
        limbs = replace(limbs, frames=np.stack([np.cross(y, z), y, z], axis=-1))
    weight = designs.density * d**3
    moments = np.stack([designs.across, designs.across, designs.polar], axis=-1)
    vectors = limbs.directions
    vectors[..., :3] /= np.sqrt(designs.mass / weight)[:, None, None, None]
    vectors[..., 3:] /= np.sqrt(moments / (weight * d**2)[:, None])[:, None, None, :]
    return limbs.lengths, vectors.reshape(len(d), 9, 6)


def _alike(lengths: Floats) -> list[tuple[NDArray[np.intp], Floats]]:
    """Return rows in groups of at most CHUNK, and the span of lengths that holds each group.

    The spans are always the same few, so that their tables are made once.
    """
    shortest, longest = lengths.min(axis=1), lengths.max(axis=1)
    octave = np.floor(np.log2(shortest))
    groups = []
    for start in np.unique(octave):
        own = np.flatnonzero(octave == start)
        for first in range(0, len(own), CHUNK):
            rows = own[first : first + CHUNK]
            low = 2.0**start
            high = max(low * SPAN, 2 ** np.ceil(np.log2(longest[rows].max())))
            groups.append((rows, np.array([low, high]) * [1 + 1e-6, 1 - 1e-6]))
    return groups
