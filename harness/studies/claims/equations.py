"""The paper's equations as printed, put to the test."""

from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse
from scipy.spatial.transform import Rotation

from analytic import Mechanism, Multipliers, Platform, Pose, Substructure, limbs_at
from analytic.substructure import (
    independent_coordinates,
    limb_selection,
    platform_selection,
    rigid_arm,
)
from harness.case import Case
from harness.signatures import Array

Formula = Callable[..., Any]
SIZES = range(1, 9)
"""Numbers of elements whose matrices are counted."""
PHI, THETA = np.radians([10.0, -12.0])
"""The angles of Case 2 [rad]."""
POSES = 200
THICKNESS = 0.02
"""h of Section 2 [m]."""
STEP = 1e-4
"""Rotation by which Eq. (10) is differentiated, centrally [rad]."""


def printed_rotation(phi: Array, theta: Array) -> Array:
    """Return R of Eq. (1), letter by letter, shape (n, 3, 3)."""
    c, s, ct, st = np.cos(phi), np.sin(phi), np.cos(theta), np.sin(theta)
    mixed = c * ct * s - s * c
    rows = [
        [c**2 * ct + s**2, mixed, c * st],
        [mixed, s**2 * ct + c**2, s * st],
        [-c * st, -s * st, ct],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def printed_position(r2: float, phi: Array, theta: Array) -> tuple[Array, Array]:
    """Return x and y of Eq. (2), each (n,) [m]."""
    ct = np.cos(theta)
    return r2 * (ct - 1) * np.cos(2 * phi) / 2, r2 * (1 - ct) * np.sin(2 * phi) / 2


def random_poses() -> Pose:
    """Return the same `POSES` every time: z 0.35-0.7 m, any azimuth, tilt to 20 degrees."""
    random, ends = np.random.default_rng(0), ((0.35, 0.7), (-np.pi, np.pi), (-20, 20))
    z, azimuth, tilt = (random.uniform(low, high, POSES) for low, high in ends)
    return Pose(z, azimuth, np.radians(tilt))


def equations(
    cases: Sequence[Case],
    *,
    rotation: Formula = printed_rotation,
    position: Formula = printed_position,
    arm: Formula = rigid_arm,
    platform: Formula = Platform.as_printed,
) -> Any:
    """Return the residuals of formulas and of the model, for the mechanism of `cases`.

    Put to the test are Eqs. (1) and (2), J_i of Eq. (10), and the plate of Eq. (8).
    """
    mechanism = cases[0].mechanism
    poses = random_poses()
    R = rotation(poses.azimuth, poses.tilt)
    r2 = np.linalg.norm(mechanism.platform_points[0]).item()
    x, y = position(r2, poses.azimuth, poses.tilt)
    o = np.stack([x, y, poses.z], axis=-1)
    # Eq. (3), limb by limb: (poses, n, 3).
    vectors = o[:, None] + mechanism.platform_points @ R.swapaxes(1, 2) - mechanism.bases
    lengths = np.linalg.norm(vectors, axis=-1)
    turns = rotation(np.array([PHI, 0.0]), np.array([0.0, THETA]))
    alone, theta = Rotation.from_matrix(turns).as_rotvec()
    headings = np.radians(np.arange(0, 360, 5))
    # The revolute axis is y of the limb's frame R_i: (headings, poses, n, 3).
    turned = [limbs_at(Mechanism.paper(heading=h), poses) for h in headings.tolist()]
    axes = np.array([limbs.frames[..., 1] for limbs in turned])
    density = mechanism.limbs[0].rod.material.density
    plate = platform(r2, THICKNESS, density)
    opened, apart, clamped = zip(*(_against_multipliers(case) for case in cases), strict=True)
    orthogonal, right = R.swapaxes(1, 2) @ R - np.eye(3), np.linalg.det(R) - 1
    return SimpleNamespace(
        # Largest of |R^T R - 1| and |det R - 1|, Eq. (1).
        rotation=max(np.abs(orthogonal).max(), np.abs(right).max()),
        phi_alone=np.linalg.norm(alone),  # how far R turns for PHI alone [rad]
        # Angle of R's axis from x for THETA alone [rad].
        theta_axis=np.arccos(abs(theta[0]) / np.linalg.norm(theta)),
        # Largest distance of an A_i from its joint's plane, Eq. (2) [m].
        beside_plane=np.abs(np.einsum("ij,pij->pi", mechanism.axes, vectors)).max(),
        # Largest difference of L_i, Eq. (3), from the model's [m].
        lengths_apart=np.abs(lengths - limbs_at(mechanism, poses).lengths).max(),
        compatibility=_compatibility(mechanism, arm),
        freedoms=_freedoms(cases[-1]),  # of the platform with its actuators free
        sizes={s: _sizes(cases[0], s) for s in SIZES},
        headings=headings,  # turns of the base (n,) [rad]
        # Smallest |denominator| over limbs and poses (n,).
        eq17=np.abs(axes[..., 1]).min(axis=(1, 2)),
        eq18=np.abs(axes[..., 0]).min(axis=(1, 2)),
        axis_rise=np.abs(axes[..., 2]).max(),  # vertical component of a revolute axis
        axis_motion=np.ptp(axes, axis=1).max(),  # of a revolute axis from pose to pose
        joints_open=max(opened),  # largest |C u| of a mode for unit largest motion
        multipliers_apart=max(apart),  # relative difference of f1-f6 from those with multipliers
        multipliers=Multipliers(3).matrices(mechanism, cases[0].pose)[2].shape[0],
        # Relative change of f1-f6 by case if Phi_Bi = 0.
        base_clamped=dict(zip((case.name for case in cases), clamped, strict=True)),
        # The printed platform's Jx, Jy, Jz over its mass [m^2].
        moments=np.diag(np.array(plate.inertia)) / plate.mass,
        thickness=THICKNESS,  # h [m]
    )


def _compatibility(mechanism: Mechanism, arm: Formula) -> float:
    """Return the largest error of `arm` against turning A_i about each axis by `STEP`."""
    turn, worst = Rotation.from_rotvec(STEP * np.eye(3)), 0.0
    for point in np.array(mechanism.platform_points):  # a copy: rotating needs one to write to
        moved = turn.apply(point) - turn.inv().apply(point)
        off = np.abs(arm(point)[:, 3:] - moved.T / (2 * STEP)).max()
        worst = max(worst, off / np.linalg.norm(point))
    return worst


def _freedoms(case: Case) -> int:
    """Return 6 less the rank of e_i . (v + omega x a_i) = 0: actuators free, rods rigid."""
    arms = limbs_at(case.mechanism, case.pose).arms
    held = np.array([e @ rigid_arm(a) for e, a in zip(case.mechanism.axes, arms, strict=True)])
    return 6 - int(np.linalg.matrix_rank(held))


def _sizes(case: Case, s: int) -> tuple[int, int, int, int]:
    """Return coordinates of a rod, all of them, rank of the constraints, size of K of Eq. (22)."""
    there = case.mechanism, case.pose
    (K, _, C), (own, _) = Multipliers(s).matrices(*there), Substructure(s).matrices(*there)
    rod = limb_selection(0, len(case.mechanism.limbs), s, case.mechanism.platform_points[0])
    return rod.shape[0], K.shape[0], np.linalg.matrix_rank(C.toarray()).item(), own.shape[0]


def _against_multipliers(case: Case) -> tuple[float, float, Array]:
    """Return how far modes of Eq. (22) open the joints, f1-f6 from those with multipliers.

    And the relative change of f1-f6 when Phi_Bi = 0 as well.
    """
    robot, s, n = case.mechanism, 3, len(case.mechanism.limbs)
    K, M = (A.toarray() for A in Substructure(s).matrices(robot, case.pose))
    squares, U = scipy.linalg.eigh(K, M, subset_by_index=(0, 5))
    arms = limbs_at(robot, case.pose).arms
    limbs = [limb_selection(i, n, s, arm) for i, arm in enumerate(arms)]
    H = scipy.sparse.vstack([*limbs, platform_selection(n, s)])
    u = H @ (independent_coordinates(robot.axes, s) @ U)
    C = Multipliers(s).matrices(robot, case.pose)[2]
    opened = np.abs(C @ u).max(axis=0) / np.abs(u).max(axis=0)
    rival = Multipliers(s, solver="saddle-point").modes(robot, case.pose, 6).frequencies
    own = np.sqrt(squares) / (2 * np.pi)
    kept = np.delete(np.arange(len(K)), (6 * s - 2) * np.arange(n))
    less = np.ix_(kept, kept)
    clamped = scipy.linalg.eigh(K[less], M[less], eigvals_only=True, subset_by_index=(0, 5))
    changes: Array = np.sqrt(clamped / squares) - 1
    return opened.max(), np.abs(own / rival - 1).max(), changes
