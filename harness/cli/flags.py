"""Flags: what the standard arguments are called and mean on the command line."""

import re
import shlex
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

FLAGS = {
    "cases": ("CASE,CASE", "Cases by name; default case1,case2, or all of --case-file."),
    "case_file": ("FILE", "TOML file with mechanisms and cases of your own, or a paper's folder."),
    "references": (
        "A,B",
        "Models to compare with: NAME, NAME@N, or NAME@N1+N2 to extrapolate; usual, quick, or all.",
    ),
    "elements": ("S,S", "Elements a limb, as in 1,2,4-8."),
    "modes": ("I,I", "Mode numbers; default 1-6."),
    "model": ("NAME[@S]", "The model under test, with @S elements or @exact."),
    "shear": ("KAPPA", "Timoshenko's kappa: cowper (default), 0.9, 6/7 or a number."),
}
"""Metavariable and help of every standard argument."""
LATEST = "results/latest"
"""Where `reproduce` writes."""
WRITES = ("output", "history", "json", "markdown", "junit", "time_limit")
"""Options that say where to write and how long to wait, not what to compute."""
NAMES = "cases", "case", "model", "models", "against", "references", "only"
"""Arguments whose names a shell can complete."""
_known: set[str] = set()
"""Arguments that are flags of the command that runs: errors name them as they are typed."""


def flag(name: str) -> str:
    """Return an argument's name as it is typed."""
    return "--" + name.replace("_", "-")


def option(name: str, metavar: str, text: str, **more: Any) -> Callable[..., Any]:
    """Return click's decorator for an argument that is handed over as text."""
    _known.add(name)
    if name in NAMES:
        more["shell_complete"] = _completed
    return click.option(flag(name), name, metavar=metavar, help=text, **more)


def _completed(context: click.Context, parameter: click.Parameter, typed: str) -> list[str]:
    """Return how the last of the names `typed`, separated by commas, may go on."""
    head, comma, last = typed.rpartition(",")
    known = known_names(parameter.name or "", context.params.get("case_file"))
    return [f"{head}{comma}{name}" for name in known if name.startswith(last)]


def known_names(argument: str, file: str | None) -> Iterable[str]:
    """Return the names that an argument takes: of a case file too, if it was typed before."""
    if argument in ("cases", "case"):
        from harness.case_file import load_cases
        from harness.cases import PRESETS

        return [*PRESETS, *(load_cases(Path(file)) if file else ())]
    if argument == "only":
        from harness.studies import STUDIES

        return [entry.name for entry in STUDIES]
    from reference_models import names

    return ["usual", "quick", "all", *names()] if argument == "references" else names()


def standard(*names: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Return a decorator that gives a command the standard arguments called `names`."""

    def give(command: Callable[..., Any]) -> Callable[..., Any]:
        for name in reversed(names):
            command = option(name, *FLAGS[name])(command)
        return command

    return give


def output(default: str | None = None) -> Callable[..., Any]:
    """Return the option --output: a folder, checked before anything is computed."""
    said = f"Folder for the files{f'; default {default}' if default else ''}."
    return option("output", "DIR", said, default=default, callback=_folder)


def history() -> Callable[..., Any]:
    """Return the option --history: a folder, or None where no history is kept."""
    said = "Folder of the history of runs, or none; default history, or $RPS_BENCH_HISTORY."
    return option("history", "DIR", said, envvar="RPS_BENCH_HISTORY", default="history",
                  callback=_folder)  # fmt: skip


def _folder(_context: click.Context, given: click.Parameter, text: str | None) -> Path | None:
    from harness.output import check_folder

    if text is None or (given.name, text) == ("history", "none"):
        return None
    return check_folder(text, given.name or "", writes=given.name == "output")


def time_limit(default: float | None = None) -> Callable[..., Any]:
    """Return the option --time-limit: seconds that a simulator may take for one pose."""
    from harness.workers import LIMIT

    seconds = default or LIMIT
    return click.option(
        "--time-limit", metavar="S", type=click.FloatRange(min=0, min_open=True), default=seconds,
        help=f"Seconds that a simulator may take for one pose; default {seconds:g}.",
    )  # fmt: skip


def dashed(sentence: str) -> str:
    """Return an error's sentence with the argument that it names as it is typed."""
    name = re.match(r"\w+(?![\w.])", sentence)
    if name and name[0] in _known:
        return flag(name[0]) + sentence[name.end() :]
    return sentence


def as_typed(without: tuple[str, ...] = ()) -> str:
    """Return the command that runs now with its options, but for `WRITES` and `without`."""
    context = click.get_current_context()
    words = ["rps-bench", context.info_name or ""]
    for parameter in context.command.params:
        name = parameter.name or ""
        source = context.get_parameter_source(name)
        if source is ParameterSource.COMMANDLINE and name not in (*WRITES, *without):
            given = context.params[name] is True
            first = parameter.opts[0]
            words += [first] if given else [first, str(context.params[name])]
    return shlex.join(words)
