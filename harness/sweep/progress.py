"""A bar for each model of a sweep, with its rate and time left, on a terminal's error stream."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from harness.sweep.jobs import Job
from harness.sweep.sweep import Sweep

Tell = Callable[[Job], None]


@contextmanager
def progress(sweep: Sweep) -> Iterator[Tell]:
    """Yield what to tell of each finished job."""
    if not sys.stderr.isatty():
        yield lambda job: None
        return
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        ProgressColumn,
        Task,
        TextColumn,
        TimeRemainingColumn,
    )
    from rich.text import Text

    class Rate(ProgressColumn):
        """Poses a second."""

        def render(self, task: Task) -> Text:
            speed = task.finished_speed or task.speed
            return Text("" if speed is None else f"{speed:,.1f} poses/s")

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        Rate(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        tasks = {
            spec: bar.add_task(spec.label, total=len(sweep.poses), start=False)
            for spec in sweep.specs
        }

        def tell(job: Job) -> None:
            bar.start_task(tasks[job.spec])
            bar.update(tasks[job.spec], advance=len(job.poses))

        yield tell
