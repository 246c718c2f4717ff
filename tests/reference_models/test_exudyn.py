"""Exudyn's cable and beam against the substructure model, exact values, symmetry and misuse."""

import builtins
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analytic import (
    InputError,
    Limb,
    Material,
    Mechanism,
    Modes,
    Platform,
    Pose,
    Rod,
    Substructure,
)
from analytic.pairing import mass_vectors, pair
from reference_models import ModelError, UnavailableError, reference
from reference_models.exudyn import system as exudyn_system
from reference_models.exudyn.beam import ExudynBeam
from reference_models.exudyn.cable import ExudynCable

MODELS = {"exudyn-cable": ExudynCable, "exudyn-beam": ExudynBeam}
# Exact dynamic stiffness of the limbs at cases 1 and 2, by an implementation outside this project.
EXACT = {
    "exudyn-cable": [
        [137.826371, 137.826371, 236.516862, 793.124051, 880.839551, 880.839551],
        [124.665975, 149.507123, 241.043346, 720.339940, 894.736495, 947.888615],
    ],
    "exudyn-beam": [
        [135.848648, 135.848648, 232.253211, 758.307568, 837.621129, 837.621129],
        [123.026950, 147.212920, 236.573004, 691.481346, 850.484305, 895.873556],
    ],
}
STEEL = Material(200e9, 77e9, 7820.0)
LIGHT = Material(70e9, 26e9, 2700.0)

Poses = Callable[[int, int], Pose]


def timoshenko(elements: int = 48, shear: str | float = 0.9) -> Substructure:
    return Substructure(elements, beam="timoshenko", shear=shear, solver="sparse")


def largest_error(model: Any, truth: Any, robot: Mechanism, poses: Pose) -> float:
    return max(
        float(
            np.abs(model.modes(robot, p).frequencies / truth.modes(robot, p).frequencies - 1).max()
        )
        for p in poses
    )


@pytest.mark.parametrize("count", [3, pytest.param(40, marks=pytest.mark.slow)])
def test_cable_is_the_paper_model(robot: Mechanism, workspace_poses: Poses, count: int) -> None:
    cable, truth = ExudynCable(8), Substructure(8)
    assert largest_error(cable, truth, robot, workspace_poses(count, 11)) < 1e-5


@pytest.mark.parametrize("count", [3, pytest.param(30, marks=pytest.mark.slow)])
def test_extrapolated_beam_is_timoshenko(
    robot: Mechanism, workspace_poses: Poses, count: int
) -> None:
    beam = reference("exudyn-beam", elements=(12, 24), shear=0.9)
    assert largest_error(beam, timoshenko(), robot, workspace_poses(count, 12)) < 3e-4


@pytest.mark.parametrize("shear", ["cowper", "6/7", 0.5])
def test_the_beam_takes_its_shear_coefficient(
    robot: Mechanism, case2: Pose, shear: str | float
) -> None:
    beam = reference("exudyn-beam", elements=(12, 24), shear=shear)
    assert largest_error(beam, timoshenko(32, shear), robot, [case2]) < 1e-4  # type: ignore[arg-type]
    assert beam.modes(robot, case2).theory == timoshenko(32, shear).theory.label(STEEL)


@pytest.mark.parametrize(
    ("name", "coarse", "settings", "low", "high"),
    [
        ("exudyn-cable", 4, {}, 3.9, 4.05),
        ("exudyn-beam", 12, {"shear": 0.9}, 1.98, 2.02),
    ],
)
def test_observed_order_of_convergence(
    robot: Mechanism,
    case1: Pose,
    case2: Pose,
    name: str,
    coarse: int,
    settings: dict[str, float],
    low: float,
    high: float,
) -> None:
    assert MODELS[name].info().order == pytest.approx((low + high) / 2, rel=0.01)
    for pose, exact in zip((case1, case2), EXACT[name], strict=True):
        first, second = (
            reference(name, elements=n, **settings).modes(robot, pose).frequencies - exact
            for n in (coarse, 2 * coarse)
        )
        order = np.log2(first / second)
        assert (order > low).all(), order
        assert (order < high).all(), order


