"""The site: built offline with warnings as errors; equations, commands and the notebook."""

import contextlib
import io
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from harness.case_file import load_cases
from harness.cli.main import HELP

ROOT = Path(__file__).parents[1]
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    ended = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "-d", str(folder)],
        cwd=ROOT, capture_output=True, text=True,
        env=os.environ | {"NO_MKDOCS_2_WARNING": "1"},
    )  # fmt: skip
    assert ended.returncode == 0, ended.stderr
    return folder


def test_equations_are_set(site: Path) -> None:
    pages = {
        one.stem: (site / "theory" / one.stem / "index.html").read_text()
        for one in (ROOT / "docs" / "theory").glob("*.md")
    }
    for name, page in pages.items():
        source = (ROOT / "docs" / "theory" / f"{name}.md").read_text()
        assert page.count("<math") == source.count("```math") + source.count("$`") > 0
        assert "$`" not in page and "\\begin" not in page
    numbers = set(map(int, re.findall(r"\((\d+)\)", (ROOT / "docs/theory/model.md").read_text())))
    assert numbers >= {*range(1, 12), 13, 16, *range(18, 21), *range(22, 26)}


def test_every_command_and_page_is_there(site: Path) -> None:
    commands = (site / "reference" / "commands" / "index.html").read_text()
    for name in HELP:
        assert f'id="{name}"' in commands
    assert "--case-file FILE" in commands
    python = (site / "reference" / "python" / "index.html").read_text()
    assert "Return the <code>count</code> lowest modes at one pose" in python


def test_every_named_mechanism_is_drawn_with_its_frequencies(site: Path) -> None:
    page = (site / "mechanisms" / "index.html").read_text()
    cases = load_cases(ROOT / "results/published/mechanisms.toml")
    assert page.count("data:image/png;base64,") == len(cases) == 10
    for name in cases:
        assert f"<code>{name}</code>" in page
    values = re.findall(r"<td>([\d.]+)</td>", page)
    assert len(values) == 8 * len(cases)
    # The three mechanisms whose exact values were worked out elsewhere.
    for known in ("123.0070", "147.1842", "84.7281", "115.9935", "27.1773", "411.9162"):
        assert known in values


def test_nothing_is_asked_from_outside(site: Path) -> None:
    for page in site.rglob("*.html"):
        asked = re.findall(
            r'<(?:script|link|img)[^>]*(?:src|href)="(https?:[^"]*)"', page.read_text()
        )
        assert not asked, page


def test_the_notebook_gives_what_it_shows() -> None:
    """Every code cell, run in order, prints what is kept with it."""
    book = json.loads((ROOT / "docs" / "reproduce-the-paper.ipynb").read_text())
    known: dict[str, object] = {}
    cells = [cell for cell in book["cells"] if cell["cell_type"] == "code"]
    assert len(cells) == 5
    for cell in cells:
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            exec(compile("".join(cell["source"]), "notebook", "exec"), known)
        (kept,) = cell["outputs"]
        assert said.getvalue() == "".join(kept["text"])
