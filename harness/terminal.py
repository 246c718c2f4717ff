"""What a command shows and writes: tables, progress, files and failures."""

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from itertools import chain
from pathlib import Path
from typing import Any

import click

from harness.files import write_all
from harness.options import as_typed
from harness.run import Study, rows
from harness.tables import Table


@contextmanager
def progress(total: int) -> Iterator[Callable[[str], None]]:
    """Show a bar on the terminal's error stream; yield what to call after each step."""
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeRemainingColumn,
    )

    columns = (
        TextColumn("[progress.description]{task.description:40.40}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
    )
    console = Console(stderr=True)
    quiet = not console.is_terminal
    with Progress(*columns, console=console, transient=True, disable=quiet) as bar:
        task = bar.add_task("starting", total=total)
        yield lambda what: bar.update(task, advance=1, description=what)


def show(*tables: Table) -> None:
    """Print tables with their titles and notes."""
    from rich.console import Console

    # A pipe has no width of its own: leave the table as wide as it needs to be.
    console = Console(highlight=False, width=None if sys.stdout.isatty() else 240)
    for table in tables:
        console.print(table.terminal())
        console.print()


def write(output: Path | None, files: dict[str, bytes]) -> None:
    """Write `files` into `output`, if a folder is given, and name each of them."""
    if output is not None:
        for path in write_all(output, files):
            click.echo(f"wrote {path}")


def status(failures: dict[tuple[str, str], str]) -> int:
    """Say on the error stream what failed; return the exit status."""
    for (case, label), why in failures.items():
        click.echo(f"rps-bench: {label} failed at {case}: {why}", err=True)
    return 1 if failures else 0


KEY = ("case", "mechanism", "z_m", "azimuth_rad", "tilt_rad", "model", "settings", "mode")
"""What tells a row of the history from the others of its run."""


def finish(history: Path | None, *studies: Study, more: Iterable[Mapping[str, Any]] = ()) -> int:
    """Say what failed in `studies`, append their rows to the history; return the exit status.

    So are `more` rows of the same form. Comes last in a command: where the history cannot be
    written, nothing else is lost.
    """
    ended = status({key: why for study in studies for key, why in study.failures.items()})
    if history is None:
        return ended
    # Parts of one command may share a model, whose rows differ in seconds at most: the first's.
    found: dict[tuple[Any, ...], Mapping[str, Any]] = {}
    for row in chain.from_iterable((*map(rows, studies), more)):
        found.setdefault(tuple(row.get(name) for name in KEY), row)
    if found:
        from harness.history.store import append

        append(history, [*found.values()], as_typed())
    return ended
