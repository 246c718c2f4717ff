"""`rps-bench dashboard`: everything known so far as one offline page."""

from pathlib import Path

import click

from analytic import InputError
from harness.history_option import takes_history


@click.command()
@click.option("--output", metavar="FILE", required=True, help="The page: one HTML file.")
@click.option("--results", metavar="DIR", default="results", help="Accepted results; results/.")
@takes_history
def dashboard(output: str, results: str, history: Path | None) -> int:
    """Everything as one offline HTML page: results, history, and what each number comes from."""
    from harness.files import write_all
    from harness.report.page import page
    from harness.report.sources import read_sources

    file = Path(output)
    if not file.name or file.is_dir():
        raise InputError("--output", output, "the name of a file, such as dashboard.html")
    if not results:
        raise InputError("--results", results, "the name of a folder")
    content = page(read_sources(Path(results), history))
    (written,) = write_all(file.parent, {file.name: content})
    click.echo(f"wrote {written} ({len(content) / 1e6:.1f} MB)")
    return 0
