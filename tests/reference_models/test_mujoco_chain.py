"""`mujoco-chain` on the installed MuJoCo; `test_mujoco.py` runs this file on 3.17.0 too."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from analytic import InputError, Limb, Material, Mechanism, Platform, Pose, Rod, Substructure
from analytic.kinematics import limbs_at
from analytic.pairing import mass_vectors, pair
from analytic.substructure import rigid_arm
from reference_models import ModelError, UnavailableError, reference
from reference_models.mujoco import system as mujoco_system
from reference_models.mujoco.chain import MujocoChain

mujoco = pytest.importorskip("mujoco")
linearise = pytest.importorskip("reference_models.mujoco.linearise")

BEAMS = ("euler-bernoulli", "rayleigh")
REFINED = MujocoChain.info().refinements
# f1-f3, f4-f6. Extrapolation leaves h^4: from 8 and 16 segments 1e-5, 1.5e-4 in 30 poses, from 12
# and 24 a fifth of that.
TOLERANCE = [5e-6] * 3 + [5e-5] * 3

Poses = Callable[[int, int], Pose]


def agrees(robot: Mechanism, pose: Pose, beam: str) -> None:
    chain = reference("mujoco-chain", elements=REFINED, beam=beam).modes(robot, pose)
    theory = Substructure(16, beam).modes(robot, pose)
    error = np.abs(chain.frequencies / theory.frequencies - 1)
    assert (error < TOLERANCE).all(), f"{beam}, {pose}: {error}"


@pytest.mark.parametrize("beam", BEAMS)
def test_extrapolated_meets_its_theory(robot: Mechanism, workspace_poses: Poses, beam: str) -> None:
    for pose in workspace_poses(3, 1):
        agrees(robot, pose, beam)


@pytest.mark.slow
@pytest.mark.parametrize("beam", BEAMS)
def test_extrapolated_meets_its_theory_everywhere(
    robot: Mechanism, workspace_poses: Poses, beam: str
) -> None:
    for pose in workspace_poses(30, 2):
        agrees(robot, pose, beam)


@pytest.mark.parametrize("beam", BEAMS)
def test_observed_order(robot: Mechanism, case2: Pose, beam: str) -> None:
    limit = Substructure(32, beam).modes(robot, case2).frequencies
    coarse, fine = (
        np.abs(MujocoChain(n, beam).modes(robot, case2).frequencies - limit) for n in (12, 24)
    )
    np.testing.assert_allclose(np.log2(coarse / fine), MujocoChain.info().order, atol=0.06)


def test_stiffness_is_that_of_the_springs(robot: Mechanism, case2: Pose) -> None:
    """K against the forces MuJoCo computes in moved positions: no spring couples coordinates."""
    made = MujocoChain(2)._assembly(robot, case2)
    model = linearise.compiled(made.document)
    data = linearise.at_rest(model)
    K, step = np.zeros((model.nv, model.nv)), 1e-6
    for i in range(model.nv):
        for sign in (1, -1):
            data.qpos[:] = model.qpos0
            mujoco.mj_integratePos(model, data.qpos, sign * step * np.eye(model.nv)[i], 1.0)
            mujoco.mj_fwdPosition(model, data)
            mujoco.mj_passive(model, data)
            K[:, i] -= sign * data.qfrc_passive / (2 * step)
    np.testing.assert_allclose(made.stiffness(model, data), K, atol=1e-9 * K.max())


@pytest.mark.parametrize("beam", BEAMS)
def test_shapes(robot: Mechanism, case2: Pose, beam: str, workspace_poses: Poses) -> None:
    for pose in (case2, *workspace_poses(2, 3)):
        found = MujocoChain(16, beam).modes(robot, pose)
        exact = Substructure(16, beam).modes(robot, pose, 7)
        pairing = pair(found, exact, robot, pose)
        assert (pairing.assurance > 0.999).all(), pairing.assurance
        # Unit modal mass: so says the mass of the reported shapes, by Simpson's rule.
        sizes = [np.linalg.norm(mass_vectors(m, robot, pose), axis=1) for m in (found, exact)]
        np.testing.assert_allclose(sizes[0], sizes[1][pairing.partner], rtol=0.005)


def test_shapes_keep_the_joints(robot: Mechanism, case2: Pose) -> None:
    modes = MujocoChain(6).modes(robot, case2)
    limbs = limbs_at(robot, case2)
    np.testing.assert_allclose(modes.limbs[:, :, 0], 0, atol=1e-12)
    tips = np.stack([modes.platform @ rigid_arm(arm).T for arm in limbs.arms], axis=1)
    np.testing.assert_allclose(modes.limbs[:, :, -1], tips, atol=1e-9)


@pytest.mark.parametrize("degrees", [37, 90, 180])
def test_frame_rotation(robot: Mechanism, case2: Pose, degrees: float) -> None:
    turn = np.radians(degrees)
    pose = Pose(case2.z, case2.azimuth + turn, case2.tilt)
    turned = MujocoChain(6).modes(Mechanism.paper(heading=turn), pose)
    straight = MujocoChain(6).modes(robot, case2)
    np.testing.assert_allclose(turned.frequencies, straight.frequencies, rtol=1e-9)
    z = np.abs(straight.platform[:, 2])
    np.testing.assert_allclose(np.abs(turned.platform[:, 2]), z, atol=1e-6 * z.max())


STEEL, ALLOY = Material(200e9, 77e9, 7820.0), Material(70e9, 26e9, 2700.0)
SKEW = Platform(20.0, ((0.3, 0.05, -0.04), (0.05, 0.4, 0.02), (-0.04, 0.02, 0.6)))


@pytest.mark.parametrize("beam", BEAMS)
def test_four_unequal_limbs(beam: str) -> None:
    four = Mechanism.regular(0.3, 0.2, Rod(STEEL, 0.05), SKEW, limbs=4, heading=np.radians(20))
    rods = [Rod(STEEL, 0.05), Rod(ALLOY, 0.09), Rod(STEEL, 0.08), Rod(ALLOY, 0.06)]
    limbs = (
        Limb.rps(limb.base, limb.axis, limb.platform_point, rod)
        for limb, rod in zip(four.limbs, rods, strict=True)
    )
    pose = Pose(0.5, np.radians(20), np.radians(8))
    agrees(Mechanism(tuple(limbs), SKEW), pose, beam)


def test_torsion_is_the_rods(robot: Mechanism, case1: Pose) -> None:
    """Upright limbs twist on their own: fixed-free, f = sqrt(G / rho) / (4 L), above f1-f6."""
    upright = Mechanism.regular(0.3, 0.3, robot.limbs[0].rod, SKEW)
    material = robot.limbs[0].rod.material
    torsion = np.sqrt(material.shear / material.density) / (4 * 0.6)
    chain = reference("mujoco-chain", elements=(8, 16)).modes(upright, Pose(0.6), count=14)
    found = np.abs(chain.frequencies / torsion - 1) < 1e-4
    assert found.sum() == 3, chain.frequencies


def test_what_is_reported(robot: Mechanism, case2: Pose) -> None:
    modes, info = MujocoChain(8).modes(robot, case2, count=9), MujocoChain.info()
    assert (info.theory, info.program, info.missing) == ("Euler-Bernoulli", "MuJoCo", "")
    assert modes.theory == info.theory
    assert MujocoChain(2, "rayleigh").modes(robot, case2).theory == "Rayleigh"
    assert modes.model == "mujoco-chain"
    assert modes.version == f"mujoco {info.version}"
    assert modes.frequencies.shape == (9,)
    assert modes.platform.shape == (9, 6)
    assert modes.limbs.shape == (9, 3, 11, 3)
    assert modes.elements == 8
    assert modes.dofs == 6 + 3 * (1 + 4 * 8) - 9
    assert modes.residual is not None
    assert modes.residual < 1e-12


def test_open_joints_are_refused(
    robot: Mechanism, case2: Pose, monkeypatch: pytest.MonkeyPatch
) -> None:
    compiled = linearise.compiled

    def shifted(text: str) -> Any:
        model = compiled(text)
        model.qpos0[0] += 2e-3  # in units of 0.5 m
        return model

    monkeypatch.setattr(linearise, "compiled", shifted)
    with pytest.raises(ModelError, match=r"mujoco-chain: joints are open by 1\.0e-03 m"):
        MujocoChain(4).modes(robot, case2)


def test_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mujoco_system, "installed", lambda: "")
    with pytest.raises(UnavailableError, match="not installed"):
        reference("mujoco-chain")


def test_bad_input(robot: Mechanism, case2: Pose, workspace_poses: Poses) -> None:
    for elements in (1, 0, 2.5, True, "8"):
        with pytest.raises(InputError, match="elements"):
            MujocoChain(elements)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="beam"):
        MujocoChain(4, "timoshenko")
    with pytest.raises(InputError, match="one pose at a time"):
        MujocoChain(4).modes(robot, workspace_poses(2, 5))
    with pytest.raises(InputError, match="at most"):
        MujocoChain(2).modes(robot, case2, count=100)