@pytest.mark.parametrize(
    ("model", "truth", "tolerance"),
    [
        (ExudynCable(8), Substructure(8), 1e-4),
        # Linear between nodes: rods sag by at most h^2 / 8 times their curvature.
        (ExudynBeam(24, 0.9), timoshenko(24), 1e-2),
    ],
)
def test_mode_shapes_and_their_scale(
    robot: Mechanism, workspace_poses: Poses, model: Any, truth: Any, tolerance: float
) -> None:
    for pose in workspace_poses(4, 13):
        mine, other = model.modes(robot, pose), truth.modes(robot, pose)
        pairing = pair(mine, other, robot, pose)
        assert (pairing.assurance > 0.999).all()
        a, b = (mass_vectors(modes, robot, pose) for modes in (mine, other))
        b = b[pairing.partner]
        sign = np.sign((a * b).sum(axis=1))
        assert np.abs(a - sign[:, None] * b).max() < tolerance * np.abs(b).max()
        rotation = mine.platform[:, 3:] - sign[:, None] * other.platform[pairing.partner, 3:]
        assert np.abs(rotation).max() < tolerance * np.abs(other.platform[:, 3:]).max()


def test_the_cable_has_unit_modal_mass(robot: Mechanism, case2: Pose) -> None:
    # It has no rotary inertia, so centre lines and platform hold all of its mass.
    vectors = mass_vectors(ExudynCable(10).modes(robot, case2, 4), robot, case2)
    np.testing.assert_allclose((vectors**2).sum(axis=1), 1.0, rtol=1e-3)


@pytest.mark.parametrize("model", [ExudynCable(6), ExudynBeam(6)])
def test_only_the_angle_to_the_limbs_matters(model: Any, robot: Mechanism, case2: Pose) -> None:
    first = model.modes(robot, case2)
    for heading in (0.3, np.pi / 2, -2.2):
        turned = replace(case2, azimuth=case2.azimuth + heading)
        second = model.modes(Mechanism.paper(heading=heading), turned)
        np.testing.assert_allclose(second.frequencies, first.frequencies, rtol=1e-8)
        c, s = np.cos(heading), np.sin(heading)
        Z = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        expected = first.platform.reshape(6, 2, 3) @ Z.T
        found = second.platform.reshape(6, 2, 3)
        sign = np.sign((expected * found).sum(axis=(1, 2)))[:, None, None]
        np.testing.assert_allclose(found, sign * expected, atol=1e-6)


def with_rods(robot: Mechanism, *rods: Rod) -> Mechanism:
    limbs = tuple(limb.with_rod(rod) for limb, rod in zip(robot.limbs, rods, strict=True))
    return replace(robot, limbs=limbs)


def skewed() -> Mechanism:
    """Limbs of many kinds: no symmetry, revolute axes out of the base plane, full inertia."""
    tips = [(0.2, 0.02, 0.03), (-0.1, 0.18, -0.02), (-0.12, -0.15, 0.01), (0.05, -0.21, 0.0)]
    bases = [(0.31, 0.05, 0.0), (-0.1, 0.18, -0.04), (-0.2, -0.2, 0.02), (0.1, -0.3, 0.05)]
    rods = [Rod(STEEL, 0.1), Rod(LIGHT, 0.08), Rod(STEEL, 0.05), Rod(LIGHT, 0.12)]
    aside = [(0.3, 1.0, 0.2), (1.0, -0.2, 0.0), (1.0, -1.0, 0.4), (-0.2, 0.6, 1.0)]
    limbs = []
    for base, tip, rod, near in zip(bases, tips, rods, aside, strict=True):
        along = np.add(tip, (0, 0, 0.5)) - base
        limbs.append(Limb.rps(base, tuple(np.cross(along, near)), tip, rod))
    inertia = ((0.5, 0.05, -0.1), (0.05, 0.3, 0.08), (-0.1, 0.08, 0.6))
    return Mechanism(tuple(limbs), Platform(17.0, inertia))


PAPER = Mechanism.paper()
VARIANTS = {
    "four limbs": (
        Mechanism.regular(0.3, 0.2, Rod(STEEL, 0.1), PAPER.platform, limbs=4),
        Pose(0.45, 0.0, 0.2),
    ),
    "different rods": (
        with_rods(PAPER, Rod(STEEL, 0.1), Rod(LIGHT, 0.07), Rod(STEEL, 0.04)),
        Pose(0.6, 2.0, 0.3),
    ),
    "vertical limbs": (
        Mechanism.regular(0.25, 0.25, Rod(STEEL, 0.1), PAPER.platform),
        Pose(0.5),
    ),
    "full inertia, tilted": (
        replace(
            PAPER, platform=Platform(20.0, ((0.5, 0.1, -0.1), (0.1, 0.3, 0.05), (-0.1, 0.05, 0.6)))
        ),
        Pose(0.5, -1.0, 0.35),
    ),
    "skewed": (skewed(), Pose(0.5)),
}


