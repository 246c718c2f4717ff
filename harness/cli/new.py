"""`rps-bench new`: a commented template that runs as it is."""

from pathlib import Path

import click

from harness.cli import flags
from harness.templates import written


@click.command()
@click.argument("kind", metavar="case|mechanism|model|study|paper")
@click.argument("name")
@flags.output(".")
def new(kind: str, name: str, output: Path) -> int:
    """Write a commented template that runs as it is, and say what to run then.

    NAME is lower-case letters, digits and hyphens. Nothing that is there is written over.
    """
    from analytic import InputError
    from harness.output import write_all

    files, then = written(kind, name)
    for file in files:
        if (output / file).exists():
            raise InputError("name", name, f"one whose files are not there yet ({output / file})")
    for path in write_all(output, {file: text.encode() for file, text in files.items()}):
        click.echo(f"wrote {path}")
    click.echo(f"run it: {then}" if output == Path() else f"run it: cd {output} && {then}")
    return 0
