"""A sweep from poses and models to files: solved, written meanwhile, compared, kept."""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from analytic import Mechanism, Pose
from analytic.model import Model
from harness import threads
from harness.cases import select
from harness.history.duck import connect, quoted
from harness.output import write_all
from harness.result import Result
from harness.sweep.engine import Patience, engine
from harness.sweep.error_map import compare
from harness.sweep.jobs import Job, Journal
from harness.sweep.pose_sets import pose_set
from harness.sweep.sweep import Failures, Rows, Sweep, complete, failure_table
from harness.tables import Table, table_files
from harness.text import models as models_of
from reference_models import parse

if TYPE_CHECKING:
    import pandas as pd

ONE_CORE_EACH = Patience()
OWN = re.compile(
    r"(frequencies|error-map)\.(parquet|csv|json)|(timing|errors|worst|failures)\.(csv|md|tex)"
)
"""Names of the files that a sweep writes."""


@dataclass(frozen=True)
class Swept(Result):
    """What came of a sweep.

    Attributes: `file` of the rows and the other `files`; `made`, the tables by name; `lacking`,
    numbers of the poses without an answer by model and reason; `solved`, how many jobs were not
    found in the folder.
    """

    file: Path
    files: tuple[Path, ...]
    made: Mapping[str, Table]
    lacking: Failures
    solved: int

    def to_frame(self) -> "pd.DataFrame":
        """Return the rows, one a pose, model and mode: SI, units in the names of the columns."""
        with connect() as base:
            frame: pd.DataFrame = base.execute(f"FROM {quoted(self.file)}").df()
        return frame

    def tables(self) -> Mapping[str, Table]:
        """Return timing, errors, worst poses and failures."""
        return self.made

    def failures(self) -> dict[str, str]:
        """Return what has no answer ("MODEL at N poses"), and why."""
        return {f"{name} at {len(n)} poses": why for (name, why), n in self.lacking.items()}


def solve(
    mechanism: Mechanism | str,
    poses: Pose | str,
    models: Iterable[Model] | str,
    folder: Path | str,
    count: int = 6,
    *,
    against: Model | str | None = None,
    cores: int | None = None,
    scheduler: str | None = None,
    patience: Patience = ONE_CORE_EACH,
) -> Swept:
    """Solve `poses` (arrays) by `models` into `folder`; what is there already is not solved again.

    Texts mean what they mean on the command line: a case's name for its mechanism, "random:7:1",
    "exudyn-cable@8,rayleigh@exact".
    `against`: one of the models, or one more, that the others are compared with. Jobs run on
    `cores`, by default all, or on the Dask cluster of a `scheduler`. Raises `OutputError` where the
    folder cannot be written.
    """
    if isinstance(mechanism, str):
        mechanism = select([mechanism], {})[0].mechanism
    if isinstance(poses, str):
        poses = pose_set(poses, mechanism)
    if isinstance(models, str):
        models = models_of(models, "models")
    if isinstance(against, str):
        against = parse(against, "against")
    folder = Path(folder)
    everything = tuple(dict.fromkeys([*models, *([] if against is None else [against])]))
    with (
        engine(cores or threads.cores(), scheduler, patience) as here,
        Journal(folder) as journal,
    ):
        sweep = Sweep(mechanism, poses, everything, count, journal, here)
        return carry_out(sweep, folder / "frequencies.parquet", range(1, count + 1), against)


def carry_out(
    sweep: Sweep,
    file: Path,
    modes: Sequence[int],
    against: Model | None = None,
    *,
    listener: Callable[[Job], None] = lambda _: None,
    again: str = "",
    history: tuple[Path, str] | None = None,
) -> Swept:
    """Run what is not in the journal and write one row a pose, model and mode into `file`.

    Errors and tables go beside it; the ending .parquet, .csv or .json is that of all rows. The
    `listener` hears of each finished job; `again`: options of a command that shows a worst pose;
    `history`: where the rows are kept, unless one has them all, and as which command. Files that
    an earlier sweep left in the folder and this one does not write are removed.
    Raises `OutputError` where a file cannot be written.
    """
    with Rows(sweep, file, modes) as rows:

        def tell(job: Job) -> None:
            listener(job)
            rows.tell(job)

        failures, solved = complete(sweep, tell)
        rows.finish()
        made, files = {"timing": rows.timing_table()}, [file]
        if against is not None:
            files.append(file.with_name(f"error-map{file.suffix}"))
            made |= compare(sweep, against, modes, files[-1], again)
        made["failures"] = failure_table(failures)
        files += write_all(file.parent, table_files(made))
        made = {"first": rows.first_table(), **made}  # shown only: the file has all of it
        for path in file.parent.iterdir():
            if OWN.fullmatch(path.name) and path not in files:  # an earlier sweep's
                path.unlink()
        if history is not None:
            rows.keep(*history)
    return Swept(file, tuple(files), made, failures, solved)
