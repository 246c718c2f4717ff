"""`rps-bench reproduce`: the main job."""

from dataclasses import replace
from pathlib import Path

import click

from harness.cli import flags
from harness.cli.terminal import Bar, finish

LATEST = "results/latest"


@click.command()
@flags.standard("cases", "case_file", "references", "elements", "modes", "model", "shear")
@flags.option("only", "NAME,NAME", "Studies to make; default all of them.")
@flags.output(LATEST)
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
                files: dict[str, bytes] = {}
                for stem, result in part.results.items():
                    files |= result_files(result, stem)
                written += len(write_all(output, files))
                parts.append(part)
            bar.finished(entry.share)
    results = {stem: result for part in parts for stem, result in part.results.items()}
    kept = finish(results, None, history)
    last = job.summaries(asked, parts)
    last |= page_files(asked, parts, history, flags.as_typed(without=("only",)), load_check(output))
    written += len(write_all(output, last))
    click.echo(job.short(parts), nl=False)
    click.echo(f"{written} files in {output}/; start with {output / 'index.html'}")
    failures = dict(kept.failures) | {part.entry.title: part.why for part in parts if part.why}
    return replace(kept, failures=failures).say()
