"""`rps-bench dashboard`: everything known so far as one offline page."""

from pathlib import Path

import click

from analytic import InputError


@click.command()
@click.option("--output", metavar="FILE", required=True, help="The page, one HTML file.")
@click.option("--results", metavar="DIR", default="results", help="Accepted results; results/.")
@click.option(
    "--history",
    metavar="DIR",
    envvar="RPS_BENCH_HISTORY",
    default="history",
    help="Recorded runs; default history/, `none` for none.",
)
def dashboard(output: str, results: str, history: str) -> None:
    """Write one self-contained HTML page: results, history, and where each number comes from."""
    from harness.files import write_all
    from harness.report.page import page
    from harness.report.sources import read_sources

    file = Path(output)
    if not output or file.is_dir() or not file.name:
        raise InputError("--output", output, "the name of a file, such as dashboard.html")
    if not results:
        raise InputError("--results", results, "the name of a folder")
    recorded = None if history == "none" else Path(history)
    content = page(read_sources(Path(results), recorded))
    (written,) = write_all(file.parent, {file.name: content})
    click.echo(f"wrote {written} ({len(content) / 1e6:.1f} MB)")
