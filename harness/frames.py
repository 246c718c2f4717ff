"""Long tables on their way to disk, in memory for a piece after the other."""

import os
import re
from pathlib import Path

import polars as pl

ROW_GROUP = 100_000
_REASON = re.compile(r"\(os error (\d+)\)|\[Errno (\d+)\]")


def sink(table: pl.LazyFrame, path: Path, suffix: str) -> None:
    """Write `table` to `path` as .parquet, .csv or .json (a list), by `suffix`, and wait until it
    is on the disk.

    Raises `OSError` for what the system refused, which polars tells only in the text of an error.
    """
    # Opened here: polars would take some names for patterns or addresses.
    with path.open("wb") as file:
        try:
            match suffix:
                case ".parquet":
                    # DuckDB skips as fast without statistics, a third of a small file.
                    table.sink_parquet(file, row_group_size=ROW_GROUP, statistics=False)
                case ".csv":
                    table.sink_csv(file)
                case _:
                    batches = (batch for batch in table.collect_batches() if batch.height)
                    file.write(b"[")
                    for k, batch in enumerate(batches):
                        file.write(b",\n" if k else b"")
                        file.write(batch.write_json()[1:-1].encode())
                    file.write(b"]\n")
        except (OSError, pl.exceptions.PolarsError) as error:
            told = _REASON.search(str(error))
            if told is None:
                raise
            number = int(told[1] or told[2])
            raise OSError(number, os.strerror(number)) from None
        file.flush()
        os.fsync(file.fileno())
