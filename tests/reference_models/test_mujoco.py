"""`mujoco-cable` on the installed MuJoCo, 4 or 3; the last test runs it on 3.17.0 too."""

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from analytic import (
    InputError,
    Limb,
    Material,
    Mechanism,
    Platform,
    Pose,
    Rod,
    Substructure,
    limbs_at,
)
from analytic.pairing import mass_vectors, pair
from analytic.substructure import rigid_arm
from reference_models import ModelError, UnavailableError, reference
from reference_models.mujoco import system as mujoco_system
from reference_models.mujoco.cable import MujocoCable
from reference_models.projection import constrained_modes

mujoco = pytest.importorskip("mujoco")
linearise = pytest.importorskip("reference_models.mujoco.linearise")

FLEX = int(mujoco.__version__.split(".")[0]) >= 4
BEAM = "euler-bernoulli" if FLEX else "rayleigh"
REFINED = (8, 16) if FLEX else (16, 32)
# f1-f3, f4-f6. A first-order model's extrapolation leaves the second order: 1.4e-3 here.
TOLERANCE = [1e-4] * 3 + [5e-4] * 3 if FLEX else [3e-3] * 6
SECOND, SECOND_MARK = "3.17.0", "RPS_BENCH_SECOND_MUJOCO"

Poses = Callable[[int, int], Pose]


def limit(robot: Mechanism, pose: Pose) -> NDArray[np.float64]:
    """What the cable converges to: the paper's model of the same theory.

    MuJoCo 3's cable cannot stretch, and its cylinders have the inertia of the rod's sections, so
    there it is Rayleigh's beam with no node of a limb moving along the limb: z_i . u = 0.
    """
    s = 16
    model = Substructure(s, BEAM)
    if FLEX:
        return model.modes(robot, pose).frequencies
    K, M = (matrix.toarray() for matrix in model.matrices(robot, pose))
    limbs = limbs_at(robot, pose)
    rows = np.zeros((len(robot.limbs), s, len(K)))
    for i, (frame, arm) in enumerate(zip(limbs.frames, limbs.arms, strict=True)):
        for node in range(1, s):  # columns of a limb: angle at B_i, six an inner node, Phi_Ai
            first = i * (6 * s - 2) + 1 + 6 * (node - 1)
            rows[i, node, first : first + 3] = frame[:, 2]
        rows[i, 0, -6:] = frame[:, 2] @ rigid_arm(arm)
    return constrained_modes("limit", K, M, rows.reshape(-1, len(K)), 6)[0]


def agrees(robot: Mechanism, pose: Pose, refined: tuple[int, int] = REFINED) -> None:
    found = reference("mujoco-cable", elements=refined).modes(robot, pose)
    error = np.abs(found.frequencies / limit(robot, pose) - 1)
    assert (error < TOLERANCE).all(), f"{pose}: {error}"


def test_extrapolated_meets_its_theory(robot: Mechanism, workspace_poses: Poses) -> None:
    for pose in workspace_poses(4, 1):
        agrees(robot, pose)


@pytest.mark.slow
def test_extrapolated_meets_its_theory_everywhere(robot: Mechanism, workspace_poses: Poses) -> None:
    for pose in workspace_poses(30, 2):
        agrees(robot, pose)


def test_observed_order(robot: Mechanism, case2: Pose) -> None:
    meshes = (8, 16, 32) if FLEX else (16, 32, 64)
    found = [MujocoCable(n).modes(robot, case2).frequencies for n in meshes]
    coarse, middle, fine = (np.abs(f - limit(robot, case2)) for f in found)
    order = MujocoCable.info().order
    assert order == (2 if FLEX else 1)
    for observed in (np.log2(coarse / middle), np.log2(middle / fine)):
        np.testing.assert_allclose(observed, order, atol=0.12)


def test_error_comes_from_the_known_side(robot: Mechanism, case2: Pose) -> None:
    """Lumped mass lowers the flex's frequencies; a stiff first element raises the composite's."""
    error = MujocoCable(8).modes(robot, case2).frequencies - limit(robot, case2)
    assert (error < 0).all() if FLEX else (error > 0).all()


def check_shapes(robot: Mechanism, pose: Pose) -> None:
    found = MujocoCable(16).modes(robot, pose)
    exact = Substructure(16, BEAM).modes(robot, pose, 7)
    pairing = pair(found, exact, robot, pose)
    assert (pairing.assurance > (0.99 if FLEX else 0.97)).all(), pairing.assurance
    # Unit modal mass: so says the mass of the reported shapes, by Simpson's rule.
    sizes = [np.linalg.norm(mass_vectors(m, robot, pose), axis=1) for m in (found, exact)]
    np.testing.assert_allclose(sizes[0], sizes[1][pairing.partner], rtol=0.005 if FLEX else 0.02)
    np.testing.assert_allclose(sizes[0], 1, rtol=0.03)  # but for the sections' rotary inertia


