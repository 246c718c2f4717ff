"""The limbs at a pose: lengths, frames, joint angles and the directions they act in, Eq. (3)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from operator import mul
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.mechanism import Mechanism
from analytic.placed import place, placed_where
from analytic.placed import position as chain_position
from analytic.pose import CLOSURE, Closure, Pose, Triple, check_poses, closed, held, parts, tried

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
    lengths, each = _framed(parts(axes), parts(closure.vectors))
    frames = np.empty((*lengths.shape, 3, 3), dtype=lengths.dtype)
    for k, axis in enumerate(each):
        for row, component in enumerate(axis):
            frames[..., row, k] = component
    return Limbs(closure.rotation, closure.centre, closure.arms, lengths, frames)


def _framed(e: Triple, v: Triple) -> tuple[Any, tuple[Triple, Triple, Triple]]:
    """Return L_i and x_i, y_i, z_i of the limb along B_i A_i = `v`, revolute about `e`: Eq. (3).

    By components, each a number or an array.
    """
    length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) ** 0.5
    z = v[0] / length, v[1] / length, v[2] / length
    across = _crossed(e, z)
    # y and z are perpendicular to rounding only; x restores an exact frame from the other two.
    size = (across[0] * across[0] + across[1] * across[1] + across[2] * across[2]) ** 0.5
    x = across[0] / size, across[1] / size, across[2] / size
    return length, (x, _crossed(z, x), z)


def _crossed(a: Triple, b: Triple) -> Triple:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _of_one(mechanism: Mechanism, pose: Pose) -> Limbs | None:
    """Return the limbs at a single pose, None where `closed` refuses it.

    Of plain numbers: a step of numpy on so few costs as much as a limb does here.
    """

    def across(gaps: Sequence[float]) -> tuple[float, float]:
        if pose.x is not None:
            return pose.x, pose.y
        u, v = mechanism.across.tolist()
        return -sum(map(mul, u, gaps)), -sum(map(mul, v, gaps))

    places, rotation = mechanism.placements, pose.rotation
    centre, found = held(places, rotation.tolist(), pose.z, across)
    arms, lengths, frames = [], [], []
    for (arm, vector, off), (_, e, _), longest in zip(
        found, places, mechanism.longest.tolist(), strict=True
    ):
        if abs(off) > CLOSURE or not CLOSURE < math.hypot(*vector) <= longest:
            return None
        length, axes = _framed(e, vector)
        arms.append(arm)
        lengths.append(length)
        frames.append(axes)
    turned: Array = np.array(frames).swapaxes(-1, -2)
    return Limbs(rotation, np.array(centre), np.array(arms), np.array(lengths), turned)


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


def position(mechanism: Mechanism, pose: Pose) -> NDArray[np.float64]:
    """Return o in the global frame, shape (*pose.shape, 3) [m]: Eq. (2) for any mechanism.

    For limbs 120 degrees apart that is Eq. (2) as printed, x = r2 (cos theta - 1) cos(2 phi) / 2
    and y = r2 (1 - cos theta) sin(2 phi) / 2, about the first (see `closure`).
    Raises `InputError` where an A_i leaves its revolute joint's plane, or meets its B_i.
    """
    check_poses(mechanism, pose)
    if not mechanism.simple:
        return chain_position(mechanism, pose)
    return closed(mechanism, pose).centre


def closes(mechanism: Mechanism, pose: Pose) -> NDArray[np.bool_]:
    """Return where limbs can be placed: all joints close, shape pose.shape."""
    if isinstance(mechanism, Mechanism) and not mechanism.simple:
        return placed_where(mechanism, pose)[1]
    found = tried(mechanism, pose)
    lengths = np.linalg.norm(found.vectors, axis=-1)
    good = (np.abs(found.off_plane) <= CLOSURE) & (lengths > CLOSURE)
    return np.asarray(good.all(axis=-1))
