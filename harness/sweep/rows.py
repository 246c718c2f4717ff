"""The rows of a sweep: one a pose, model and mode, made from the finished jobs."""

from collections import deque
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from analytic.model import Model
from harness.bench import label
from harness.history.duck import constant, one_of
from harness.history.provenance import provenance
from harness.history.store import append_table
from harness.poses import cells, columns, headings
from harness.rows import SWEEP, mechanism_hash, settings
from harness.sweep.jobs import BATCH, Answer, Job, Sweep
from harness.sweep.long_table import RECORDS, LongTable
from harness.tables import Number, Table

FEW = 3
"""Poses whose frequencies are shown when a sweep ends."""


class Rows(LongTable):
    """The rows on their way to `file`, added block by block while further jobs are solved.

    Texts are numbers in the base: `which` of the models, and which of all that answers have `told`
    of themselves, their theory, version and what made them.
    """

    def __init__(self, sweep: Sweep, file: Path) -> None:
        self._sweep = sweep
        self._told: dict[tuple[str, ...], int] = {}
        # What each model itself took over all runs into the folder: poses and seconds of each job.
        self._times = {model: (list[int](), list[float]()) for model in sweep.models}
        self._left = {
            (model, start): min(BATCH, len(sweep.poses) - start)
            for model in sweep.models
            for start in sweep.blocks
        }
        self._blocks = deque(self._left)
        super().__init__(
            file,
            ("pose", "which", "told", "dofs"),
            (*sweep.where, "closure_m"),
            ("frequency_hz", "uncertainty_hz"),
            sweep.modes,
        )

    def tell(self, job: Job) -> None:
        """Take in a finished job, with or without an answer; add blocks that are complete."""
        self._left[job.model, job.start // BATCH * BATCH] -= len(job.poses)
        while self._blocks and not self._left[self._blocks[0]]:
            model, start = self._blocks.popleft()
            if found := list(self._sweep.answers(model, start)):
                self._add(model, *zip(*found, strict=True))

    def _add(self, model: Model, jobs: Sequence[Job], answers: Sequence[Answer]) -> None:
        sweep, pick = self._sweep, np.array(self._sweep.modes) - 1
        sweep.journal.takes(jobs)
        sizes = [len(job.poses) for job in jobs]
        poses, seconds = self._times[model]
        poses += sizes
        seconds += [answer.seconds for answer in answers]
        about = []
        for a in answers:
            told = self._told.setdefault((a.theory, a.version, *a.made), len(self._told))
            about.append([told, a.dofs or None, a.closure])
        of_poses = np.repeat(np.array(about, dtype=float), sizes, axis=0)
        own = [a.frequencies * np.nan if a.uncertainty is None else a.uncertainty for a in answers]
        numbers = np.concatenate([job.start + np.arange(len(job.poses)) for job in jobs])
        self.add(
            columns(sweep.poses[numbers])
            | {"pose": numbers + 1, "which": sweep.models.index(model)}
            | dict(zip(("told", "dofs", "closure_m"), of_poses.T, strict=True))
            | {"frequency_hz": np.concatenate([a.frequencies for a in answers])[:, pick],
               "uncertainty_hz": np.concatenate(own)[:, pick]}
        )  # fmt: skip

    def finish(self) -> None:
        """Write the file when all blocks are there."""
        sweep = self._sweep
        usual = ", ".join(str(self._usual(model) or "NULL") for model in sweep.models)
        texts = {
            "mechanism": constant(mechanism_hash(sweep.mechanism)),
            "model": one_of([label(model) for model in sweep.models], "which"),
            "case": constant(SWEEP),
            "settings": one_of([settings(model, sweep.count) for model in sweep.models], "which"),
            "solve_s": f"[{usual}][which + 1]",
        }
        for k, name in enumerate(("theory", "version", *provenance())):
            texts[name] = one_of([said[k] for said in self._told], "told")
        names = ("pose", *sweep.where, "mechanism", "model", "theory", "version", "mode",
                 "frequency_hz", "uncertainty_hz", "closure_m", "dofs")  # fmt: skip
        self.write(names, texts)

    def keep(self, folder: Path, command: str) -> None:
        """Append the rows to the history in `folder`, if it lacks any; `solve_s` is a median.

        Each says what made it, which need not be what resumed the sweep.
        """
        journal = self._sweep.journal
        if not all(run and any(folder.glob(f"{run}.*.parquet")) for run in journal.runs()):
            append_table(folder, self.base, RECORDS, command, None, journal.goes_to)

    def _usual(self, model: Model) -> float | None:
        """Return the median over the model's jobs of the seconds a pose."""
        poses, seconds = self._times[model]
        return float(np.median(np.divide(seconds, poses))) if poses else None

    def first_table(self) -> Table:
        """Return the frequencies of the first few poses; the file has all of them."""
        where, modes = self._sweep.where, self._sweep.modes
        found = self.base.execute(f"FROM wide WHERE pose <= {FEW} ORDER BY pose, which")
        rows = []
        for values in found.fetchall():
            row = dict(zip(self.names, values, strict=True))
            f = [row[f"frequency_hz_{i}"] for i in modes]
            numbers = ["-" if value is None else Number(value) for value in f]
            model = label(self._sweep.models[row["which"]])
            rows.append((row["pose"], *cells(row, where), model, *numbers))
        names = "Pose", *headings(where), "Model", *(f"f{i} [Hz]" for i in modes)
        poses = len(self._sweep.poses)
        title = f"Frequencies of the first {min(FEW, poses)} of {poses} poses"
        return Table(title, names, tuple(rows))

    def timing_table(self) -> Table:
        """What each model itself took, over all runs into this folder."""
        rows = []
        for model, (poses, seconds) in self._times.items():
            usual = self._usual(model)
            ms = "-" if usual is None else Number(1e3 * usual, 4)
            rows.append((label(model), sum(poses), Number(sum(seconds), 2), ms))
        note = "ms a pose: the median; seconds: all, with what each process loads for its first job"
        return Table("Time", ("Model", "Poses", "Seconds", "ms a pose"), tuple(rows), (note,))