def test_shapes(robot: Mechanism, case2: Pose, workspace_poses: Poses) -> None:
    for pose in (case2, *workspace_poses(3, 3)):
        check_shapes(robot, pose)


def test_shapes_keep_the_joints(robot: Mechanism, case2: Pose) -> None:
    modes = MujocoCable(6).modes(robot, case2)
    limbs = limbs_at(robot, case2)
    np.testing.assert_allclose(modes.limbs[:, :, 0], 0, atol=1e-12)
    tips = np.stack([modes.platform @ rigid_arm(arm).T for arm in limbs.arms], axis=1)
    np.testing.assert_allclose(modes.limbs[:, :, -1], tips, atol=1e-9)
    if not FLEX:
        along = np.einsum("mikd,id->mik", modes.limbs, limbs.frames[:, :, 2])
        np.testing.assert_allclose(along, 0, atol=1e-9)


@pytest.mark.parametrize("degrees", [37, 90, 180])
def test_frame_rotation(robot: Mechanism, case2: Pose, degrees: float) -> None:
    turn = np.radians(degrees)
    pose = Pose(case2.z, case2.azimuth + turn, case2.tilt)
    turned = MujocoCable(6).modes(Mechanism.paper(heading=turn), pose)
    straight = MujocoCable(6).modes(robot, case2)
    np.testing.assert_allclose(turned.frequencies, straight.frequencies, rtol=1e-6)
    z = np.abs(straight.platform[:, 2])
    np.testing.assert_allclose(np.abs(turned.platform[:, 2]), z, atol=1e-4 * z.max())


STEEL, ALLOY = Material(200e9, 77e9, 7820.0), Material(70e9, 26e9, 2700.0)
SKEW = Platform(20.0, ((0.3, 0.05, -0.04), (0.05, 0.4, 0.02), (-0.04, 0.02, 0.6)))
FLAT = Platform.diagonal(20.0, (0.3, 0.6, 0.9))  # no thickness: A + B = C, but for rounding


def uneven(robot: Mechanism, platform: Platform) -> Mechanism:
    rods = [Rod(STEEL, 0.05), Rod(ALLOY, 0.09), Rod(STEEL, 0.08), Rod(ALLOY, 0.06)]
    limbs = (
        Limb.rps(limb.base, limb.axis, limb.platform_point, rod)
        for limb, rod in zip(robot.limbs, rods, strict=False)
    )
    return Mechanism(tuple(limbs), platform)


def test_unequal_rods_and_any_inertia(robot: Mechanism, case2: Pose) -> None:
    for platform in (SKEW, FLAT):
        agrees(uneven(robot, platform), case2)


def test_inertia_as_printed(case2: Pose) -> None:
    agrees(Mechanism.paper(inertia="printed"), case2)


def test_four_limbs() -> None:
    four = Mechanism.regular(0.3, 0.2, Rod(STEEL, 0.05), SKEW, limbs=4, heading=np.radians(20))
    pose = Pose(0.5, np.radians(20), np.radians(8))
    agrees(uneven(four, SKEW), pose, REFINED if FLEX else (32, 64))  # f6 is late to its order


def test_vertical_limbs() -> None:
    agrees(Mechanism.regular(0.3, 0.3, Rod(STEEL, 0.05), SKEW), Pose(0.6))


def test_what_is_reported(robot: Mechanism, case2: Pose) -> None:
    modes = MujocoCable(8).modes(robot, case2, count=9)
    info = MujocoCable.info()
    installed = os.environ.get(SECOND_MARK, mujoco.__version__)
    assert modes.version == f"mujoco {installed}"
    assert (info.program, info.version, info.missing) == ("MuJoCo", installed, "")
    assert modes.theory == info.theory
    assert ("inextensible" in info.remark and "first order" in info.remark) is not FLEX
    assert ("inextensible" in info.theory) is not FLEX
    assert modes.frequencies.shape == (9,)
    assert modes.platform.shape == (9, 6)
    assert modes.limbs.shape == (9, 3, 11, 3)
    assert modes.elements == 8
    assert modes.dofs == 6 + 3 * (1 + 3 * 7) - (0 if FLEX else 9)
    assert modes.residual is not None
    assert modes.residual < 1e-12
    assert modes.build_seconds > 0
    assert modes.solve_seconds > 0


