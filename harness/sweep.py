"""A sweep: any set of poses by any models; finished jobs are kept, rows come from them alone."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from time import perf_counter

import numpy as np
import polars as pl
from numpy.typing import NDArray

from analytic import Mechanism, Pose
from analytic.condensed import CHUNK
from harness.engine import Engine, run
from harness.frames import write_frames
from harness.jobs import BATCH, Answer, Failure, Job, jobs
from harness.journal import Journal
from harness.models import Spec
from harness.tables import Cell, Number, Table

FAILURES_SHOWN = 3
"""Poses named for each reason of failure."""

ROWS = {
    "pose": pl.Int64,
    "z_m": pl.Float64,
    "azimuth_rad": pl.Float64,
    "tilt_rad": pl.Float64,
    "mechanism": pl.String,
    "model": pl.String,
    "theory": pl.String,
    "version": pl.String,
    "mode": pl.Int64,
    "frequency_hz": pl.Float64,
    "uncertainty_hz": pl.Float64,
    "closure_m": pl.Float64,
    "dofs": pl.Int64,
}


@dataclass(frozen=True)
class Sweep:
    """The lowest `count` modes of `mechanism` at `poses` (arrays) by all `specs`."""

    mechanism: Mechanism
    poses: Pose
    specs: tuple[Spec, ...]
    count: int

    def jobs(self, spec: Spec, start: int = 0, stop: int | None = None) -> Iterator[Job]:
        """Return the jobs of one model for the poses from `start`, a multiple of `BATCH`, on."""
        return jobs(spec, self.mechanism, self.poses[start:stop], self.count, start)

    def blocks(self) -> Iterator[tuple[int, int]]:
        """Yield start and stop of the blocks in which poses are read back."""
        for start in range(0, len(self.poses), BATCH):
            yield start, min(start + BATCH, len(self.poses))

    def done(self, spec: Spec, journal: Journal) -> tuple[int, int, int]:
        """Return the number of jobs of one model, how many are finished, and the poses left."""
        total = finished = left = 0
        for job in self.jobs(spec):
            total += 1
            if job in journal:
                finished += 1
            else:
                left += len(job.poses)
        return total, finished, left


Failures = dict[tuple[str, str], list[int]]
"""Numbers of the poses without an answer, by model and reason."""


def complete(
    sweep: Sweep, journal: Journal, engine: Engine, tell: Callable[[Spec, int], None]
) -> Failures:
    """Run what is not in the journal; `tell` hears of each finished job's model and poses."""

    def missing() -> Iterator[Job]:
        for spec in sweep.specs:
            for job in sweep.jobs(spec):
                if job in journal:
                    tell(spec, len(job.poses))
                else:
                    yield job

    failures: Failures = {}
    for job, result in run(engine, missing()):
        if isinstance(result, Failure):
            numbers = range(job.start + 1, job.start + 1 + len(job.poses))
            failures.setdefault((job.spec.label, result.reason), []).extend(numbers)
        else:
            journal.put(job, result)
        tell(job.spec, len(job.poses))
    return {key: sorted(numbers) for key, numbers in sorted(failures.items())}


def seconds_a_pose(sweep: Sweep, spec: Spec, engine: Engine) -> float | Failure:
    """Return what a pose of one model takes on one core, measured at the first job [s]."""
    first = next(sweep.jobs(spec, 0, CHUNK))
    for _ in range(2):  # the first time pays for the start of a process
        began = perf_counter()
        ((_, result),) = run(engine, [first])
        elapsed = perf_counter() - began
    if isinstance(result, Failure):
        return result
    return elapsed / len(first.poses)


def answers(
    sweep: Sweep, journal: Journal, spec: Spec, start: int, stop: int
) -> Iterator[tuple[Job, Answer]]:
    """Yield the finished jobs of a block of poses, in order."""
    for job in sweep.jobs(spec, start, stop):
        answer = journal.get(job)
        if answer is not None:
            yield job, answer


