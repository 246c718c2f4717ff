"""`rps-bench sweep`: its options, what it shows and what it writes."""

import os
import shlex
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from analytic import InputError
from analytic.errors import number
from harness.case_file import load_cases
from harness.cases import select
from harness.files import write_all
from harness.models import parse
from harness.options import MOST_MODES, numbers, shear_coefficient, split
from harness.tables import Cell, Number, Table
from harness.terminal import show

if TYPE_CHECKING:  # imported where they are used: other commands need not wait for them
    from harness.sweep.engine import Engine
    from harness.sweep.journal import Journal
    from harness.sweep.sweep import Finished, Sweep

MOST_CORES = 4096
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
def sweep(
    poses: str,
    models: str,
    against: str | None,
    modes: str,
    shear: str,
    case: str,
    case_file: str | None,
    output: str | None,
    form: str,
    cores: str | None,
    scheduler: str | None,
    time_limit: str,
    tries: str,
    dry_run: bool,
) -> int:
    """Any set of poses by any models: a row a pose, model and mode.

    Finished jobs are kept in --output: the same command again computes only what is missing.
    """
    from harness.sweep.engine import Patience, engine
    from harness.sweep.journal import NAME, Journal
    from harness.sweep.pose_sets import pose_set
    from harness.sweep.progress import progress
    from harness.sweep.sweep import Finished, Sweep, complete, failure_table, timing_table

    kappa = shear_coefficient(shear)
    specs = [parse(name, "--models", kappa) for name in split("--models", models)]
    reference = None if against is None else parse(against, "--against", kappa)
    if reference is not None and set(specs) == {reference}:
        raise InputError("--against", against, "a model that is not the only one of --models")
    shown = numbers("--modes", modes, MOST_MODES)
    if form not in ("parquet", "csv"):
        raise InputError("--format", form, "parquet or csv")
    if output == "":
        raise InputError("--output", output, "the name of a folder")
    patience = Patience(_seconds(time_limit), _whole("--tries", tries, 1000))
    at_once = _whole("--cores", cores, MOST_CORES) if cores is not None else _cores()
    extra = load_cases(Path(case_file)) if case_file is not None else {}
    (chosen,) = select([case], extra)
    everything = tuple(dict.fromkeys([*specs, *([reference] if reference else [])]))
    study = Sweep(chosen.mechanism, pose_set(poses, chosen.mechanism), everything, max(shown))
    given = (
        ("modes", modes, "1-6"),
        ("shear", shear, "cowper"),
        ("case", case, "case1"),
        ("case-file", case_file, None),
    )
    same = "".join(f" --{k} {shlex.quote(v)}" for k, v, usual in given if v and v != usual)

    dry = dry_run and not (output and (Path(output) / NAME).exists())
    simulations = len(study.poses) * sum(not spec.analytic for spec in everything)
    with engine(at_once, scheduler, patience, simulations) as cluster, ExitStack() as stack:
        for spec in everything:
            spec.build()  # a program that is missing is said now
        folder = stack.enter_context(_folder(None if dry else output))
        journal = stack.enter_context(Journal(folder))
        if dry_run:
            show(_dry_run(study, journal, cluster))
            return 0
        finished = Finished(study)
        with ThreadPoolExecutor(1) as writer, progress(study) as bar, finished:
            rows = writer.submit(_write, study, journal, finished, shown, folder, form)
            failures = complete(study, journal, cluster, (bar, finished.tell))
        written = [rows.result()]
        tables = {"timing": timing_table(study, journal)}
        if reference is not None:
            from harness.sweep.error_map import compare, error_table
            from harness.sweep.worst_poses import worst_table

            gathered = compare(study, journal, reference, shown, folder, form)
            written.append(folder / f"errors.{form}")
            tables["errors"] = error_table(gathered, reference)
            tables["worst"] = worst_table(study, gathered, reference, cluster, same)
        tables["failures"] = failure_table(failures)
        if not failures:
            show(*(table for name, table in tables.items() if name != "failures"))
        else:
            show(*tables.values())
        files = {k: v for stem, table in tables.items() for k, v in table.files(stem).items()}
        written += write_all(folder, files)
        if output is not None:
            for path in written:
                click.echo(f"wrote {path}")
    return 1 if failures else 0


def _write(
    study: "Sweep",
    journal: "Journal",
    finished: "Finished",
    modes: list[int],
    folder: Path,
    form: str,
) -> Path:
    """Write the rows while models run; the libraries for that take as long to load as to use."""
    import rich.table  # noqa: F401
    import tabulate  # noqa: F401

    from harness.sweep.rows import export

    return export(study, journal, finished, modes, folder, form)


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _whole(option: str, text: str, most: int) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= most:
        raise InputError(option, text, f"a whole number from 1 to {most}")
    return int(text)


def _seconds(text: str) -> float:
    expected = "a positive number of seconds"
    try:
        return number("--time-limit", float(text), expected, positive=True)
    except ValueError:
        raise InputError("--time-limit", text, expected) from None


@contextmanager
def _folder(output: str | None) -> Iterator[Path]:
    """Yield the folder to work in: a passing one where nothing is to be kept."""
    if output is not None:
        yield Path(output)
        return
    with tempfile.TemporaryDirectory() as folder:
        yield Path(folder)


def _dry_run(study: "Sweep", journal: "Journal", cluster: "Engine") -> Table:
    from harness.sweep.jobs import Failure
    from harness.sweep.sweep import seconds_a_pose

    rows: list[tuple[Cell, ...]] = []
    together = 0.0
    for spec in study.specs:
        total, done, left = study.done(spec, journal)
        each = seconds_a_pose(study, spec, cluster)
        if isinstance(each, Failure):
            rows.append((spec.label, total, done, total - done, "-", each.reason))
            continue
        seconds = left * each / min(cluster.cores, max(1, total - done))
        together += seconds
        rows.append(
            (spec.label, total, done, total - done, Number(1e3 * each, 3), _duration(seconds))
        )
    columns = ("Model", "Jobs", "Done", "To do", "ms a pose", "Time")
    notes = (
        f"{len(study.poses)} poses; all together {_duration(together)} on {cluster.cores} cores, "
        "from the time of one pose a model",
    )
    return Table("Dry run", columns, tuple(rows), notes)


def _duration(seconds: float) -> str:
    if seconds < 100:
        return f"{seconds:.2g} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 100 else f"{minutes // 60} h {minutes % 60} min"