@pytest.mark.parametrize("variant", VARIANTS)
def test_other_mechanisms(variant: str) -> None:
    robot, pose = VARIANTS[variant]
    assert largest_error(ExudynCable(8), Substructure(8), robot, [pose]) < 1e-5  # type: ignore[arg-type]
    beam = reference("exudyn-beam", elements=(12, 24), shear=0.9)
    assert largest_error(beam, timoshenko(32), robot, [pose]) < 3e-4  # type: ignore[arg-type]
    modes = ExudynBeam(12).modes(robot, pose)
    limbs = len(robot.limbs)
    assert modes.limbs.shape == (6, limbs, 11, 3)
    # All but B_i's and one spherical joint's coordinates: per limb 6 (n + 1) - 5 - 3, and 6.
    assert modes.dofs == limbs * (6 * 13 - 8) + 6


def test_torsion_modes_are_the_beams_alone(robot: Mechanism, case1: Pose) -> None:
    # Held at B_i about its own axis and free at A_i: f = sqrt(G / rho) / 4 L, one a limb.
    length = np.sqrt(0.1**2 + 0.49**2)
    torsion = np.sqrt(STEEL.shear / STEEL.density) / (4 * length)
    beam = ExudynBeam(24).modes(robot, case1, 14).frequencies
    cable = ExudynCable(8).modes(robot, case1, 14).frequencies
    assert (np.abs(beam / torsion - 1) < 5e-4).sum() == 3
    assert (np.abs(cable / torsion - 1) < 5e-3).sum() == 0
    assert "torsion" in ExudynCable.info().remark


def check_record(modes: Modes, name: str, elements: int, dofs: int) -> None:
    assert (modes.model, modes.elements, modes.dofs) == (name, elements, dofs)
    assert modes.version == f"exudyn {MODELS[name].info().version}"
    assert modes.residual is not None
    assert 0 <= modes.residual < 1e-12
    assert 0 < modes.build_seconds < 5
    assert 0 < modes.solve_seconds < 5


def test_what_every_answer_says_of_itself(robot: Mechanism, case2: Pose) -> None:
    cable = ExudynCable(4).modes(robot, case2, 2)
    check_record(cable, "exudyn-cable", 4, 3 * (6 * 5 - 4 - 3) + 6)
    assert cable.theory == "Euler-Bernoulli"
    beam = ExudynBeam(4, "0.9").modes(robot, case2, 2)
    check_record(beam, "exudyn-beam", 4, 3 * (6 * 5 - 8) + 6)
    assert beam.theory == "Timoshenko, kappa=0.9"


@pytest.mark.parametrize("model", [ExudynCable(3), ExudynBeam(3)])
@pytest.mark.parametrize("shift", [1e-3, 2e-9])
def test_open_joints_are_refused(
    monkeypatch: pytest.MonkeyPatch, model: Any, robot: Mechanism, case2: Pose, shift: float
) -> None:
    place = exudyn_system.add_platform

    def beside(exu: Any, mbs: Any, platform: Platform, o: Any, R: Any) -> tuple[int, int]:
        return place(exu, mbs, platform, o + np.array([0, shift, 0]), R)  # in units of 0.5 m

    monkeypatch.setattr(exudyn_system, "add_platform", beside)
    with pytest.raises(ModelError, match=f"joints are open by {shift / 2:.1e} m"):
        model.modes(robot, case2)


@pytest.mark.parametrize("name", MODELS)
def test_without_exudyn(
    monkeypatch: pytest.MonkeyPatch, robot: Mechanism, case1: Pose, name: str
) -> None:
    assert MODELS[name].info().missing == ""
    monkeypatch.setitem(sys.modules, "exudyn", None)
    assert "pip install exudyn" in MODELS[name].info().missing
    with pytest.raises(UnavailableError, match="exudyn is not installed"):
        reference(name)
    with pytest.raises(UnavailableError, match="exudyn is not installed"):
        MODELS[name]().modes(robot, case1)


