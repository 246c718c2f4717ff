"""Case files as people write them: read, or refused in one sentence in the file's own words."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analytic import Continuum, InputError
from harness.case_file import load_cases

RODS = """
young_GPa = 200
shear_GPa = 77
density_kg_m3 = 7820
rod_diameter_mm = 60
"""
REGULAR = f"""[mechanisms.m]{RODS}base_radius_mm = 300
platform_radius_mm = 200
platform_thickness_mm = 20
"""
BODY = "platform_mass_kg = 1\nplatform_inertia_kg_m2 = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n"
ONE = (
    "[[mechanisms.m.limb]]\nbase_mm = [0, 0, 0]\naxis = [0, 1, 0]\nplatform_point_mm = [0, 0, 0]\n"
)
GIVEN = f"[mechanisms.m]{RODS}{BODY}"
DISC = """[mechanisms.m]
platform = {radius_mm = 200, thickness_mm = 20, density_kg_m3 = 7820}
"""
CHAIN = 'platform_point_mm = [200, 0, 0]\nchain = [{joint = "S"}, {rod = "r"}, {joint = "S"}]\n'
CHAIN += "[rods.r]\nmaterial = 's'\ndiameter_mm = 20\n[materials.s]\nyoung_GPa = 200\n"
CHAIN += "shear_GPa = 77\ndensity_kg_m3 = 7820\n"
CASE = '[cases.a]\nmechanism = "m"\nz_mm = 400\n'
LONG = 400 * "9"

# What is written, and the sentence: key and value of the file, and what was expected, in its units.
REFUSED = {
    "a list for a name": ('[cases.a]\nmechanism = ["paper"]\nz_mm = 490',
                          r"cases\.a\.mechanism = \['paper'\]: expected one of paper, "),
    "a list for a form": (REGULAR + 'inertia = ["disc"]\n' + CASE,
                          r"mechanisms\.m\.inertia = \['disc'\]: expected one of disc, printed"),
    "a number for limbs": (f"{GIVEN}limb = 3\n{CASE}",
                           r"mechanisms\.m\.limb = 3: expected tables called \[\[mechanisms\.m"),
    "no limbs": (f"{GIVEN}limb = []\n{CASE}", r"mechanisms\.m\.limb = \[\]: expected tables"),
    "400 digits": (f"[cases.a]\nz_mm = {LONG}", r"cases\.a\.z_mm = a whole number of 1329 bits: "),
    "400 digits, limbs": (f"{REGULAR}limbs = {LONG}\n{CASE}",
                          r"mechanisms\.m\.limbs = a whole number of 1329 bits: expected .* 1000"),
    "5000 digits": (f"[cases.a]\nz_mm = 4\ntilt_deg = {5000 * '9'}",
                    "at most 4300 digits in tilt_deg of line 3"),
    "brackets": (f"[cases.a]\nz_mm = {2000 * '['}{2000 * ']'}", "fewer brackets in z_mm of line 2"),
    "10^30 limbs": (f"{REGULAR}limbs = {10**30}\n{CASE}", r"mechanisms\.m\.limbs = 10{30}: "),
    "pascals": (REGULAR.replace("= 200\n", "= 200e9\n", 1) + CASE,
                r"shear_GPa = 77\.0: expected more than a third of young_GPa = 2e\+11"),
    "no stiffness": (REGULAR.replace("young_GPa = 200", "young_GPa = 1e-300") + CASE,
                     r"young_GPa = 1e-300: expected 1e-39 to 1e\+21"),
    "below zero": (REGULAR.replace("base_radius_mm = ", "base_radius_mm = -") + CASE,
                   r"base_radius_mm = -300: expected a positive number of millimetres"),
    "an invisible rod": (REGULAR.replace("meter_mm = 60", "meter_mm = 1e-7") + CASE,
                         r"rod_diameter_mm = 1e-07: expected 1e-06 to 1e\+12 millimetres"),
    "no body": (f"{GIVEN.replace('[0, 0, 1]]', '[0, 0, 3]]')}{ONE}{CASE}",
                r"platform_inertia_kg_m2 = .* none exceeds the sum of the others, not 1, 1, 3"),
    "no axis": (GIVEN + ONE.replace("[0, 1, 0]", "[0, 0, 0]") + CASE,
                r"mechanisms\.m\.limb\.axis = \[0, 0, 0\]: expected a direction"),
    "an axis left out": (GIVEN + ONE.replace("axis = [0, 1, 0]", "") + CASE,
                         r"mechanisms\.m\.limb\.axis = None: expected a direction"),
    "too far": ("[cases.a]\nz_mm = 1e300", r"cases\.a\.z_mm = 1e\+300: expected at most 1e\+12 m"),
    "no rods": (
        f"{DISC}"
        "[[mechanisms.m.limbs]]\nbase_mm = [300, 0, 0]\nplatform_point_mm = [200, 0, 0]\n"
        'chain = [{joint = "S"}, {rod = "link"}, {joint = "S"}]\n' + CASE,
        r"chain\[1\]\.rod = 'link': expected a known one, and there is none",
    ),
    "one load for many": (
        f"{DISC}"
        f"payloads = 3\n[[mechanisms.m.limbs]]\nbase_mm = [300, 0, 0]\n{CHAIN}{CASE}",
        r"mechanisms\.m\.payloads = 3: expected tables called \[\[mechanisms\.m\.payloads\]\]"),
    "a number for tilts": (
        DISC + "[[mechanisms.m.limbs]]\nbase_mm = [300, 0, 0]\n"
        + CHAIN.replace("{rod", "{joint = 'fixed', tilt_stiffness_Nm_rad = 3}, {rod") + CASE,
        r"chain\[1\]\.tilt_stiffness_Nm_rad = 3: expected stiffnesses by the x,y,z of their axes"),
    "a disc without radius": (
        f"{DISC.replace('200', '0')}"
        f"[[mechanisms.m.limbs]]\nbase_mm = [300, 0, 0]\n{CHAIN}{CASE}",
        r"mechanisms\.m\.platform\.radius_mm = 0: expected a positive number of millimetres"),
    "text": ('[cases.a]\nz_mm = "490"', r"cases\.a\.z_mm = '490': expected a finite number of m"),
}  # fmt: skip


def written(folder: Path, text: str) -> Path:
    path = folder / "mine.toml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("what", REFUSED)
def test_refused_in_the_words_of_the_file(tmp_path: Path, what: str) -> None:
    text, says = REFUSED[what]
    with pytest.raises(InputError, match=says) as told:
        load_cases(written(tmp_path, text))
    assert "\n" not in str(told.value) and len(str(told.value)) < 400


def test_the_sentence_is_typed_as_the_file_spells_it(
    rps_bench: Callable[..., Any], tmp_path: Path
) -> None:
    """A key of the file is no flag; what would steer a terminal is shown escaped."""
    path = written(tmp_path, '[cases."\\u001b[31mred"]\nz_mm = "x"\n')
    answer = rps_bench("table", "--case-file", str(path))
    assert answer.status == 2
    assert answer.err.startswith(r"rps-bench: cases.\x1b[31mred.z_mm = 'x': expected")


def test_a_byte_order_mark_is_none_of_the_text(tmp_path: Path) -> None:
    (case,) = load_cases(written(tmp_path, "\ufeff[cases.low]\nz_mm = 490\n")).values()
    assert case.pose.z == 0.49


@pytest.mark.parametrize(("limbs", "free"), [(1, 4), (2, 2)])
def test_few_limbs_leave_free_motions(
    rps_bench: Callable[..., Any], tmp_path: Path, limbs: int, free: int
) -> None:
    """0 Hz, and against 0 Hz a dash: in every study that divides by a frequency."""
    path = written(tmp_path, f"{REGULAR}limbs = {limbs}\n{CASE}")
    (case,) = load_cases(path).values()
    exact = Continuum().modes(case.mechanism, case.pose).frequencies
    assert (exact[:free] == 0).all() and exact[free] > 100
    for command in ("table", "convergence", "refine", "budget"):
        given = {"convergence": ("--elements", "1,2,4"), "refine": ("--elements", "1,2,4")}
        answer = rps_bench(
            command, "--case-file", str(path), "--references", "euler-bernoulli@exact",
            *given.get(command, ()),
        )  # fmt: skip
        assert answer.status == 0, answer.err
        assert "nan" not in answer.out and "inf " not in answer.out, command
        assert "-100" not in answer.out, command
    answer = rps_bench("sweep", "--case-file", str(path), "--case", "a", "--poses", "pose:400,0,0",
                       "--models", "euler-bernoulli@4,euler-bernoulli@exact",
                       "--against", "euler-bernoulli@exact")  # fmt: skip
    assert answer.status == 0, answer.err
    assert "nan" not in answer.out


def test_names_never_become_paths(rps_bench: Callable[..., Any], tmp_path: Path) -> None:
    """Neither those of cases nor those of models, whose settings may hold a slash."""
    path = written(tmp_path, '[cases."a/../../../escaped"]\nz_mm = 490\n')
    out = tmp_path / "deep" / "out"
    answer = rps_bench("shapes", "--case-file", str(path), "--modes", "1",
                       "--references", "timoshenko@exact[shear=6/7]",
                       "--output", str(out))  # fmt: skip
    assert answer.status == 0, answer.err
    files = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert {p.parent for p in files} == {out, tmp_path}
    assert any("escaped" in p.name for p in files) and any("6-7" in p.name for p in files)


def test_the_case_of_the_documents_is_answered(tmp_path: Path) -> None:
    """A cantilever with a mass at its tip: beta^2 = 1.557298 clamped, 10.714402 pinned."""
    rods = RODS.replace("7820", "7800").replace("= 60", "= 20")
    mass = 7800 * np.pi * 0.02**2 / 4
    body = f"platform_mass_kg = {mass!r}\n{BODY.splitlines()[1].replace('1', '1e-4')}\n"
    text = f"[mechanisms.m]{rods}{body}{ONE}{CASE.replace('400', '1000')}"
    (case,) = load_cases(written(tmp_path, text)).values()
    found = Continuum().modes(case.mechanism, case.pose).frequencies
    unit = np.sqrt(200e9 / 7800) * 0.02 / 4 / (2 * np.pi)
    assert (found[:4] == 0).all()
    np.testing.assert_allclose(found[4:] / unit, [1.557298, 10.714402], atol=1e-6)
