"""The exact limits against simulators that know nothing of them, over the workspace."""

from collections.abc import Callable

import numpy as np
import pytest

from analytic import Continuum, Mechanism, Pose
from reference_models import reference

PoseSet = Callable[[int, int], Pose]


@pytest.mark.slow
def test_euler_bernoulli_is_the_limit_of_the_cable(
    robot: Mechanism, workspace_poses: PoseSet
) -> None:
    cable, exact = reference("exudyn-cable", elements=20), Continuum()
    for pose in workspace_poses(50, 41):
        found, limit = (model.modes(robot, pose).frequencies for model in (cable, exact))
        np.testing.assert_allclose(found, limit, rtol=1e-6)


@pytest.mark.slow
def test_timoshenko_is_the_limit_of_the_beam(robot: Mechanism, workspace_poses: PoseSet) -> None:
    beam = reference("exudyn-beam", elements=(12, 24), shear="6/7")
    exact = Continuum("timoshenko", "6/7")
    for pose in workspace_poses(50, 42):
        found, limit = (model.modes(robot, pose).frequencies for model in (beam, exact))
        np.testing.assert_allclose(found, limit, rtol=3e-4)
