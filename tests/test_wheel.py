"""The wheel in an environment of its own: every command runs in a folder that has nothing else."""

import os
import site
import subprocess
import sys
import tomllib
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    ended = subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(folder)],
        cwd=ROOT, capture_output=True, text=True,
    )  # fmt: skip
    assert ended.returncode == 0, ended.stderr
    (made,) = folder.glob("*.whl")
    return made


@pytest.fixture(scope="module")
def program(wheel: Path) -> Path:
    """`rps-bench` installed from the wheel; what it needs is looked for where it is here."""
    folder = wheel.parent / "env"
    venv.create(folder, with_pip=True)
    python = folder / "bin" / "python"
    subprocess.run(
        [python, "-m", "pip", "install", "-q", "--no-deps", "--no-index", wheel], check=True
    )
    (packages,) = folder.glob("lib/python*/site-packages")
    # A path in such a file is searched, but the files of its kind in there are not read: this
    # checkout, which one of them adds, stays out.
    (packages / "more.pth").write_text("\n".join(site.getsitepackages()))
    return folder / "bin" / "rps-bench"


def call(
    program: Path, folder: Path, *arguments: str, past: Path | None = None
) -> subprocess.CompletedProcess[str]:
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    environment["RPS_BENCH_HISTORY"] = str(past or "none")
    return subprocess.run(
        [program, *arguments], cwd=folder, env=environment, capture_output=True, text=True
    )


def test_it_holds_what_it_says(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as file:
        names = file.namelist()
        (about,) = (name for name in names if name.endswith(".dist-info/METADATA"))
        said = file.read(about).decode()
    for name in (
        *(f"{package}/py.typed" for package in ("analytic", "reference_models", "harness")),
        "harness/accepted_baseline/frequencies.csv",
        "harness/published_data/gong-lou-2023/cases.toml",
        "harness/studies/claims/findings.toml",
        "harness/report/templates/page.html",
    ):
        assert name in names
    assert not [name for name in names if name.startswith(("tests", "docs"))]
    assert "License-Expression: BSD-3-Clause" in said
    asked = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
    assert said.count("Requires-Dist: ") - said.count("; extra ==") == len(asked)


def test_it_is_what_runs(program: Path, tmp_path: Path) -> None:
    python = program.with_name("python")
    code = "import analytic, harness; print(analytic.__file__, harness.__file__)"
    found = call(python, tmp_path, "-c", code).stdout
    assert found.count(str(program.parents[1])) == 2


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("table", "--references", "timoshenko@exact"), "Table I: natural frequencies"),
        (("check", "--help"), "Compare with the accepted figures"),
        (("check", "--quick", "--models", "rayleigh"), "nothing moved"),
        (("models",), "calculix-solid"),
        (("history",), "check --models rayleigh"),
    ],
    ids=lambda x: x[0] if isinstance(x, tuple) else "",
)
def test_a_command_in_an_empty_folder(
    program: Path, tmp_path_factory: pytest.TempPathFactory, arguments: tuple[str, ...], says: str
) -> None:
    past = program.parents[2] / "past"
    ended = call(program, tmp_path_factory.mktemp("empty"), *arguments, past=past)
    assert ended.returncode == 0, ended.stderr
    assert says in ended.stdout and ended.stderr == ""


def test_the_page_of_a_run(program: Path, tmp_path: Path) -> None:
    lost = call(program, tmp_path, "dashboard", "--output", "page.html")
    assert lost.returncode == 2 and "`rps-bench reproduce`" in lost.stderr
    made = call(program, tmp_path, "reproduce", "--only", "table", "--references", "exudyn-cable@4")
    assert made.returncode == 0, made.stderr
    again = call(program, tmp_path, "dashboard", "--output", "page.html")
    assert again.returncode == 0, again.stderr
    assert (tmp_path / "page.html").stat().st_size > 1e6
