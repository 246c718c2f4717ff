"""The limbs at a pose: lengths, frames, joint angles and the directions they act in, Eq. (3)."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.mechanism import Mechanism
from analytic.placed import place
from analytic.placed import position as chain_position
from analytic.pose import CLOSURE, Closure, Pose, check_poses, closed, dot

Array = NDArray[Any]
"""Real, or complex where a derivative is taken by complex step."""


@dataclass(frozen=True)
class Limbs:
    """All limbs of a mechanism at one pose or many; `...` below is the shape of the pose.

    Attributes:
        rotation: R of Eq. (1), from moving to global frame, shape (..., 3, 3).
        centre: o in the global frame, shape (..., 3) [m].
        arms: o to A_i in the global frame, shape (..., n, 3) [m].
        lengths: L_i = |B_i A_i|, shape (..., n) [m].
        frames: R_i from limb to global axes, shape (..., n, 3, 3); y_i is the revolute axis and
            z_i points from B_i to A_i.
    """

    rotation: Array
    centre: Array
    arms: Array
    lengths: Array
    frames: Array

    @property
    def revolute(self) -> Array:
        """The angle of B_i A_i from the global z, about the revolute axis, (..., n) [rad]."""
        y, z = self.frames[..., 1], self.frames[..., 2]
        across = y[..., 1] * z[..., 0] - y[..., 0] * z[..., 1]
        return np.asarray(np.arctan2(across, z[..., 2]))

    @property
    def spherical(self) -> Array:
        """The angle between B_i A_i and the platform's normal, shape (..., n) [rad]."""
        z, normal = self.frames[..., 2], self.rotation[..., None, :, 2]
        across = np.linalg.norm(_cross(normal, z), axis=-1)
        return np.asarray(np.arctan2(across, (normal * z).sum(axis=-1)))

    @property
    def directions(self) -> Array:
        """How x_i, y_i and z_i of every limb move the platform, shape (..., n, 3, 6).

        Row k of limb i is a_k = [c, p_i x c]: in the moving frame, c is the axis and p_i = o A_i.
        A platform displacement U moves A_i by a_k . U along it; a force f along it is f a_k at o.
        """
        R = self.rotation[..., None, :, :]
        c = self.frames.swapaxes(-1, -2) @ R
        points = (self.arms[..., None, :] @ R)[..., 0, :]
        return np.concatenate([c, _cross(points[..., None, :], c)], axis=-1)


def limbs_at(mechanism: Mechanism, pose: Pose) -> Limbs:
    """Return the limbs at `pose`, by Eq. (3): B_i A_i = O o + R o A_i - O B_i.

    Of other chains, lengths and z axes are from where a limb starts, on its slider, to A_i.
    Raises `InputError` where a joint cannot close (see `position`).
    """
    check_poses(mechanism, pose)
    if not mechanism.simple:
        return _of_chains(mechanism, pose)
    alone = None if pose.shape else _of_one(mechanism, pose)
    return alone or limbs_of(mechanism.axes, closed(mechanism, pose))


def limbs_of(axes: Array, closure: Closure) -> Limbs:
    """Return the limbs of joints closed by `closure` about revolute `axes` (..., n, 3).

    Real or complex, so that derivatives can be taken by complex step.
    """
    vectors = closure.vectors
    lengths = np.sqrt(dot(vectors, vectors))
    z = vectors / lengths[..., None]
    x = _cross(axes, z)
    # y and z are perpendicular to rounding only; x restores an exact frame from the other two.
    x /= np.sqrt(dot(x, x))[..., None]
    frames = np.empty((*x.shape, 3), dtype=x.dtype)
    frames[..., 0], frames[..., 1], frames[..., 2] = x, _cross(z, x), z
    return Limbs(closure.rotation, closure.centre, closure.arms, lengths, frames)


def _of_one(mechanism: Mechanism, pose: Pose) -> Limbs | None:
    """Return what `limbs_of` does for a single pose, None where `closed` refuses it.

    Number by number: a step of numpy on so few costs as much as a limb does here.
    """
    rotation, placements, z = pose.rotation, mechanism.placements, pose.z
    (r00, r01, r02), (r10, r11, r12), (r20, r21, r22) = rotation.tolist()
    arms = [
        (r00 * p + r01 * q + r02 * r, r10 * p + r11 * q + r12 * r, r20 * p + r21 * q + r22 * r)
        for _, _, (p, q, r) in placements
    ]
    x, y = pose.x, pose.y
    if x is None:
        x = y = 0.0
        for (b, e, _), a, (u, v) in zip(placements, arms, mechanism.across.T.tolist(), strict=True):
            gap = (a[0] - b[0]) * e[0] + (a[1] - b[1]) * e[1] + (a[2] - b[2] + z) * e[2]
            x, y = x - u * gap, y - v * gap
    lengths, frames = [], []
    for ((b0, b1, b2), (e0, e1, e2), _), (a0, a1, a2), longest in zip(
        placements, arms, mechanism.longest.tolist(), strict=True
    ):
        v0, v1, v2 = x + a0 - b0, y + a1 - b1, z + a2 - b2
        length = math.sqrt(v0 * v0 + v1 * v1 + v2 * v2)
        if abs(v0 * e0 + v1 * e1 + v2 * e2) > CLOSURE or not CLOSURE < length <= longest:
            return None
        z0, z1, z2 = v0 / length, v1 / length, v2 / length
        x0, x1, x2 = e1 * z2 - e2 * z1, e2 * z0 - e0 * z2, e0 * z1 - e1 * z0
        # y and z are perpendicular to rounding only; x restores an exact frame from the other two.
        across = math.sqrt(x0 * x0 + x1 * x1 + x2 * x2)
        x0, x1, x2 = x0 / across, x1 / across, x2 / across
        y0, y1, y2 = z1 * x2 - z2 * x1, z2 * x0 - z0 * x2, z0 * x1 - z1 * x0
        lengths.append(length)
        frames.append(((x0, y0, z0), (x1, y1, z1), (x2, y2, z2)))
    return Limbs(rotation, *map(np.array, ((x, y, z), arms, lengths, frames)))


def _of_chains(mechanism: Mechanism, pose: Pose) -> Limbs:
    groups, n = place(mechanism, pose), len(mechanism.limbs)
    arms, lengths = np.empty((*pose.shape, n, 3)), np.empty((*pose.shape, n))
    frames = np.empty((*pose.shape, n, 3, 3))
    for group in groups:
        which = group.alike.limbs
        arms[..., which, :], frames[..., which, :, :] = group.arms, group.frames
        lengths[..., which] = group.lengths.sum(axis=-1)
    return Limbs(pose.rotation, chain_position(mechanism, pose), arms, lengths, frames)


_NEXT, _AFTER = np.array([1, 2, 0]), np.array([2, 0, 1])


def _cross(a: Array, b: Array) -> Array:
    first = a.take(_NEXT, axis=-1) * b.take(_AFTER, axis=-1)
    return np.asarray(first - a.take(_AFTER, axis=-1) * b.take(_NEXT, axis=-1))
