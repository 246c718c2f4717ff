"""Where the platform is: tilt-and-torsion angles and height, Eqs. (1)-(2)."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.errors import InputError
from analytic.mechanism import LARGEST, SLENDEREST, Mechanism

CLOSURE = 1e-9
"""How far a joint may be from closed before a pose or a model is refused [m]."""


@dataclass(frozen=True)
class Pose:
    """Height `z` of o [m], `azimuth` phi and `tilt` theta of Eq. (1) [rad].

    Scalars give one pose; arrays (broadcast against each other) give many. Zero torsion: the
    platform leans by `tilt` about the horizontal axis at `azimuth` + 90 degrees.
    Raises `InputError` for anything that is not finite, a z beyond 1e9 m, or a tilt of more than a
    turn, which is in degrees.
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
            if not np.isfinite(value).all() or (name == "z" and (np.abs(value) > LARGEST).any()):
                raise InputError(f"Pose.{name}", given, f"finite numbers of {unit}")
            values.append(value)
        if (np.abs(values[2]) > 2 * np.pi).any():
            raise InputError(
                "Pose.tilt", self.tilt, "radians, less than a turn; np.radians(-12) is 12 degrees"
            )
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
        return rotation(self.azimuth, self.tilt)


def rotation(azimuth: Any, tilt: Any) -> NDArray[Any]:
    """Return R of Eq. (1) at angles of one shape [rad], real or complex, shape (..., 3, 3)."""
    c_phi, s_phi = np.cos(azimuth), np.sin(azimuth)
    c_tilt, s_tilt = np.cos(tilt), np.sin(tilt)
    R = np.empty((*np.shape(c_phi), 3, 3), dtype=np.result_type(c_phi, c_tilt))
    R[..., 0, 0] = c_phi * c_phi * c_tilt + s_phi * s_phi
    R[..., 1, 1] = s_phi * s_phi * c_tilt + c_phi * c_phi
    R[..., 2, 2] = c_tilt
    R[..., 0, 1] = R[..., 1, 0] = c_phi * s_phi * (c_tilt - 1)
    R[..., 0, 2] = c_phi * s_tilt
    R[..., 1, 2] = s_phi * s_tilt
    R[..., 2, 0], R[..., 2, 1] = -R[..., 0, 2], -R[..., 1, 2]
    return R


@dataclass(frozen=True)
class Closure:
    """The platform held by its limbs; `...` is the shape of the poses.

    Attributes: `rotation` R (..., 3, 3); `centre` o in the global frame (..., 3) [m]; `arms`
    R o A_i and `vectors` B_i A_i, global frame (..., n, 3) [m]; `off_plane`, how far each A_i is
    beside its revolute joint's plane (..., n) [m].
    """

    rotation: NDArray[Any]
    centre: NDArray[Any]
    arms: NDArray[Any]
    vectors: NDArray[Any]
    off_plane: NDArray[Any]


def closure(
    mechanism: Mechanism, bases: NDArray[Any], points: NDArray[Any], z: Any, R: NDArray[Any]
) -> Closure:
    """Return the platform at height `z` (...) turned by `R` (..., 3, 3), real or complex.

    Each revolute joint keeps its limb in the plane through B_i normal to its axis e_i, so x and y
    solve e_i . (o + R A_i - B_i) = 0 for all i. The axes e_i are those of `mechanism`; `bases` B_i
    and `points` A_i have shape (..., n, 3). Nothing is refused: see `closed`.
    """
    axes = mechanism.axes
    arms = points @ R.swapaxes(-1, -2)
    height = np.asarray(z)[..., None]
    gap = ((arms - bases) * axes).sum(axis=-1) + axes[:, 2] * height
    across = -gap @ mechanism.across.T
    o = np.concatenate([across, height], axis=-1)
    vectors = o[..., None, :] + arms - bases
    return Closure(R, o, arms, vectors, (vectors * axes).sum(axis=-1))


def closed(mechanism: Mechanism, pose: Pose) -> Closure:
    """Return `mechanism` closed at `pose`: Eqs. (1) and (2).

    Raises `InputError` where an A_i leaves its revolute joint's plane, or meets its B_i, and for a
    limb more slender than is answered.
    """
    found = _closure(mechanism, pose)
    off_plane, squares = np.abs(found.off_plane), (found.vectors * found.vectors).sum(axis=-1)
    beside, gone = off_plane > CLOSURE, squares <= CLOSURE**2
    if beside.any():
        expected = "A_i in its revolute joint's plane, not A_{} {:.1e} m beside it"
        raise _refused(pose, beside, off_plane, expected)
    if gone.any():
        expected = "limbs of some length, not that of A_{} of {:.1e} m"
        raise _refused(pose, gone, np.sqrt(squares), expected)
    thin = squares > mechanism.longest**2
    if thin.any():
        expected = f"limbs of at most {SLENDEREST:g} diameters, not A_{{}}'s of {{:.1e}}"
        slender = SLENDEREST * np.sqrt(squares) / mechanism.longest
        raise _refused(pose, thin, slender, expected)
    return found


def position(mechanism: Mechanism, pose: Pose) -> NDArray[np.float64]:
    """Return o in the global frame, shape (*pose.shape, 3) [m]: Eq. (2) for any mechanism.

    For limbs 120 degrees apart that is Eq. (2) as printed, x = r2 (cos theta - 1) cos(2 phi) / 2
    and y = r2 (1 - cos theta) sin(2 phi) / 2, about the first (see `closure`).
    Raises `InputError` where an A_i leaves its revolute joint's plane, or meets its B_i.
    """
    return closed(mechanism, pose).centre


def closes(mechanism: Mechanism, pose: Pose) -> NDArray[np.bool_]:
    """Return where `position` has an answer: all joints close, shape pose.shape."""
    found = _closure(mechanism, pose)
    lengths = np.linalg.norm(found.vectors, axis=-1)
    good = (np.abs(found.off_plane) <= CLOSURE) & (lengths > CLOSURE)
    return np.asarray(good.all(axis=-1))


def _closure(mechanism: Mechanism, pose: Pose) -> Closure:
    check_poses(mechanism, pose)
    points = mechanism.platform_points
    return closure(mechanism, mechanism.bases, points, pose.z, pose.rotation)


def check_poses(mechanism: Any, poses: Any) -> None:
    """Raise `InputError` unless `mechanism` is a `Mechanism` and `poses` a `Pose`."""
    if not isinstance(mechanism, Mechanism):
        raise InputError("mechanism", mechanism, "a Mechanism")
    if not isinstance(poses, Pose):
        raise InputError("pose", poses, "a Pose")


def one_pose(mechanism: Any, pose: Any) -> Pose:
    """Return `pose` if it is a single one and `mechanism` a mechanism, or raise `InputError`."""
    check_poses(mechanism, pose)
    single: Pose = pose
    if single.shape:
        raise InputError("pose", f"{single.shape} poses", "one pose at a time for this model")
    return single


def _refused(
    pose: Pose, bad: NDArray[np.bool_], amount: NDArray[np.float64], expected: str
) -> InputError:
    *where, limb = (int(i) for i in np.argwhere(bad)[0])
    one = pose[tuple(where)] if where else pose
    value = f"z={one.z!r}, azimuth={one.azimuth!r}, tilt={one.tilt!r}"
    return InputError("pose", value, expected.format(limb + 1, amount[(*where, limb)]))
