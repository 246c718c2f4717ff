"""One pose, written for one: the numbers of many, and nothing that is not certain."""

from typing import Any

import numpy as np
import pytest

from analytic import (
    Continuum,
    InputError,
    Material,
    Mechanism,
    Platform,
    Pose,
    Rod,
    Substructure,
    condensed_frequencies,
    limbs_at,
    single,
)
from analytic.reduced import constants
from analytic.theory import Theory

THEORIES = [("euler-bernoulli", "cowper"), ("rayleigh", "cowper"), ("timoshenko", 0.9)]


def alone(
    mechanism: Mechanism,
    pose: Pose,
    elements: int | None = None,
    beam: str = "euler-bernoulli",
    shear: Any = "cowper",
    *,
    count: int = 6,
    torsion: bool = True,
) -> Any:
    known = constants(mechanism, Theory(beam, shear))
    omega2 = single.lowest(known, limbs_at(mechanism, pose), elements, count, torsion=torsion)
    return None if omega2 is None else np.sqrt(omega2) / (2 * np.pi)


@pytest.mark.parametrize(("beam", "shear"), THEORIES)
@pytest.mark.parametrize("elements", [1, 3, 64, None])
def test_equals_the_full_model(
    robot: Mechanism, workspace_poses: Any, beam: str, shear: Any, elements: int | None
) -> None:
    full = Continuum(beam, shear) if elements is None else Substructure(elements, beam, shear)
    answered = 0
    for pose in workspace_poses(8, 31):
        found = alone(robot, pose, elements, beam, shear)
        expected = full.modes(robot, pose).frequencies
        if found is not None:
            answered += 1
            np.testing.assert_allclose(found, expected, rtol=1e-9)
        again = condensed_frequencies(robot, pose, elements, beam=beam, shear=shear)
        np.testing.assert_allclose(again, expected, rtol=1e-9)
    assert answered >= 5


def test_the_papers_poses_need_no_other_way(robot: Mechanism) -> None:
    for pose in (Pose(0.49, 0.0, np.radians(10)), Pose(0.5, 0.3, 0.2), Pose(0.61, -2.0, 0.1)):
        assert alone(robot, pose) is not None


def test_what_the_count_contradicts_is_left_to_the_others(
    robot: Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    pose = Pose(0.5, 0.3, 0.2)
    expected = Continuum().modes(robot, pose).frequencies
    count = single.Single.below
    monkeypatch.setattr(single.Single, "below", lambda self, at: count(self, at) + 1)
    assert alone(robot, pose) is None
    np.testing.assert_allclose(condensed_frequencies(robot, pose), expected, rtol=1e-9)


def test_a_root_that_is_wrong_is_not_counted_right(
    robot: Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The sixth moved up to the seventh, or down to the fifth: the count tells both."""
    pose = Pose(0.5, 0.3, 0.2)
    seven = Continuum().modes(robot, pose, 7).frequencies
    omega2 = (2 * np.pi * seven) ** 2
    corrected = single._corrected
    for wrong in (omega2[6], omega2[5] * (1 - 1e-6), omega2[4] * (1 + 1e-6)):

        def moved(problem: Any, count: int, wrong: float = wrong) -> Any:
            found, largest = corrected(problem, count) or ([], 0.0)
            return [*found[:-1], wrong], largest

        monkeypatch.setattr(single, "_corrected", moved)
        assert alone(robot, pose, torsion=False) is None


def test_torsion_among_the_modes_is_left_to_the_others(robot: Mechanism) -> None:
    pose = Pose(0.2, 0.3, 0.1)
    still = alone(robot, pose, torsion=False)
    assert alone(robot, pose) is None
    found = condensed_frequencies(robot, pose)
    np.testing.assert_allclose(found, Continuum().modes(robot, pose).frequencies, rtol=1e-9)
    assert still is None or (found <= still * (1 + 1e-9)).all()


@pytest.mark.parametrize("tilt", [0.0, 1e-15, 1e-12, 1e-9, 1e-7])
def test_repeated_modes_are_right_or_left(robot: Mechanism, tilt: float) -> None:
    for count in (1, 2, 5, 6):
        pose = Pose(0.49, 0.3, tilt)
        found = alone(robot, pose, count=count)
        expected = Continuum().modes(robot, pose, count).frequencies
        if found is not None:
            np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_unlike_limbs_and_few_limbs() -> None:
    steel, plate = Material(200e9, 77e9, 7820), Platform.disc(0.2, 0.02, 7820)
    four = Mechanism.regular(0.3, 0.2, Rod(steel, 0.05), plate, limbs=4)
    mixed = Mechanism((four.limbs[0].with_rod(Rod(steel, 0.04)), *four.limbs[1:]), plate)
    pose = Pose(0.5)
    assert alone(mixed, pose) is None
    for mechanism in (four, mixed):
        expected = Continuum().modes(mechanism, pose).frequencies
        np.testing.assert_allclose(condensed_frequencies(mechanism, pose), expected, rtol=1e-9)


@pytest.mark.parametrize("x", [None, 0.01])
def test_limbs_at_one_pose_are_those_at_many(robot: Mechanism, x: float | None) -> None:
    mechanism = Mechanism.regular(
        0.3, 0.2, robot.limbs[0].rod, robot.platform, limbs=1 if x else 3, heading=0.4
    )
    y = None if x is None else x * np.tan(0.4)
    pose = Pose(0.5, 0.4, 0.2, 0.0, x, y)
    many = limbs_at(mechanism, Pose.stacked([pose, pose]))
    for name, value in vars(limbs_at(mechanism, pose)).items():
        np.testing.assert_allclose(value, getattr(many, name)[0], rtol=0, atol=1e-15)


def test_one_pose_is_refused_as_many_are(robot: Mechanism) -> None:
    for pose in (Pose(0.5, 0.3, 0.2, 0.1), Pose(0.5, 0.0, 0.0, 0.0, 0.1, 0.0), Pose(1e4)):
        with pytest.raises(InputError) as one:
            limbs_at(robot, pose)
        with pytest.raises(InputError) as many:
            limbs_at(robot, Pose.stacked([pose]))
        assert str(one.value) == str(many.value)


def test_equal_mechanisms_have_one_hash_and_unlike_ones_their_own_answers() -> None:
    assert hash(Mechanism.paper()) == hash(Mechanism.paper())
    thick, thin = (
        Mechanism(tuple(limb.with_rod(Rod(limb.rod.material, d)) for limb in m.limbs), m.platform)
        for m, d in ((Mechanism.paper(), 0.1), (Mechanism.paper(), 0.05))
    )
    assert thick != thin
    first, second = (condensed_frequencies(m, Pose(0.5, 0.3, 0.2)) for m in (thick, thin))
    assert (first > 1.5 * second).all()
