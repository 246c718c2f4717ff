"""Eqs. (1)-(3): rotation, position and limbs."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from analytic import InputError, Limb, Mechanism, Pose, limbs_at, position

angles = st.floats(-np.pi, np.pi)
tilts = st.floats(-0.6, 0.6)


def about_z(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def about_y(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


@given(angles, tilts)
def test_rotation_is_tilt_and_torsion(azimuth: float, tilt: float) -> None:
    """Eq. (1) is Bonev's T&T rotation with no torsion: Rz(phi) Ry(theta) Rz(-phi)."""
    wanted = about_z(azimuth) @ about_y(tilt) @ about_z(-azimuth)
    np.testing.assert_allclose(Pose(1.0, azimuth, tilt).rotation, wanted, atol=1e-15)


@given(angles, tilts)
def test_position_is_eq_2(azimuth: float, tilt: float) -> None:
    o = position(Mechanism.paper(), Pose(0.49, azimuth, tilt))
    x = 0.2 * (np.cos(tilt) - 1) * np.cos(2 * azimuth) / 2
    y = 0.2 * (1 - np.cos(tilt)) * np.sin(2 * azimuth) / 2
    np.testing.assert_allclose(o, [x, y, 0.49], atol=1e-15)


@given(angles, angles, tilts)
def test_turning_everything_turns_the_position(turn: float, azimuth: float, tilt: float) -> None:
    still = position(Mechanism.paper(), Pose(0.49, azimuth, tilt))
    turned = position(Mechanism.paper(heading=turn), Pose(0.49, azimuth + turn, tilt))
    np.testing.assert_allclose(turned, about_z(turn) @ still, atol=1e-14)


@given(angles, angles, tilts, st.floats(0.3, 1.0))
def test_limbs_close_the_loop(turn: float, azimuth: float, tilt: float, z: float) -> None:
    robot, pose = Mechanism.paper(heading=turn), Pose(z, azimuth, tilt)
    limbs = limbs_at(robot, pose)
    o = position(robot, pose)
    tips = robot.bases + limbs.lengths[:, None] * limbs.frames[:, :, 2]
    np.testing.assert_allclose(tips, o + limbs.arms, atol=1e-14)
    np.testing.assert_allclose(limbs.frames[:, :, 1], robot.axes, atol=1e-14)
    eye = limbs.frames @ limbs.frames.transpose(0, 2, 1)
    np.testing.assert_allclose(eye, np.broadcast_to(np.eye(3), eye.shape), atol=1e-14)
    np.testing.assert_allclose(np.linalg.det(limbs.frames), 1, atol=1e-14)
    # A limb turned by the revolute angle about its axis, from the vertical.
    for frame, angle, axis in zip(limbs.frames, limbs.revolute, robot.axes, strict=True):
        vertical = np.array([0, 0, 1.0])
        turned = np.cos(angle) * vertical + np.sin(angle) * np.cross(axis, vertical)
        np.testing.assert_allclose(frame[:, 2], turned, atol=1e-14)
    normal = pose.rotation[:, 2]
    np.testing.assert_allclose(np.cos(limbs.spherical), limbs.frames[:, :, 2] @ normal, atol=1e-14)


def test_many_poses_are_each_of_them(robot: Mechanism) -> None:
    poses = Pose(np.array([[0.4], [0.5]]), np.array([0.1, 0.2, 0.3]), 0.2)
    assert poses.shape == (2, 3)
    many = limbs_at(robot, poses)
    for index in np.ndindex(2, 3):
        one = limbs_at(robot, poses[index])
        np.testing.assert_allclose(many.frames[index], one.frames, atol=1e-15)
        np.testing.assert_allclose(many.lengths[index], one.lengths, rtol=1e-15)
        np.testing.assert_allclose(many.spherical[index], one.spherical, rtol=1e-14)
    assert len(poses) == 2
    assert [pose.shape for pose in poses] == [(3,), (3,)]


def test_home_pose_by_hand(robot: Mechanism, case1: Pose) -> None:
    limbs = limbs_at(robot, case1)
    np.testing.assert_allclose(limbs.lengths, np.hypot(0.49, 0.1), rtol=1e-15)
    np.testing.assert_allclose(np.abs(limbs.revolute), np.arctan2(0.1, 0.49), rtol=1e-14)
    np.testing.assert_allclose(limbs.spherical, np.arctan2(0.1, 0.49), rtol=1e-14)


def test_a_point_beside_its_plane_is_refused(robot: Mechanism) -> None:
    square = Mechanism.regular(0.3, 0.2, robot.limbs[0].rod, robot.platform, limbs=4)
    limbs_at(square, Pose(0.49))
    limbs_at(square, Pose(0.49, 0.0, 0.2))  # leaning along a limb keeps all four in plane
    with pytest.raises(InputError, match=r"pose = .*revolute joint's plane, not A_\d .* m beside"):
        limbs_at(square, Pose(0.49, np.radians(20), 0.2))


def test_a_limb_of_no_length_is_refused(robot: Mechanism) -> None:
    upright = Mechanism.regular(0.2, 0.2, robot.limbs[0].rod, robot.platform)
    with pytest.raises(InputError, match="limbs of some length"):
        limbs_at(upright, Pose(0.0))


def test_the_bad_pose_of_many_is_named(robot: Mechanism) -> None:
    upright = Mechanism.regular(0.2, 0.2, robot.limbs[0].rod, robot.platform)
    with pytest.raises(InputError, match=r"z=0\.0"):
        limbs_at(upright, Pose(np.array([0.5, 0.0, 0.4])))


def test_a_tilted_revolute_axis_still_closes(robot: Mechanism) -> None:
    limb = Limb.rps((0.3, 0, 0), (0, 1, 0.5), (0.2, 0, 0), robot.limbs[0].rod)
    tilted = Mechanism((limb,), robot.platform)
    frame = limbs_at(tilted, Pose(0.4)).frames[0]
    np.testing.assert_allclose(frame[:, 1], np.array([0, 1, 0.5]) / np.hypot(1, 0.5), atol=1e-14)
