"""The regular workspace: circles in the reachable region, and the truncated cone in them."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.errors import InputError, count
from analytic.mechanism import Mechanism
from analytic.pose import Pose
from analytic.workspace import Floats, Limits, inscribed

ROUNDING = 1e-12
"""Circles that differ by no more than this are equal [rad]."""


@dataclass(frozen=True)
class RegularWorkspace:
    """A body of revolution about tilt 0: tilt up to `radii` [rad] at heights `z` [m], any azimuth.

    Both have shape (n,), n >= 2, `z` ascending; in between the radius is linear in z. From
    `regular_workspace` these are the largest inscribed circles, layer by layer; from `cone`, the
    two ends of a truncated cone.
    """

    z: Floats
    radii: Floats

    def radius(self, z: Any) -> Floats:
        """Return the largest tilt at `z` [rad]; zero outside the layers."""
        return np.asarray(np.interp(z, self.z, self.radii, left=0.0, right=0.0))

    @property
    def volume(self) -> float:
        """The volume in (tilt cos azimuth, tilt sin azimuth, z) [rad^2 m]."""
        return float(_frusta(self.z, self.radii).sum())

    def contains(self, poses: Pose) -> NDArray[np.bool_]:
        """Return which poses lie inside or on the edge, shape poses.shape."""
        z, tilt = np.asarray(poses.z), np.abs(poses.tilt)
        within = (z >= self.z[0]) & (z <= self.z[-1])
        return np.asarray(within & (tilt <= self.radius(z)))

    def cone(self) -> "RegularWorkspace":
        """Return the largest truncated cone, by volume, whose end circles are two layers' circles.

        No layer between its ends is narrower than the cone, but for `ROUNDING`.
        """
        best, chosen = -1.0, (0, 1)
        for i in range(len(self.z) - 1):
            # The steepest ascent that still clears every layer so far.
            rise = self.z[i + 1 :] - self.z[i]
            slopes = (self.radii[i + 1 :] - self.radii[i]) / rise
            clear = (
                np.flatnonzero(slopes <= np.minimum.accumulate(slopes + ROUNDING / rise)) + i + 1
            )
            ends = np.stack([np.full(len(clear), i), clear], axis=1)
            volumes = _frusta(self.z[ends], self.radii[ends])[:, 0]
            if volumes.max() > best:
                best, chosen = volumes.max(), (i, int(clear[volumes.argmax()]))
        return RegularWorkspace(self.z[list(chosen)], self.radii[list(chosen)])

    def grid(self, azimuths: int, tilts: int) -> Pose:
        """Return poses (n, azimuths, tilts): every layer from tilt 0 to its radius, evenly."""
        around = 2 * np.pi * np.arange(count("azimuths", azimuths)) / azimuths
        outwards = self.radii[:, None] * np.linspace(0, 1, count("tilts", tilts, at_least=2))
        return Pose(self.z[:, None, None], around[:, None], outwards[:, None, :])

    def random(self, number: int, seed: int) -> Pose:
        """Return `number` poses, uniform in volume; the same for the same `seed`."""
        generator = np.random.default_rng(seed)
        part, along, out, turn = generator.random((4, count("number", number)))
        share = np.cumsum(_frusta(self.z, self.radii))
        k = np.minimum(np.searchsorted(share, part * share[-1], side="right"), len(share) - 1)
        start, end = self.radii[k], self.radii[k + 1]
        # Within a frustum the cube of the radius is uniform.
        radius = np.cbrt(start**3 + along * (end**3 - start**3))
        rise = end - start
        t = np.where(rise == 0, along, (radius - start) / np.where(rise == 0, 1.0, rise))
        z = self.z[k] + t.clip(0, 1) * (self.z[k + 1] - self.z[k])
        return Pose(z, 2 * np.pi * turn, self.radius(z) * np.sqrt(out))


def _frusta(z: Floats, radii: Floats) -> Floats:
    """Return the volume between each layer and the next, along the last axis."""
    a, b = radii[..., :-1], radii[..., 1:]
    return np.asarray(np.pi / 3 * np.diff(z) * (a * a + a * b + b * b))


def regular_workspace(
    mechanism: Mechanism, layers: Any, limits: Limits, azimuths: int = 72
) -> RegularWorkspace:
    """Return the largest inscribed circles of the reachable region at heights `layers` [m].

    Raises `InputError` for fewer than two layers, or one that the level platform cannot reach.
    """
    try:
        z = np.unique(np.asarray(layers, dtype=float))
    except (TypeError, ValueError):
        raise InputError("layers", layers, "at least two different heights in metres") from None
    if z.ndim != 1 or len(z) < 2:
        raise InputError("layers", layers, "at least two different heights in metres")
    radii, _ = inscribed(mechanism, z, limits, azimuths)
    if np.isnan(radii).any():
        bad = float(z[np.isnan(radii)][0])
        raise InputError("layers", bad, "heights in metres that the level platform can reach")
    return RegularWorkspace(z, radii)
