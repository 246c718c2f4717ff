"""Where the items of chains are: the simulators' own geometry, shared with no analytic model."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from analytic.errors import InputError
from analytic.mechanism import Freedom, Item, Joint, Limb, Link, Mechanism, Rod
from analytic.pose import Pose

Array = NDArray[np.float64]
GAP = 1e-9
"""Largest distance of A_i from its hinge's plane, relative to the limb's size; and largest angle
[rad] by which universal joints of a limb may be out of line."""
ALONG = 1e-6
"""A universal joint's axis nearer than this to its limb [rad] turns about one axis only."""


@dataclass(frozen=True)
class Standing:
    """One limb at a pose, in global axes.

    Attributes: its `number`, from 1; the `limb`; `frame`, columns x, y, z of its axes (3, 3);
    `starts` of its items and the end of the last (items + 1, 3) [m]; `mass` of its rods or,
    where it has none, of the platform [kg].
    """

    number: int
    limb: Limb
    frame: Array
    starts: Array
    mass: float

    @property
    def length(self) -> float:
        """From where it starts, on its slider if it has one, to A_i [m]."""
        return float(np.linalg.norm(self.starts[-1] - self.starts[0]))

    @property
    def may_spin(self) -> bool:
        """Whether two balls, free to turn, let it spin about itself."""
        balls = [
            item
            for item in self.limb.chain
            if isinstance(item, Joint)
            and sum(f.kind == "rotation" and not f.stiffness for f in item.freedoms) == 3
        ]
        return len(balls) == 2

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
    limbs = [_stand(i + 1, mechanism, o, R, pose) for i in range(len(mechanism.limbs))]
    for limb in limbs:
        _check(limb, R, pose)
    return o, R, limbs


def largest_gap(limbs: list[Standing], R: Array, tips: Array) -> float:
    """Return how far any of `tips` A_i (n, 3) is beside the plane of a hinge in its limb [m].

    With the hinges' axes as given: a simulator's, turned with its limb, would hide the gap.
    """
    gaps = [
        abs(float(axis @ (tip - limb.starts[0])))
        for limb, tip in zip(limbs, tips, strict=True)
        for axis in _hinges(limb, R)
    ]
    return max(gaps, default=0.0)


def _hinges(limb: Standing, R: Array) -> list[Array]:
    """Return the axes of the joints that turn freely about one axis alone, as given."""
    hinges = (item.hinge for item in limb.limb.chain if isinstance(item, Joint))
    return [limb.axis(hinge, R) for hinge in hinges if hinge]


def _check(limb: Standing, R: Array, pose: Pose) -> None:
    """Raise `InputError` for hinges not square to the limb, universal joints along it or out of
    line.
    """
    size = limb.length + sum(map(np.linalg.norm, (limb.limb.base, limb.limb.platform_point)))
    gap = largest_gap([limb], R, limb.starts[-1:])
    if gap > GAP * size:
        expected = f"A_i in its revolute joint's plane, not A_{limb.number} {gap:.1e} m beside it"
        raise InputError("pose", pose, expected)
    across = []
    for item in limb.limb.chain:
        if not isinstance(item, Joint):
            continue
        turns = [f for f in item.freedoms if f.kind == "rotation"]
        for f in turns:
            if not f.across:
                continue
            lean = np.linalg.norm(
                np.cross(limb.axis(replace(f, across=False), R), limb.frame[:, 2])
            )
            if lean < ALONG:
                raise InputError(
                    "pose", pose, f"universal joints across, not that of limb {limb.number} along"
                )
            if not f.stiffness and sum(not g.stiffness for g in turns) == len(turns) == 2:
                across.append(limb.axis(f, R))
    if len(across) == 2:
        out = float(np.linalg.norm(np.cross(across[0], across[1])))
        if out > GAP:
            expected = f"universal joints in line, not limb {limb.number}'s {out:.1e} rad out of it"
            raise InputError("pose", pose, expected)


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
    few = np.linalg.matrix_rank(np.array(rows).reshape(-1, 2), tol=1e-9) < 2
    if few and not mechanism.simple:
        raise InputError("pose", pose, "x and y too: no hinges at the base set them")
    return np.array([*np.linalg.lstsq(np.array(rows), np.array(right), rcond=1e-9)[0], pose.z])


def _stand(number: int, mechanism: Mechanism, o: Array, R: Array, pose: Pose) -> Standing:
    limb = mechanism.limbs[number - 1]
    tip, start = o + R @ np.array(limb.platform_point), np.array(limb.base)
    given = sum(_length(item) or 0.0 for item in limb.chain)
    first = limb.chain[0]
    if isinstance(first, Joint) and first.slider:
        e = np.array(first.freedoms[0].axis)
        # |tip - start - t e| = given, a quadratic in t.
        roots = np.roots([1.0, -2 * e @ (tip - start), (tip - start) @ (tip - start) - given**2])
        if np.iscomplexobj(roots):
            raise InputError("pose", pose, f"rods of limb {number} that reach the platform")
        start = start + (max(roots) if first.slider == "above" else min(roots)) * e
    total = float(np.linalg.norm(tip - start))
    size = total + sum(map(np.linalg.norm, (limb.base, limb.platform_point)))
    if not total > GAP * size:
        expected = f"limbs of some length, not that of A_{number} of {total:.1e} m"
        raise InputError("pose", pose, expected)
    left = total - given
    z = (tip - start) / total
    x = np.cross(np.array(limb.towards), z)
    x /= np.linalg.norm(x)
    own = [_length(item) for item in limb.chain]
    if None in own and not left > GAP * size:
        expected = f"something left to what adapts, not {left:.3e} m in limb {number}"
        raise InputError("pose", pose, expected)
    lengths = [left if length is None else length for length in own]
    starts = start + np.concatenate([[0.0], np.cumsum(lengths)])[:, None] * z
    masses = (
        item.material.density * item.area * length
        for item, length in zip(limb.chain, lengths, strict=True)
        if isinstance(item, Rod)
    )
    frame, mass = np.stack([x, np.cross(z, x), z], axis=1), sum(masses)
    return Standing(number, limb, frame, starts, mass or mechanism.platform.mass)


def _length(item: Item) -> float | None:
    return item.length if isinstance(item, (Rod, Link)) else 0.0
