"""What the study takes, refuses and tells: names, tables, mechanisms, history."""

from dataclasses import replace

import numpy as np
import pytest

from analytic import (
    InputError,
    Mechanism,
    Pose,
    Rod,
)
from harness.bench import Bench
from harness.case import Case
from harness.cases import PRESETS
from harness.studies import identification
from harness.studies.identification.estimate import identify
from harness.studies.identification.fit import minimise
from harness.studies.identification.problem import INERTIAS, Problem, described, parameters
from harness.studies.identification.result import Identification
from harness.studies.identification.table import FrequencyTable, published_table, read_table
from harness.text import plan, request
from reference_models import Named

MODEL = Named("euler-bernoulli", 3)
TABLE = published_table("Theoretical", (PRESETS["case1"], PRESETS["case2"]))


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (("mass",), "one of z_mm"),
        (("case9.z_mm",), "one of z_mm"),
        (("case1.young_GPa",), "one of z_mm"),
        (("z_mm", "case1.z_mm", "case2.z_mm"), "left for"),
    ],
)
def test_names_that_mean_nothing_are_refused(names, expected):
    with pytest.raises(InputError, match=expected):
        Problem(TABLE, MODEL, names)


def test_tables_from_files(tmp_path):
    path = tmp_path / "measured.csv"
    path.write_text("case,method,f1,f2\ncase1,ours,115.0,116\n\ncase1,theirs,120,121\n")
    table = read_table(path, "ours", [])
    assert isinstance(table, FrequencyTable)
    np.testing.assert_allclose(table.frequencies, [[115.0, 116.0]])
    np.testing.assert_allclose(table.step, [[0.1, 1.0]])
    with pytest.raises(InputError, match="method = 'hers': expected one of ours, theirs"):
        read_table(path, "hers", [])
    own = Case("mine", Mechanism.paper(), Pose(0.5), "a test")
    path.write_text("case,f1\nmine,5\n")
    assert read_table(path, None, [own]).cases == (own,)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("case,f1\ncase1,abc\n", "positive number of hertz"),
        ("case,f1,f2\ncase1,5,4\n", "ascend"),
        ("name,f1\ncase1,5\n", "under the columns"),
        ("case,f1\ncase1,5\ncase1,6\n", "one row a case"),
        ("case,f1\n", "under the columns"),
        ("case,f1\ncase9,5\n", "one of the cases case1"),
        ("case,f1,f1\ncase1,5,6\n", "one column 'f1', not 2"),
        ("case,f1\ncase1,5,6\n", "2 values a row, as many as columns, not 3"),
        ("case,f1,f2\ncase1,5\n", "3 values a row, as many as columns, not 2"),
        ('case,f1\n"case1,5\n', "readable CSV"),
    ],
)
def test_tables_that_say_two_things_or_none_are_refused(tmp_path, text, expected):
    path = tmp_path / "measured.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=expected):
        read_table(path, None, [])


@pytest.mark.parametrize("inertia", ["disc", "printed"])
def test_a_fitted_mechanism_has_the_frequencies_of_the_fit(inertia):
    """Assembled limb by limb as any other mechanism, against the batch that was fitted."""
    base = TABLE
    turned = tuple(replace(c, mechanism=Mechanism.paper(heading=0.4)) for c in base.cases)
    table = replace(base, cases=turned)
    names = [name for name in parameters(turned[1]) if name != "z_mm"]
    problem = Problem(table, MODEL, (*names, "case1.z_mm", "case2.z_mm"), inertia)
    x = problem.start + np.linspace(-0.1, 0.1, len(problem.names))
    values = dict(zip(problem.names, problem.from_x(x).tolist(), strict=True))
    expected = problem.frequencies(x[None])[0]
    given = problem.frequencies(problem.start[None])[0]
    assert (np.abs(expected / given - 1) > 1e-3).all()
    for case, own, f in zip(table.cases, problem.at(values), expected, strict=True):
        mechanism, pose = described(case, own, INERTIAS[inertia])
        np.testing.assert_allclose(MODEL.modes(mechanism, pose).frequencies, f, rtol=1e-8)
        assert mechanism.platform.form == INERTIAS[inertia]


