"""The simulators' own geometry, against the analytic model's and against what joints demand."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from analytic import InputError, Limb, Mechanism, Pose, limbs_at
from reference_models import ModelError, chain_placement
from reference_models.exudyn import system
from reference_models.exudyn.cable import ExudynCable
from reference_models.mujoco import chain, rig
from reference_models.mujoco.cable import MujocoCable
from reference_models.mujoco.chain import MujocoChain
from reference_models.placement import Placement, largest_gap, place
from reference_models.solid import calculix_deck, ngsolve
from reference_models.solid.calculix import CalculixSolid
from reference_models.solid.ngsolve import NgsolveSolid

Poses = Callable[[int, int], Pose]


def test_two_ways_to_place_the_platform_agree(robot: Mechanism, workspace_poses: Poses) -> None:
    """Elementary rotations and the joints' conditions; Eqs. 1 to 3."""
    poses = workspace_poses(50, 61)
    own, eqs = place(robot, poses), limbs_at(robot, poses)
    np.testing.assert_allclose(own.rotation, eqs.rotation, atol=1e-14)
    np.testing.assert_allclose(own.centre, eqs.centre, atol=1e-14)
    np.testing.assert_allclose(own.arms, eqs.arms, atol=1e-14)
    np.testing.assert_allclose(own.lengths, eqs.lengths, rtol=1e-13)
    np.testing.assert_allclose(own.frames, eqs.frames, atol=1e-13)


@given(
    st.floats(0.3, 0.9), st.floats(-3, 3), st.floats(-0.4, 0.4), st.sampled_from([1e-3, 1.0, 1e3])
)
def test_joints_close_along_the_axes_as_given(
    z: float, azimuth: float, tilt: float, size: float
) -> None:
    paper = Mechanism.paper()
    limbs = tuple(
        Limb.rps(
            tuple(size * x for x in limb.base),  # type: ignore[arg-type]
            limb.axis,
            tuple(size * x for x in limb.platform_point),  # type: ignore[arg-type]
            limb.rod,
        )
        for limb in paper.limbs
    )
    robot = replace(paper, limbs=limbs)
    placed = place(robot, Pose(z * size, azimuth, tilt))
    assert largest_gap(robot, placed.tips) < 1e-15 * size
    # The platform's normal leans by the tilt towards the azimuth, and does not turn about itself.
    normal = [np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)]
    np.testing.assert_allclose(placed.rotation[:, 2], normal, atol=1e-15)
    assert placed.rotation[0, 1] == pytest.approx(placed.rotation[1, 0], abs=1e-15)


def test_what_cannot_close_is_named(robot: Mechanism) -> None:
    first = robot.limbs[0]
    skewed = Limb.rps(first.base, (1.0, 1.0, 0.0), first.platform_point, first.rod)
    with pytest.raises(InputError, match=r"not 3\.2e-02 m beside it"):
        place(replace(robot, limbs=(skewed, *robot.limbs[1:])), Pose(0.49, 0, 0.2))
    flat = Mechanism.regular(0.2, 0.2, first.rod, robot.platform)
    with pytest.raises(InputError, match="limbs of some length"):
        place(flat, Pose(0.0))


SIMULATORS = [
    pytest.param(ExudynCable(2), system, id="exudyn"),
    pytest.param(MujocoCable(3), rig, id="mujoco"),
    pytest.param(NgsolveSolid(1, 1), ngsolve, id="ngsolve"),
]


@pytest.mark.parametrize(("model", "where"), SIMULATORS)
def test_a_platform_beside_its_joints_is_refused(
    robot: Mechanism, case2: Pose, monkeypatch: pytest.MonkeyPatch, model: Any, where: Any
) -> None:
    """10 mm beside: the simulators turn the axis with the limb, and see nothing themselves."""
    if missing := model.info().missing:
        pytest.skip(missing)

    def beside(mechanism: Mechanism, pose: Pose) -> Placement:
        right = place(mechanism, pose)
        centre = right.centre + np.array([0.02, 0, 0])  # in units of 0.5 m
        tips = centre + right.arms
        spans = tips - mechanism.bases
        lengths = np.linalg.norm(spans, axis=-1)
        along = spans / lengths[:, None]
        about = mechanism.axes - along * (along * mechanism.axes).sum(axis=-1)[:, None]
        about /= np.linalg.norm(about, axis=-1)[:, None]
        return Placement(centre, right.rotation, right.arms, tips, along, about, lengths)

    monkeypatch.setattr(where, "place", beside)
    gap = 0.01 * np.abs(robot.axes[:, 0]).max()
    with pytest.raises(ModelError, match=f"joints are open by {gap:.1e} m"):
        model.modes(robot, case2)


@pytest.mark.parametrize(
    ("model", "where"),
    [
        pytest.param(MujocoChain(3), chain, id="mujoco-chain"),
        pytest.param(CalculixSolid(2), calculix_deck, id="calculix"),
    ],
)
def test_chains_beside_their_hinges_are_refused(
    robot: Mechanism, case2: Pose, monkeypatch: pytest.MonkeyPatch, model: Any, where: Any
) -> None:
    if missing := model.info().missing:
        pytest.skip(missing)

    def beside(mechanism: Mechanism, pose: Pose) -> Any:
        o, R, _ = chain_placement.stand(mechanism, pose)
        o = o + np.array([0.02, 0, 0])
        every = range(1, len(mechanism.limbs) + 1)
        return o, R, [chain_placement._stand(i, mechanism, o, R, pose) for i in every]

    monkeypatch.setattr(where, "stand", beside)
    gap = 0.01 * np.abs(robot.axes[:, 0]).max()
    with pytest.raises(ModelError, match=f"joints are open by {gap:.1e} m"):
        model.modes(robot, case2)


def test_chains_stand_where_the_simple_limbs_do(robot: Mechanism, workspace_poses: Poses) -> None:
    for pose in workspace_poses(5, 62):
        own, (o, R, limbs) = place(robot, pose), chain_placement.stand(robot, pose)
        np.testing.assert_allclose(o, own.centre, atol=1e-14)
        np.testing.assert_allclose(R, own.rotation, atol=1e-14)
        np.testing.assert_allclose([limb.frame for limb in limbs], own.frames, atol=1e-13)
        np.testing.assert_allclose([limb.starts[-1] for limb in limbs], own.tips, atol=1e-14)


def test_chains_that_cannot_close_are_named(robot: Mechanism) -> None:
    first = robot.limbs[0]
    skewed = Limb.rps(first.base, (1.0, 1.0, 0.0), first.platform_point, first.rod)
    with pytest.raises(InputError, match=r"not A_1 3\.2e-02 m beside it"):
        chain_placement.stand(replace(robot, limbs=(skewed, *robot.limbs[1:])), Pose(0.49, 0, 0.2))
    flat = Mechanism.regular(0.2, 0.2, first.rod, robot.platform)
    with pytest.raises(InputError, match="limbs of some length, not that of A_1"):
        chain_placement.stand(flat, Pose(0.0))
