"""`rps-bench dashboard`: the page anew, with the newest history and the gate's last answer."""

from pathlib import Path

import click

from harness.cli import flags
from harness.cli.reproduce import LATEST


@click.command()
@flags.option("output", "FILE", "The page to write, such as dashboard.html.", required=True)
@flags.option("results", "DIR", f"Folder of the run that is shown; default {LATEST}.",
              default=LATEST)  # fmt: skip
@flags.history()
def dashboard(output: str, results: str, history: Path | None) -> None:
    """Make the page anew from the last run, the newest history and the gate's last answer.

    Nothing is solved: the run has left what the page needs in page.json.
    """
    from harness.output import check_file, write_all
    from harness.report.page import load, load_check, render

    file = check_file(output)
    folder = Path(results)
    page = render(load(folder), history, load_check(folder))
    write_all(file.parent, {file.name: page})
    click.echo(f"wrote {file} ({len(page) / 1e6:.1f} MB)")
