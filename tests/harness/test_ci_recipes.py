"""The CI recipes call what there is, with options it has, and hand on files that it writes."""

import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click
import pytest
import yaml

from harness.cli.main import cli

ROOT = Path(__file__).parents[2]
RECIPES = sorted((ROOT / "docs" / "ci").glob("*.yml"))
NOT_NEEDED = {"python3-venv": "the image's Python has it", "chromium": "it runs no tests",
              "texlive-latex-recommended": "it runs no tests"}  # fmt: skip


def texts(node: Any) -> Iterator[str]:
    """Every text in a recipe."""
    match node:
        case str():
            yield node
        case dict():
            for value in node.values():
                yield from texts(value)
        case list():
            for value in node:
                yield from texts(value)


def lines(recipe: Path) -> list[str]:
    found = texts(yaml.safe_load(recipe.read_text()))
    return [line.strip() for text in found for line in text.splitlines()]


def parsed(recipe: Path, versions: bool = False) -> dict[str, click.Context]:
    """The bench's commands in a recipe, each parsed as the bench itself would.

    `versions`: of the job that runs the lowest and the newest versions, else of the others.
    """
    group = click.Context(cli)
    found = {}
    for line in lines(recipe):
        if "rps-bench" in line and (".versions/" in line) == versions:
            words = shlex.split(line.replace(".versions/bin/", ""))
            name, *arguments = words[words.index("rps-bench") + 1 :]
            command = cli.get_command(group, name)
            assert command is not None, line
            found[name] = command.make_context(name, arguments, parent=group)
    return found


def test_both_are_there() -> None:
    assert [recipe.stem for recipe in RECIPES] == ["github", "gitlab"]


@pytest.mark.parametrize("recipe", RECIPES, ids=lambda recipe: recipe.stem)
def test_commands_parse(recipe: Path) -> None:
    commands = parsed(recipe)
    assert set(commands) == {"check", "dashboard"}
    folders = {str(context.params["history"]) for context in commands.values()}
    assert folders == {"history"}
    assert any(line.rstrip("/") == "history" for line in lines(recipe)), "kept between runs"
    page = Path(commands["dashboard"].params["output"])
    assert page == Path("public/index.html")


@pytest.mark.parametrize("recipe", RECIPES, ids=lambda recipe: recipe.stem)
def test_what_is_handed_on_is_what_is_written(recipe: Path) -> None:
    folder = parsed(recipe)["check"].params["output"]
    written = {f"{folder}/check.{suffix}" for suffix in ("json", "md", "xml")}
    named = {name for line in lines(recipe) for name in re.findall(r"[\w/]+/check\.\w+", line)}
    assert named == written


@pytest.mark.parametrize("recipe", RECIPES, ids=lambda recipe: recipe.stem)
def test_packages_are_those_of_ci(recipe: Path) -> None:
    """But for what it does not need, and why."""
    ours = set(re.findall(r"missing\+=\((\S+)\)", (ROOT / ".ci" / "run").read_text()))
    installs = [line for line in lines(recipe) if "apt-get install" in line]
    (install,) = set(installs)
    assert len(installs) == 2
    theirs = {word for word in install.split()[2:] if not word.startswith("-")}
    assert theirs == ours - set(NOT_NEEDED)
    assert set(NOT_NEEDED) <= ours


def test_the_summary_reaches_github() -> None:
    (summary,) = [line for line in lines(RECIPES[0]) if "GITHUB_STEP_SUMMARY" in line]
    assert "cat results/latest/check.md >>" in summary


@pytest.mark.parametrize("recipe", RECIPES, ids=lambda recipe: recipe.stem)
def test_the_lowest_and_the_newest_versions_are_run(recipe: Path) -> None:
    """Without the pins of [tool.uv], which win otherwise; the gate and a table."""
    job = yaml.safe_load(recipe.read_text())
    job = job.get("jobs", job)["versions"]
    assert list(texts(job)).count("lowest-direct") == list(texts(job)).count("highest") == 1
    commands = parsed(recipe, versions=True)
    assert set(commands) == {"check", "table"}
    (install,) = [one for line in texts(job) for one in line.splitlines() if "pip install" in one
                  and "resolution" in one]  # fmt: skip
    # `uv run` would keep to the pins, whatever it is told.
    assert "uv pip install -q --no-config --resolution $" in install
