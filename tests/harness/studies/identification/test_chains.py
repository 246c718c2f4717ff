"""Any mechanism's numbers by name: read, changed, planted and found again."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analytic import Continuum, InputError
from analytic.description import numbers
from harness.case import Case
from harness.case_file import load_cases
from harness.paper import SHIPPED
from harness.studies.identification.estimate import Fit, fit, sensitivities
from harness.studies.identification.problem import FAR, Problem, described, parameters
from harness.studies.identification.result import Identification
from harness.studies.identification.table import FrequencyTable
from reference_models import Named

PUBLISHED = next(path for path in SHIPPED[::-1] if path.is_dir())
CHAINS = PUBLISHED / "mechanisms.toml"
CASES = load_cases(CHAINS)
MODEL = Named("timoshenko", 2)
CARRIAGES = """
[materials.steel]
young_GPa = {young}
shear_GPa = {shear}
density_kg_m3 = {density}
[rods]
link = {{material = "steel", diameter_mm = {diameter}, bore_mm = {bore}}}
[mechanisms.prs]
platform = {{radius_mm = {radius}, thickness_mm = {thickness}, density_kg_m3 = {platform}}}
[[mechanisms.prs.limbs]]
copies = 3
base_mm = [{base}, 0, 0]
platform_point_mm = [{point}, 0, 0]
chain = [
  {{joint = "P", axis = [0, 0, 1], slider = "above", stiffness_N_m = {drive}, {tilts}}},
  {{body_kg = {body}, centre_mm = [0, 0, 15], inertia_kg_m2 = [0.06, 0.05, 0.07]}},
  {{joint = "R", axis = [0, 1, 0]}},
  {{rod = "link", length_mm = {length}}},
  {{joint = "S"}},
]
[cases.prs]
mechanism = "prs"
z_mm = {z}
azimuth_deg = {azimuth}
tilt_deg = {tilt}
"""
STATED = {
    "young": ("young_GPa", 200), "density": ("density_kg_m3", 7820),
    "diameter": ("rod_diameter_mm", 50), "bore": ("rod_bore_mm", 36),
    "length": ("rod_length_mm", 550), "radius": ("disc_radius_mm", 210),
    "thickness": ("platform_thickness_mm", 25), "platform": ("platform_density_kg_m3", 7000),
    "base": ("base_radius_mm", 350), "point": ("platform_radius_mm", 180),
    "drive": ("P1_stiffness_N_m", 1.2e8), "first": ("P2_stiffness_Nm_rad", 6e5),
    "second": ("P3_stiffness_Nm_rad", 8e5), "body": ("body_mass_kg", 12), "z": ("z_mm", -900),
    "azimuth": ("azimuth_deg", 25), "tilt": ("tilt_deg", 15),
}  # fmt: skip
"""What each blank of `CARRIAGES` is called, and a value."""


def stated(path: Path, factor: float = 1.0) -> tuple[Case, dict[str, float]]:
    """The case of a file whose every number is `factor` times that of `STATED`, and these."""
    values = {key: value * factor for key, (_, value) in STATED.items()}
    first, second = values["first"], values["second"]
    tilts = f'tilt_stiffness_Nm_rad = {{"0,1,0" = {first}, "-1,0,0" = {second}}}'
    path.write_text(CARRIAGES.format(**values, shear=77 * factor, tilts=tilts))
    (case,) = load_cases(path).values()
    return case, {name: values[key] for key, (name, _) in STATED.items()}


def table(case: Case, frequencies: Any) -> FrequencyTable:
    f = np.atleast_2d(frequencies)
    return FrequencyTable("a plant", (case,), f, np.zeros(f.shape))


def test_every_number_of_a_file_is_read_and_changed(tmp_path: Path) -> None:
    """The file with other numbers is the mechanism that the names make of the first."""
    case, values = stated(tmp_path / "first.toml")
    other, changed = stated(tmp_path / "other.toml", 1.03)
    for one, known in ((case, values), (other, changed)):
        assert {n: p.value for n, p in parameters(one).items()} == pytest.approx(known, rel=1e-12)
    mechanism, pose = described(case, changed, None)
    expected = MODEL.frequencies(other.mechanism, other.pose)
    np.testing.assert_allclose(MODEL.frequencies(mechanism, pose), expected, rtol=1e-9)
    assert (np.abs(MODEL.frequencies(case.mechanism, case.pose) / expected - 1) > 1e-3).any()
    assert described(case, {n: p.value for n, p in parameters(case).items()}, None) == (
        case.mechanism, case.pose,
    )  # fmt: skip


def test_what_is_equal_is_one_parameter_and_what_differs_is_numbered() -> None:
    found = numbers(CASES["hexapod"].mechanism, CASES["hexapod"].pose)
    rods = {n: p for n, p in parameters(CASES["hexapod"]).items() if n.startswith("rod")}
    names = "rod1_diameter_mm", "rod1_bore_mm", "rod1_length_mm", "rod2_diameter_mm"
    assert {n: p.value for n, p in rods.items()} == pytest.approx(
        dict(zip(names, (70, 50, 420, 40), strict=True))
    )
    assert [len(n.places) for k, n in found.items() if k.startswith("rod")] == [6, 6, 6, 6]
    own = parameters(CASES["rps-real"])
    assert own["R1_stiffness_Nm_rad"].value == 4e5 and own["R2_stiffness_Nm_rad"].value == 3e5
    # Two equal moments are one: a hexapod's platform stays as round as it is.
    mechanism, _ = described(
        CASES["hexapod"],
        {n: p.value for n, p in parameters(CASES["hexapod"]).items()}
        | {"platform_inertia_xx_kg_m2": 2.0, "platform_mass_kg": 50.0},
        None,
    )
    np.testing.assert_allclose(mechanism.platform.inertia, np.diag([2.0, 2.0, 3.1]))
    assert mechanism.platform.mass == 50


@pytest.mark.slow
def test_planted_numbers_come_back_but_for_what_elements_cost() -> None:
    """Without elements a drive and a rod are planted; two elements a rod find them again.

    By as much beside them as the elements' errors make: to first order pinv(J) times these.
    """
    case = CASES["prs"]
    planted = {"P1_stiffness_N_m": 0.9e8, "rod_diameter_mm": 52.0}
    values = {name: p.value for name, p in parameters(case).items()} | planted
    truth = described(case, values, None)
    exact = Continuum("timoshenko").modes(*truth, 6).frequencies
    problem = Problem(table(case, exact), MODEL, tuple(planted))
    (found,) = fit(problem, np.log(exact)[None], noise=1e-6, starts=1)
    _, x, J = sensitivities(problem, planted, problem.names)
    expected = -np.linalg.pinv(J) @ np.log(MODEL.frequencies(*truth) / exact)
    assert 1e-5 < np.abs(expected).max() < 1e-2
    np.testing.assert_allclose(found.x - x, expected, rtol=0.05, atol=0.02 * max(abs(expected)))
    # The same elements leave nothing beside it.
    f = MODEL.frequencies(*truth)
    (found,) = fit(Problem(table(case, f), MODEL, tuple(planted)), np.log(f)[None], 1e-6, starts=1)
    np.testing.assert_allclose(found.values, list(planted.values()), rtol=1e-6)
    assert ((found.together[:, 0] < found.values) & (found.values < found.together[:, 1])).all()


def left_open(case: Case, *names: str) -> tuple[Fit, list[str]]:
    f = Named("timoshenko", 1).frequencies(case.mechanism, case.pose)
    problem = Problem(table(case, f), Named("timoshenko", 1), names)
    (found,) = fit(problem, np.log(f)[None], noise=1e-4, starts=1)
    return found, Identification((found,), (), ()).sentences()


@pytest.mark.slow
def test_what_a_table_cannot_tell_is_left_open() -> None:
    """E and rho raised alike; and a height that vertical carriages follow."""
    found, said = left_open(CASES["four-rps"], "young_GPa", "density_kg_m3")
    assert found.open.any(axis=1).all()
    assert np.isinf(found.left[-1].deviation)
    assert list(found.left[-1].exponents.values()) == pytest.approx([1, 1], abs=1e-4)
    assert found.left[0].deviation < 0.01
    assert any(line.startswith("The table leaves E rho open") for line in said)
    found, said = left_open(CASES["prs"], "z_mm", "P1_stiffness_N_m")
    np.testing.assert_array_equal(found.open, [[True, True], [False, False]])
    low, high = found.alone[1]
    assert low < 1.2e8 < high < 1.01 * low
    assert "z_mm is" not in said[0] and said[1].startswith("The table leaves z open")


@pytest.mark.slow
def test_a_published_hexapod_gives_back_its_springs(
    rps_bench: Callable[..., Any], tmp_path: Path
) -> None:
    """Of wrong springs and a wrong mass in its file, its table makes those that it states.

    Rounding to 0.1 Hz is 3e-5 of a value; of four different ones that is some 1e-4 of a spring.
    """
    folder = tmp_path / "other"
    shutil.copytree(PUBLISHED / "stewart-simscape", folder)
    text = (folder / "cases.toml").read_text()
    text = text.replace("= 2e7", "= 1.7e7").replace("mass_kg = 1,", "mass_kg = 1.3,")
    (folder / "cases.toml").write_text(text)
    answer = rps_bench("identify", "--case-file", str(folder), "--model", "euler-bernoulli@1",
                       "--parameters", "P_stiffness_N_m,platform_mass_kg", "--starts", "1",
                       "--free", "0", "--output", str(tmp_path / "out"))  # fmt: skip
    assert answer.status == 0, answer.err
    import pandas as pd

    rows = pd.read_csv(tmp_path / "out" / "identify-data.csv").query("kind == 'fit'")
    assert list(rows["parameter"]) == ["P_stiffness_N_m", "platform_mass_kg"]
    for (_, row), truth in zip(rows.iterrows(), (2e7, 1.0), strict=True):
        assert row["together_from"] < truth < row["together_to"] < row["together_from"] * 1.001
    assert "P_stiffness_N_m is " in answer.out


def test_where_no_such_mechanism_can_be_it_is_far_off() -> None:
    case = CASES["prs"]
    f = MODEL.frequencies(case.mechanism, case.pose)
    problem = Problem(table(case, f), MODEL, ("rod_length_mm",))
    x = np.log([[550.0], [50.0]])
    f = problem.frequencies(x)
    assert np.isfinite(f[0]).all() and np.isnan(f[1]).all()
    off = problem.residuals(problem.table.logarithms[None])(x, np.zeros(2, dtype=np.intp))
    np.testing.assert_allclose(off, [[0] * 6, [FAR] * 6], atol=1e-9)


@pytest.mark.parametrize(
    ("names", "how", "says"),
    [
        (("mass",), {}, r"parameters = 'mass': expected one of z_mm, .*P3_stiffness_Nm_rad"),
        (("z_mm",), {"mirrored": True}, "frames = 'mirrored': expected three equal R-P-S limbs"),
        (
            ("z_mm",),
            {"inertia": "printed"},
            "inertia = 'printed': expected three equal R-P-S limbs",
        ),
        (("body_mass_kg",), {"bounds": {"body_mass_kg": (-1, 2)}}, "expected bounds above 0"),
    ],
)
def test_what_chains_cannot_be_asked_for(
    names: tuple[str, ...], how: dict[str, Any], says: str
) -> None:
    case = CASES["prs"]
    with pytest.raises(InputError, match=says):
        Problem(table(case, [27.0, 30.0]), MODEL, names, **how)
