"""Where the platform is: tilt-and-torsion angles and height, Eqs. (1)-(2)."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.errors import InputError
from analytic.mechanism import Mechanism

CLOSURE = 1e-9
"""How far a joint may be from closed before a pose or a model is refused [m]."""


@dataclass(frozen=True)
class Pose:
    """Height `z` of o [m], `azimuth` phi and `tilt` theta of Eq. (1) [rad].

    Scalars give one pose; arrays (broadcast against each other) give many. Zero torsion: the
    platform leans by `tilt` about the horizontal axis at `azimuth` + 90 degrees.
    Raises `InputError` for anything that is not finite.
    """

    z: Any
    azimuth: Any = 0.0
    tilt: Any = 0.0

    def __post_init__(self) -> None:
        values = []
        for name, unit in (("z", "metres"), ("azimuth", "radians"), ("tilt", "radians")):
            given = getattr(self, name)
            try:
                value = np.asarray(given, dtype=float)
            except (TypeError, ValueError):
                raise InputError(f"Pose.{name}", given, f"finite numbers of {unit}") from None
            if not np.isfinite(value).all():
                raise InputError(f"Pose.{name}", given, f"finite numbers of {unit}")
            values.append(value)
        try:
            shaped = np.broadcast_arrays(*values)
        except ValueError:
            shapes = ", ".join(str(value.shape) for value in values)
            raise InputError("Pose", shapes, "z, azimuth and tilt of matching shapes") from None
        for name, value in zip(("z", "azimuth", "tilt"), shaped, strict=True):
            object.__setattr__(self, name, float(value) if value.ndim == 0 else value.copy())

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of the array of poses; () for a single one."""
        return np.shape(self.z)

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError("a single Pose has no len()")
        return self.shape[0]

    def __getitem__(self, index: Any) -> "Pose":
        return Pose(self.z[index], self.azimuth[index], self.tilt[index])

    def __iter__(self) -> Iterator["Pose"]:
        return (self[i] for i in range(len(self)))

    @property
    def rotation(self) -> NDArray[np.float64]:
        """R of Eq. (1), moving to global frame, shape (*shape, 3, 3)."""
        c_phi, s_phi = np.cos(self.azimuth), np.sin(self.azimuth)
        c_tilt, s_tilt = np.cos(self.tilt), np.sin(self.tilt)
        mixed = c_phi * s_phi * (c_tilt - 1)
        rows = [
            [c_phi**2 * c_tilt + s_phi**2, mixed, c_phi * s_tilt],
            [mixed, s_phi**2 * c_tilt + c_phi**2, s_phi * s_tilt],
            [-c_phi * s_tilt, -s_phi * s_tilt, c_tilt],
        ]
        return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def position(mechanism: Mechanism, pose: Pose) -> NDArray[np.float64]:
    """Return o in the global frame, shape (*pose.shape, 3) [m]: Eq. (2) for any mechanism.

    Each revolute joint keeps its limb in the plane through B_i normal to its axis e_i, so x and y
    solve e_i . (o + R A_i - B_i) = 0 for all i. For limbs 120 degrees apart that is Eq. (2):
    x = r2 (cos theta - 1) cos(2 phi) / 2, y = r2 (1 - cos theta) sin(2 phi) / 2 about the first.
    Raises `InputError` where an A_i leaves that plane, or meets its B_i.
    """
    o, off_plane, lengths = _closure(mechanism, pose)
    _refuse(
        pose,
        off_plane > CLOSURE,
        off_plane,
        "A_i in its revolute joint's plane, not A_{} {:.1e} m beside it",
    )
    gone = "limbs of some length, not that of A_{} of {:.1e} m"
    _refuse(pose, lengths <= CLOSURE, lengths, gone)
    return o


def closes(mechanism: Mechanism, pose: Pose) -> NDArray[np.bool_]:
    """Return where `position` has an answer: all joints close, shape pose.shape."""
    _, off_plane, lengths = _closure(mechanism, pose)
    return np.asarray(((off_plane <= CLOSURE) & (lengths > CLOSURE)).all(axis=-1))


def _closure(mechanism: Mechanism, pose: Pose) -> tuple[NDArray[np.float64], ...]:
    """Return o (..., 3), how far each A_i is beside its plane (..., n) and |B_i A_i| (..., n)."""
    axes, bases = mechanism.axes, mechanism.bases
    arms = np.einsum("...jk,ik->...ij", pose.rotation, mechanism.platform_points)
    height = np.asarray(pose.z)[..., None]
    gap = np.einsum("ij,...ij->...i", axes, arms - bases) + axes[:, 2] * height
    across = -gap @ np.linalg.pinv(axes[:, :2], rcond=1e-9).T
    o = np.concatenate([across, height], axis=-1)
    limbs = o[..., None, :] + arms - bases
    off_plane = np.abs(np.einsum("ij,...ij->...i", axes, limbs))
    return o, off_plane, np.linalg.norm(limbs, axis=-1)


def _refuse(pose: Pose, bad: NDArray[np.bool_], amount: NDArray[np.float64], expected: str) -> None:
    if not bad.any():
        return
    *where, limb = (int(i) for i in np.argwhere(bad)[0])
    one = pose[tuple(where)] if where else pose
    value = f"z={one.z!r}, azimuth={one.azimuth!r}, tilt={one.tilt!r}"
    raise InputError("pose", value, expected.format(limb + 1, amount[(*where, limb)]))
