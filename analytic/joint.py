"""Joints as lists of freedoms: what a joint does not list is rigid."""

import math
from dataclasses import dataclass, field

from analytic.errors import InputError, number, vector
from analytic.rod import Vector

KINDS = ("rotation", "translation")
FRAMES = ("base", "limb", "platform")
SLIDERS = ("above", "below")


@dataclass(frozen=True)
class Freedom:
    """One freedom of a joint: a turn about, or a shift along, an axis through the joint.

    Attributes: `kind`, "rotation" or "translation"; `axis`, a direction (normalised here) in the
    axes of `frame`: "base" (global), "limb" (x, y, z; z along it, y nearest to the limb's
    reference) or "platform"; `stiffness` [N m/rad or N/m], 0 where nothing resists, `math.inf`
    where it is locked and rigid; `across`:
    the direction square to `axis` and to the limb, instead of `axis` itself, as the second axis of
    a universal joint is.
    """

    kind: str
    axis: Vector
    frame: str = "base"
    stiffness: float = 0.0
    across: bool = False

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise InputError("Freedom.kind", self.kind, f"one of {', '.join(KINDS)}")
        if self.frame not in FRAMES:
            raise InputError("Freedom.frame", self.frame, f"one of {', '.join(FRAMES)}")
        object.__setattr__(self, "axis", direction("Freedom.axis", self.axis))
        unit = "N m/rad" if self.kind == "rotation" else "N/m"
        expected = f"a number of {unit}, at least 0, or math.inf"
        if self.stiffness != math.inf and number("Freedom.stiffness", self.stiffness, expected) < 0:
            raise InputError("Freedom.stiffness", self.stiffness, expected)


@dataclass(frozen=True)
class Joint:
    """A joint of any `freedoms`; none of them: rigid.

    `slider`, "above" or "below": its first freedom, a translation in base axes, adapts to the pose
    and is locked there; of the two places where rods of given lengths reach, the one further along
    its axis ("above") or less far. `name` is what drawings and sentences call it. Where the
    workspace ends: the limb leaves `rest`, a direction in the base's axes or, of a joint beyond the
    last rod, in the platform's, by at most `largest` [rad]; None: by any angle.
    """

    freedoms: tuple[Freedom, ...]
    slider: str = ""
    name: str = field(default="joint", compare=False)
    largest: float | None = field(default=None, compare=False, repr=False)
    rest: Vector = field(default=(0.0, 0.0, 1.0), compare=False, repr=False)

    def __post_init__(self) -> None:
        if self.largest is not None:
            expected = "an angle above 0 and at most pi"
            angle = number("Joint.largest", self.largest, expected, positive=True)
            if angle > math.pi:
                raise InputError("Joint.largest", angle, expected)
        object.__setattr__(self, "rest", direction("Joint.rest", self.rest))
        object.__setattr__(self, "freedoms", tuple(self.freedoms))
        if not all(isinstance(freedom, Freedom) for freedom in self.freedoms):
            raise InputError("Joint.freedoms", self.freedoms, "Freedoms")
        if self.slider:
            if self.slider not in SLIDERS:
                raise InputError("Joint.slider", self.slider, f"one of {', '.join(SLIDERS)}")
            first = self.freedoms[0] if self.freedoms else None
            found = first and (first.kind, first.frame, first.across)
            if found != ("translation", "base", False):
                raise InputError("Joint.freedoms", first, "a translation in base axes to slide by")

    @classmethod
    def revolute(cls, axis: Vector, frame: str = "base", stiffness: float = 0.0) -> "Joint":
        """Return a joint that turns about `axis`."""
        return cls((Freedom("rotation", axis, frame, stiffness),), name="R")

    @classmethod
    def universal(cls, axis: Vector, frame: str = "base", stiffness: float = 0.0) -> "Joint":
        """Return a joint that turns about `axis` and about the direction across it and the limb."""
        both = (
            Freedom("rotation", axis, frame, stiffness),
            Freedom("rotation", axis, frame, stiffness, across=True),
        )
        return cls(both, name="U")

    @classmethod
    def spherical(cls, stiffness: float = 0.0) -> "Joint":
        """Return a joint that turns freely, or against the same `stiffness` about every axis."""
        axes: tuple[Vector, ...] = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
        return cls(tuple(Freedom("rotation", axis, "base", stiffness) for axis in axes), name="S")

    @classmethod
    def prismatic(
        cls,
        axis: Vector | None = None,
        stiffness: float = 0.0,
        *,
        slider: str = "",
        rest: tuple[Freedom, ...] = (),
    ) -> "Joint":
        """Return a slide along `axis` in base axes, by default along the limb.

        `stiffness` of its locked drive [N/m]; `rest`, what else of it gives way.
        """
        if axis is None:
            along = Freedom("translation", (0.0, 0.0, 1.0), "limb", stiffness)
        else:
            along = Freedom("translation", axis, "base", stiffness)
        return cls((along, *rest), slider, name="P")

    @property
    def hinge(self) -> Freedom | None:
        """The freedom of a joint that turns freely about one axis alone, not across, or None."""
        turns = [f for f in self.freedoms if f.kind == "rotation" and not f.stiffness]
        return turns[0] if len(turns) == 1 and not turns[0].across else None


def direction(name: str, axis: object) -> Vector:
    """Return `axis` as a unit vector, or raise `InputError`."""
    x, y, z = vector(name, axis, "a direction other than zero")
    length = math.hypot(x, y, z)
    if length == 0:
        raise InputError(name, axis, "a direction other than zero")
    return x / length, y / length, z / length
