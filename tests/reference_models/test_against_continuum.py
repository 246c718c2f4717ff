"""The exact limits against simulators that know nothing of them, over the workspace."""

from collections.abc import Callable

import numpy as np
import pytest

from analytic import Continuum, Mechanism, Pose, limbs_at
from reference_models import Named, UnavailableError, reference

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


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "elements"),
    [
        ("exudyn-cable", 8),
        ("exudyn-beam", 12),
        ("exudyn-ffrf", 1),
        ("mujoco-cable", 32),  # on MuJoCo 3 of first order
        ("mujoco-chain", 16),
        ("calculix-solid", 2),
        ("ngsolve-solid", 1),
        ("ngsolve-averaged", 1),
    ],
)
def test_limbs_twist_where_the_model_says_so(robot: Mechanism, name: str, elements: int) -> None:
    """The two longest limbs twist at sqrt(G / rho) / 4 L, below other modes, or not at all."""
    pose = Pose(0.22, 5.8, 0.19)
    try:
        modes = reference(name, elements).modes(robot, pose, 9)
    except UnavailableError as reason:
        pytest.skip(str(reason))
    rod = robot.limbs[0].rod.material
    twist = np.sqrt(rod.shear / rod.density) / 4 / np.sort(limbs_at(robot, pose).lengths)[:0:-1]
    amplitude = np.abs(modes.limbs).max(axis=(1, 2, 3))
    still = modes.frequencies[amplitude < 1e-3 * amplitude.max()]
    if Named(name, None).info().torsion:
        np.testing.assert_allclose(still[:2], twist, rtol=0.02)
    else:
        assert not still.size
