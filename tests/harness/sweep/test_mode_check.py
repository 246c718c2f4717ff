"""Modes that a simulator misses, repeats or makes up, found by counting."""

import numpy as np
import pytest
from numpy.typing import NDArray

from analytic import Mechanism, Pose, condensed_frequencies, limbs_at
from harness.sweep.error_map import check_modes
from harness.sweep.pose_sets import pose_set

THEORY = {"elements": None, "beam": "timoshenko", "shear": "cowper"}


@pytest.fixture(scope="module")
def poses(robot: Mechanism) -> Pose:
    return pose_set("random:60:4", robot)


@pytest.fixture(scope="module")
def exact(robot: Mechanism, poses: Pose) -> NDArray[np.float64]:
    return condensed_frequencies(robot, poses, beam="timoshenko", count=8)


def test_a_good_simulator_has_as_many_modes_as_its_theory(
    robot: Mechanism, poses: Pose, exact: NDArray[np.float64]
) -> None:
    """With errors of 0.1 %; gaps too small for that are left out, and only those."""
    found = exact[:, :6] * np.random.default_rng(1).uniform(0.999, 1.001, (60, 6))
    check = check_modes(found, robot, poses, THEORY)
    assert not check.wrong.any()
    wide = np.diff(exact[:, :7]) > 0.01 * exact[:, 1:7]
    assert check.counted[wide].all()
    assert 0.9 < check.counted.mean() < 1


@pytest.mark.parametrize("missed", range(6))
def test_a_mode_that_is_missed_shows_at_every_pose(
    robot: Mechanism, poses: Pose, exact: NDArray[np.float64], missed: int
) -> None:
    found = 1.0001 * np.delete(exact[:, :7], missed, axis=1)
    check = check_modes(found, robot, poses, THEORY)
    assert check.wrong.any(axis=1).all()
    assert not check.wrong[:, :missed].any()


@pytest.mark.parametrize("at", [0.0, 1.0001, 1.05])
def test_a_mode_too_many_shows_at_every_pose(
    robot: Mechanism, poses: Pose, exact: NDArray[np.float64], at: float
) -> None:
    """Free motion, a mode found twice, and one that belongs to nothing; all beside the third."""
    found = np.sort(np.insert(exact[:, :5], 3, at * exact[:, 2], axis=1), axis=1)
    assert check_modes(found, robot, poses, THEORY).wrong.any(axis=1).all()


def test_repeated_modes_are_not_told_apart(robot: Mechanism) -> None:
    level = Pose(np.linspace(0.4, 0.6, 20))
    found = condensed_frequencies(robot, level, beam="timoshenko") * (1 - 1e-5)
    check = check_modes(found, robot, level, THEORY)
    assert not check.wrong.any()
    assert check.counted.tolist() == [[False, True, True, True, False, True]] * 20


def test_rods_that_cannot_twist_are_counted_without_torsion(robot: Mechanism) -> None:
    """Short limbs twist at a lower frequency than they bend: below the sixth mode at 200 mm."""
    short = pose_set("random:40:3:z=190..210,tilt=5", robot)
    exact = condensed_frequencies(robot, short, beam="timoshenko", count=12)
    twist = 0.25 * np.sqrt(77e9 / 7820) / np.stack([limbs_at(robot, p).lengths for p in short])
    is_twist = (np.abs(exact[:, :, None] / twist[:, None, :] - 1) < 1e-9).any(axis=2)
    assert is_twist[:, :6].any(axis=1).all()
    rigid = np.stack([row[~own][:6] for row, own in zip(exact, is_twist, strict=True)])
    assert check_modes(1.0001 * rigid, robot, short, THEORY).wrong.any(axis=1).all()
    check = check_modes(1.0001 * rigid, robot, short, THEORY, torsion=False)
    assert check.counted.mean() > 0.5 and not check.wrong.any()
    worse = check_modes(np.delete(rigid, 1, axis=1), robot, short, THEORY, torsion=False)
    assert worse.wrong.any(axis=1).all()
