"""`rps-bench sweep`: loads nothing heavy before the first process is on its way."""

import shlex
import tempfile
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

import click

from analytic import InputError
from harness.cli import flags
from harness.threads import cores as all_cores
from harness.workers import Children

SETS = (
    "pose:Z,AZIMUTH,TILT, pose:NAME=VALUE,..., random:N[:SEED][:RANGES], grid:RANGES, "
    "workspace:N[:SEED], FILE.csv or FILE.parquet; ranges as in z=350..700x8,azimuth=0..360x12,"
    "tilt=5; names also torsion, x, y, yaw, pitch, roll. Millimetres and degrees."
)
FORMS = ("parquet", "csv", "json")


@click.command()
@flags.option("poses", "SET", SETS, required=True)
@flags.option("models", "A,B", "Models: NAME, NAME@S, NAME@exact.", required=True)
@flags.option("against", "MODEL", "Error maps of all models against this one.")
@flags.option("modes", "I,I", "Mode numbers; default 1-6.", default="1-6")
@flags.standard("shear")
@flags.option("case", "CASE", "The mechanism of this case.", default="case1")
@flags.standard("case_file")
@flags.output()
@click.option("--format", "form", default="parquet", help="parquet (default), csv or json.")
@click.option(
    "--cores", metavar="N", type=click.IntRange(1, 4096), help="Jobs at a time; default one a core."
)
@flags.option("scheduler", "ADDRESS", "Dask scheduler to use, tcp://HOST:PORT.")
@flags.time_limit(60.0)
@click.option(
    "--tries", metavar="N", type=click.IntRange(1, 1000), default=3,
    help="For a job whose process dies; default 3.",
)  # fmt: skip
@click.option("--dry-run", is_flag=True, help="Only say how many jobs there are, and how long.")
@flags.history()
def sweep(
    output: Path | None,
    history: Path | None,
    form: str,
    cores: int | None,
    scheduler: str | None,
    time_limit: float,
    tries: int,
    dry_run: bool,
    **texts: Any,
) -> int:
    """Solve any poses by any models: a row a pose, model and mode.

    Finished jobs are kept in --output: the same command again computes only what is missing.
    """
    with ExitStack() as stack:
        children = stack.enter_context(closing(Children()))
        at_once = cores or all_cores()
        if scheduler is None and at_once > 1:
            children.start(1)  # it loads while this process does
        from harness import text
        from harness.bench import label
        from harness.case_file import load_cases
        from harness.cases import select
        from harness.cli.terminal import Bar, Written, show_tables
        from harness.sweep.cluster import engine
        from harness.sweep.engine import Patience
        from harness.sweep.jobs import NAME, Journal, Sweep
        from harness.sweep.pose_sets import pose_set
        from harness.sweep.sweep import carry_out, estimate
        from reference_models import parse

        kappa, against = text.shear_coefficient(texts["shear"]), texts["against"]
        chosen = text.models(texts["models"], "models", **kappa)
        reference = None if against is None else parse(against, "against", **kappa)
        if reference is not None and set(chosen) == {reference}:
            raise InputError("against", against, "a model that is not the only one of --models")
        shown = text.numbers("modes", texts["modes"], text.MOST_MODES)
        if form not in FORMS:
            raise InputError("format", form, ", ".join(FORMS))
        file = texts["case_file"]
        (at,) = select([texts["case"]], load_cases(Path(file)) if file is not None else {})
        poses = pose_set(texts["poses"], at.mechanism)
        again = "".join(
            f" {flags.flag(name)} {shlex.quote(str(texts[name]))}"
            for name, usual in (("modes", "1-6"), ("case", "case1"), ("case_file", None))
            if texts[name] != usual
        )
        patience = Patience(time_limit, tries)
        here = stack.enter_context(engine(at_once, scheduler, patience, children))
        folder = output
        if folder is None or (dry_run and not (folder / NAME).exists()):
            folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        journal = stack.enter_context(closing(Journal(folder)))
        study = Sweep(at.mechanism, poses, chosen, shown, reference, journal, here)
        if dry_run:
            show_tables(estimate(study))
            return 0
        with Bar() as bar:
            bar.expect(len(poses) * len(study.models))
            found = carry_out(
                study, folder / f"frequencies.{form}", again=again,
                listener=lambda job: bar.done(label(job.model), len(job.poses)),
                history=None if history is None else (history, flags.as_typed()),
            )  # fmt: skip
        show_tables(*(t for name, t in found.made.items() if t.rows or name != "failures"))
        Written(found.files if output is not None else (), {}).say()
    return 1 if found.lacking else 0
