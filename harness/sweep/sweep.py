"""A sweep: any set of poses by any models; finished jobs are kept, rows come from them alone."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from analytic import Mechanism, Pose
from analytic.condensed import CHUNK
from analytic.model import Model
from harness.bench import label
from harness.history.duck import constant, named, one_of
from harness.history.provenance import provenance
from harness.history.store import append_table, has, name_of
from harness.poses import cells, columns, headings, used
from harness.rows import SWEEP, mechanism_hash, settings
from harness.sweep.engine import Engine, run
from harness.sweep.jobs import BATCH, Answer, Job, Journal, jobs, program_of
from harness.sweep.long_table import TABLE, LongTable
from harness.tables import Cell, Number, Table
from harness.workers import Failure

FEW = 3
"""Poses named for each reason of failure, and whose frequencies are shown when a sweep ends."""
Failures = dict[tuple[str, str], list[int]]
"""Numbers of the poses without an answer, by model and reason."""


@dataclass(frozen=True)
class Sweep:
    """The lowest `count` modes of `mechanism` at `poses` (arrays) by all `models`.

    Jobs run where the `engine` says; what they find is kept in the `journal`.
    """

    mechanism: Mechanism
    poses: Pose
    models: tuple[Model, ...]
    count: int
    journal: Journal
    engine: Engine

    def jobs(self, model: Model, start: int = 0, stop: int | None = None) -> Iterator[Job]:
        """Return the jobs of one model for the poses from `start`, a multiple of `BATCH`, on."""
        return jobs(model, self.mechanism, self.poses[start:stop], self.count, start)

    def blocks(self) -> range:
        """Return where the blocks start in which poses are read back."""
        return range(0, len(self.poses), BATCH)

    def answers(self, model: Model, start: int) -> Iterator[tuple[Job, Answer]]:
        """Yield the finished jobs of a block of poses, in order."""
        for job in self.jobs(model, start, start + BATCH):
            answer = self.journal.get(job)
            if answer is not None:
                yield job, answer


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
                if unusable or job in sweep.journal:
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
        named = ", ".join(map(str, numbers[:FEW]))
        if len(numbers) > FEW:
            named += f" and {len(numbers) - FEW} more"
        rows.append((model, len(numbers), named, reason))
    notes = ("run the same command again to try these, and only these, anew",)
    return Table("Failures", ("Model", "Poses", "Numbers", "Reason"), tuple(rows), notes)


def estimate(sweep: Sweep) -> Table:
    """Return the jobs of each model and the time they will take, from that of one."""
    rows: list[tuple[Cell, ...]] = []
    cores, together = sweep.engine.cores, 0.0
    for model in sweep.models:
        jobs = [(job in sweep.journal, len(job.poses)) for job in sweep.jobs(model)]
        total, done = len(jobs), sum(there for there, _ in jobs)
        counts = label(model), total, done, total - done
        why, _ = program_of(model)
        each = Failure(why) if why else _seconds_a_pose(sweep, model)
        if isinstance(each, Failure):
            rows.append((*counts, "-", each.reason))
            continue
        left = sum(poses for there, poses in jobs if not there)
        seconds = left * each / min(cores, max(1, total - done))
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


class Rows(LongTable):
    """The rows of a sweep on their way to `file`, added while further jobs are solved.

    Texts are numbers in the base: `which` of the models, and which of all that answers have `told`
    of themselves, their theory, version and what made them.
    """

    def __init__(self, sweep: Sweep, file: Path, modes: Sequence[int]) -> None:
        self._sweep, self._pick, self._where = sweep, np.array(modes) - 1, used([sweep.poses])
        self._told: dict[tuple[str, ...], int] = {}
        self._runs: set[str | None] = set()
        # What each model itself took over all runs into the folder: poses and seconds of each job.
        self._times = {model: (list[int](), list[float]()) for model in sweep.models}
        self._left = {
            (model, start): min(BATCH, len(sweep.poses) - start)
            for model in sweep.models
            for start in sweep.blocks()
        }
        self._blocks = deque(self._left)
        columns = dict.fromkeys(("pose", "which", "told", "dofs"), "BIGINT")
        reals = (*self._where, "frequency_hz", "uncertainty_hz", "closure_m")
        columns |= dict.fromkeys(reals, "DOUBLE")
        super().__init__(file, columns, ("frequency_hz", "uncertainty_hz"), modes)

    def tell(self, job: Job) -> None:
        """Take in a finished job, with or without an answer; add blocks that are complete."""
        self._left[job.model, job.start // BATCH * BATCH] -= len(job.poses)
        while self._blocks and not self._left[self._blocks[0]]:
            model, start = self._blocks.popleft()
            if found := list(self._sweep.answers(model, start)):
                self._add(model, *zip(*found, strict=True))

    def _add(self, model: Model, jobs: Sequence[Job], answers: Sequence[Answer]) -> None:
        sizes = [len(job.poses) for job in jobs]
        poses, seconds = self._times[model]
        poses += sizes
        seconds += [answer.seconds for answer in answers]
        self._runs.update(map(self._sweep.journal.run_of, jobs))

        def each(values: Iterable[Any]) -> Any:
            """Return a value of every job for each of its poses."""
            return np.repeat(np.array([*values], dtype=float), sizes)

        def told(answer: Answer) -> int:
            said = answer.theory, answer.version, *answer.made
            return self._told.setdefault(said, len(self._told))

        f = np.concatenate([answer.frequencies for answer in answers])
        own = [np.full_like(a.frequencies, np.nan) if a.uncertainty is None else a.uncertainty
               for a in answers]  # fmt: skip
        numbers = np.concatenate([job.start + np.arange(len(job.poses)) for job in jobs])
        at = columns(self._sweep.poses[numbers])
        block = {
            "pose": numbers + 1,
            "which": self._sweep.models.index(model),
            "told": each(map(told, answers)),
            "dofs": each(answer.dofs or None for answer in answers),
            "closure_m": each(answer.closure for answer in answers),
            "frequency_hz": f[:, self._pick],
            "uncertainty_hz": np.concatenate(own)[:, self._pick],
        }
        self.add(block | {name: at[name] for name in self._where})

    def _texts(self) -> dict[str, str]:
        """Return the columns of texts as SQL."""
        models = self._sweep.models
        texts = {
            "mechanism": constant(mechanism_hash(self._sweep.mechanism)),
            "model": one_of([label(model) for model in models], "which"),
        }
        for k, name in enumerate(("theory", "version", *provenance())):
            texts[name] = one_of([said[k] for said in self._told], "told")
        return texts

    def finish(self) -> None:
        """Write the file when all blocks are there."""
        names = ("pose", *self._where, "mechanism", "model", "theory", "version", "mode",
                 "frequency_hz", "uncertainty_hz", "closure_m", "dofs")  # fmt: skip
        texts = self._texts()
        self.write({name: texts.get(name, name) for name in names})

    def keep(self, folder: Path, command: str) -> None:
        """Append the rows to the history in `folder`, if it lacks any; `solve_s` is a median.

        Each says what made it, which need not be what resumed the sweep.
        """
        if all(run is not None and has(folder, run) for run in self._runs):
            return
        sweep = self._sweep
        usual = ", ".join(str(self._usual(model) or "NULL") for model in sweep.models)
        texts = self._texts() | {
            "case": constant(SWEEP),
            "settings": one_of([settings(model, sweep.count) for model in sweep.models], "which"),
            "solve_s": f"[{usual}][which + 1]",
        }
        shown = ", ".join(f"{sql} AS {named(name)}" for name, sql in texts.items())
        self.base.execute(f"CREATE TEMP VIEW records AS SELECT *, {shown} FROM {TABLE}")
        time = datetime.now(UTC)
        name = name_of(time)
        answered = (
            job
            for model in sweep.models
            for start in sweep.blocks()
            for job, _ in sweep.answers(model, start)
        )
        sweep.journal.goes_to(name, answered)
        append_table(folder, self.base, "records", command, time, name)

    def _usual(self, model: Model) -> float | None:
        """Return the median over the model's jobs of the seconds a pose."""
        poses, seconds = self._times[model]
        return float(np.median(np.divide(seconds, poses))) if poses else None

    def first_table(self) -> Table:
        """Return the frequencies of the first few poses; the file has all of them."""
        number = len(self._where)
        asked = ["pose", "which", *self._where, *(f"frequency_hz_{i}" for i in self._pick + 1)]
        found = self.base.execute(
            f"SELECT {', '.join(asked)} FROM wide WHERE pose <= {FEW} ORDER BY pose, which"
        )
        rows = tuple(
            (
                pose, *cells(dict(zip(self._where, values[:number], strict=True)), self._where),
                label(self._sweep.models[which]),
                *("-" if f is None else Number(f) for f in values[number:]),
            )
            for pose, which, *values in found.fetchall()
        )  # fmt: skip
        names = "Pose", *headings(self._where), "Model", *(f"f{i} [Hz]" for i in self._pick + 1)
        poses = len(self._sweep.poses)
        title = f"Frequencies of the first {min(FEW, poses)} of {poses} poses"
        return Table(title, names, rows)

    def timing_table(self) -> Table:
        """What each model itself took, over all runs into this folder."""
        rows: list[tuple[Cell, ...]] = []
        for model, (poses, seconds) in self._times.items():
            usual = self._usual(model)
            ms = "-" if usual is None else Number(1e3 * usual, 4)
            rows.append((label(model), sum(poses), Number(sum(seconds), 2), ms))
        notes = (
            "ms a pose: the median; seconds: all, with what each process loads for its first job",
        )
        return Table("Time", ("Model", "Poses", "Seconds", "ms a pose"), tuple(rows), notes)
