"""Counts of modes at many poses: beside the certified count at one, and assembled matrices."""

import numpy as np
import pytest

from analytic import Continuum, InputError, Mechanism, Pose, Substructure
from analytic.mode_counts import CHUNK, mode_counts


def poses(count: int) -> Pose:
    z, azimuth, tilt = np.random.default_rng(2).uniform([[0.35], [-3], [0]], [[0.7], [3], [0.3]],
                                                        (3, count))  # fmt: skip
    return Pose(z, azimuth, tilt)


@pytest.mark.parametrize("beam", ["euler-bernoulli", "rayleigh", "timoshenko"])
def test_as_many_as_at_one_pose(beam: str, robot: Mechanism) -> None:
    """Up to frequencies where limbs twist and stretch; more counts than fit into a chunk."""
    some, model = poses(CHUNK // 4), Continuum(beam)
    hertz = np.random.default_rng(3).uniform(50, 6000, (len(some), 5))
    found = mode_counts(robot, some, hertz, beam=beam)
    assert found.min() == 0 and found.max() > 30
    for i in (0, 1, CHUNK // 5, CHUNK // 4 - 1):
        alone = [model.count_below(robot, some[i], f) for f in hertz[i].tolist()]
        assert found[i].tolist() == alone


def test_as_many_as_assembled_matrices_have(robot: Mechanism) -> None:
    some = poses(5)
    hertz = np.random.default_rng(4).uniform(50, 6000, (5, 40))
    found = mode_counts(robot, some, hertz, 3, beam="timoshenko")
    for pose, own, counts in zip(some, hertz, found, strict=True):
        modes = Substructure(3, "timoshenko").modes(robot, pose, 30).frequencies
        low = own < modes[-1]
        np.testing.assert_array_equal(counts[low], (modes[:, None] < own[low]).sum(axis=0))


def test_a_pose_out_of_reach_is_refused(robot: Mechanism) -> None:
    flat = Mechanism.regular(0.2, 0.2, robot.limbs[0].rod, robot.platform)
    with pytest.raises(InputError, match="pose"):
        mode_counts(flat, Pose(np.zeros(2)), np.ones((2, 1)))
