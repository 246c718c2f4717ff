"""Limbs of rigid links, joints and springs: a stiffness at the platform."""

import math

import numpy as np
import pytest

from analytic import (
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
