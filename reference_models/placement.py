"""Where the platform and the limbs are: the simulators' own geometry, shared with no other model.

The analytic model has Eqs. (1)-(3) of its own: a slip in either of the two shows as a disagreement.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analytic.errors import InputError, RefusedError
from analytic.mechanism import Mechanism
from analytic.pose import Pose

Array = NDArray[np.float64]
GAP = 1e-9
"""Largest distance of A_i from its revolute joint's plane, relative to the mechanism's size."""


@dataclass(frozen=True)
class Placement:
    """The mechanism at poses of shape (...), of n limbs; all in global axes.

    Attributes: `centre` o (..., 3) [m]; `rotation` of the platform (..., 3, 3); `arms` from o to
    A_i (..., n, 3); `tips` A_i (..., n, 3); `along`, unit vectors from B_i to A_i, and `about`, the
    revolute axes as given but for rounding, square to them, (..., n, 3); `lengths` (..., n) [m].
    """

    centre: Array
    rotation: Array
    arms: Array
    tips: Array
    along: Array
    about: Array
    lengths: Array

    @property
    def frames(self) -> Array:
        """Limb frames (..., n, 3, 3): columns x, y (the revolute axis) and z (along the limb)."""
        return np.stack([np.cross(self.about, self.along), self.about, self.along], axis=-1)


def place(mechanism: Mechanism, pose: Pose) -> Placement:
    """Return where everything is at one pose or many.

    The platform is turned by `tilt` about the axis in the base plane at right angles to `azimuth`:
    three elementary rotations. Its x and y follow from the joints: every A_i stays in the plane
    through B_i square to the revolute axis as given, by least squares. Raises `InputError` naming
    the limb and the gap where one does not, or where A_i meets B_i, and the limb that is no ideal
    R-P-S limb of one solid round rod.
    """
    for number, limb in enumerate(mechanism.limbs, start=1):
        if not limb.simple:
            found = f"limb {number}, {limb.described}"
            expected = "limbs of one solid round rod between an R and an S joint for this model"
            raise RefusedError("mechanism", found, expected)
    if any(mechanism.platform.centre):
        off = mechanism.platform.centre
        raise RefusedError("Platform.centre", off, "o itself for this model")
    if pose.x is not None or np.any(pose.torsion):
        raise RefusedError("pose", pose, "z, azimuth and tilt alone for this model")
    turn = _about_z(pose.azimuth)
    rotation = turn @ _about_y(pose.tilt) @ turn.swapaxes(-1, -2)
    bases = np.array([limb.base for limb in mechanism.limbs])
    axes = np.array([limb.axis for limb in mechanism.limbs])
    points = np.array([limb.platform_point for limb in mechanism.limbs])
    arms = (rotation @ points.T).swapaxes(-1, -2)
    z = np.asarray(pose.z, dtype=float)[..., None]
    # e_x x + e_y y = e . (B - arm) - e_z z for every limb
    wanted = ((bases - arms) * axes).sum(axis=-1) - axes[:, 2] * z
    flat = wanted.reshape(-1, len(axes))
    across = np.linalg.lstsq(axes[:, :2], flat.T, rcond=1e-9)[0].T.reshape(*z.shape[:-1], 2)
    centre = np.concatenate([across, z], axis=-1)
    tips = centre[..., None, :] + arms
    spans = tips - bases
    lengths = np.linalg.norm(spans, axis=-1)
    gaps = np.abs((spans * axes).sum(axis=-1))
    size = np.linalg.norm(bases, axis=-1) + np.linalg.norm(points, axis=-1) + np.abs(z)
    plane = "A_{} in its revolute joint's plane, not {:.1e} m beside it"
    _refuse(pose, ~(gaps <= GAP * size), gaps, plane)
    _refuse(
        pose, ~(lengths > GAP * size), lengths, "limbs of some length, not that of A_{} of {:.1e} m"
    )
    along = spans / lengths[..., None]
    about = axes - along * (along * axes).sum(axis=-1, keepdims=True)
    about /= np.linalg.norm(about, axis=-1, keepdims=True)
    return Placement(centre, rotation, arms, tips, along, about, lengths)


def largest_gap(mechanism: Mechanism, tips: Array) -> float:
    """Return how far any of `tips` A_i (n, 3) is beside its joint, |e_i . (A_i - B_i)| [m].

    With the revolute axes e_i as given: a simulator's, turned with its limb, would hide the gap.
    """
    return float(np.abs(((tips - mechanism.bases) * mechanism.axes).sum(axis=-1)).max())


def _refuse(pose: Pose, bad: NDArray[np.bool_], amount: Array, expected: str) -> None:
    """Raise `InputError` for the first pose and limb that is `bad`."""
    if bad.any():
        *where, limb = np.argwhere(bad)[0].tolist()
        one = pose[tuple(where)] if where else pose
        raise InputError("pose", one, expected.format(limb + 1, float(amount[(*where, limb)])))


def _about_z(angle: object) -> Array:
    c, s = np.cos(angle), np.sin(angle)  # type: ignore[call-overload]
    o, i = np.zeros_like(c), np.ones_like(c)
    return _matrix([[c, -s, o], [s, c, o], [o, o, i]])


def _about_y(angle: object) -> Array:
    c, s = np.cos(angle), np.sin(angle)  # type: ignore[call-overload]
    o, i = np.zeros_like(c), np.ones_like(c)
    return _matrix([[c, o, s], [o, i, o], [-s, o, c]])


def _matrix(rows: list[list[Array]]) -> Array:
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
