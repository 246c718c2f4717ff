"""What a command shows and writes: tables, progress, files and failures. It writes first."""

import shutil
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import click

from harness.cli.flags import as_typed
from harness.listener import Listener
from harness.plain import plain

if TYPE_CHECKING:
    from harness.result import Result
    from harness.tables import Table


class Bar(Listener):
    """A progress bar on the terminal's error stream: what runs, for how long, and how long yet."""

    def __init__(self) -> None:
        from rich import progress
        from rich.console import Console
        from rich.table import Column

        console = Console(stderr=True)
        self._bar = progress.Progress(
            progress.TextColumn(  # as wide as the other columns leave it
                "{task.description}",
                markup=False,
                table_column=Column(ratio=1, no_wrap=True, overflow="ellipsis"),
            ),
            progress.BarColumn(12),
            progress.MofNCompleteColumn(),
            progress.TimeElapsedColumn(),
            progress.TextColumn("left:"),
            progress.TimeRemainingColumn(),
            console=console,
            transient=True,
            expand=True,
            disable=not console.is_terminal,
        )
        self._task = self._bar.add_task("starting", total=0)
        self._total = 0

    def parts(self, total: int) -> None:
        """Take in that the job has parts, of `total` shares of its time: a bar for all of it."""
        self._all = self._bar.add_task("", total=total)

    def part(self, what: str) -> None:
        """Take in that another part begins, whose steps are counted anew."""
        self._total = 0
        self._bar.reset(self._task, total=0, description=what)
        self._bar.update(self._all, description=what)

    def finished(self, share: int) -> None:
        """Take in that a part is finished, and what its share was."""
        self._bar.update(self._all, advance=share)

    def expect(self, number: int) -> None:
        """Take in that so many more steps are to come."""
        self._total += number
        self._bar.update(self._task, total=self._total)

    def begin(self, what: str) -> None:
        """Take in that a step begins."""
        self._bar.update(self._task, description=plain(what))

    def done(self, what: str, steps: int = 1) -> None:
        """Take in that a step is finished, or several."""
        self._bar.update(self._task, advance=steps, description=plain(what))

    def __enter__(self) -> Self:
        if not self._bar.disable:
            self._bar.start()
        return self

    def __exit__(self, *error: object) -> None:
        if not self._bar.disable:  # Rich 13 ends a line even so
            self._bar.stop()


@dataclass(frozen=True)
class Written:
    """What a command wrote, and what has no answer.

    `refusals`: models that cannot take a mechanism; `asked`: whether models were named.
    """

    paths: tuple[Path, ...]
    failures: Mapping[str, str]
    unwritten: Exception | None = None
    refusals: Mapping[str, str] = field(default_factory=dict)
    asked: bool = False

    def say(self) -> int:
        """Name files and failures; return the exit status. Raises why the history is not kept."""
        wrote(self.paths)
        for what, why in self.failures.items():
            click.echo(f"rps-bench: {plain(f'{what} failed: {why}')}", err=True)
        for why in dict.fromkeys(self.refusals.values()):
            who = [what for what, reason in self.refusals.items() if reason == why]
            says = f"{', '.join(who)} {'is' if len(who) == 1 else 'are'} left out: {why}"
            click.echo(f"rps-bench: {plain(says)}", err=True)
        if self.unwritten is not None:
            raise self.unwritten
        return 1 if self.failures or (self.refusals and self.asked) else 0


def finish(results: Mapping[str, "Result"], output: Path | None, history: Path | None) -> Written:
    """Write the results' files and their rows of the history; return what was written."""
    from harness.output import OutputError, result_files, write_all
    from harness.text import GROUPS

    paths = () if output is None else write_all(output, result_files(results))
    unwritten = None
    if history is not None:
        try:
            _append_rows(history, results)
        except OutputError as error:  # what was found is shown all the same
            unwritten = error
    failures = {what: why for one in results.values() for what, why in one.failures().items()}
    refusals = {what: why for one in results.values() for what, why in one.refusals().items()}
    # Whether the command line names its references, rather than takes a group of them.
    context = click.get_current_context(silent=True)
    asked = context is not None and context.params.get("references") not in (None, *GROUPS)
    return Written(tuple(paths), failures, unwritten, refusals, asked)


def _append_rows(history: Path, results: Mapping[str, "Result"]) -> None:
    """Append the rows of a run to the history, each once for what tells it from the others.

    Parts of one command may share a model, whose rows differ in seconds at most: the first's.
    """
    from harness.poses import COLUMNS

    key = ("case", "mechanism", *COLUMNS, "model", "settings", "mode")
    found: dict[tuple[Any, ...], Mapping[str, Any]] = {}
    for result in results.values():
        for row in result.rows():
            found.setdefault(tuple(row.get(name) for name in key), row)
    if found:
        from harness.history.store import append

        append(history, [*found.values()], as_typed())


def wrote(paths: Iterable[Path]) -> None:
    """Name the files that were written."""
    for path in paths:
        click.echo(f"wrote {plain(str(path))}")


def show(results: Mapping[str, "Result"]) -> None:
    """Print every result's tables and sentences."""
    for result in results.values():
        show_tables(*result.tables().values())
        for line in result.sentences():
            click.echo(f"- {plain(line)}")


def show_tables(*tables: "Table") -> None:
    """Print tables with their titles and notes; in a pipe as wide as they need to be."""
    from rich.console import Console

    class Pipe(Console):
        def on_broken_pipe(self) -> None:
            raise BrokenPipeError  # whoever read has enough: no failure

    for table in tables:
        if sys.stdout.isatty():
            width = shutil.get_terminal_size().columns
            console, shown = Pipe(highlight=False, markup=False), table.terminal(width)
        else:
            width = max(table.width(), 1)
            console = Pipe(highlight=False, markup=False, width=width, soft_wrap=True)
            shown = table.terminal()
        console.print(shown)
        console.print()
