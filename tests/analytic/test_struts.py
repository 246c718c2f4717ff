"""Limbs of rigid links, joints and springs: a stiffness at the platform."""

import math

import numpy as np
import pytest

from analytic import (
    Body,
    Continuum,
    InputError,
    Joint,
    Limb,
    Link,
    Mechanism,
    Multipliers,
    Platform,
    Pose,
    Substructure,
)
from analytic.stiffness import stiffness

U, S = Joint.universal((0, 1, 0)), Joint.spherical()


@pytest.mark.parametrize("first", [U, S])
def test_rigid_struts_are_springs_of_the_closed_form(first: Joint) -> None:
    """K = k sum_i v v^T with v = (s, a x s): massless struts of one stiffness along them."""
    k, height = 20e6, 0.0771
    limbs = []
    for i in range(6):
        base, point = (
            (r * math.cos(angle), r * math.sin(angle), 0.0)
            for r, angle in (
                (0.15, math.radians(120 * (i // 2) + 15 * (-1) ** i)),
                (0.10, math.radians(120 * (i // 2) + 45 * (-1) ** i)),
            )
        )
        limbs.append(Limb(base, point, (first, Link(), Joint.prismatic(stiffness=k), S)))
    plate = Platform.diagonal(0.9, (0.0084, 0.0084, 0.0168))
    robot, pose = Mechanism(tuple(limbs), plate), Pose.at((0, 0, height))
    K = np.zeros((6, 6))
    for limb in limbs:
        a = np.array(limb.platform_point)
        along = a + np.array([0, 0, height]) - np.array(limb.base)
        along = along / np.linalg.norm(along)
        v = np.concatenate([along, np.cross(a, along)])
        K += k * np.outer(v, v)
    squares = np.linalg.eigvals(np.linalg.solve(plate.mass_matrix, K))
    expected = np.sqrt(np.sort(squares.real)) / (2 * math.pi)
    for model in (Substructure(2), Continuum("timoshenko"), Multipliers(2)):
        found = model.modes(robot, pose, 6)
        assert found.frequencies == pytest.approx(expected, rel=1e-9)
        # A strut turns about its start as its end moves.
        tips = found.limbs[:, :, -1]
        assert found.limbs[:, :, 5] == pytest.approx(tips / 2, rel=1e-9)
    assert stiffness(robot, pose).matrix == pytest.approx(K, rel=1e-9, abs=1e-6 * k)
    assert stiffness(robot, pose).shares.sum(axis=0) == pytest.approx(np.ones(6))
    with pytest.raises(InputError, match="at most 6"):
        Continuum().modes(robot, pose, 7)


def carried(stiffness: float, joints: tuple[Joint, Joint]) -> tuple[Mechanism, list[Limb]]:
    """Six struts of two bodies each, 25 mm from their joints, below a plate."""
    body = Body(0.1, ((2e-5, 0, 0), (0, 2e-5, 0), (0, 0, 1e-6)), frame="limb")
    limbs = []
    for i in range(6):
        base, point = (
            (r * math.cos(angle), r * math.sin(angle), 0.0)
            for r, angle in (
                (0.115, math.radians(120 * (i // 2) + 10 * (-1) ** i)),
                (0.09, math.radians(120 * (i // 2) + 50 * (-1) ** i)),
            )
        )
        drive = Joint.prismatic(stiffness=stiffness)
        chain = (joints[0], Link(0.025), body, drive, Link(), body, Link(0.025), joints[1])
        limbs.append(Limb(base, point, chain))
    return Mechanism(tuple(limbs), Platform.diagonal(1.0, (0.0025, 0.0025, 0.005))), limbs


def test_bodies_of_rigid_struts_are_moved_by_the_platform() -> None:
    """M gains, of each strut with e along it and T across it, moved by the tip's X: rows of turning
    bodies (m a^2 / L^2 + I / L^2) X^T T X and of the upper one m X^T e e^T X.
    """
    k, height, a, m, own = 2e7, 0.06, 0.025, 0.1, 2e-5
    across = Joint.universal((1, 0, 0), frame="limb")
    robot, limbs = carried(k, (across, S))
    pose = Pose.at((0, 0, height))
    K, M = np.zeros((6, 6)), np.array(robot.platform.mass_matrix)
    for limb in limbs:
        point = np.array(limb.platform_point)
        line = point + np.array([0, 0, height]) - np.array(limb.base)
        L = float(np.linalg.norm(line))
        e = line / L
        X = np.hstack([np.eye(3), np.cross(np.eye(3), point).T])
        along, side = np.outer(e, e), np.eye(3) - np.outer(e, e)
        K += k * X.T @ along @ X
        turning = m * (a**2 + (L - a) ** 2) / L**2 + 2 * own / L**2
        M += X.T @ (turning * side + m * along) @ X
    squares = np.linalg.eigvals(np.linalg.solve(M, K)).real
    expected = np.sqrt(np.sort(squares)) / (2 * math.pi)
    for model in (Substructure(2), Continuum("timoshenko"), Multipliers(2)):
        found = model.modes(robot, pose, 6).frequencies
        assert found == pytest.approx(expected, rel=1e-9)
    assert stiffness(robot, pose).matrix == pytest.approx(K, rel=1e-9, abs=1e-6 * k)


def test_a_body_that_the_platform_leaves_free_is_refused() -> None:
    robot, _ = carried(2e7, (S, S))
    with pytest.raises(InputError, match=r"limb 1 with a body, no rod and 7 free.*elastic rod"):
        Continuum().modes(robot, Pose.at((0, 0, 0.06)), 6)
