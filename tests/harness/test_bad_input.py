"""Bad input: one clear sentence with the argument, its value and what was expected."""

import math
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

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
from reference_models import reference

GOOD = """
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
STEEL = Material(200e9, 77e9, 7820)
DISC = Platform.disc(0.2, 0.02, 7820)
ROD = Rod(STEEL, 0.1)

SWEEP = ["sweep", "--models", "rayleigh@1", "--poses", "pose:490,0,0"]

# What is typed, and what the sentence must name: argument, value, expectation.
COMMANDS = [
    (["table", "--cases", "case9"], "--cases", "'case9'", "case1"),
    (["table", "--cases", "case1,,case2"], "--cases", "'case1,,case2'", "separated by commas"),
    (["table", "--cases", ""], "--cases", "''", "names"),
    (["table", "--references", "ansys"], "--references", "'ansys'", "exudyn-beam"),
    (
        ["table", "--references", "exudyn-beam@0"],
        "--references",
        "'exudyn-beam@0'",
        "elements as in",
    ),
    (["table", "--references", "exudyn-beam@24+12"], "--references", "24+12", "elements as in"),
    (["table", "--references", "exudyn-beam@exact"], "--references", "@exact", "elements as in"),
    (["table", "--references", "exudyn-cable@1.5"], "--references", "1.5", "elements as in"),
    (["table", "--references", ""], "--references", "''", "names"),
    (["table", "--model", "exudyn-beam"], "--model", "'exudyn-beam'", "an analytic model"),
    (["table", "--model", "euler@3"], "--model", "'euler@3'", "one of euler-bernoulli"),
    (["table", "--model", "timoshenko@x"], "--model", "'timoshenko@x'", "elements as in"),
    (["table", "--modes", "0"], "--modes", "'0'", "whole numbers"),
    (["table", "--modes", "six"], "--modes", "'six'", "whole numbers"),
    (["table", "--modes", "3-1"], "--modes", "'3-1'", "whole numbers"),
    (["table", "--modes", "1-"], "--modes", "'1-'", "whole numbers"),
    (["table", "--modes", "101"], "--modes", "'101'", "1 to 100"),
    (["table", "--elements", "-3"], "--elements", "'-3'", "whole numbers"),
    (["convergence", "--elements", "1,two"], "--elements", "'1,two'", "whole numbers"),
    (["convergence", "--elements", "1000000"], "--elements", "'1000000'", "1 to 512"),
    (["convergence", "--shear", "big"], "--shear", "'big'", "cowper"),
    (["convergence", "--shear", "-1"], "--shear", "'-1'", "positive"),
    (["convergence", "--shear", "nan"], "--shear", "'nan'", "positive"),
    (["table", "--case-file", "missing.toml"], "--case-file", "missing.toml", "readable file"),
    (["table", "--output", ""], "--output", "''", "folder"),
    (["work-precision", "--truth", "timoshenko"], "--truth", "'timoshenko'", "a solid model"),
    (["work-precision", "--truth", "ansys"], "--truth", "'ansys'", "calculix-solid"),
    (["work-precision", "--repeats", "0"], "--repeats", "'0'", "a whole number from 1 to 1000"),
    (["reproduce", "--only", "table9"], "--only", "'table9'", "some of table1"),
    (["cost", "--elements", "0"], "--elements", "'0'", "whole numbers"),
    (["cost", "--elements", "1-64"], "--elements", "'1-64'", "at most 32 sizes"),
    (["cost", "--references", "ansys"], "--references", "'ansys'", "exudyn-beam"),
    (["cost", "--references", "exudyn-beam@8"], "--references", "'exudyn-beam@8'", "without @"),
    (["cost", "--repeats", "0"], "--repeats", "'0'", "a whole number from 1 to 1000"),
    (["cost", "--repeats", "often"], "--repeats", "'often'", "a whole number"),
    (["cost", "--batches", "1,1e3"], "--batches", "'1,1e3'", "whole numbers from 1 to 1000000"),
    (["cost", "--batches", "2000000"], "--batches", "'2000000'", "1 to 1000000"),
    (["cost", "--output", ""], "--output", "''", "folder"),
    (["cost", "--cases", "case1"], "--cases", "", "No such option"),
    (["check", "--compare", "mujoco"], "--compare", "'mujoco'", "two requirements, as in mujoco"),
    (["check", "--compare", "mujoco,"], "--compare", "'mujoco,'", "two requirements"),
    (["check", "--compare", "a==1,a==2"], "--compare", "'a==1,a==2'", "a simulator's package"),
    (["check", "--compare", "a==1,a==2", "--quick"], "--compare", "'a==1,a==2'", "no option"),
    (["table", "--history", ""], "--history", "''", "the name of a folder, or none"),
    (["table", "--history", __file__], "--history", "test_bad_input.py'", "the name of a folder"),
    (["table", "--colour", "red"], "--colour", "", "No such option"),
    (["workspace", "--model", "ansys"], "--model", "'ansys'", "one of euler-bernoulli"),
    (["workspace", "--modes", "0"], "--modes", "'0'", "whole numbers"),
    (["workspace", "--layers", "high"], "--layers", "'high'", "between 173.2 and 995.0 mm"),
    (["workspace", "--layers", "300,1200"], "--layers", "'300,1200'", "995.0 mm"),
    (["workspace", "--layers", ""], "--layers", "''", "heights z"),
    (["workspace", "--grid", "72"], "--grid", "'72'", "azimuths, a multiple of the 3 limbs"),
    (["workspace", "--grid", "20x5"], "--grid", "'20x5'", "a multiple of the 3 limbs"),
    (["workspace", "--grid", "72x1"], "--grid", "'72x1'", "2 tilts or more"),
    (["workspace", "--grid", "90000x90"], "--grid", "'90000x90'", "poses a layer"),
    (["workspace", "--length-min-mm", "-1"], "--length-min-mm", "'-1'", "millimetres from 0"),
    (["workspace", "--length-max-mm", "100"], "--length-max-mm", "'100'", "more than"),
    (["workspace", "--length-max-mm", "nan"], "--length-max-mm", "'nan'", "millimetres"),
    (["workspace", "--spherical-max-deg", "0"], "--spherical-max-deg", "'0'", "degrees above 0"),
    (["workspace", "--revolute-max-deg", "x"], "--revolute-max-deg", "'x'", "at most 180"),
    (["workspace", "--cases", "case1,case2"], "--cases", "'case1,case2'", "one case"),
    (["workspace", "--shear", "big"], "--shear", "'big'", "cowper"),
    (["workspace", "--history", ""], "--history", "''", "the name of a folder, or none"),
    (["claims", "--only", "table1"], "--only", "'table1'", "ids that `rps-bench claims` lists"),
    (["claims", "--only", "eq2-plane,"], "--only", "'eq2-plane,'", "separated by commas"),
    (["claims", "--output", ""], "--output", "''", "folder"),
    (["tabel"], "tabel", "", "No such command"),
    (["table", "--cases"], "--cases", "", "requires an argument"),
    ([*SWEEP[:3], "--poses", "all"], "--poses", "'all'", "random:N"),
    ([*SWEEP[:3], "--poses", "random:0"], "--poses", "'random:0'", "N above 0"),
    ([*SWEEP[:3], "--poses", "grid:tilt=3"], "--poses", "'grid:tilt=3'", "heights"),
    ([*SWEEP[:3], "--poses", "pose:490,nan,0"], "--poses", "nan", "mm and degrees"),
    ([*SWEEP[:3], "--poses", "absent.csv"], "--poses", "'absent.csv'", "No such file"),
    (["sweep", *SWEEP[3:], "--models", "ansys"], "--models", "'ansys'", "exudyn-beam"),
    ([*SWEEP, "--against", "rayleigh@1"], "--against", "'rayleigh@1'", "not the only one"),
    ([*SWEEP, "--modes", "0"], "--modes", "'0'", "whole numbers"),
    ([*SWEEP, "--format", "xls"], "--format", "'xls'", "parquet or csv"),
    ([*SWEEP, "--cores", "0"], "--cores", "'0'", "from 1"),
    ([*SWEEP, "--tries", "x"], "--tries", "'x'", "from 1"),
    ([*SWEEP, "--time-limit", "-1"], "--time-limit", "-1", "positive"),
    ([*SWEEP, "--output", ""], "--output", "''", "folder"),
    ([*SWEEP, "--scheduler", "nonsense"], "--scheduler", "'nonsense'", "tcp://HOST:PORT"),
    ([*SWEEP, "--scheduler", "ftp://here:1"], "--scheduler", "'ftp://here:1'", "address scheme"),
    (["identify", "--table", "missing.csv"], "--table", "missing.csv", "readable CSV"),
    (["identify", "--method", "ANSYS"], "--method", "'ANSYS'", "Theoretical or FEA"),
    (["identify", "--parameters", "mass"], "--parameters", "'mass'", "one of z_mm"),
    (["identify", "--parameters", "case9.z_mm"], "--parameters", "case9.z_mm", "one of z_mm"),
    (["identify", "--candidates", "z_mm,"], "--candidates", "'z_mm,'", "separated by commas"),
    (["identify", "--candidates", "mass"], "--candidates", "'mass'", "one of z_mm"),
    (["identify", "--free", "9"], "--free", "'9'", "0 to 5"),
    (["identify", "--bounds", "z_mm=7"], "--bounds", "'z_mm=7'", "NAME=LOW..HIGH"),
    (["identify", "--bounds", "z_mm=700..400"], "--bounds", "700..400", "LOW below HIGH"),
    (["identify", "--bounds", "E=1..2"], "--bounds", "'E=1..2'", "one of"),
    (["identify", "--model", "exudyn-beam"], "--model", "'exudyn-beam'", "an analytic model"),
    (["identify", "--inertia", "ring"], "--inertia", "'ring'", "disc, printed"),
    (["identify", "--frames", "upside"], "--frames", "'upside'", "stated, mirrored, both"),
    (["identify", "--starts", "0"], "--starts", "'0'", "1 to 256"),
    (["identify", "--noise", "-1"], "--noise", "'-1'", "percentage"),
    (["identify", "--seed", "x"], "--seed", "'x'", "whole number"),
    (["identify", "--output", ""], "--output", "''", "folder"),
    (["identify", "--history", ""], "--history", "''", "the name of a folder, or none"),
    (["cost", "--history", ""], "--history", "''", "the name of a folder, or none"),
    (["work-precision", "--history", ""], "--history", "''", "the name of a folder, or none"),
    (["claims", "--history", ""], "--history", "''", "the name of a folder, or none"),
    (["dashboard", "--output", ""], "--output", "''", "name of a file"),
    (["dashboard", "--results", "nowhere"], "--results", "'nowhere'", "rps-bench reproduce"),
    (["dashboard", "--results", ""], "--results", "''", "a folder"),
]

CASE_FILES = [
    ("not = [toml", "--case-file", "a TOML file"),
    ("", "--case-file", "at least one [cases.NAME] table"),
    (GOOD.replace("z_mm = 400", "z_mm = nan"), "cases.low.z_mm = nan", "a finite number"),
    (GOOD.replace("z_mm = 400", ""), "cases.low.z_mm = None", "a finite number"),
    (GOOD.replace("z_mm", "z_m"), "cases.low = 'z_m'", "only the keys"),
    (GOOD.replace('"light"', '"heavy"'), "cases.low.mechanism = 'heavy'", "light"),
    (GOOD.replace("cases.low", "cases.case1"), "cases.case1 = 'case1'", "no built-in case"),
    (GOOD.replace("= 60", "= -60"), "Rod.diameter = -0.06", "a positive number of metres"),
    (GOOD.replace("= 77", "= 0"), "Material.shear = 0.0", "a positive pascals"),
    (GOOD.replace("= 77", "= 20"), "Material.shear", "more than a third of young"),
    (GOOD.replace("= 300", '= "wide"'), "base_radius_mm = 'wide'", "a finite number"),
    (GOOD.replace("= 7820", "= inf"), "density_kg_m3 = inf", "a finite number"),
    (GOOD + "tilt_deg = true", "cases.low.tilt_deg = True", "a finite number"),
    (GOOD + 'model = "exudyn-beam"', "cases.low.model = 'exudyn-beam'", "an analytic model"),
    (GOOD.replace("[cases.low]", "limbs = 2.5\n[cases.low]"), "limbs = 2.5", "a whole number"),
    (GOOD.replace("[cases.low]", 'inertia = "ball"\n[cases.low]'), "inertia = 'ball'", "'disc'"),
    (
        GOOD.replace("[cases.low]", "limbs = 4\n[cases.low]") + "azimuth_deg = 20\ntilt_deg = 5",
        "pose = 'z=0.4",
        "revolute joint's plane",
    ),
]

CALLS: list[tuple[Callable[[], Any], str, str]] = [
    (lambda: Material(math.nan, 77e9, 7820), "Material.young = nan", "a positive"),
    (lambda: Material(200e9, 77e9, -1), "Material.density = -1", "a positive"),
    (lambda: Material("steel", 77e9, 1), "Material.young = 'steel'", "a positive"),  # type: ignore[arg-type]
    (lambda: Rod(STEEL, 0), "Rod.diameter = 0", "a positive number of metres"),
    (lambda: Rod("steel", 0.1), "Rod.material = 'steel'", "a Material"),  # type: ignore[arg-type]
    (lambda: Platform.disc(-0.2, 0.02, 7820), "Platform radius = -0.2", "a positive"),
    (lambda: Platform.diagonal(0, (1, 1, 1)), "Platform.mass = 0", "a positive"),
    (lambda: Platform.diagonal(1, (1, 1, -1)), "Platform.inertia", "positive definite"),
    (lambda: Platform(1, ((1, 2, 0), (0, 1, 0), (0, 0, 1))), "Platform.inertia", "symmetric"),
    (lambda: Limb((0, 0), (0, 1, 0), (0, 0, 0), ROD), "Limb.base = (0, 0)", "three"),  # type: ignore[arg-type]
    (lambda: Limb((0, 0, 0), (0, 0, 0), (0, 0, 0), ROD), "Limb.axis", "other than zero"),
    (lambda: Mechanism((), DISC), "Mechanism.limbs = ()", "at least one Limb"),
    (lambda: Mechanism.paper(inertia="sphere"), "inertia = 'sphere'", "'disc' or 'printed'"),
    (lambda: Mechanism.regular(0.3, 0.2, ROD, DISC, limbs=0), "limbs = 0", "at least 1"),
    (lambda: Pose(math.nan), "Pose.z = nan", "finite numbers of metres"),
    (lambda: Pose(0.5, 0.0, np.array([0.1, np.inf])), "Pose.tilt", "finite numbers of radians"),
    (lambda: Pose("high"), "Pose.z = 'high'", "finite numbers of metres"),
    (lambda: Pose(np.zeros(2), np.zeros(3)), "Pose = ", "matching shapes"),
    (lambda: Substructure(0), "elements = 0", "a whole number of at least 1"),
    (lambda: Substructure(2.0), "elements = 2.0", "a whole number"),  # type: ignore[arg-type]
    (lambda: Substructure(3, "euler"), "beam = 'euler'", "euler-bernoulli"),
    (lambda: Substructure(3, shear=-0.9), "shear = -0.9", "a positive shear coefficient"),
    (lambda: Substructure(3, solver="lanczos"), "solver = 'lanczos'", "dense, sparse"),
    (lambda: Substructure(1).modes(Mechanism.paper(), Pose(0.5), 19), "count = 19", "at most 18"),
    (lambda: Substructure(1).modes(Mechanism.paper(), Pose(0.5), 0), "count = 0", "at least 1"),
    (
        lambda: Substructure(1).modes(Mechanism.paper(), Pose(np.full(2, 0.5))),
        "pose = '(2,) poses'",
        "one pose at a time",
    ),
    (
        lambda: limbs_at(Mechanism.regular(0.2, 0.2, ROD, DISC), Pose(0.0)),
        "pose = 'z=0.0",
        "limbs of some length",
    ),
    (lambda: reference("ansys"), "reference = 'ansys'", "exudyn-beam"),
    (lambda: reference("exudyn-cable", elements=0), "elements = 0", "a whole number"),
    (lambda: reference("exudyn-cable", elements=(8, 4)), "elements = (8, 4)", "the smaller first"),
    (lambda: reference("exudyn-cable", colour="red"), "settings", "unexpected keyword"),
]


@pytest.mark.parametrize(
    ("arguments", "argument", "value", "expected"), COMMANDS, ids=[" ".join(c[0]) for c in COMMANDS]
)
def test_command_line(
    rps_bench: Callable[..., Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: list[str],
    argument: str,
    value: str,
    expected: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    if "--output" not in arguments and len(arguments) > 2:
        arguments = [*arguments, "--output", "out"]
    one_sentence(rps_bench(*arguments), argument, value, expected)
    assert not list(tmp_path.iterdir()), "nothing half-written"


@pytest.mark.parametrize(("text", "named", "expected"), CASE_FILES, ids=[c[1] for c in CASE_FILES])
def test_case_files(
    rps_bench: Callable[..., Any], tmp_path: Path, text: str, named: str, expected: str
) -> None:
    file, out = tmp_path / "cases.toml", tmp_path / "out"
    file.write_text(text)
    answer = rps_bench("table", "--case-file", str(file), "--output", str(out))
    one_sentence(answer, named, expected)
    assert not out.exists()


def one_sentence(answer: Any, *parts: str) -> None:
    assert answer.status == 2
    lines = answer.err.strip().splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("rps-bench: ")
    for part in parts:
        assert part in lines[0]
    assert "Traceback" not in answer.err
    assert answer.out == ""


@pytest.mark.parametrize(("call", "named", "expected"), CALLS, ids=[c[1] for c in CALLS])
def test_python(call: Callable[[], Any], named: str, expected: str) -> None:
    with pytest.raises(InputError) as refused:
        call()
    text = str(refused.value)
    assert named in text
    assert expected in text.split("expected", 1)[1]
    assert "\n" not in text


def test_a_folder_that_cannot_be_written(rps_bench: Callable[..., Any], tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("mine")
    answer = rps_bench("table", "--references", "exudyn-cable@2", "--output", str(blocked))
    assert answer.status == 2
    assert f"--output = '{blocked}': cannot write there" in answer.err
    assert blocked.read_text() == "mine"


@pytest.mark.slow
def test_a_process_ends_the_same_way() -> None:
    """Through the installed command: no traceback, exit status 2."""
    command = [str(Path(sys.executable).with_name("rps-bench")), "table", "--cases", "case9"]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert ended.returncode == 2
    assert ended.stderr.startswith("rps-bench: --cases = 'case9': expected one of case1, ")
    assert ended.stderr.count("\n") == 1
