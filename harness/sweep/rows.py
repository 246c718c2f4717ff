"""The rows of a sweep: one a pose, model and mode, made from the finished jobs."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.model import Model
from harness.bench import label
from harness.history.duck import constant, named, quoted
from harness.history.store import append_table
from harness.rows import SWEEP, mechanism_hash, settings
from harness.sweep.jobs import Answer, Job
from harness.sweep.journal import Journal
from harness.sweep.long_table import TABLE, LongTable
from harness.sweep.sweep import Finished, Sweep, Timing, answers

ROWS = {
    "pose": "BIGINT",
    "z_m": "DOUBLE",
    "azimuth_rad": "DOUBLE",
    "tilt_rad": "DOUBLE",
    "mechanism": "VARCHAR",
    "model": "VARCHAR",
    "theory": "VARCHAR",
    "version": "VARCHAR",
    "mode": "BIGINT",
    "frequency_hz": "DOUBLE",
    "uncertainty_hz": "DOUBLE",
    "closure_m": "DOUBLE",
    "dofs": "BIGINT",
}
BY_MODE = ("frequency_hz", "uncertainty_hz")
Floats = NDArray[np.float64]


def rows_table(sweep: Sweep, file: Path, modes: Sequence[int]) -> LongTable:
    """Return the table of the rows of `file`, still empty."""
    labels = ", ".join(quoted(label(model)) for model in sweep.models)
    return LongTable(file, ROWS | {"model": f"ENUM({labels})"}, BY_MODE, modes)


def fill(
    sweep: Sweep, journal: Journal, finished: Finished, modes: Sequence[int], table: LongTable
) -> None:
    """Add one row a pose, model and mode as blocks of poses are finished; then write the file."""
    mechanism = mechanism_hash(sweep.mechanism)
    for model in sweep.models:
        for start, stop in sweep.blocks():
            finished.wait(model, start)
            found = list(answers(sweep, journal, model, start, stop))
            if found:
                same = {"mechanism": mechanism, "model": label(model)}
                table.add(_block(found, np.array(modes) - 1) | same)
    table.write()


def keep(
    sweep: Sweep, timings: Mapping[Model, Timing], table: LongTable, folder: Path, command: str
) -> None:
    """Append the rows to the history in `folder`; `solve_s` is a median."""
    one = len(sweep.models) == 1
    parts = []
    for model in sweep.models:
        timing = timings[model]
        same = {  # what is the same in all rows of a model need not be read
            "case": SWEEP,
            "mechanism": mechanism_hash(sweep.mechanism),
            "model": label(model),
            "settings": settings(model, sweep.count),
            "theory": timing.theories,
            "version": timing.versions,
        }
        texts = {k: min(v) if isinstance(v, frozenset) and len(v) == 1 else v
                 for k, v in same.items()}  # fmt: skip
        found = {
            name: "NULL" if value is None else constant(value)
            for name, value in texts.items()
            if not isinstance(value, frozenset)
        }
        own = [name for name in ROWS if name not in found]
        found["solve_s"] = str(timing.usual or "NULL")
        columns = [*own, *(f"{value} AS {named(name)}" for name, value in found.items())]
        only = "" if one else f" WHERE model = {quoted(label(model))}"
        parts.append(f"SELECT {', '.join(columns)} FROM {TABLE}{only}")
    table.base.execute(f"CREATE VIEW records AS {' UNION ALL BY NAME '.join(parts)}")
    append_table(folder, table.base, "records", command)


def _block(found: list[tuple[Job, Answer]], modes: NDArray[np.int64]) -> dict[str, Any]:
    """Return some jobs' answers as columns, a row a pose."""
    jobs, got = zip(*found, strict=True)
    sizes = [len(job.poses) for job in jobs]

    def each(values: list[Any]) -> Any:
        """Return a value of every job for its poses: one for all where all are the same."""
        if len(set(values)) == 1:
            return values[0]
        if any(isinstance(value, str) for value in values):
            return np.repeat(np.array(values, dtype=object), sizes)
        return np.repeat(np.array(values, dtype=float), sizes)  # None is not a number

    uncertainty = [
        np.full(a.frequencies.shape, np.nan) if a.uncertainty is None else a.uncertainty
        for a in got
    ]
    numbers = [job.start + 1 + np.arange(len(job.poses)) for job in jobs]
    return {
        "pose": np.concatenate(numbers),
        "z_m": np.concatenate([job.poses.z for job in jobs]),
        "azimuth_rad": np.concatenate([job.poses.azimuth for job in jobs]),
        "tilt_rad": np.concatenate([job.poses.tilt for job in jobs]),
        "theory": each([a.theory for a in got]),
        "version": each([a.version for a in got]),
        "closure_m": each([a.closure for a in got]),
        "dofs": each([a.dofs or None for a in got]),
        "frequency_hz": np.concatenate([a.frequencies[:, modes] for a in got]),
        "uncertainty_hz": np.concatenate([u[:, modes] for u in uncertainty]),
    }
