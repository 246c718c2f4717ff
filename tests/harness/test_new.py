"""`rps-bench new`: every template runs as it is, and nothing is written over."""

import re
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from harness.templates import FILES

ROOT = Path(__file__).parents[2]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("kind", ["case", "mechanism"])
def test_a_case_file(rps_bench: Callable[..., Any], here: Path, kind: str) -> None:
    made = rps_bench("new", kind, "my-robot")
    assert made.status == 0 and (here / "my-robot.toml").is_file()
    assert "run it: rps-bench table --case-file my-robot.toml" in made.out
    said = rps_bench("table", "--case-file", "my-robot.toml", "--references", "timoshenko@exact")
    assert said.status == 0, said.err
    assert "my-robot" in said.out and "NAME" not in (here / "my-robot.toml").read_text()
    again = rps_bench("new", kind, "my-robot")
    assert again.status == 2 and "one whose files are not there yet (my-robot.toml)" in again.err


def test_the_chain_that_is_commented_out_runs_too(
    rps_bench: Callable[..., Any], here: Path
) -> None:
    assert rps_bench("new", "mechanism", "mine").status == 0
    text = (here / "mine.toml").read_text()
    head, mark, chain = text.partition("# [materials.steel]")
    bare = re.sub(r"^# ?", "", mark + chain, flags=re.MULTILINE)
    (here / "mine.toml").write_text(head + bare)
    said = rps_bench("stiffness", "--case-file", "mine.toml", "--cases", "mine-moved")
    assert said.status == 0, said.err
    assert "of that is P joint (item 3): stiffen it first" in said.out


def test_a_paper(rps_bench: Callable[..., Any], here: Path) -> None:
    assert rps_bench("new", "paper", "other").status == 0
    said = rps_bench("table", "--case-file", "other", "--references", "timoshenko@exact")
    assert said.status == 0, said.err
    assert "6 of the 6 values that other prints (Theory) agree with euler-bern" in " ".join(
        said.out.split()
    )
    claims = rps_bench("claims", "--case-file", "other")
    assert claims.status == 0 and "2 statements" in claims.out, claims.err
    found = rps_bench("identify", "--case-file", "other", "--method", "Theory", "--parameters",
                      "z_mm", "--references", "rayleigh@3", "--starts", "2")  # fmt: skip
    assert found.status == 0 and "450.0" in found.out, found.err


def test_a_study(rps_bench: Callable[..., Any], here: Path) -> None:
    assert rps_bench("new", "study", "my-study").status == 0
    ran = subprocess.run([sys.executable, "my_study.py"], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    assert "case2: timoshenko@exact is down to 0.945 of euler-bernoulli@exact." in ran.stdout


@pytest.mark.slow
def test_a_model(
    rps_bench: Callable[..., Any], here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert rps_bench("new", "model", "my-rods").status == 0
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", "dist"]
    subprocess.run(build, check=True, capture_output=True)
    with zipfile.ZipFile(next(here.glob("dist/*.whl"))) as wheel:
        wheel.extractall(here / "site")
    monkeypatch.setenv("PYTHONPATH", str(here / "site"))
    monkeypatch.syspath_prepend(here / "site")
    said = rps_bench("table", "--references", "my-rods@8")
    assert said.status == 0 and "my-rods@8" in said.out, said.err
    assert 'verify_model("my-rods")' in (here / "test_my_rods.py").read_text()


def test_the_model_is_that_of_the_docs() -> None:
    """It is verified there; the page shows what the template has."""
    page = (ROOT / "docs" / "how-to" / "own-simulator.md").read_text()
    shown = re.findall(r"```(?:python|toml)\n(.*?)```", page, re.DOTALL)
    sources = FILES["model"].values()
    assert shown == [(ROOT / "harness" / "new" / f"{one}.txt").read_text() for one in sources]


def test_what_cannot_be_made(rps_bench: Callable[..., Any], here: Path) -> None:
    said = rps_bench("new", "robot", "x")
    assert said.status == 2 and "'robot': expected one of case, mechanism, model" in said.err
    said = rps_bench("new", "case", "My Robot")
    assert said.status == 2 and "lower-case letters, digits and hyphens" in said.err
    assert not [*here.iterdir()]