def displaced(monkeypatch: pytest.MonkeyPatch, distance: float) -> None:
    compiled = linearise.compiled

    def shifted(document: str) -> Any:
        model = compiled(document)
        model.qpos0[0] += distance
        return model

    monkeypatch.setattr(linearise, "compiled", shifted)


def test_open_joints_are_refused(
    robot: Mechanism, case2: Pose, monkeypatch: pytest.MonkeyPatch
) -> None:
    displaced(monkeypatch, 2e-3)  # in units of 0.5 m
    with pytest.raises(ModelError, match=r"open by 1\.0e-03 m"):
        MujocoCable(4).modes(robot, case2)


def test_mujoco_warnings_are_errors(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    model = linearise.compiled(
        "<mujoco><worldbody><body><freejoint/><geom size='1'/></body></worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    data.qpos[0] = np.nan
    with pytest.raises(ModelError, match="QPOS"), linearise.strict():
        mujoco.mj_step(model, data)
    with pytest.raises(ModelError, match="cannot compile"):
        linearise.compiled("<mujoco><nonsense/></mujoco>")
    assert not list(tmp_path.iterdir())
    assert capfd.readouterr() == ("", "")


@pytest.mark.slow
def test_silent_and_clean(
    robot: Mechanism,
    workspace_poses: Poses,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    """300 poses print nothing, leave no file and hold no memory."""
    monkeypatch.chdir(tmp_path)
    statm = Path("/proc/self/statm")

    def pages() -> int:
        return int(statm.read_text().split()[1]) if statm.exists() else 0

    model = MujocoCable(4)
    for k, pose in enumerate(workspace_poses(300, 4)):
        model.modes(robot, pose)
        if k == 50:
            before = pages()
    assert (pages() - before) * 4096 < 4e6
    assert not list(tmp_path.iterdir())
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("installed", "said"),
    [("", "not installed"), ("3.16.0", "MuJoCo 3.16.0"), ("5.0.0", "MuJoCo 5.0.0")],
)
def test_missing(
    robot: Mechanism, case2: Pose, installed: str, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mujoco_system, "installed", lambda: installed)
    missing = MujocoCable.info().missing
    assert said in missing
    assert "pip install" in missing
    with pytest.raises(UnavailableError, match=said):
        reference("mujoco-cable")
    with pytest.raises(UnavailableError, match=said):
        MujocoCable(4).modes(robot, case2)


@pytest.mark.slow
def test_info_does_not_load_mujoco() -> None:
    code = (
        "import sys; from reference_models.mujoco.cable import MujocoCable; MujocoCable.info(); "
        "sys.exit('mujoco' in sys.modules)"
    )
    root = Path(__file__).parents[2]
    subprocess.run([sys.executable, "-c", code], check=True, cwd=root)


def test_bad_input(robot: Mechanism, case2: Pose, workspace_poses: Poses) -> None:
    for elements in (2, 0, -3, 2.5, True, "8"):
        with pytest.raises(InputError, match="elements"):
            MujocoCable(elements)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="one pose at a time"):
        MujocoCable(4).modes(robot, workspace_poses(2, 5))
    with pytest.raises(InputError, match="at most"):
        MujocoCable(3).modes(robot, case2, count=100)
    with pytest.raises(InputError, match="count"):
        MujocoCable(3).modes(robot, case2, count=0)


@pytest.mark.slow
@pytest.mark.skipif(not FLEX or SECOND_MARK in os.environ, reason="this is the second environment")
def test_on_the_last_mujoco_3(tmp_path: Path) -> None:
    """Both models on 3.17.0, laid over the running environment, which stays as it is."""
    uv = shutil.which("uv")
    command = [uv] if uv else [sys.executable, "-m", "uv"]
    if subprocess.run([*command, "--version"], capture_output=True).returncode:
        pytest.skip("uv is missing, which lays another MuJoCo over this environment")
    overlay = ["--no-project", "--python", sys.executable, "--with", f"mujoco=={SECOND}"]
    numpy = ["--with", f"numpy=={np.__version__}"]
    tests = ["python", "-m", "pytest", "-q", "-p", "no:cacheprovider", __file__]
    tests.append(str(Path(__file__).with_name("test_mujoco_chain.py")))
    done = subprocess.run(
        [*command, "run", *overlay, *numpy, *tests],
        cwd=Path(__file__).parents[2],
        env=os.environ | {SECOND_MARK: SECOND},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
