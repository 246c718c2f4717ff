"""A sweep: any set of poses by any models; finished jobs are kept, rows come from them alone."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from time import perf_counter

from analytic import Mechanism, Pose
from analytic.condensed import CHUNK
from analytic.model import Model
from harness.bench import label
from harness.sweep.engine import Engine, run
from harness.sweep.jobs import BATCH, Answer, Job, jobs, unusable
from harness.sweep.journal import Journal
from harness.tables import Cell, Number, Table
from harness.workers import Failure

FAILURES_SHOWN = 3
"""Poses named for each reason of failure."""
Failures = dict[tuple[str, str], list[int]]
"""Numbers of the poses without an answer, by model and reason."""


@dataclass(frozen=True)
class Sweep:
    """The lowest `count` modes of `mechanism` at `poses` (arrays) by all `models`."""

    mechanism: Mechanism
    poses: Pose
    models: tuple[Model, ...]
    count: int

    def jobs(self, model: Model, start: int = 0, stop: int | None = None) -> Iterator[Job]:
        """Return the jobs of one model for the poses from `start`, a multiple of `BATCH`, on."""
        return jobs(model, self.mechanism, self.poses[start:stop], self.count, start)

    def blocks(self) -> Iterator[tuple[int, int]]:
        """Yield start and stop of the blocks in which poses are read back."""
        for start in range(0, len(self.poses), BATCH):
            yield start, min(start + BATCH, len(self.poses))

    def answers(
        self, journal: Journal, model: Model, start: int, stop: int
    ) -> Iterator[tuple[Job, Answer]]:
        """Yield the finished jobs of a block of poses, in order."""
        for job in self.jobs(model, start, stop):
            answer = journal.get(job)
            if answer is not None:
                yield job, answer


def complete(
    sweep: Sweep, journal: Journal, engine: Engine, listener: Callable[[Job], None]
) -> tuple[Failures, int]:
    """Run what is not in the journal; `listener` hears of each finished job.

    Returns what has no answer, and how many jobs were solved, not found in the journal.
    """

    def missing() -> Iterator[Job]:
        for model in sweep.models:
            known = unusable(model)
            for job in sweep.jobs(model):
                if known or job in journal:
                    listener(job)
                else:
                    yield job

    failures: Failures = {}
    solved = 0
    for model in sweep.models:
        if why := unusable(model):  # once, not at every pose
            failures[label(model), why] = list(range(1, len(sweep.poses) + 1))
    for job, result in run(engine, missing()):
        why = result.reason if isinstance(result, Failure) else job.flaw(result)
        if why:
            numbers = range(job.start + 1, job.start + 1 + len(job.poses))
            failures.setdefault((label(job.model), why), []).extend(numbers)
        else:
            journal.put(job, result)
            solved += 1
        listener(job)
    return {key: sorted(numbers) for key, numbers in sorted(failures.items())}, solved


def failure_table(failures: Failures) -> Table:
    """Why models have no answer, and where."""
    rows: list[tuple[Cell, ...]] = []
    for (model, reason), numbers in failures.items():
        named = ", ".join(map(str, numbers[:FAILURES_SHOWN]))
        more = len(numbers) - FAILURES_SHOWN
        named += f" and {more} more" if more > 0 else ""
        rows.append((model, len(numbers), named, reason))
    notes = ("run the same command again to try these, and only these, anew",)
    return Table("Failures", ("Model", "Poses", "Numbers", "Reason"), tuple(rows), notes)


def estimate(sweep: Sweep, journal: Journal, engine: Engine) -> Table:
    """Return the jobs of each model and the time they will take, from that of one."""
    rows: list[tuple[Cell, ...]] = []
    together = 0.0
    for model in sweep.models:
        jobs = [(job in journal, len(job.poses)) for job in sweep.jobs(model)]
        total, done = len(jobs), sum(there for there, _ in jobs)
        left = sum(poses for there, poses in jobs if not there)
        why = unusable(model)
        each = Failure(why) if why else _seconds_a_pose(sweep, model, engine)
        if isinstance(each, Failure):
            rows.append((label(model), total, done, total - done, "-", each.reason))
            continue
        seconds = left * each / min(engine.cores, max(1, total - done))
        together += seconds
        ms = Number(1e3 * each, 3)
        rows.append((label(model), total, done, total - done, ms, _duration(seconds)))
    columns = ("Model", "Jobs", "Done", "To do", "ms a pose", "Time")
    notes = (
        f"{len(sweep.poses)} poses; all together {_duration(together)} on {engine.cores} cores, "
        "from the time of one pose a model",
    )
    return Table("Dry run", columns, tuple(rows), notes)


def _seconds_a_pose(sweep: Sweep, model: Model, engine: Engine) -> float | Failure:
    """Return what a pose of one model takes on one core, measured at the first job [s]."""
    first = next(sweep.jobs(model, 0, CHUNK))
    for _ in range(2):  # the first time pays for the start of a process
        began = perf_counter()
        ((_, result),) = run(engine, [first])
        elapsed = perf_counter() - began
    if isinstance(result, Failure):
        return result
    return elapsed / len(first.poses)


def _duration(seconds: float) -> str:
    if seconds < 100:
        return f"{seconds:.2g} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 100 else f"{minutes // 60} h {minutes % 60} min"
