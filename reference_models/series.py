"""What gives way at one point, in series: compliances add up, and what is free stays free."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from analytic.mechanism import Joint
from reference_models.chain_placement import Standing

Array = NDArray[np.float64]

NONE = 1e-14
"""Compliance below this part of the largest at the same point is rounding: rigid."""


@dataclass(frozen=True)
class Series:
    """What gives way in one way, to move or to turn, at a point: all of it in series.

    Attributes, in the limb's axes: `free` directions (f, 3); compliance `before`, `own` and
    `after` (3, 3): of the rod that ends there, of the joint, and of the rod that starts.
    """

    free: Array = field(default_factory=lambda: np.zeros((0, 3)))
    before: Array = field(default_factory=lambda: np.zeros((3, 3)))
    own: Array = field(default_factory=lambda: np.zeros((3, 3)))
    after: Array = field(default_factory=lambda: np.zeros((3, 3)))

    def apart(self) -> tuple[Array, Array, Array]:
        """Return free directions (3, f), principal ones that give way (3, g), their compliance."""
        _, size, axes = np.linalg.svd(self.free)
        rank = int((size > 1e-9).sum())
        free, held = axes[:rank].T, axes[rank:].T
        c, principal = np.linalg.eigh(held.T @ (self.before + self.own + self.after) @ held)
        gives = c > NONE * c.max(initial=0.0)
        return free, held @ principal[:, gives], c[gives]

    def shares(self) -> tuple[Array, Array]:
        """Return what part of a relative motion is `before`'s, and what part `after`'s, (3, 3)."""
        _, axes, c = self.apart()
        stiffness = (axes / c) @ axes.T
        return self.before @ stiffness, self.after @ stiffness

    @property
    def all_free(self) -> bool:
        """Whether nothing resists in any direction."""
        return bool(self.apart()[0].shape[1] == 3)

    def joined(self, joint: Joint, kind: str, limb: Standing, R: Array) -> "Series":
        """Return this with a joint's freedoms of a `kind`; R is the platform's rotation."""
        free, own = self.free, self.own
        for freedom in joint.freedoms:
            if freedom.kind != kind or freedom.stiffness == np.inf:
                continue
            axis = limb.frame.T @ limb.axis(freedom, R)
            if freedom.stiffness:
                own = own + np.outer(axis, axis) / freedom.stiffness
            else:
                free = np.vstack([free, axis])
        return Series(free, self.before, own, self.after)
