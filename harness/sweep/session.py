"""What `rps-bench sweep` does with its options: solves, shows and writes."""

import shlex
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import click

from analytic import InputError
from analytic.errors import number
from harness import threads
from harness.case_file import load_cases
from harness.cases import select
from harness.files import write_all
from harness.models import parse
from harness.options import MOST_MODES, as_typed, numbers, shear_coefficient, split
from harness.sweep.child import Children
from harness.sweep.engine import Engine, Patience, engine
from harness.sweep.journal import NAME, Journal
from harness.sweep.pose_sets import pose_set
from harness.sweep.progress import progress
from harness.sweep.solve import solve
from harness.sweep.sweep import Sweep, failure_table, seconds_a_pose, timing_table, timings
from harness.sweep.task import Failure
from harness.tables import Cell, Number, Table, table_files
from harness.terminal import show

MOST_CORES = 4096


def session(
    children: Children,
    *,
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
    history: Path | None,
) -> int:
    """Run a sweep as typed, in `children` or on a cluster; return the exit status."""
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
    at_once = _whole("--cores", cores, MOST_CORES) if cores is not None else threads.cores()
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
    with ExitStack() as stack:
        cluster = stack.enter_context(engine(at_once, scheduler, patience, simulations, children))
        for spec in everything:
            spec.build()  # a program that is missing is said now
        folder = stack.enter_context(_folder(None if dry else output))
        journal = stack.enter_context(Journal(folder))
        if dry_run:
            show(_dry_run(study, journal, cluster))
            return 0
        target = folder / f"frequencies.{form}"
        with progress(study) as bar:
            outcome = solve(study, journal, cluster, target, shown, bar)
        written, failures = [target], outcome.failures
        took = timings(study, journal)
        tables = {"timing": timing_table(took)}
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
        written += write_all(folder, table_files(tables))
        if output is not None:
            for path in written:
                click.echo(f"wrote {path}")
        if history is not None and outcome.solved:
            from harness.history.store import append
            from harness.sweep.rows import records

            append(history, records(study, took, target), as_typed())
    return 1 if failures else 0


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


def _dry_run(study: Sweep, journal: Journal, cluster: Engine) -> Table:
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
