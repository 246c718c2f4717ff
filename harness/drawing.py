"""A mechanism at a pose, at rest or moved by a mode, as every picture of it draws it."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analytic import STATIONS, Mechanism, Pose, limbs_at, position

Array = NDArray[np.float64]
AMPLITUDE = 0.2
"""Largest displacement drawn, relative to the mean limb length."""
TURN, HEIGHT = np.radians(-60), np.radians(18)
"""From where a mechanism is looked at: azimuth and elevation [rad]."""
LIGHT = np.array([0.35, -0.75, 0.56])
"""Where the light comes from, of unit length."""
RING = np.linspace(0, 2 * np.pi, 33)
"""Angles of the corners of a rod's and of the platform's rim [rad]."""
RINGS = np.linspace(0, 1, 9)
"""Radii of the platform's faces, relative to its own: small faces are well told apart by depth."""


@dataclass(frozen=True)
class Drawn:
    """The undeformed mechanism [m].

    Attributes: limbs from `bases` to `tips`, each (n, 3), with radii `rods` (n,); the platform's
    `centre` (3,), the two `axes` of its plane (2, 3), and its `radius`; mean `length` of the limbs.
    """

    bases: Array
    tips: Array
    rods: Array
    centre: Array
    axes: Array
    radius: float
    length: float

    def limbs(self, shift: Array | float = 0.0) -> Array:
        """Return the limbs' axes, (n, stations, 3), moved by `shift` of the same shape."""
        along = (self.tips - self.bases)[:, None]
        return np.asarray(self.bases[:, None] + STATIONS[:, None] * along + shift)

    def rim(self) -> Array:
        """Return the arms from the platform's centre to its rim, (33, 3)."""
        return self.radius * np.stack([np.cos(RING), np.sin(RING)], axis=1) @ self.axes

    def surfaces(self, platform: Array, limbs: Array) -> Iterator[Array]:
        """Yield the surface of each limb and of the platform last, as grids of points (k, 33, 3).

        `platform`: its displacement and rotation (6,); `limbs`: their displacements (n, stations,
        3), both as large as they are drawn.
        """
        for line, radius in zip(self.limbs(limbs), self.rods, strict=True):
            yield tube(line, radius)
        arms = self.rim()
        moved = arms + np.cross(platform[3:], arms)
        yield self.centre + platform[:3] + RINGS[:, None, None] * moved


def drawn(mechanism: Mechanism, pose: Pose) -> Drawn:
    """Return what is drawn of `mechanism` at `pose`."""
    limbs, bases = limbs_at(mechanism, pose), mechanism.bases
    return Drawn(
        bases,
        bases + limbs.lengths[:, None] * limbs.frames[:, :, 2],
        np.array([limb.rod.diameter / 2 for limb in mechanism.limbs]),
        np.asarray(position(mechanism, pose)),
        pose.rotation.T[:2],
        float(np.linalg.norm(mechanism.platform_points, axis=1).max()),
        float(limbs.lengths.mean()),
    )


def scale(there: Drawn, limbs: Array) -> Array:
    """Return the factors that make the largest displacement of `limbs` (..., n, stations, 3) as
    large as `AMPLITUDE` says."""
    largest = np.abs(limbs).max(axis=(-1, -2, -3), initial=0.0)
    return np.asarray(AMPLITUDE * there.length / np.maximum(largest, 1e-12))


def tube(line: Array, radius: float) -> Array:
    """Return the surface of a rod of `radius` round `line` (k, 3), closed by its two end faces, as
    points (k + 2, 33, 3)."""
    along = line[-1] - line[0]
    side = np.cross(along, np.eye(3)[np.abs(along).argmin()])
    side /= np.linalg.norm(side)
    up = np.cross(along, side) / np.linalg.norm(along)
    ring = np.cos(RING)[:, None] * side + np.sin(RING)[:, None] * up
    return np.concatenate(
        [line[0] + 0 * ring[None], line[:, None] + radius * ring, line[-1] + 0 * ring[None]]
    )


def seen(points: Array) -> tuple[Array, Array]:
    """Return `points` (..., 3) from the front: right and up (..., 2), and how near (...)."""
    front = np.array([np.cos(TURN), np.sin(TURN), 0.0])
    right = np.array([-front[1], front[0], 0.0])
    towards = np.cos(HEIGHT) * front + np.sin(HEIGHT) * np.eye(3)[2]
    return points @ np.stack([right, np.cross(towards, right)], axis=1), points @ towards


def faces(surface: Array) -> tuple[Array, Array, Array]:
    """Return the faces of a grid of points (k, m, 3): corners as seen (f, 4, 2), how near (f,), and
    how light, 0 to 1 (f,)."""
    a, b, c, d = surface[:-1, :-1], surface[:-1, 1:], surface[1:, 1:], surface[1:, :-1]
    corners = np.stack([a, b, c, d], axis=2).reshape(-1, 4, 3)
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    flat, _ = seen(corners)
    _, facing = seen(normal)
    normal *= np.where(facing < 0, -1, 1)[:, None]
    _, near = seen(corners.mean(axis=1))
    return flat, near, np.clip(normal @ LIGHT, 0, 1)
