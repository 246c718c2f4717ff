"""Solves a sweep and writes its rows meanwhile."""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from harness.sweep.engine import Engine
from harness.sweep.jobs import Job
from harness.sweep.journal import Journal
from harness.sweep.sweep import Finished, Outcome, Sweep, complete


def solve(
    sweep: Sweep,
    journal: Journal,
    engine: Engine,
    file: Path,
    modes: Sequence[int] = (),
    listener: Callable[[Job], None] = lambda _: None,
) -> Outcome:
    """Run what is not in the journal and write one row a pose, model and mode into `file`.

    The ending of `file` is .parquet or .csv; `modes` are all unless given; the `listener` hears of
    each finished job. Raises `OutputError` where the file cannot be written.
    """
    finished = Finished(sweep)
    shown = list(modes) or list(range(1, sweep.count + 1))
    with ThreadPoolExecutor(1) as writer, finished:
        rows = writer.submit(_write, sweep, journal, finished, shown, file)
        outcome = complete(sweep, journal, engine, (listener, finished.tell))
    rows.result()
    return outcome


def _write(
    sweep: Sweep, journal: Journal, finished: Finished, modes: list[int], file: Path
) -> None:
    """Write the rows while models run; the libraries for that take as long to load as to use."""
    import rich.table  # noqa: F401
    import tabulate  # noqa: F401

    from harness.sweep.rows import export

    export(sweep, journal, finished, modes, file)
