"""What is exported runs by the bare program, and gives the bench's own frequencies."""

import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from analytic import (
    InputError,
    Joint,
    Limb,
    Link,
    Material,
    Mechanism,
    Platform,
    Pose,
    Rod,
)
from analytic.mechanism import Item
from harness.case_file import load_cases
from reference_models import Named
from reference_models.export import Export, exporter

pytestmark = pytest.mark.slow
CASES = load_cases(Path(__file__).parents[2] / "results/published/mechanisms.toml")
ROD, BALL, POSE = (
    Rod.round(Material(200e9, 77e9, 7820), 0.05),
    Joint.spherical(),
    Pose(0.5, 0.3, 0.15),
)
OURS = ("analytic", "reference_models", "harness", "rps_bench")
ALONE = (
    "import runpy, sys; runpy.run_path('rps.py'); "
    f"assert not {{*sys.modules}} & {{*{OURS}}}, 'it needs this bench'"
)


def three(*chain: Item) -> Mechanism:
    """Three equal limbs of a chain under a plate."""
    limb = Limb((0.3, 0, 0), (0.2, 0, 0), chain)
    limbs = tuple(limb.turned(2 * np.pi * k / 3) for k in range(3))
    return Mechanism(limbs, Platform.disc(0.2, 0.02, 7820))


LINKED = three(Joint.revolute((0, 1, 0)), Link(0.1), ROD, Link(0.05), BALL), POSE


def by_python(folder: Path) -> list[float]:
    ended = subprocess.run(
        [sys.executable, "-I", "-W", "error", "-c", ALONE],
        cwd=folder, capture_output=True, text=True,
    )  # fmt: skip
    assert ended.returncode == 0, ended.stderr
    return [float(line) for line in ended.stdout.split()]


