"""The option --history, which every command has that runs a model; loads nothing heavy."""

from collections.abc import Callable
from pathlib import Path

import click


def takes_history(command: Callable[..., int]) -> Callable[..., int]:
    """Give a command the option --history, as a folder or None where no history is kept."""
    return click.option(
        "--history",
        metavar="DIR",
        envvar="RPS_BENCH_HISTORY",
        default="history",
        callback=lambda _context, _option, text: _history(text),
        help="Folder of the history of runs, or none; default history, or $RPS_BENCH_HISTORY.",
    )(command)


def _history(text: str) -> Path | None:
    if text == "" or Path(text).is_file():
        from analytic import InputError

        raise InputError("--history", text, "the name of a folder, or none")
    return None if text == "none" else Path(text)
