"""Where the items of chains are: the simulators' own geometry, shared with no analytic model."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from analytic.errors import InputError
from analytic.mechanism import Freedom, Item, Joint, Limb, Link, Mechanism, Rod
from analytic.pose import Pose

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Standing:
    """One limb at a pose, in global axes.

    Attributes: the `limb`; `frame`, columns x, y, z of its axes (3, 3); `starts` of its items and
    the end of the last (items + 1, 3) [m].
    """

    limb: Limb
    frame: Array
    starts: Array

    def axis(self, freedom: Freedom, turned: Array) -> Array:
        """Return a freedom's direction; `turned` is the platform's rotation."""
        given = np.array(freedom.axis)
        axis = {"base": given, "limb": self.frame @ given, "platform": turned @ given}[
            freedom.frame
        ]
        if freedom.across:
            axis = np.cross(axis, self.frame[:, 2])
        return np.asarray(axis / np.linalg.norm(axis))


def stand(mechanism: Mechanism, pose: Pose) -> tuple[Array, Array, list[Standing]]:
    """Return o (3,), the platform's rotation (3, 3) and all limbs, at one pose.

    The platform turns by its torsion about its own z, then leans by `tilt` towards `azimuth`.
    Raises `InputError` naming a limb that does not reach.
    """
    if pose.shape:
        raise InputError("pose", f"{pose.shape} poses", "one pose at a time for this model")
    about = [-np.sin(pose.azimuth), np.cos(pose.azimuth), 0.0]
    lean = Rotation.from_rotvec(pose.tilt * np.array(about))
    R = (lean * Rotation.from_rotvec([0.0, 0.0, pose.torsion])).as_matrix()
    o = _centre(mechanism, pose, R)
    return o, R, [_stand(i, limb, o, R) for i, limb in enumerate(mechanism.limbs)]


def _centre(mechanism: Mechanism, pose: Pose, R: Array) -> Array:
    if pose.x is not None:
        return np.array([pose.x, pose.y, pose.z])
    rows, right = [], []
    for limb in mechanism.limbs:
        for item in limb.chain:
            hinge = item.hinge if isinstance(item, Joint) else None
            if hinge and hinge.frame == "base":
                # e . (o + R A - B) = 0: the hinge keeps A in a plane.
                e = np.array(hinge.axis)
                rows.append(e[:2])
                offset = np.array(limb.base) - R @ np.array(limb.platform_point)
                right.append(e @ offset - e[2] * pose.z)
    if np.linalg.matrix_rank(np.array(rows).reshape(-1, 2), tol=1e-9) < 2:
        raise InputError("pose", pose, "x and y too: no hinges at the base set them")
    return np.array([*np.linalg.lstsq(np.array(rows), np.array(right), rcond=None)[0], pose.z])


def _stand(number: int, limb: Limb, o: Array, R: Array) -> Standing:
    tip, start = o + R @ np.array(limb.platform_point), np.array(limb.base)
    given = sum(_length(item) or 0.0 for item in limb.chain)
    first = limb.chain[0]
    if isinstance(first, Joint) and first.slider:
        e = np.array(first.freedoms[0].axis)
        # |tip - start - t e| = given, a quadratic in t.
        roots = np.roots([1.0, -2 * e @ (tip - start), (tip - start) @ (tip - start) - given**2])
        if np.iscomplexobj(roots):
            raise InputError(
                "pose", f"limb {number + 1}", "rods that reach from slider to platform"
            )
        start = start + (max(roots) if first.slider == "above" else min(roots)) * e
    total = float(np.linalg.norm(tip - start))
    left = total - given
    z = (tip - start) / total
    x = np.cross(np.array(limb.towards), z)
    x /= np.linalg.norm(x)
    lengths = [left if length is None else length for length in map(_length, limb.chain)]
    if min(length for length in lengths) < 0:
        raise InputError("pose", f"limb {number + 1}", f"rods that fit, not {left:.3e} m over")
    starts = start + np.concatenate([[0.0], np.cumsum(lengths)])[:, None] * z
    return Standing(limb, np.stack([x, np.cross(z, x), z], axis=1), starts)


def _length(item: Item) -> float | None:
    return item.length if isinstance(item, (Rod, Link)) else 0.0


def triad(axes: list[Array]) -> Array | None:
    """Return a right-handed frame (3, 3) whose columns `axes` are along, up to sign, or None."""
    found: list[Array] = []
    for axis in axes:
        along = [abs(float(axis @ other)) for other in found]
        if any(dot > 1 - 1e-9 for dot in along):
            continue
        if any(dot > 1e-9 for dot in along):
            return None
        found.append(axis)
    leaning = np.array([max([abs(float(s @ f)) for f in found], default=0.0) for s in np.eye(3)])
    for spare in np.eye(3)[np.argsort(leaning)]:
        if len(found) == 3:
            break
        left = spare - sum((spare @ f) * f for f in found)
        if np.linalg.norm(left) > 1e-3:
            found.append(left / np.linalg.norm(left))
    frame = np.stack(found, axis=1)
    if np.linalg.det(frame) < 0:
        frame[:, 2] *= -1
    return frame