def export(sweep: Sweep, journal: Journal, modes: list[int], folder: Path, suffix: str) -> Path:
    """Write one row a pose, model and mode into `folder`; SI units; flat in memory."""
    mechanism = sha256(repr(sweep.mechanism).encode()).hexdigest()[:12]

    def frames() -> Iterator[pl.DataFrame]:
        for spec in sweep.specs:
            for start, stop in sweep.blocks():
                found = list(answers(sweep, journal, spec, start, stop))
                if found:
                    yield _frame(spec, mechanism, found, np.array(modes))

    return write_frames(folder, f"frequencies.{suffix}", frames(), ROWS)


def _frame(
    spec: Spec, mechanism: str, found: list[tuple[Job, Answer]], modes: NDArray[np.int64]
) -> pl.DataFrame:
    sizes = [len(job.poses) for job, _ in found]
    each = np.repeat(np.arange(len(found)), sizes)
    poses = [job.poses for job, _ in found]
    m = len(modes)

    def by_mode(values: list[NDArray[np.float64] | None]) -> NDArray[np.float64]:
        filled = [
            np.full((n, m), np.nan) if value is None else value[:, modes - 1]
            for n, value in zip(sizes, values, strict=True)
        ]
        return np.concatenate(filled).ravel()

    numbers = np.concatenate([np.arange(job.start + 1, job.start + 1 + n)
                              for (job, _), n in zip(found, sizes, strict=True)])  # fmt: skip
    frame = pl.DataFrame(
        {
            "pose": np.repeat(numbers, m),
            "z_m": np.repeat(np.concatenate([p.z for p in poses]), m),
            "azimuth_rad": np.repeat(np.concatenate([p.azimuth for p in poses]), m),
            "tilt_rad": np.repeat(np.concatenate([p.tilt for p in poses]), m),
            "mode": np.tile(modes, len(numbers)),
            "frequency_hz": by_mode([a.frequencies for _, a in found]),
            "uncertainty_hz": by_mode([a.uncertainty for _, a in found]),
        }
    )
    of_job = pl.DataFrame(
        {
            "mechanism": mechanism,
            "model": spec.label,
            "theory": [a.theory for _, a in found],
            "version": [job.version for job, _ in found],
            "closure_m": [a.closure for _, a in found],
            "dofs": [a.dofs or None for _, a in found],
        },
        schema={name: ROWS[name] for name in
                ("mechanism", "model", "theory", "version", "closure_m", "dofs")},
    )  # fmt: skip
    frame = frame.with_columns(pl.col("uncertainty_hz").fill_nan(None))
    return frame.hstack(of_job[np.repeat(each, m)]).select(list(ROWS))


def timing_table(sweep: Sweep, journal: Journal) -> Table:
    """What each model itself took, over all runs into this folder."""
    rows: list[tuple[Cell, ...]] = []
    for spec in sweep.specs:
        total, poses = 0.0, 0
        for start, stop in sweep.blocks():
            for job, answer in answers(sweep, journal, spec, start, stop):
                total += answer.seconds
                poses += len(job.poses)
        each = Number(1e3 * total / poses, 4) if poses else "-"
        rows.append((spec.label, poses, Number(total, 2), each))
    return Table("Time", ("Model", "Poses", "Seconds", "ms a pose"), tuple(rows))


def failure_table(failures: Failures) -> Table:
    """Why models have no answer, and where."""
    rows: list[tuple[Cell, ...]] = []
    for (label, reason), numbers in failures.items():
        named = ", ".join(map(str, numbers[:FAILURES_SHOWN]))
        more = len(numbers) - FAILURES_SHOWN
        rows.append(
            (label, len(numbers), f"{named} and {more} more" if more > 0 else named, reason)
        )
    notes = ("run the same command again to try these, and only these, anew",)
    return Table("Failures", ("Model", "Poses", "Numbers", "Reason"), tuple(rows), notes)
