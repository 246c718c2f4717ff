"""`exudyn-ffrf` against the solid it comes from, solved whole by `ngsolve-solid`."""

import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from analytic import InputError, Limb, Material, Mechanism, Platform, Pose, Rod
from analytic.kinematics import limbs_at
from analytic.pairing import pair
from analytic.substructure import rigid_arm
from reference_models import ModelError, UnavailableError, reference
from reference_models.exudyn import system as exudyn_system
from reference_models.exudyn.ffrf import ExudynFfrf
from reference_models.solid.ngsolve import NgsolveSolid
from reference_models.solid.nodal_rod import nodal_rod

pytest.importorskip("exudyn", reason="exudyn is not installed: pip install exudyn")
pytest.importorskip("ngsolve", reason="ngsolve is not installed")

Poses = Callable[[int, int], Pose]
MESH = 1  # tetrahedra a diameter: the same for both, and the rims are finer anyway


def agrees(robot: Mechanism, pose: Pose, elements: int = MESH) -> None:
    """Within 1e-4 of the whole solid and, as a limb of fewer shapes is stiffer, not below it."""
    reduced = ExudynFfrf(elements).modes(robot, pose).frequencies
    solid = NgsolveSolid(elements).modes(robot, pose).frequencies
    error = reduced / solid - 1
    assert (error < 1e-4).all(), f"{pose}: {error}"
    assert (error > -1e-9).all(), f"{pose}: {error}"


@pytest.mark.slow
def test_both_cases_are_the_solid_rods(robot: Mechanism, case1: Pose, case2: Pose) -> None:
    for pose in (case1, case2):
        agrees(robot, pose)


@pytest.mark.slow
def test_a_finer_mesh_is_the_solid_rods(robot: Mechanism, case1: Pose) -> None:
    agrees(robot, case1, elements=3)


@pytest.mark.slow
def test_random_poses_are_the_solid_rods(robot: Mechanism, workspace_poses: Poses) -> None:
    for pose in workspace_poses(2, 6):
        agrees(robot, pose)


@pytest.mark.slow
def test_unequal_limbs_any_platform() -> None:
    steel, alloy = Material(200e9, 77e9, 7820.0), Material(70e9, 26e9, 2700.0)
    platform = Platform(20.0, ((0.3, 0.05, -0.04), (0.05, 0.4, 0.02), (-0.04, 0.02, 0.6)))
    rods = [Rod(steel, 0.05), Rod(alloy, 0.09), Rod(steel, 0.08), Rod(steel, 0.06)]
    four = Mechanism.regular(0.3, 0.2, rods[0], platform, limbs=4, heading=np.radians(20))
    limbs = (
        Limb.rps(limb.base, limb.axis, limb.platform_point, rod)
        for limb, rod in zip(four.limbs, rods, strict=True)
    )
    agrees(Mechanism(tuple(limbs), platform), Pose(0.5, np.radians(20), np.radians(8)))


@pytest.mark.slow
def test_more_modes_are_nearer(robot: Mechanism, case1: Pose) -> None:
    solid = NgsolveSolid(MESH).modes(robot, case1).frequencies
    few, some, many = (
        np.abs(ExudynFfrf(MESH, kept).modes(robot, case1).frequencies / solid - 1).max()
        for kept in (4, 12, 28)
    )
    assert few > 3 * some > 9 * many, (few, some, many)


@pytest.mark.slow
def test_shapes(robot: Mechanism, case2: Pose) -> None:
    found, solid = (model.modes(robot, case2) for model in (ExudynFfrf(MESH), NgsolveSolid(MESH)))
    paired = pair(found, solid, robot, case2)
    assert (paired.partner == np.arange(6)).all()
    assert (paired.assurance > 1 - 1e-6).all(), paired.assurance
    # Both have unit modal mass, so that only the sign is left open.
    sign = np.sign((found.platform * solid.platform).sum(axis=1))
    for name in ("platform", "limbs"):
        mine, theirs = getattr(found, name), getattr(solid, name)
        turned = theirs * sign.reshape(-1, *[1] * (theirs.ndim - 1))
        np.testing.assert_allclose(mine, turned, atol=1e-3 * np.abs(theirs).max())


def test_shapes_keep_the_joints(robot: Mechanism, case2: Pose) -> None:
    modes = ExudynFfrf(MESH).modes(robot, case2)
    size = np.abs(modes.limbs).max()
    np.testing.assert_allclose(modes.limbs[:, :, 0], 0, atol=1e-9 * size)
    arms = limbs_at(robot, case2).arms
    tips = np.stack([modes.platform @ rigid_arm(arm).T for arm in arms], axis=1)
    np.testing.assert_allclose(modes.limbs[:, :, -1], tips, atol=1e-9 * size)


