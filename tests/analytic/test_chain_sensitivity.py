"""Derivatives of frequencies of limbs of any chain."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from analytic import Continuum, InputError, Mechanism, Pose
from analytic.chain_sensitivity import chain_sensitivities
from analytic.sensitivity import frequency_sensitivities
from analytic.theory import Theory
from harness.case_file import load_cases

CASES = load_cases(Path(__file__).parents[2] / "results" / "published" / "mechanisms.toml")


@pytest.mark.parametrize("elements", [None, 3])
def test_of_the_papers_limbs_they_are_the_exact_derivatives(elements: int | None) -> None:
    robot, pose = Mechanism.paper(), Pose(0.49, 0.3, -0.2)
    names = ["z", "azimuth", "tilt", "young", "density", "diameter", "mass", "base_radius"]
    exact = frequency_sensitivities(robot, pose, names, elements, beam="timoshenko")
    pairs: list[tuple[str, int | None]] = [(name, None) for name in names]
    found = chain_sensitivities(robot, pose, pairs, elements, Theory("timoshenko"), 6)
    assert (np.abs(found - exact).max(axis=0) < 1e-8 * np.abs(exact).max(axis=0)).all()


def test_of_a_hexapod_they_are_the_slopes_of_its_frequencies() -> None:
    case = CASES["hexapod"]
    names = ["z", "mass", "stiffness", *(f"stiffness[{i}]" for i in range(6))]
    found = frequency_sensitivities(case.mechanism, case.pose, names)
    ends = [
        Continuum().modes(case.mechanism, replace(case.pose, z=case.pose.z + step), 6).frequencies
        for step in (-1e-5, 1e-5)
    ]
    assert found[:, 0] == pytest.approx((ends[1] - ends[0]) / 2e-5, rel=1e-5)
    assert (found[:, 1] < 0).all()
    assert (found[:, 2] > 0).all()
    assert found[:, 3:].sum(axis=1) == pytest.approx(found[:, 2], rel=1e-6)


def test_repeated_modes_share_their_derivatives() -> None:
    case = CASES["hexapod-home"]
    found = frequency_sensitivities(case.mechanism, case.pose, ["z", "mass"], count=5)
    assert found[0] == pytest.approx(found[1], rel=1e-6)


@pytest.mark.parametrize("name", ["foo", "young[7]", "mass[1]"])
def test_unknown_parameters_are_refused(name: str) -> None:
    case = CASES["hexapod"]
    with pytest.raises(InputError, match="stiffness"):
        frequency_sensitivities(case.mechanism, case.pose, [name])


def test_what_the_pose_does_not_say_cannot_change() -> None:
    case = CASES["rps-real"]
    with pytest.raises(InputError, match="the pose says"):
        frequency_sensitivities(case.mechanism, case.pose, ["x"])
