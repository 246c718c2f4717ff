"""A study from Python: texts or objects, the same numbers as the models give."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import harness
from analytic import Continuum, InputError, Mechanism, Pose, Substructure
from harness import study
from harness.case import Case
from reference_models import Named

MINE = """
[mechanisms.light]
base_radius_mm = 300
platform_radius_mm = 200
platform_thickness_mm = 20
rod_diameter_mm = 60
young_GPa = 200
shear_GPa = 77
density_kg_m3 = 7820
[cases.low]
mechanism = "light"
z_mm = 400
"""


def test_from_a_file_to_a_frame_and_a_plot(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(MINE)
    result = study("convergence", case_file=file, references="euler-bernoulli@exact",
                   elements="1,2,4,8", modes="1-3")  # fmt: skip
    frame = result.to_frame()
    assert set(frame["case"]) == {"low"} and list(frame["elements"].unique()) == [1, 2, 4, 8]
    errors = frame.pivot(index="elements", columns="mode", values="error_percent").to_numpy()
    assert (np.log2(errors[-2] / errors[-1]) > 3.9).all()  # Hermite's cubic: order 4
    figure = result.plot()
    assert figure is not None and figure.axes[0].get_title() == "(a) low"
    assert "table" in result._repr_html_()


def test_objects_are_as_good_as_texts() -> None:
    case = Case("mine", Mechanism.paper(), Pose(0.45), "tried")
    result = study("table", cases=case, references=[Named("rayleigh", None)], modes=range(1, 4),
                   model=Named("euler-bernoulli", 2))  # fmt: skip
    frame = result.to_frame()
    for label, model in (("euler-bernoulli@2", Substructure(2)),
                         ("rayleigh@exact", Continuum("rayleigh"))):  # fmt: skip
        found = frame[frame["model"] == label]["frequency_hz"]
        right = model.modes(case.mechanism, case.pose, 8).frequencies[:3]
        np.testing.assert_allclose(found, right, rtol=1e-11)


def test_what_cannot_be_read_names_its_argument() -> None:
    with pytest.raises(InputError, match="argument = 'colour': expected one of case_file, cases"):
        study("table", colour="red")
    with pytest.raises(InputError, match="study = 'tables': expected one of table, convergence"):
        study("tables")
    with pytest.raises(InputError, match=r"references = .*: expected one, for"):
        study("convergence", references="rayleigh@exact,timoshenko@exact")
    with pytest.raises(AttributeError, match="no attribute 'stud'"):
        harness.stud  # noqa: B018


def test_wrong_types_get_one_sentence(robot: Mechanism, case2: Pose) -> None:
    from reference_models import reference

    case = Case("mine", robot, case2, "tried")
    for call, says in (
        (lambda: study("table", cases=robot), "cases = Mechanism.*expected a Case"),
        (lambda: study("table", references=3), "models = 3: expected a model"),
        (lambda: harness.run(case2, Named("rayleigh", 3)), "cases = Pose.*expected a Case"),
        (lambda: harness.run(case, "rayleigh@3"), "models = 'rayleigh@3': expected a model"),
        (lambda: Substructure().frequencies(robot, 0.49), "pose = 0.49: expected a Pose"),
        (lambda: reference("exudyn-cable", 4).modes(robot, 0.49), "pose = 0.49: expected a Pose"),
        (lambda: reference("mujoco-cable", 4).modes(case2, robot), "mechanism = Pose"),
    ):
        with pytest.raises(InputError, match=says):
            call()


def test_nothing_is_loaded_before_it_is_asked_for() -> None:
    code = (
        "import harness, sys; print([m for m in ('numpy', 'pandas', 'click') if m in sys.modules])"
    )
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ended.stdout.strip() == "[]"
