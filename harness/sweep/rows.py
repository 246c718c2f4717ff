"""The rows of a sweep: one a pose, model and mode, made from the finished jobs."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Self

import numpy as np

from analytic.model import Model
from harness.bench import label
from harness.history.duck import constant, named, one_of, quoted
from harness.history.provenance import provenance
from harness.history.run_file import COLUMNS as HISTORY
from harness.history.store import append_table, has, name_of
from harness.poses import COLUMNS, cells, columns, headings, used
from harness.rows import SWEEP, mechanism_hash, settings
from harness.sweep.jobs import BATCH, Answer, Job
from harness.sweep.journal import Journal
from harness.sweep.long_table import TABLE, LongTable
from harness.sweep.sweep import Sweep
from harness.tables import Cell, Number, Table

ROWS = {
    "pose": "BIGINT",
    **{name: HISTORY[name] for name in (
        *COLUMNS, "mechanism", "model", "theory", "version", "mode", "frequency_hz",
        "uncertainty_hz", "closure_m", "dofs",
    )},
    "made": "BIGINT",
}  # fmt: skip
"""Columns and their types; the last one, which of `Rows.made` it was, is not for the file."""

FEW = 3
"""Poses whose frequencies are shown when a sweep ends."""


@dataclass
class Timing:
    """What a model itself took over all runs into a folder: all, and a pose of `each` job [s]."""

    poses: int = 0
    seconds: float = 0.0
    each: list[float] = field(default_factory=list)

    @property
    def usual(self) -> float | None:
        """The median of the seconds a pose."""
        return float(np.median(self.each)) if self.each else None


class Rows:
    """The rows on their way to `file`, added block by block while further jobs are solved.

    As a context. Attributes, whole when `write` has returned: `timings` of each model; `made`: what
    code, machines and libraries made the answers, numbered; `runs` of a history that the answers
    went to, None among them where one went nowhere yet.
    """

    def __init__(self, sweep: Sweep, journal: Journal, file: Path, modes: Sequence[int]) -> None:
        self.timings = {model: Timing() for model in sweep.models}
        self.made: dict[tuple[str, ...], int] = {}
        self.runs: set[str | None] = set()
        self._sweep, self._journal, self._pick = sweep, journal, np.array(modes) - 1
        labels = ", ".join(quoted(label(model)) for model in sweep.models)
        self._where = used([sweep.poses])
        kinds = {n: k for n, k in ROWS.items() if n not in COLUMNS or n in self._where}
        kinds["model"] = f"ENUM({labels})"
        self._kinds = kinds
        self._table = LongTable(file, kinds, ["frequency_hz", "uncertainty_hz"], modes)
        self._left = {
            (model, start): stop - start for model in sweep.models for start, stop in sweep.blocks()
        }
        self._blocks = deque(self._left)

    def tell(self, job: Job) -> None:
        """Take in a finished job, with or without an answer."""
        self._left[job.model, job.start // BATCH * BATCH] -= len(job.poses)
        while self._blocks and not self._left[self._blocks[0]]:
            self._add(*self._blocks.popleft())

    def _add(self, model: Model, start: int) -> None:
        """Add one row a pose and mode of a block, whose jobs are all finished."""
        sweep = self._sweep
        stop = min(start + BATCH, len(sweep.poses))
        found = list(sweep.answers(self._journal, model, start, stop))
        for job, answer in found:
            timing = self.timings[model]
            timing.poses += len(job.poses)
            timing.seconds += answer.seconds
            timing.each.append(answer.seconds / len(job.poses))
            self.runs.add(self._journal.run_of(job))
        if found:
            same = {"mechanism": mechanism_hash(sweep.mechanism), "model": label(model)}
            self._table.add(self._block(found) | same)

    def _block(self, found: list[tuple[Job, Answer]]) -> dict[str, Any]:
        """Return some jobs' answers as columns, a row a pose."""
        jobs, got = zip(*found, strict=True)
        sizes = [len(job.poses) for job in jobs]

        def each(values: list[Any]) -> Any:
            """Return a value of every job for its poses: one for all where all are the same."""
            if len(set(values)) == 1:
                return values[0]
            # Where there are numbers, None is not a number.
            kind: type = object if any(isinstance(value, str) for value in values) else float
            return np.repeat(np.array(values, dtype=kind), sizes)

        def of_modes(values: list[Any]) -> Any:
            return np.concatenate([value[:, self._pick] for value in values])

        return {
            "pose": np.concatenate([job.start + 1 + np.arange(len(job.poses)) for job in jobs]),
            **{
                column: np.concatenate([columns(job.poses)[column] for job in jobs])
                for column in self._where
            },
            "theory": each([a.theory for a in got]),
            "version": each([a.version for a in got]),
            "closure_m": each([a.closure for a in got]),
            "dofs": each([a.dofs or None for a in got]),
            "made": each([self.made.setdefault(a.made, len(self.made)) for a in got]),
            "frequency_hz": of_modes([a.frequencies for a in got]),
            "uncertainty_hz": of_modes(
                [np.nan * a.frequencies if a.uncertainty is None else a.uncertainty for a in got]
            ),
        }

    def write(self) -> None:
        """Write the file when all blocks are there."""
        self._table.write("made")

    def keep(self, folder: Path, command: str) -> None:
        """Append the rows to the history in `folder`, if it lacks any; `solve_s` is a median.

        Each says what made it, which need not be what resumed the sweep.
        """
        if all(run is not None and has(folder, run) for run in self.runs):
            return
        models, timings = self._sweep.models, self.timings.values()
        usual = ", ".join(str(timing.usual or "NULL") for timing in timings)
        count = self._sweep.count
        own = {
            "case": constant(SWEEP),
            "settings": one_of([settings(model, count) for model in models], "enum_code(model)"),
            "solve_s": f"[{usual}][enum_code(model) + 1]",
        }
        for name, values in zip(provenance(), zip(*self.made, strict=True), strict=True):
            own[name] = one_of(values, "made")
        shown = ", ".join(f"{sql} AS {named(name)}" for name, sql in own.items())
        base = self._table.base
        base.execute(f"CREATE TEMP VIEW records AS SELECT *, {shown} FROM {TABLE}")
        time = datetime.now(UTC)
        run = name_of(time)
        self._journal.goes_to(
            run,
            (
                job
                for model in self._sweep.models
                for start, stop in self._sweep.blocks()
                for job, _ in self._sweep.answers(self._journal, model, start, stop)
            ),
        )
        append_table(folder, base, "records", command, time, run)

    def first_table(self) -> Table:
        """Return the frequencies of the first few poses; the file has all of them."""
        where = ", ".join(self._where)
        found = self._table.base.execute(
            f"""SELECT pose, {where}, model::VARCHAR,
            list(frequency_hz ORDER BY mode) FROM {TABLE} WHERE pose <= {FEW}
            GROUP BY pose, {where}, model ORDER BY pose, model"""
        ).fetchall()
        rows = tuple(
            (
                int(pose), *cells(dict(zip(self._where, at, strict=True)), self._where), model,
                *("-" if f is None else Number(f) for f in frequencies),
            )
            for pose, *at, model, frequencies in found
        )  # fmt: skip
        names = "Pose", *headings(self._where), "Model", *(f"f{i} [Hz]" for i in self._pick + 1)
        poses = len(self._sweep.poses)
        title = f"Frequencies of the first {min(FEW, poses)} of {poses} poses"
        return Table(title, names, rows)

    def timing_table(self) -> Table:
        """What each model itself took, over all runs into this folder."""
        rows: list[tuple[Cell, ...]] = []
        for model, timing in self.timings.items():
            usual = "-" if timing.usual is None else Number(1e3 * timing.usual, 4)
            rows.append((label(model), timing.poses, Number(timing.seconds, 2), usual))
        notes = (
            "ms a pose: the median; seconds: all, with what each process loads for its first job",
        )
        return Table("Time", ("Model", "Poses", "Seconds", "ms a pose"), tuple(rows), notes)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._table.__exit__(*error)
