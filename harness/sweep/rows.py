"""The rows of a sweep: one a pose, model and mode, made from the finished jobs."""

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import polars as pl
from numpy.typing import NDArray

from harness.models import Spec
from harness.run import SWEEP, mechanism_hash, settings
from harness.sweep.frames import write_frames
from harness.sweep.jobs import Answer, Job, version_of
from harness.sweep.journal import Journal
from harness.sweep.sweep import Finished, Sweep, Timing, answers

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


def export(
    sweep: Sweep,
    journal: Journal,
    finished: Finished,
    modes: list[int],
    file: Path,
) -> None:
    """Write one row a pose, model and mode into `file` as blocks of poses are finished.

    SI units; flat in memory.
    """
    mechanism = mechanism_hash(sweep.mechanism)

    def frames() -> Iterator[pl.DataFrame]:
        for spec in sweep.specs:
            for start, stop in sweep.blocks():
                finished.wait(spec, start)
                found = list(answers(sweep, journal, spec, start, stop))
                if found:
                    yield _frame(spec, mechanism, found, np.array(modes))

    write_frames(file.parent, file.name, frames(), ROWS)


def records(sweep: Sweep, timings: Mapping[Spec, Timing], file: Path) -> pl.LazyFrame:
    """Return what `export` wrote into `file` as rows of the history; `solve_s` is a median."""
    whole = (
        pl.scan_parquet(file, glob=False)
        if file.suffix == ".parquet"
        else pl.scan_csv(file, schema=ROWS, glob=False)
    )
    return pl.concat(_record(sweep, spec, timings[spec], whole) for spec in sweep.specs)


def _record(sweep: Sweep, spec: Spec, timing: Timing, whole: pl.LazyFrame) -> pl.LazyFrame:
    """Return the rows of one model; what is the same in all of them need not be read."""
    same = {
        "case": SWEEP,
        "mechanism": mechanism_hash(sweep.mechanism),
        "model": spec.label,
        "settings": settings(spec, sweep.count),
        "version": version_of(spec),
    }
    if len(timing.theories) == 1:
        (same["theory"],) = timing.theories
    rows = whole if len(sweep.specs) == 1 else whole.filter(model=spec.label)
    return rows.with_columns(
        pl.col("theory").cast(pl.Categorical),
        solve_s=pl.lit(timing.usual, dtype=pl.Float64),
    ).with_columns(pl.lit(text).cast(pl.Categorical).alias(name) for name, text in same.items())


def _frame(
    spec: Spec, mechanism: str, found: list[tuple[Job, Answer]], modes: NDArray[np.int64]
) -> pl.DataFrame:
    sizes = [len(job.poses) for job, _ in found]
    poses = [job.poses for job, _ in found]

    def by_mode(values: list[NDArray[np.float64] | None]) -> NDArray[np.float64]:
        filled = [
            np.full((n, len(modes)), np.nan) if value is None else value[:, modes - 1]
            for n, value in zip(sizes, values, strict=True)
        ]
        return np.concatenate(filled)

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
    of_pose = pl.DataFrame(
        {
            "pose": np.concatenate([job.start + 1 + np.arange(len(job.poses)) for job, _ in found]),
            "z_m": np.concatenate([p.z for p in poses]),
            "azimuth_rad": np.concatenate([p.azimuth for p in poses]),
            "tilt_rad": np.concatenate([p.tilt for p in poses]),
            "mode": np.tile(modes, (sum(sizes), 1)),
            "frequency_hz": by_mode([a.frequencies for _, a in found]),
            "uncertainty_hz": by_mode([a.uncertainty for _, a in found]),
        }
    )
    return (
        of_pose.hstack(of_job[np.repeat(np.arange(len(found)), sizes)])
        .explode("mode", "frequency_hz", "uncertainty_hz")
        .with_columns(pl.col("uncertainty_hz").fill_nan(None))
        .select(list(ROWS))
    )
