"""What is exported runs by the bare program, and gives the bench's own frequencies."""

import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from analytic import InputError, Mechanism, Pose
from harness.case_file import load_cases
from reference_models import Named
from reference_models.export import Export, exporter

pytestmark = pytest.mark.slow
OURS = ("analytic", "reference_models", "harness", "rps_bench")
ALONE = (
    "import runpy, sys; runpy.run_path('rps.py'); "
    f"assert not {{*sys.modules}} & {{*{OURS}}}, 'it needs this bench'"
)


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


def test_the_bare_ccx_agrees_on_a_chain(tmp_path: Path) -> None:
    """3-PRS: three springs a slider, a body, a tube."""
    case = load_cases(Path(__file__).parents[2] / "results/published/mechanisms.toml")["prs"]
    made = exporter("calculix")(case.mechanism, case.pose, 2, 6)
    if made.model.info().missing:
        pytest.skip(made.model.info().missing)
    for name, text in made.files.items():
        (tmp_path / name).write_text(text)
    assert made.files["rps.inp"].count("*ELEMENT,TYPE=SPRING1") == 3 * 3
    assert made.files["rps.inp"].count("A body of limb") == 3
    known = right(made.model, case.mechanism, case.pose)
    np.testing.assert_allclose(by_calculix(tmp_path), known, rtol=2e-6)


@pytest.mark.parametrize("to", ["exudyn", "exudyn-beam", "mujoco"])
def test_what_a_script_cannot_say_of_a_chain(to: str) -> None:
    case = load_cases(Path(__file__).parents[2] / "results/published/mechanisms.toml")["prs"]
    with pytest.raises(InputError, match="limb 1, P-body-R-rod-S"):
        exporter(to)(case.mechanism, case.pose, 4, 6)


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