def by_calculix(folder: Path) -> list[float]:
    ended = subprocess.run(["ccx", "rps"], cwd=folder, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stdout
    table = (folder / "rps.dat").read_text().split("P A R T I C I P A T I O N")[0]
    return [float(line.split()[3]) for line in table.splitlines() if re.match(r" +\d+ ", line)]


def right(model: Named, mechanism: Mechanism, pose: Pose) -> np.ndarray:
    return model.modes(mechanism, pose).frequencies


@pytest.mark.parametrize(
    ("to", "elements", "run", "known"),
    [
        ("exudyn", 4, by_python, 1e-8),
        ("exudyn-beam", 6, by_python, 1e-8),
        ("mujoco", 4, by_python, 1e-7),  # differences
        ("calculix", 4, by_calculix, 2e-6),  # seven digits are printed
    ],
)
def test_the_bare_program_agrees(
    robot: Mechanism, case2: Pose, tmp_path: Path, to: str, elements: int,
    run: Callable[[Path], list[float]], known: float,
) -> None:  # fmt: skip
    made = exporter(to)(robot, case2, elements, 6)
    if made.model.info().missing:
        pytest.skip(made.model.info().missing)
    for name, text in made.files.items():
        assert not [word for word in OURS if f"import {word}" in text or f"from {word}" in text]
        assert f"model {made.model.label}" in text or name == "rps.py"
        (tmp_path / name).write_text(text)
    f = run(tmp_path)
    np.testing.assert_allclose(f, right(made.model, robot, case2), rtol=known)
    # A slip in the pose, the platform or a limb would show: another pose has other frequencies.
    assert np.abs(f / right(made.model, robot, Pose(0.49)) - 1).max() > 0.01


def written(made: Export, folder: Path) -> Export:
    if made.model.info().missing:
        pytest.skip(made.model.info().missing)
    for name, text in made.files.items():
        assert not [word for word in OURS if f"import {word}" in text or f"from {word}" in text]
        (folder / name).write_text(text)
    return made


def test_the_bare_ccx_agrees_on_a_chain(tmp_path: Path) -> None:
    """3-PRS: three springs a slider, a body, a tube."""
    case = CASES["prs"]
    made = written(exporter("calculix")(case.mechanism, case.pose, 2, 6), tmp_path)
    assert made.files["rps.inp"].count("*ELEMENT,TYPE=SPRING1,ELSET=L") == 3 * 3
    assert made.files["rps.inp"].count("A body of limb") == 3
    known = right(made.model, case.mechanism, case.pose)
    np.testing.assert_allclose(by_calculix(tmp_path), known, rtol=2e-6)


@pytest.mark.parametrize(
    ("to", "case"),
    [
        *(("exudyn", case) for case in ("prs", "rps-real", "six-sps", "tricept")),
        *(("mujoco", case) for case in ("prs", "three-upu", "six-sps", "flexure-hexapod")),
        ("exudyn-beam", "linked"),
        ("mujoco", "linked"),
    ],
)
def test_bare_python_agrees_on_a_chain(tmp_path: Path, to: str, case: str) -> None:
    """Sliders, drives, bearings, tubes, bodies, payloads, links, limbs that spin or end fixed."""
    robot, pose = LINKED if case == "linked" else (CASES[case].mechanism, CASES[case].pose)
    made = written(exporter(to)(robot, pose, 2, 6), tmp_path)
    label = "mujoco-chain@2" if to == "mujoco" else "exudyn-beam@2"
    assert made.model.label == label and robot.limbs[-1].described in "".join(made.files.values())
    np.testing.assert_allclose(by_python(tmp_path), right(made.model, robot, pose), rtol=1e-8)


def test_what_a_script_cannot_say_of_a_chain() -> None:
    """What its model refuses, in that model's sentence."""
    robot, pose = three(BALL, Joint.revolute((0, 1, 0)), ROD, BALL), POSE
    for to in ("exudyn", "exudyn-beam"):
        with pytest.raises(InputError, match=r"limb 1, S-R-rod-S'.*independent freedoms"):
            exporter(to)(robot, pose, 4, 6)


def struts(size: float) -> tuple[Mechanism, Pose]:
    """Six struts, 1 kN/m each, below a plate of a gram."""
    at = np.radians([-15, 15, 105, 135, 225, 255])
    on = np.radians([-45, 45, 75, 165, 195, 285])
    chain = (Joint.universal((1, 0, 0)), Link(0.5 * size), Joint.prismatic(None, 1e3), Link(None),
             BALL)  # fmt: skip
    limbs = tuple(
        Limb((size * np.cos(a), size * np.sin(a), 0),
             (0.7 * size * np.cos(b), 0.7 * size * np.sin(b), 0), chain)
        for a, b in zip(at, on, strict=True)
    )  # fmt: skip
    J = 1e-4 * size**2
    platform = Platform(1e-3, ((J, 0, 0), (0, J, 0), (0, 0, J)))
    return Mechanism(limbs, platform), Pose(size, x=0.0, y=0.0)


def test_links_alone_weigh_nothing(tmp_path: Path) -> None:
    """What stands for no mass is little beside a gram, too; what MuJoCo takes for none is said."""
    robot, pose = struts(1.0)
    made = written(exporter("mujoco")(robot, pose, 2, 6), tmp_path)
    np.testing.assert_allclose(by_python(tmp_path), right(made.model, robot, pose), rtol=1e-8)
    with pytest.raises(InputError, match=r"limb 1, U-.*of 1e-14 kg m2 and more"):
        exporter("mujoco")(*struts(0.1), 2, 6)


def test_numbers_in_a_script_are_those_of_the_system(robot: Mechanism, case2: Pose) -> None:
    made: Export = exporter("exudyn")(robot, case2, None, 6)
    text = made.files["rps.py"]
    assert made.model == Named("exudyn-cable", 8)
    assert text.count("ObjectANCFCable") == 3 * 8 and text.count("SphericalJoint(") == 6
    assert "# --- limb 3" in text and "z = 0.49 m, azimuth 10 deg, tilt -12 deg" in text


def test_what_cannot_be_written(robot: Mechanism) -> None:
    with pytest.raises(InputError, match="to = 'ansys': expected one of calculix, exudyn"):
        exporter("ansys")
    for to in ("calculix", "mujoco", "exudyn"):
        with pytest.raises(InputError, match="one pose at a time"):
            exporter(to)(robot, Pose(np.array([0.4, 0.5])), 4, 6)
        with pytest.raises(InputError, match="elements = 0"):
            exporter(to)(robot, Pose(0.49), 0, 6)
