"""`rps-bench sweep`: its options; loads nothing heavy before the first process is on its way."""

from contextlib import closing
from typing import Any

import click

from harness.history_option import takes_history
from harness.sweep.child import Children
from harness.threads import cores

SETS = (
    "pose:Z,AZIMUTH,TILT, random:N[:SEED][:RANGES], grid:RANGES, workspace:N[:SEED], FILE.csv or "
    "FILE.parquet; ranges as in z=350..700x8,azimuth=0..360x12,tilt=5."
)


@click.command()
@click.option("--poses", metavar="SET", required=True, help=f"{SETS} Millimetres and degrees.")
@click.option("--models", metavar="A,B", required=True, help="Models: NAME, NAME@S, NAME@exact.")
@click.option("--against", metavar="MODEL", help="Error maps of all models against this one.")
@click.option("--modes", metavar="I,I", default="1-6", help="Mode numbers; default 1-6.")
@click.option("--shear", metavar="KAPPA", default="cowper", help="As for the other commands.")
@click.option("--case", metavar="CASE", default="case1", help="The mechanism of this case.")
@click.option(
    "--case-file", metavar="FILE", help="TOML file with mechanisms and cases of your own."
)
@click.option("--output", metavar="DIR", help="Folder for rows, tables and finished jobs.")
@click.option("--format", "form", default="parquet", help="parquet (default) or csv.")
@click.option("--cores", metavar="N", help="Jobs at a time; default one a core.")
@click.option("--scheduler", metavar="ADDRESS", help="Dask scheduler to use, tcp://HOST:PORT.")
@click.option("--time-limit", metavar="SECONDS", default="60", help="For one simulator's pose.")
@click.option("--tries", metavar="N", default="3", help="For a job whose process dies; default 3.")
@click.option("--dry-run", is_flag=True, help="Only say how many jobs there are, and how long.")
@takes_history
def sweep(scheduler: str | None, **given: Any) -> int:
    """Any set of poses by any models: a row a pose, model and mode.

    Finished jobs are kept in --output: the same command again computes only what is missing.
    """
    with closing(Children()) as children:
        alone = given["cores"] == "1" or (given["cores"] is None and cores() == 1)
        if scheduler is None and not alone:
            children.start(1)  # it loads while this process does
        from harness.sweep.session import session

        return session(children, scheduler=scheduler, **given)