@pytest.mark.parametrize("name", MODELS)
def test_without_opengl(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    """A bare machine has no libGL, and Exudyn is linked to it; it says so in six lines."""
    said = (
        "Exudyn could not import its compiled module. Tried, in order:\n  .exudynCPP  ->  "
        "libGL.so.1: cannot open shared object file: No such file or directory\n  exudynCPP  ->  "
        "No module named 'exudynCPP'\nCheck that the wheel matches this Python, or reinstall."
    )

    def unlinked(module: str, *arguments: Any) -> Any:
        if module == "exudyn":
            raise ImportError(said)
        return real(module, *arguments)

    real = builtins.__import__
    monkeypatch.setattr(builtins, "__import__", unlinked)
    info = MODELS[name].info()
    assert info.missing.startswith("exudyn cannot be imported: libGL.so.1 is missing; install")
    assert "apt-get install libgl1" in info.missing and "exudynCPP" not in info.missing


def test_a_failing_simulator_is_a_model_error(
    monkeypatch: pytest.MonkeyPatch, robot: Mechanism, case1: Pose
) -> None:
    def unusable(exu: Any, mbs: Any, *_: Any) -> tuple[int, int]:
        return 0, mbs.AddObject(exu.itemInterface.ObjectRigidBody(nodeNumber=99))

    monkeypatch.setattr(exudyn_system, "add_platform", unusable)
    with pytest.raises(ModelError, match=r"^exudyn-cable: .* invalid .*number 99$"):
        ExudynCable(2).modes(robot, case1)


@pytest.mark.parametrize("elements", [0, -1, 2.0, "3", True])
def test_bad_elements(elements: Any) -> None:
    for model in MODELS.values():
        with pytest.raises(InputError, match="elements"):
            model(elements)


@pytest.mark.parametrize("shear", ["5/6", 0.0, -1, float("nan")])
def test_bad_shear(shear: Any) -> None:
    with pytest.raises(InputError, match="shear"):
        ExudynBeam(shear=shear)


def test_bad_calls(robot: Mechanism) -> None:
    for model, most in ((ExudynCable(1), 21), (ExudynBeam(1), 18)):
        with pytest.raises(InputError, match=f"count = 50: expected at most {most}"):
            model.modes(robot, Pose(0.49), 50)
        with pytest.raises(InputError, match="count = 0"):
            model.modes(robot, Pose(0.49), 0)
        with pytest.raises(InputError, match="one pose at a time"):
            model.modes(robot, Pose(np.array([0.4, 0.5])))
        with pytest.raises(InputError, match="limbs of some length"):
            model.modes(Mechanism.regular(0.2, 0.2, robot.limbs[0].rod, robot.platform), Pose(0.0))


QUIET = """
import sys
from analytic import Mechanism, Pose
from reference_models import reference
from reference_models.exudyn.beam import ExudynBeam
from reference_models.exudyn.cable import ExudynCable

assert not ExudynBeam.info().missing and not ExudynCable.info().missing
for name in ("exudyn-cable", "exudyn-beam"):
    reference(name, elements=2).modes(Mechanism.paper(), Pose(0.49, 0.1, 0.2))
"""

GROWTH = """
from pathlib import Path
from analytic import Mechanism, Pose
from reference_models.exudyn.beam import ExudynBeam
from reference_models.exudyn.cable import ExudynCable

robot = Mechanism.paper()
def megabytes(poses):
    for i in range(poses):
        for model in (ExudynCable(3), ExudynBeam(3)):
            model.modes(robot, Pose(0.4 + 0.001 * i, 0.01 * i, 0.1), 1)
    status = Path('/proc/self/status').read_text()  # ru_maxrss is inherited by new programs
    return int(status.split('VmHWM:')[1].split()[0]) / 1024
before = megabytes(50)
print(megabytes(300) - before)
"""


def script(text: str, folder: Path) -> str:
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", text],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout


@pytest.mark.slow
def test_prints_nothing_and_writes_nothing(tmp_path: Path) -> None:
    assert script(QUIET, tmp_path) == ""
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="no /proc, which says the peak of a process")
def test_memory_does_not_grow_over_300_poses(tmp_path: Path) -> None:
    assert float(script(GROWTH, tmp_path)) < 2.0
