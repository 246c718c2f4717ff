"""What a sweep would take: jobs, how many are done, and the time of the others."""

from time import perf_counter

from analytic.condensed import CHUNK
from analytic.model import Model
from harness.bench import label
from harness.sweep.engine import Engine, run
from harness.sweep.journal import Journal
from harness.sweep.sweep import Sweep
from harness.tables import Cell, Number, Table
from harness.workers import Failure


def estimate(sweep: Sweep, journal: Journal, engine: Engine) -> Table:
    """Return the jobs of each model and the time they will take, from that of one."""
    rows: list[tuple[Cell, ...]] = []
    together = 0.0
    for model in sweep.models:
        total, done, left = sweep.done(model, journal)
        each = _seconds_a_pose(sweep, model, engine)
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
