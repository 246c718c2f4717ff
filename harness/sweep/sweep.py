"""A sweep from poses and models to files: solved, written meanwhile, compared, kept."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

from analytic import Mechanism, Pose
from analytic.condensed import CHUNK
from analytic.model import Model
from harness import threads
from harness.bench import label
from harness.cases import select
from harness.history.duck import connect, quoted
from harness.output import write_all
from harness.result import Result
from harness.sweep.cluster import engine
from harness.sweep.engine import Patience, run
from harness.sweep.error_map import compare
from harness.sweep.jobs import Job, Journal, Sweep, program_of
from harness.sweep.pose_sets import pose_set
from harness.sweep.rows import Rows
from harness.tables import Cell, Number, Table, table_files
from harness.text import models as models_of
from harness.workers import Failure
from reference_models import parse

if TYPE_CHECKING:
    import pandas as pd

Failures = dict[tuple[str, str], list[int]]
"""Numbers of the poses without an answer, by model and reason."""
FAILURES_SHOWN = 3
"""Poses named for each reason of failure."""
USUAL = Patience()
OWN = re.compile(
    r"(frequencies|error-map)\.(parquet|csv|json)|(timing|errors|worst|failures)\.(csv|md|tex)"
)
"""Names of the files that a sweep writes."""


@dataclass(frozen=True)
class Swept(Result):
    """What came of a sweep.

    Attributes: `file` of the rows and the other `files`; `made`, the tables by name; `lacking`,
    numbers of the poses without an answer by model and reason; `solved`, how many jobs were not
    found in the folder.
    """

    file: Path
    files: tuple[Path, ...]
    made: Mapping[str, Table]
    lacking: Failures
    solved: int

    def to_frame(self) -> "pd.DataFrame":
        """Return the rows, one a pose, model and mode: SI, units in the names of the columns."""
        with connect() as base:
            frame: pd.DataFrame = base.execute(f"FROM {quoted(self.file)}").df()
        return frame

    def tables(self) -> Mapping[str, Table]:
        """Return timing, errors, worst poses and failures."""
        return self.made

    def failures(self) -> dict[str, str]:
        """Return what has no answer ("MODEL at N poses"), and why."""
        return {f"{name} at {len(n)} poses": why for (name, why), n in self.lacking.items()}


def solve(
    mechanism: Mechanism | str,
    poses: Pose | str,
    models: Iterable[Model] | str,
    folder: Path | str,
    count: int = 6,
    *,
    against: Model | str | None = None,
    cores: int | None = None,
    scheduler: str | None = None,
    patience: Patience = USUAL,
) -> Swept:
    """Solve `poses` (arrays) by `models` into `folder`; what is there already is not solved again.

    Texts mean what they mean on the command line: a case's name for its mechanism, "random:7:1",
    "exudyn-cable@8,rayleigh@exact".
    `against`: one of the models, or one more, that the others are compared with. Jobs run on
    `cores`, by default all, or on the Dask cluster of a `scheduler`. Raises `OutputError` where the
    folder cannot be written.
    """
    if isinstance(mechanism, str):
        mechanism = select([mechanism], {})[0].mechanism
    if isinstance(poses, str):
        poses = pose_set(poses, mechanism)
    if isinstance(models, str):
        models = models_of(models, "models")
    if isinstance(against, str):
        against = parse(against, "against")
    folder, modes = Path(folder), range(1, count + 1)
    with (
        engine(cores or threads.cores(), scheduler, patience) as here,
        closing(Journal(folder)) as journal,
    ):
        sweep = Sweep(mechanism, poses, tuple(models), modes, against, journal, here)
        return carry_out(sweep, folder / "frequencies.parquet")


def carry_out(
    sweep: Sweep,
    file: Path,
    *,
    listener: Callable[[Job], None] = lambda _: None,
    again: str = "",
    history: tuple[Path, str] | None = None,
) -> Swept:
    """Run what is not in the journal and write one row a pose, model and mode into `file`.

    Errors and tables go beside it; the ending .parquet, .csv or .json is that of all rows. The
    `listener` hears of each finished job; `again`: options of a command that shows a worst pose;
    `history`: where the rows are kept, unless one has them all, and as which command. Files that
    an earlier sweep left in the folder and this one does not write are removed.
    Raises `OutputError` where a file cannot be written.
    """
    with closing(Rows(sweep, file)) as rows:

        def tell(job: Job) -> None:
            listener(job)
            rows.tell(job)

        failures, solved = complete(sweep, tell)
        rows.finish()
        made, files = {"timing": rows.timing_table()}, [file]
        if sweep.against is not None:
            files.append(file.with_name(f"error-map{file.suffix}"))
            made |= compare(sweep, sweep.against, files[-1], again)
        made["failures"] = failure_table(failures)
        files += write_all(file.parent, table_files(made))
        made = {"first": rows.first_table(), **made}  # shown only: the file has all of it
        for path in file.parent.iterdir():
            if OWN.fullmatch(path.name) and path not in files:  # an earlier sweep's
                path.unlink()
        if history is not None:
            rows.keep(*history)
    return Swept(file, tuple(files), made, failures, solved)


def complete(sweep: Sweep, listener: Callable[[Job], None]) -> tuple[Failures, int]:
    """Run what is not in the journal; `listener` hears of each finished job.

    Returns what has no answer, and how many jobs were solved, not found in the journal.
    """
    failures: Failures = {}
    solved = 0

    def missing() -> Iterator[Job]:
        for model in sweep.models:
            unusable, _ = program_of(model)
            if unusable:  # said once, not found at every pose
                failures[label(model), unusable] = list(range(1, len(sweep.poses) + 1))
            for job in sweep.jobs(model):
                if unusable or sweep.journal.get(job):
                    listener(job)
                else:
                    yield job

    for job, result in run(sweep.engine, missing()):
        why = result.reason if isinstance(result, Failure) else job.flaw(result)
        if why:
            numbers = range(job.start + 1, job.start + 1 + len(job.poses))
            failures.setdefault((label(job.model), why), []).extend(numbers)
        else:
            sweep.journal.put(job, result)
            solved += 1
        listener(job)
    return {key: sorted(numbers) for key, numbers in sorted(failures.items())}, solved


def failure_table(failures: Failures) -> Table:
    """Why models have no answer, and where."""
    rows: list[tuple[Cell, ...]] = []
    for (model, reason), numbers in failures.items():
        named = ", ".join(map(str, numbers[:FAILURES_SHOWN]))
        if len(numbers) > FAILURES_SHOWN:
            named += f" and {len(numbers) - FAILURES_SHOWN} more"
        rows.append((model, len(numbers), named, reason))
    notes = ("run the same command again to try these, and only these, anew",)
    return Table("Failures", ("Model", "Poses", "Numbers", "Reason"), tuple(rows), notes)


def estimate(sweep: Sweep) -> Table:
    """Return the jobs of each model and the time they will take, from that of one."""
    rows: list[tuple[Cell, ...]] = []
    cores, together = sweep.engine.cores, 0.0
    for model in sweep.models:
        sizes = [0 if sweep.journal.get(job) else len(job.poses) for job in sweep.jobs(model)]
        todo = sum(size > 0 for size in sizes)
        counts = label(model), len(sizes), len(sizes) - todo, todo
        each = _seconds_a_pose(sweep, model)
        if isinstance(each, Failure):
            rows.append((*counts, "-", each.reason))
            continue
        seconds = sum(sizes) * each / min(cores, max(1, todo))
        together += seconds
        rows.append((*counts, Number(1e3 * each, 3), _duration(seconds)))
    names = ("Model", "Jobs", "Done", "To do", "ms a pose", "Time")
    note = (
        f"{len(sweep.poses)} poses; all together {_duration(together)} on {cores} cores, "
        "from the time of one pose a model"
    )
    return Table("Dry run", names, tuple(rows), (note,))


def _seconds_a_pose(sweep: Sweep, model: Model) -> float | Failure:
    """Return what a pose of one model takes on one core, measured at the first job [s]."""
    first = next(sweep.jobs(model, 0, CHUNK))
    for _ in range(2):  # the first time pays for the start of a process
        began = perf_counter()
        ((_, result),) = run(sweep.engine, [first])
        elapsed = perf_counter() - began
    return result if isinstance(result, Failure) else elapsed / len(first.poses)


def _duration(seconds: float) -> str:
    if seconds < 100:
        return f"{seconds:.2g} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 100 else f"{minutes // 60} h {minutes % 60} min"
