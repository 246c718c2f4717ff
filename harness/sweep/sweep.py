"""A sweep: any set of poses by any models; finished jobs are kept, rows come from them alone."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError
from dataclasses import dataclass
from threading import Condition
from typing import Self

import numpy as np

from analytic import Mechanism, Pose
from analytic.model import Model
from harness.bench import label
from harness.sweep.engine import Engine, run
from harness.sweep.jobs import BATCH, Answer, Job, jobs
from harness.sweep.journal import Journal
from harness.tables import Cell, Number, Table
from harness.workers import Failure

FAILURES_SHOWN = 3
"""Poses named for each reason of failure."""


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

    def done(self, model: Model, journal: Journal) -> tuple[int, int, int]:
        """Return the number of jobs of one model, how many are finished, and the poses left."""
        total = finished = left = 0
        for job in self.jobs(model):
            total += 1
            if job in journal:
                finished += 1
            else:
                left += len(job.poses)
        return total, finished, left


class Finished:
    """Which blocks of poses are finished, for a thread that reads them while others are solved.

    As a context it says, where it is left before all are, that no more will be.
    """

    def __init__(self, sweep: Sweep) -> None:
        self._left = {
            (model, start): stop - start for model in sweep.models for start, stop in sweep.blocks()
        }
        self._over = False
        self._changed = Condition()

    def tell(self, job: Job) -> None:
        """Take in a finished job, with or without an answer."""
        with self._changed:
            self._left[job.model, job.start // BATCH * BATCH] -= len(job.poses)
            self._changed.notify_all()

    def wait(self, model: Model, start: int) -> None:
        """Return when the block from `start` on is finished; raises `CancelledError` if never."""
        with self._changed:
            self._changed.wait_for(lambda: self._over or not self._left[model, start])
            if self._left[model, start]:
                raise CancelledError

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        with self._changed:
            self._over = True
            self._changed.notify_all()


Failures = dict[tuple[str, str], list[int]]
"""Numbers of the poses without an answer, by model and reason."""


def complete(
    sweep: Sweep, journal: Journal, engine: Engine, listeners: Sequence[Callable[[Job], None]]
) -> tuple[Failures, int]:
    """Run what is not in the journal; `listeners` hear of each finished job.

    Returns what has no answer, and how many jobs were solved, not found in the journal.
    """

    def tell(job: Job) -> None:
        for listener in listeners:
            listener(job)

    def missing() -> Iterator[Job]:
        for model in sweep.models:
            for job in sweep.jobs(model):
                if job in journal:
                    tell(job)
                else:
                    yield job

    failures: Failures = {}
    solved = 0
    for job, result in run(engine, missing()):
        why = result.reason if isinstance(result, Failure) else job.flaw(result)
        if why:
            numbers = range(job.start + 1, job.start + 1 + len(job.poses))
            failures.setdefault((label(job.model), why), []).extend(numbers)
        else:
            journal.put(job, result)
            solved += 1
        tell(job)
    return {key: sorted(numbers) for key, numbers in sorted(failures.items())}, solved


def answers(
    sweep: Sweep, journal: Journal, model: Model, start: int, stop: int
) -> Iterator[tuple[Job, Answer]]:
    """Yield the finished jobs of a block of poses, in order."""
    for job in sweep.jobs(model, start, stop):
        answer = journal.get(job)
        if answer is not None:
            yield job, answer


@dataclass(frozen=True)
class Timing:
    """What a model itself took over all runs into a folder: seconds in all, and usually a pose.

    `theories` and `versions` in words: usually one, but a simulator may have others elsewhere.
    """

    poses: int
    total: float
    usual: float | None
    theories: frozenset[str]
    versions: frozenset[str]


def timings(sweep: Sweep, journal: Journal) -> dict[Model, Timing]:
    """Return what each model took."""
    found = {}
    for model in sweep.models:
        poses, each, total, theories, versions = 0, [], 0.0, set(), set()
        for start, stop in sweep.blocks():
            for job, answer in answers(sweep, journal, model, start, stop):
                poses += len(job.poses)
                each.append(answer.seconds / len(job.poses))
                total += answer.seconds
                theories.add(answer.theory)
                versions.add(answer.version)
        usual = float(np.median(each)) if each else None
        found[model] = Timing(poses, total, usual, frozenset(theories), frozenset(versions))
    return found


def timing_table(found: dict[Model, Timing]) -> Table:
    """What each model itself took, over all runs into this folder."""
    rows: list[tuple[Cell, ...]] = []
    for model, timing in found.items():
        usual = "-" if timing.usual is None else Number(1e3 * timing.usual, 4)
        rows.append((label(model), timing.poses, Number(timing.total, 2), usual))
    notes = ("ms a pose: the median; seconds: all, with what each process loads for its first job",)
    return Table("Time", ("Model", "Poses", "Seconds", "ms a pose"), tuple(rows), notes)


def failure_table(failures: Failures) -> Table:
    """Why models have no answer, and where."""
    rows: list[tuple[Cell, ...]] = []
    for (model, reason), numbers in failures.items():
        named = ", ".join(map(str, numbers[:FAILURES_SHOWN]))
        more = len(numbers) - FAILURES_SHOWN
        rows.append(
            (model, len(numbers), f"{named} and {more} more" if more > 0 else named, reason)
        )
    notes = ("run the same command again to try these, and only these, anew",)
    return Table("Failures", ("Model", "Poses", "Numbers", "Reason"), tuple(rows), notes)
