"""Where the platform is: tilt-and-torsion angles and height, Eqs. (1)-(2)."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.errors import InputError
from analytic.mechanism import LARGEST, SLENDEREST, Mechanism

CLOSURE = 1e-9
"""How far a joint may be from closed before a pose or a model is refused [m]."""


FIELDS = {
    "z": "metres",
    "azimuth": "radians",
    "tilt": "radians",
    "torsion": "radians",
    "x": "metres",
    "y": "metres",
}


@dataclass(frozen=True)
class Pose:
    """Where o is, and how the platform is turned: scalars give one pose, arrays give many.

    Attributes: height `z` of o [m]; `azimuth` phi and `tilt` theta of Eq. (1) [rad]: the platform
    leans by `tilt` about the horizontal axis at `azimuth` + 90 degrees; `torsion`, by which it is
    turned about its own z before that [rad]; `x` and `y` of o [m], None where the limbs' hinges are
    to say (Eq. 2). Any position and rotation can be stated so: see `at`.
    Raises `InputError` for anything that is not finite, a coordinate beyond 1e9 m, or a
    tilt of more than a turn, which is in degrees.
    """

    z: Any
    azimuth: Any = 0.0
    tilt: Any = 0.0
    torsion: Any = 0.0
    x: Any = None
    y: Any = None

    def __post_init__(self) -> None:
        names = [name for name in FIELDS if getattr(self, name) is not None]
        if (self.x is None) != (self.y is None):
            raise InputError("Pose", f"x={self.x}, y={self.y}", "both x and y, or neither")
        values = []
        for name in names:
            given = getattr(self, name)
            unit = FIELDS[name]
            try:
                value = np.asarray(given, dtype=float)
            except (TypeError, ValueError):
                raise InputError(f"Pose.{name}", given, f"finite numbers of {unit}") from None
            if not np.isfinite(value).all() or (
                unit == "metres" and (np.abs(value) > LARGEST).any()
            ):
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
            raise InputError("Pose", shapes, f"{', '.join(names)} of matching shapes") from None
        for name, value in zip(names, shaped, strict=True):
            object.__setattr__(self, name, float(value) if value.ndim == 0 else value.copy())

    @classmethod
    def at(cls, position: Any, rotation: Any = None) -> "Pose":
        """Return the pose with o at `position` (..., 3) [m], turned by `rotation` (..., 3, 3).

        None: not turned. Raises `InputError` for a matrix that is no rotation to 1e-9.
        """
        try:
            o = np.asarray(position, dtype=float)
            R = np.eye(3) if rotation is None else np.asarray(rotation, dtype=float)
        except (TypeError, ValueError):
            raise InputError("Pose.at", position, "numbers") from None
        if o.shape[-1:] != (3,) or R.shape[-2:] != (3, 3):
            raise InputError("Pose.at", o.shape, "a position (..., 3) and a rotation (..., 3, 3)")
        if not (
            np.abs(R @ R.swapaxes(-1, -2) - np.eye(3)).max() <= 1e-9
            and (np.linalg.det(R) > 0).all()
        ):
            raise InputError("Pose.at", R.tolist(), "a rotation matrix")
        normal = R[..., 2]
        azimuth = np.arctan2(normal[..., 1], normal[..., 0])
        tilt = np.arctan2(np.hypot(normal[..., 0], normal[..., 1]), normal[..., 2])
        left = leaned(azimuth, tilt).swapaxes(-1, -2) @ R
        torsion = np.arctan2(left[..., 1, 0], left[..., 0, 0])
        return cls(o[..., 2], azimuth, tilt, torsion, o[..., 0], o[..., 1])

    @classmethod
    def stacked(cls, poses: Sequence["Pose"]) -> "Pose":
        """Return single poses as one row; raises `InputError` where some say x and y, some not."""
        free = {pose.x is None for pose in poses}
        if len(free) > 1:
            raise InputError("poses", poses, "poses that all say x and y, or none")
        values = ([getattr(pose, name) for pose in poses] for name in FIELDS)
        return cls(*(None if None in row else np.array(row) for row in values))

    @classmethod
    def planar(cls, x: Any, y: Any, angle: Any = 0.0, z: Any = 0.0) -> "Pose":
        """Return the pose of a platform that stays in a plane: turned by `angle` about z [rad]."""
        return cls(z, 0.0, 0.0, angle, x, y)

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of the array of poses; () for a single one."""
        return np.shape(self.z)

    def __len__(self) -> int:
        if not self.shape:
            raise TypeError("a single Pose has no len()")
        return self.shape[0]

    def __getitem__(self, index: Any) -> "Pose":
        return self._each(lambda value: value[index])

    def __iter__(self) -> Iterator["Pose"]:
        return (self[i] for i in range(len(self)))

    def ravel(self) -> "Pose":
        """Return the poses in one row."""
        return self._each(np.ravel)

    def _each(self, change: Callable[[Any], Any]) -> "Pose":
        values = {name: getattr(self, name) for name in FIELDS}
        return Pose(**{k: None if v is None else change(v) for k, v in values.items()})

    @property
    def rotation(self) -> NDArray[np.float64]:
        """R of Eq. (1), moving to global frame, shape (*shape, 3, 3)."""
        lean = leaned(self.azimuth, self.tilt)
        if not np.any(self.torsion):
            return lean
        c, s = np.cos(self.torsion), np.sin(self.torsion)
        about = np.zeros_like(lean)
        about[..., 0, 0] = about[..., 1, 1] = c
        about[..., 1, 0], about[..., 0, 1], about[..., 2, 2] = s, -s, 1.0
        return np.asarray(lean @ about)


