"""The file of a run: its columns, its name, and whether it is what was written."""

import os
import re
from dataclasses import dataclass
from hashlib import file_digest
from pathlib import Path

import polars as pl

COLUMNS = {
    "run": "VARCHAR",
    "time": "TIMESTAMP",
    "command": "VARCHAR",
    "commit": "VARCHAR",
    "release": "VARCHAR",
    "machine": "VARCHAR",
    "python": "VARCHAR",
    "numpy": "VARCHAR",
    "scipy": "VARCHAR",
    "blas": "VARCHAR",
    "case": "VARCHAR",
    "mechanism": "VARCHAR",
    "z_m": "DOUBLE",
    "azimuth_rad": "DOUBLE",
    "tilt_rad": "DOUBLE",
    "model": "VARCHAR",
    "theory": "VARCHAR",
    "settings": "VARCHAR",
    "version": "VARCHAR",
    "mode": "BIGINT",
    "frequency_hz": "DOUBLE",
    "uncertainty_hz": "DOUBLE",
    "assurance": "DOUBLE",
    "closure_m": "DOUBLE",
    "dofs": "BIGINT",
    "build_s": "DOUBLE",
    "solve_s": "DOUBLE",
}
"""Every column and its type; `time` is UTC. What files of an older release lack is null."""
NEEDED = ("run", "time", "model", "mode", "frequency_hz")
_TYPES: dict[str, pl.DataType] = {
    "VARCHAR": pl.String(),
    "DOUBLE": pl.Float64(),
    "BIGINT": pl.Int64(),
    "TIMESTAMP": pl.Datetime("us"),
}
SCHEMA = {name: _TYPES[kind] for name, kind in COLUMNS.items()}
NAME = re.compile(r"\d{8}-\d{6}\.\d{6}-[0-9a-f]{6}\.([0-9a-f]{16})\.parquet")


class FlawError(Exception):
    """Why a file is not part of the history."""


@dataclass(frozen=True)
class RunFile:
    """A sound file: which of `COLUMNS` it has, and what the system said of it when it was read."""

    path: Path
    columns: frozenset[str]
    stat: os.stat_result

    def changed(self) -> str | None:
        """Return what has happened to the file since, or None."""
        try:
            now = self.path.stat()
        except OSError as error:
            return f"{self.path.name} cannot be read any more: {error.strerror}"
        same = all(
            getattr(now, name) == getattr(self.stat, name)
            for name in ("st_size", "st_mtime_ns", "st_ino")
        )
        return None if same else f"{self.path.name} was changed"


def read(path: Path) -> RunFile:
    """Return the file if it is whole and of this bench; raises `FlawError` with the reason."""
    named = NAME.fullmatch(path.name)
    if named is None:
        raise FlawError("not written by rps-bench: its name is not RUN.CHECKSUM.parquet")
    try:
        stat = path.stat()
        if checksum(path) != named[1]:
            size = stat.st_size
            raise FlawError(f"damaged: {size} bytes that are not those that were written")
        with path.open("rb") as file:  # its name may look like a pattern
            schema = pl.read_parquet_schema(file)
    except OSError as error:
        raise FlawError(f"cannot be read ({error.strerror})") from None
    except pl.exceptions.PolarsError:
        raise FlawError("not written by rps-bench: it is no Parquet file") from None
    for name in NEEDED:
        if name not in schema:
            raise FlawError(f"of another release: it has no column {name}")
    for name, kind in SCHEMA.items():
        # A text may be written as a category: in Parquet the two are one type.
        if name in schema and schema[name] not in (kind, pl.Categorical):
            raise FlawError(f"of another release: its column {name} is {schema[name]}, not {kind}")
    return RunFile(path, frozenset(schema) & frozenset(SCHEMA), stat)


def checksum(path: Path) -> str:
    """Return the start of a file's SHA-256, which its name holds."""
    with path.open("rb") as file:
        return file_digest(file, "sha256").hexdigest()[:16]
