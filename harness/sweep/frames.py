"""Long tables on disk: written frame by frame, there whole or not at all."""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path

import polars as pl
from polars.datatypes import DataTypeClass
from polars.io.plugins import register_io_source

from harness.files import OutputError
from harness.frames import sink


def write_frames(
    folder: Path, name: str, frames: Iterator[pl.DataFrame], schema: Mapping[str, DataTypeClass]
) -> Path:
    """Write `frames` as NAME.parquet or NAME.csv, by the suffix of `name`; the same bytes for the
    same rows, in memory for one frame after the other. One writer at a time for a `name`.

    Raises `OutputError` with the reason, leaving what was there before.
    """
    target = folder / name
    broken: list[OutputError] = []

    def source(
        columns: list[str] | None, where: pl.Expr | None, most: int | None, size: int | None
    ) -> Iterator[pl.DataFrame]:
        try:
            yield from frames
        except OutputError as error:  # polars would wrap it
            broken.append(error)
            raise

    # Always the same name: what a killed process left behind is overwritten, not kept.
    temporary = folder / f".{name}.part"
    try:
        sink(register_io_source(source, schema=dict(schema)), temporary, target.suffix)
        temporary.replace(target)
    except (OSError, pl.exceptions.PolarsError) as error:
        if broken:
            raise broken[0] from None
        reason = getattr(error, "strerror", None) or str(error).splitlines()[0]
        raise OutputError(f"--output = {str(folder)!r}: cannot write there ({reason})") from None
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)
    return target
