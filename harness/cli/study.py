"""The command of a study, made from what the study says it takes; and `reproduce`, all of them."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from harness.cli import flags
from harness.cli.terminal import Bar, finish, show
from harness.studies import STANDARD, find


def study_command(name: str) -> click.Command:
    """Return the command of the study called `name`."""
    entry = find(name)
    module = entry.load()

    def command(
        output: Path | None, history: Path | None, time_limit: float, **texts: str | None
    ) -> int:
        from harness.bench import Bench
        from harness.text import request

        asked, stem = request(module, texts), getattr(module, "STEM", name)
        asks = {stem: asked}
        if getattr(module, "EACH_REFERENCE", False) and len(asked.references) > 1:
            asks = {
                f"{stem}-{one.label}": asked.with_(references=(one,)) for one in asked.references
            }
        with Bar() as bar, Bench(time_limit, bar) as bench:
            results = {stem: module.run(one, bench) for stem, one in asks.items()}
        written = finish(results, output, history)
        show(results)
        return written.say()

    made: Callable[..., Any] = command
    for option in (
        flags.output(getattr(module, "OUTPUT", None)),
        flags.history(),
        flags.time_limit(),
        *(
            flags.option(own.name, own.metavar, own.help)
            for own in reversed(getattr(module, "OPTIONS", ()))
        ),
        flags.standard(*getattr(module, "TAKES", STANDARD)),
    ):
        made = option(made)
    _, _, rest = (module.run.__doc__ or "").partition("\n\n")
    return click.command(name, help="\n\n".join(filter(None, [entry.help, rest])))(made)


@click.command()
@flags.standard(*STANDARD)
@flags.option("only", "NAME,NAME", "Studies to make; default all of them.")
@flags.output(flags.LATEST)
@flags.history()
@flags.time_limit()
def reproduce(
    only: str | None, output: Path, history: Path | None, time_limit: float, **texts: str | None
) -> int:
    """Run every study for the cases and write tables, figures, a summary and a page."""
    from harness import reproduce as job
    from harness.bench import Bench
    from harness.output import result_files, write_all
    from harness.report.page import load_check, page_files
    from harness.text import plan, split

    asked = plan(texts)
    entries = job.chosen(None if only is None else split("only", only))
    parts, written = [], 0
    with Bar() as bar, Bench(time_limit, bar) as bench:
        bar.parts(sum(entry.share for entry in entries))
        for k, entry in enumerate(entries, 1):
            bar.part(f"{k} of {len(entries)}, {entry.title}")
            for part in job.reproduce([entry], asked, bench):
                written += len(write_all(output, result_files(part.results)))
                parts.append(part)
            bar.finished(entry.share)
    kept = finish({s: one for part in parts for s, one in part.results.items()}, None, history)
    command = flags.as_typed(without=("only",))
    last = job.summaries(asked, parts) | page_files(
        asked, parts, history, command, load_check(output)
    )
    written += len(write_all(output, last))
    click.echo(job.short(parts), nl=False)
    click.echo(f"{written} files in {output}/; start with {output / 'index.html'}")
    missing = {part.entry.title: part.why for part in parts if part.why}
    return replace(kept, failures={**kept.failures, **missing}).say()
