"""The limbs at a pose: lengths, frames and passive joint angles, Eq. (3)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analytic.mechanism import Mechanism
from analytic.pose import Pose, position


@dataclass(frozen=True)
class Limbs:
    """All limbs of a mechanism at one pose or many; `...` below is the shape of the pose.

    Attributes:
        lengths: L_i = |B_i A_i|, shape (..., n) [m].
        frames: R_i from limb to global axes, shape (..., n, 3, 3); y_i is the revolute axis and
            z_i points from B_i to A_i.
        arms: o to A_i in the global frame, shape (..., n, 3) [m].
        revolute: angle of B_i A_i from the global z, about the revolute axis, (..., n) [rad].
        spherical: angle between B_i A_i and the platform's normal, shape (..., n) [rad].
    """

    lengths: NDArray[np.float64]
    frames: NDArray[np.float64]
    arms: NDArray[np.float64]
    revolute: NDArray[np.float64]
    spherical: NDArray[np.float64]


def limbs_at(mechanism: Mechanism, pose: Pose) -> Limbs:
    """Return the limbs at `pose`, by Eq. (3): B_i A_i = O o + R o A_i - O B_i.

    Raises `InputError` where a joint cannot close (see `position`).
    """
    o = position(mechanism, pose)
    rotation = pose.rotation
    arms = np.einsum("...jk,ik->...ij", rotation, mechanism.platform_points)
    vectors = o[..., None, :] + arms - mechanism.bases
    lengths = np.linalg.norm(vectors, axis=-1)
    z = vectors / lengths[..., None]
    y = np.broadcast_to(mechanism.axes, z.shape)
    x = np.cross(y, z)
    # y and z are perpendicular to rounding only; x restores an exact frame from the other two.
    x /= np.linalg.norm(x, axis=-1, keepdims=True)
    frames = np.stack([x, np.cross(z, x), z], axis=-1)
    up = np.array([0.0, 0.0, 1.0])
    revolute = np.arctan2(_dot(np.cross(up, z), y), z[..., 2])
    normal = rotation[..., None, :, 2]
    spherical = np.arctan2(np.linalg.norm(np.cross(normal, z), axis=-1), _dot(normal, z))
    return Limbs(lengths, frames, arms, revolute, spherical)


def _dot(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.einsum("...i,...i->...", a, b))