@pytest.mark.slow
def test_the_study_starts_from_a_mechanism_of_ones_own(tmp_path):
    """Its frequencies in a table, its parameters wrong by 10 %: found again, twice the same."""
    (tmp_path / "mine.toml").write_text(
        "[mechanisms.light]\nbase_radius_mm = 300\nplatform_radius_mm = 200\n"
        "platform_thickness_mm = 20\nrod_diameter_mm = 60\nyoung_GPa = 200\nshear_GPa = 77\n"
        'density_kg_m3 = 7820\n[cases.low]\nmechanism = "light"\nz_mm = 400\nazimuth_deg = 10\n'
        "tilt_deg = -12\n"
    )
    texts = {
        "case_file": str(tmp_path / "mine.toml"), "table": str(tmp_path / "measured.csv"),
        "parameters": "z_mm,rod_diameter_mm", "starts": "4", "references": "rayleigh@3",
        "bounds": "z_mm=350..600", "free": "1", "noise": "0.01",
    }  # fmt: skip
    (case,) = request(identification, texts).cases
    rod = Rod(case.mechanism.limbs[0].rod.material, 0.066)
    limbs = tuple(limb.with_rod(rod) for limb in case.mechanism.limbs)
    truth = replace(case.mechanism, limbs=limbs)
    f = MODEL.modes(truth, replace(case.pose, z=0.44)).frequencies
    (tmp_path / "measured.csv").write_text(
        "case,f1,f2,f3,f4,f5,f6\nlow," + ",".join(f"{x:.4f}" for x in f) + "\n"
    )
    with Bench() as bench:
        first, again = (identification.run(request(identification, texts), bench) for _ in "ab")
    (found,) = first.fits
    assert found.fitted == pytest.approx({"z_mm": 440.0, "rod_diameter_mm": 66.0}, rel=1e-4)
    assert first.to_frame().equals(again.to_frame())
    assert set(first.to_frame()["frames"]) == {"stated"}
    assert {row["case"] for row in first.rows()} == {"identified"}
    assert set(first.tables()) == {"", "-parameters", "-residuals", "-directions", "-quantities"}
    drawn_profiles_are_those_of(found, first.plot())


def drawn_profiles_are_those_of(found, figure):
    """S minimised anew at points of the curves is as far above its minimum as they are."""
    problem = found.problem
    residuals = problem.residuals(problem.table.logarithms[None])
    for k, axes in enumerate(figure.axes[: len(problem.names)]):
        values, heights = (row[[4, 16, 32, 44]] for row in axes.lines[0].get_data())
        at = np.tile(found.values, (4, 1))
        at[:, k] = values
        free = np.tile(np.arange(len(problem.names)) != k, (4, 1))
        x, owner = problem.to_x(at), np.zeros(4, dtype=np.intp)
        _, sums = minimise(residuals, x, free, *problem.limits, owner)
        np.testing.assert_allclose((sums - found.sum) / found.noise**2, heights, rtol=0.05)


def test_a_parameter_alone_is_drawn():
    """Both of its intervals are one."""
    found = identify(Problem(TABLE, MODEL, ("z_mm",)), starts=1)
    np.testing.assert_array_equal(found.alone, found.together)
    drawn_profiles_are_those_of(found, Identification((found,), (), ()).plot())


def test_a_run_about_ones_own_cases_says_nothing_of_the_papers_table(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text("[cases.low]\nz_mm = 400\n")
    own = plan({"case_file": str(file), "references": "rayleigh@3"})
    assert identification.jobs(own) == {}
    (one,) = identification.jobs(plan({"references": "rayleigh@3"})).values()
    assert one.theory == MODEL and [case.name for case in one.cases] == ["case1", "case2"]
    with Bench() as bench, pytest.raises(InputError, match="a CSV file with frequencies of low"):
        identification.run(request(identification, {"case_file": str(file)}), bench)


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"starts": "0"}, "starts = '0': expected a whole number from 1 to 256"),
        ({"free": "x"}, "free = 'x': expected a whole number from 0 to 5"),
        ({"inertia": "ring"}, "inertia = 'ring': expected one of disc, printed"),
        ({"frames": "all"}, "frames = 'all': expected one of stated, mirrored, both"),
        ({"noise": "0"}, "noise = '0': expected a percentage"),
        ({"bounds": "z_mm=5..4"}, "bounds = 'z_mm=5..4': expected NAME=LOW..HIGH"),
        ({"bounds": "mass=1..4"}, "bounds = 'mass': expected NAME=LOW..HIGH with one of"),
        ({"candidates": "mass"}, "candidates = 'mass': expected one of z_mm"),
        ({"model": "multipliers@3"}, "model = 'multipliers@3': expected a beam theory"),
        ({"method": "Guess"}, "method = 'Guess': expected one of FEA, Theoretical"),
        ({"table": "nowhere.csv"}, "table = 'nowhere.csv': expected 'published' or a readable"),
    ],
)
def test_bad_input_is_one_sentence(given, expected):
    with Bench() as bench, pytest.raises(InputError) as error:
        identification.run(request(identification, given), bench)
    assert str(error.value).startswith(expected)
