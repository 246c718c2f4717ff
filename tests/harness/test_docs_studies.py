"""docs/studies.md, exactly as it stands: a study is one file and one line."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
BLOCKS = dict(
    zip(
        ("notebook", "study", "line", "command"),
        re.findall(r"```\w+\n(.*?)```", (ROOT / "docs" / "studies.md").read_text(), re.DOTALL),
        strict=True,
    )
)
START = "from harness.cli.main import main; main()"
MINE = """
[cases.low]
z_mm = 400
tilt_deg = 5
"""


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """The harness with the study of the text in it."""
    shutil.copytree(ROOT / "harness", tmp_path / "harness")
    shutil.copytree(ROOT / "results" / "published", tmp_path / "results" / "published")
    (tmp_path / "harness" / "studies" / "ratios.py").write_text(BLOCKS["study"])
    listed = tmp_path / "harness" / "studies" / "__init__.py"
    before, found, after = listed.read_text().partition("STUDIES = (\n")
    listed.write_text(f"{before}{found}{BLOCKS['line']}{after}")
    return tmp_path


def call(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    paths = os.pathsep.join([str(folder), str(ROOT)])
    return subprocess.run(
        [sys.executable, "-P", "-c", START, *arguments],
        cwd=folder, env=os.environ | {"PYTHONPATH": paths}, capture_output=True, text=True,
    )  # fmt: skip


@pytest.mark.slow
def test_the_study_of_the_text(copy: Path) -> None:
    program, *arguments = shlex.split(BLOCKS["command"].removeprefix("$ "))
    assert program == "rps-bench"
    ended = call(copy, *arguments)
    assert ended.returncode == 0, ended.stderr
    assert "case2: f2/f1 of timoshenko@exact is 1.197." in " ".join(ended.stdout.split())
    assert "Frequencies over the lowest" in ended.stdout and "f3/f1" in ended.stdout
    assert "Show each frequency over the lowest." in call(copy, "--help").stdout
    made = call(copy, "reproduce", "--only", "ratios", "--references", "timoshenko@exact",
                "--output", "out")  # fmt: skip
    assert made.returncode == 0, made.stderr
    names = {path.name for path in (copy / "out").iterdir()}
    assert {"ratios.csv", "ratios.md", "ratios.tex", "ratios-data.csv"} <= names
    assert "case2: f2/f1 of timoshenko@exact is 1.197" in (copy / "out" / "findings.md").read_text()


@pytest.mark.slow
def test_the_notebook_of_the_text(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(MINE)
    (tmp_path / "notebook.py").write_text(BLOCKS["notebook"])
    ended = subprocess.run(
        [sys.executable, "notebook.py"], cwd=tmp_path, capture_output=True, text=True,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert ended.returncode == 0, ended.stderr
    assert "error_percent" in ended.stdout and "low" in ended.stdout
    assert (tmp_path / "convergence.png").read_bytes().startswith(b"\x89PNG")


def test_the_study_is_as_neat_as_the_others(tmp_path: Path) -> None:
    file = tmp_path / "ratios.py"
    file.write_text(BLOCKS["study"])
    for command in (["check"], ["format", "--check"]):
        ended = subprocess.run(
            [sys.executable, "-m", "ruff", *command, "--config", str(ROOT / "pyproject.toml"),
             str(file)], capture_output=True, text=True,
        )  # fmt: skip
        assert ended.returncode == 0, ended.stdout + ended.stderr
