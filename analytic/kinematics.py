"""The limbs at a pose: lengths, frames, joint angles and the directions they act in, Eq. (3)."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.mechanism import Mechanism
from analytic.placed import place
from analytic.placed import position as chain_position
from analytic.pose import Closure, Pose, closed, dot

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
    if isinstance(mechanism, Mechanism) and isinstance(pose, Pose) and not mechanism.simple:
        return _of_chains(mechanism, pose)
    return limbs_of(mechanism.axes, closed(mechanism, pose))


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
