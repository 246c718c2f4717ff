"""README and docs: what they show exists, and their Python runs."""

import re
import shlex
import tomllib
from pathlib import Path

import pytest

from analytic import Continuum
from harness.case_file import load_cases
from harness.cli.main import cli

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")]
PAGES += sorted((ROOT / "docs").rglob("*.md"))
TEXTS = {str(page.relative_to(ROOT)): page.read_text(encoding="utf-8") for page in PAGES}
RUN = ("docs/use.md", "docs/tutorial.md")
"""Pages whose Python runs here; that of the others has tests of its own."""


def blocks(kind: str) -> list[tuple[str, str]]:
    return [
        (name, block)
        for name, text in TEXTS.items()
        for block in re.findall(rf"```{kind}\n(.*?)```", text, flags=re.DOTALL)
    ]


@pytest.mark.parametrize(
    ("name", "line"),
    [
        (name, line)
        for name, block in blocks("sh")
        for line in block.replace("\\\n", " ").splitlines()
        if line.startswith("rps-bench ")
    ],
)
def test_commands_have_the_options_that_are_shown(name: str, line: str) -> None:
    _, command, *rest = shlex.split(line, comments=True)
    found = cli.get_command(None, command)  # type: ignore[arg-type]
    assert found is not None
    known = {option for parameter in found.params for option in parameter.opts}
    for word in rest:
        if word.startswith("--"):
            assert word.partition("=")[0] in known, word
        if word in ("|", ">"):
            break


@pytest.mark.parametrize("name", list(TEXTS))
def test_links_lead_somewhere(name: str) -> None:
    page = ROOT / name
    for link in re.findall(r"\]\(([^)#:]+)\)", TEXTS[name]):
        assert (page.parent / link).exists(), link


def test_the_case_file_of_the_docs_is_one(tmp_path: Path) -> None:
    found = [block for name, block in blocks("toml") if "[cases." in block]
    assert len(found) >= 2
    for block in found:
        path = tmp_path / "mine.toml"
        path.write_text(block)
        cases = load_cases(path)
        assert cases
        for case in cases.values():
            assert Continuum("timoshenko").modes(case.mechanism, case.pose).frequencies[0] > 1, (
                block
            )


@pytest.mark.slow
@pytest.mark.parametrize("block", [b for n, b in blocks("python") if n in RUN])
def test_python_of_the_docs_runs(
    block: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("exudyn")
    monkeypatch.chdir(tmp_path)
    exec(compile(block, "docs", "exec"), {})


def test_the_readme_fits_two_screens() -> None:
    assert len(TEXTS["README.md"].splitlines()) <= 70


def test_both_commands_are_those_of_ci() -> None:
    command = "python3 -m venv .venv && .venv/bin/pip install -q uv && .venv/bin/uv run pytest"
    assert command in TEXTS["README.md"]
    assert command in (ROOT / ".ci" / "run").read_text()


def test_pins_are_of_dependencies() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    asked = [*project["project"]["dependencies"], *project["dependency-groups"]["dev"]]
    for more in project["project"]["optional-dependencies"].values():
        asked += more
    names = {re.split(r"[<>=\[]", item)[0] for item in asked}
    for pin in project["tool"]["uv"]["constraint-dependencies"]:
        name = pin.partition("==")[0]
        assert name in names | {"dask", "mkdocs", "mkdocstrings-python", "narwhals"}, pin