def leaned(azimuth: Any, tilt: Any) -> NDArray[Any]:
    """Return R of Eq. (1) at angles of one shape [rad], real or complex, shape (..., 3, 3)."""
    alone = isinstance(azimuth, float) and isinstance(tilt, float)
    cos, sin = (math.cos, math.sin) if alone else (np.cos, np.sin)
    c_phi, s_phi, c_tilt, s_tilt = cos(azimuth), sin(azimuth), cos(tilt), sin(tilt)
    both, x, y = c_phi * s_phi * (c_tilt - 1), c_phi * s_tilt, s_phi * s_tilt
    rows = (
        (c_phi * c_phi * c_tilt + s_phi * s_phi, both, x),
        (both, s_phi * s_phi * c_tilt + c_phi * c_phi, y),
        (-x, -y, c_tilt),
    )
    if alone:
        return np.array(rows)
    R = np.empty((*np.shape(c_phi), 3, 3), dtype=np.result_type(c_phi, c_tilt))
    for i, row in enumerate(rows):
        for j, entry in enumerate(row):
            R[..., i, j] = entry
    return R


def dot(a: NDArray[Any], b: NDArray[Any]) -> NDArray[Any]:
    """Return a . b over the last axis, which has three: a sum over so few is slower."""
    return np.asarray(a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2])


Triple = tuple[Any, Any, Any]


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
    mechanism: Mechanism,
    bases: NDArray[Any],
    points: NDArray[Any],
    z: Any,
    R: NDArray[Any],
    given: NDArray[Any] | None = None,
) -> Closure:
    """Return the platform at height `z` (...) turned by `R` (..., 3, 3), real or complex.

    Each revolute joint keeps its limb in the plane through B_i normal to its axis e_i, so x and y
    solve e_i . (o + R A_i - B_i) = 0 for all i. The axes e_i are those of `mechanism`; `bases` B_i
    and `points` A_i have shape (..., n, 3). x and y may be `given` (..., 2) instead. Nothing is
    refused: see `closed`.
    """

    def across(gaps: Sequence[Any]) -> tuple[Any, Any]:
        xy = -gaps[0] @ mechanism.across.T if given is None else given
        return xy[..., :1], xy[..., 1:]

    whole = parts(bases), parts(mechanism.axes), parts(points)
    rows = R[..., 0, :], R[..., 1, :], R[..., 2, :]
    turn = tuple(parts(row[..., None, :]) for row in rows)
    (x, y, height), ((arms, vectors, off_plane),) = held(
        [whole], turn, np.asarray(z)[..., None], across
    )
    centre = np.concatenate([x, y, height], axis=-1)
    return Closure(R, centre, np.stack(arms, axis=-1), np.stack(vectors, axis=-1), off_plane)


def held(
    places: Sequence[tuple[Triple, Triple, Triple]],
    R: Sequence[Triple],
    z: Any,
    across: Callable[[Sequence[Any]], tuple[Any, Any]],
) -> tuple[Triple, list[tuple[Triple, Triple, Any]]]:
    """Return o, and of every limb R o A_i, B_i A_i and e_i . B_i A_i: Eq. (2), by components.

    Every component is a number, or an array over poses and limbs alike. `places` are B_i, e_i and
    A_i; `across` returns x and y from e_i . (R A_i - B_i + z), which they are to undo.
    """
    (r00, r01, r02), (r10, r11, r12), (r20, r21, r22) = R
    arms = [
        (r00 * p + r01 * q + r02 * r, r10 * p + r11 * q + r12 * r, r20 * p + r21 * q + r22 * r)
        for _, _, (p, q, r) in places
    ]
    over = [
        (a0 - b0, a1 - b1, a2 - b2 + z)
        for (a0, a1, a2), ((b0, b1, b2), _, _) in zip(arms, places, strict=True)
    ]
    axes = [e for _, e, _ in places]
    x, y = across(
        [v[0] * e[0] + v[1] * e[1] + v[2] * e[2] for v, e in zip(over, axes, strict=True)]
    )
    limbs = []
    for a, (u0, u1, v2), e in zip(arms, over, axes, strict=True):
        v0, v1 = x + u0, y + u1
        limbs.append((a, (v0, v1, v2), v0 * e[0] + v1 * e[1] + v2 * e[2]))
    return (x, y, z), limbs


def parts(vectors: NDArray[Any]) -> Triple:
    """Return the three components of vectors (..., 3)."""
    return vectors[..., 0], vectors[..., 1], vectors[..., 2]


def closed(mechanism: Mechanism, pose: Pose) -> Closure:
    """Return `mechanism` closed at `pose`: Eqs. (1) and (2).

    Raises `InputError` where an A_i leaves its revolute joint's plane, or meets its B_i, and for a
    limb more slender than is answered.
    """
    found = tried(mechanism, pose)
    off_plane, squares = np.abs(found.off_plane), dot(found.vectors, found.vectors)
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


def tried(mechanism: Mechanism, pose: Pose) -> Closure:
    """Return Eqs. (2) and (3) of the paper's limbs, whether joints close or not."""
    check_poses(mechanism, pose)
    if any(mechanism.platform.centre):
        centre = mechanism.platform.centre
        raise InputError("Platform.centre", centre, "o itself for this model")
    points = mechanism.platform_points
    given = None if pose.x is None else np.stack([pose.x, pose.y], axis=-1)
    return closure(mechanism, mechanism.bases, points, pose.z, pose.rotation, given)


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
