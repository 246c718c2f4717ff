"""What pre-commit checks, as tests: lint, format, types and the direction of imports."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.mark.slow
@pytest.mark.parametrize(
    "command", ["ruff check", "ruff format --check", "mypy", "lint-imports"], ids=str
)
def test_style(command: str) -> None:
    program, *arguments = command.split()
    tool = Path(sys.executable).with_name(program)
    ended = subprocess.run(
        [tool, *arguments], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr


def test_ci_runs_the_command_of_the_readme() -> None:
    """The last line of .ci/run is a command that the README gives, to the letter."""
    last = (ROOT / ".ci" / "run").read_text().splitlines()[-1]
    assert last.endswith("uv run pytest")
    assert last in (ROOT / "README.md").read_text().splitlines()


def test_no_file_is_two_files() -> None:
    """A file over 400 lines is probably two."""
    long = [
        str(path.relative_to(ROOT))
        for folder in ("analytic", "reference_models", "harness", "tests")
        for path in (ROOT / folder).rglob("*.py")
        if len(path.read_text().splitlines()) > 400
    ]
    assert not long