def test_frame_rotation(robot: Mechanism, case2: Pose) -> None:
    turn = np.radians(37)
    pose = Pose(case2.z, case2.azimuth + turn, case2.tilt)
    turned = ExudynFfrf(MESH).modes(Mechanism.paper(heading=turn), pose)
    straight = ExudynFfrf(MESH).modes(robot, case2)
    np.testing.assert_allclose(turned.frequencies, straight.frequencies, rtol=1e-8)


def test_the_whole_rod_is_a_free_body(robot: Mechanism) -> None:
    """Rigid motions cost no force at any stretch; mass and inertia are a cylinder's."""
    rod = nodal_rod(robot.limbs[0].rod.material.poisson, MESH)
    positions, K, M = rod.stretched(1.3)
    centred = positions - [0.0, 0.0, 5 * 1.3 / 2]
    turns = [np.cross(axis, centred).ravel() for axis in np.eye(3)]
    rigid = np.stack([*np.tile(np.eye(3), (len(positions), 1)).T, *turns], axis=1)
    assert np.abs(K @ rigid).max() < 1e-12 * np.abs(K.diagonal()).max() * np.abs(rigid).max()
    mass, length = np.pi / 4 * 6.5, 6.5
    across = mass * (1 / 16 + length**2 / 12)
    inertia = np.diag([*[mass] * 3, across, across, mass / 8])
    # The section is a parabola's between nodes, not a circle's.
    np.testing.assert_allclose(rigid.T @ M @ rigid, inertia, rtol=1e-3, atol=1e-9 * mass)
    for face, z in ((rod.base, 0.0), (rod.tip, 6.5)):
        np.testing.assert_allclose(positions[face, 2], z, atol=1e-12)
        np.testing.assert_allclose(positions[face].mean(axis=0), [0, 0, z], atol=1e-12)


def test_what_is_reported(robot: Mechanism, case1: Pose) -> None:
    modes, info = ExudynFfrf(MESH, 4).modes(robot, case1, count=8), ExudynFfrf.info()
    assert modes.model == "exudyn-ffrf"
    assert modes.version.startswith(f"exudyn {info.version}, ngsolve ")
    assert modes.theory == "3-D elasticity, rigid end faces, 4 modes"
    assert (info.theory, info.missing) == ("3-D elasticity, rigid end faces", "")
    assert modes.elements == MESH
    assert modes.dofs == 6 + 3 * (6 + 6 + 4) - 3 * (5 + 3)
    assert modes.frequencies.shape == (8,)
    assert modes.limbs.shape == (8, 3, 11, 3)
    assert modes.residual is not None
    assert modes.residual < 1e-12


def test_open_joints_are_refused(
    monkeypatch: pytest.MonkeyPatch, robot: Mechanism, case1: Pose
) -> None:
    place = exudyn_system.add_platform

    def beside(exu: Any, mbs: Any, platform: Platform, o: Any, R: Any) -> tuple[int, int]:
        return place(exu, mbs, platform, o + np.array([0, 2e-3, 0]), R)  # in units of 0.5 m

    monkeypatch.setattr(exudyn_system, "add_platform", beside)
    with pytest.raises(ModelError, match=r"exudyn-ffrf: joints are open by 1\.0e-03 m"):
        ExudynFfrf(MESH).modes(robot, case1)


@pytest.mark.parametrize("program", ["exudyn", "ngsolve"])
def test_without_a_program(
    monkeypatch: pytest.MonkeyPatch, robot: Mechanism, case1: Pose, program: str
) -> None:
    monkeypatch.setitem(sys.modules, program, None)
    missing = ExudynFfrf.info().missing
    assert f"{program} is not installed; pip install" in missing or "cannot be imported" in missing
    with pytest.raises(UnavailableError, match=program):
        reference("exudyn-ffrf")
    with pytest.raises(UnavailableError, match=program):
        ExudynFfrf(MESH).modes(robot, case1)


def test_bad_input(robot: Mechanism, case1: Pose, workspace_poses: Poses) -> None:
    for elements in (0, -1, 1.5, True, "4", 7):
        with pytest.raises(InputError, match="elements"):
            ExudynFfrf(elements)  # type: ignore[arg-type]
    for kept in (0, 2.5, 101):
        with pytest.raises(InputError, match="modes_kept"):
            ExudynFfrf(MESH, kept)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="one pose at a time"):
        ExudynFfrf(MESH).modes(robot, workspace_poses(2, 5))
    with pytest.raises(InputError, match="at most"):
        ExudynFfrf(MESH).modes(robot, case1, count=100)
