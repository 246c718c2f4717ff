"""The command of a study, made from what the study says it takes."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from harness.cli import flags
from harness.cli.terminal import Bar, finish, show
from harness.request import Request
from harness.studies import STANDARD, Entry, find


def study_command(name: str) -> click.Command:
    """Return the command of the study called `name`."""
    entry = find(name)
    module = entry.load()

    def command(
        output: Path | None, history: Path | None, time_limit: float, **texts: str | None
    ) -> int:
        from harness.bench import Bench
        from harness.text import request

        asked = request(module, texts)
        with Bar() as bar, Bench(time_limit, bar) as bench:
            results = {
                stem: module.run(one, bench)
                for stem, one in _requests(entry, module, asked).items()
            }
        written = finish(results, output, history)
        show(results)
        return written.say()

    made: Callable[..., Any] = command
    made = flags.time_limit()(flags.history()(flags.output(getattr(module, "OUTPUT", None))(made)))
    for own in reversed(getattr(module, "OPTIONS", ())):
        made = flags.option(own.name, own.metavar, own.help)(made)
    made = flags.standard(*getattr(module, "TAKES", STANDARD))(made)
    more = module.run.__doc__ or ""
    _, _, rest = more.partition("\n\n")
    return click.command(name, help="\n\n".join(filter(None, [entry.help, rest])))(made)


def _requests(entry: Entry, module: Any, asked: Request) -> dict[str, Request]:
    """Return what the study is asked, by the stem of its files."""
    stem = getattr(module, "STEM", entry.name)
    if not getattr(module, "EACH_REFERENCE", False) or len(asked.references) == 1:
        return {stem: asked}
    return {f"{stem}-{one.label}": asked.with_(references=(one,)) for one in asked.references}
