"""The file of a run: its columns, its name, and whether it is what was written."""

import os
import re
from dataclasses import dataclass
from glob import escape
from hashlib import file_digest
from pathlib import Path
from stat import S_ISREG
from typing import TYPE_CHECKING

from harness.history.duck import reason

if TYPE_CHECKING:
    from duckdb import DuckDBPyConnection

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
    "torsion_rad": "DOUBLE",
    "x_m": "DOUBLE",
    "y_m": "DOUBLE",
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
NAME = re.compile(r"\d{8}-\d{6}\.\d{6}-[0-9a-f]{6}\.([0-9a-f]{16})\.parquet")


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
        was = self.stat
        same = (now.st_size, now.st_mtime_ns, now.st_ino) == (
            was.st_size, was.st_mtime_ns, was.st_ino,
        )  # fmt: skip
        return None if same else f"{self.path.name} was changed"


def read(base: "DuckDBPyConnection", path: Path) -> RunFile | str:
    """Return a file that is whole and of this bench, or what is wrong with it."""
    import duckdb

    matched = NAME.fullmatch(path.name)
    if matched is None:
        return "not written by rps-bench: its name is not RUN.CHECKSUM.parquet"
    try:
        found = path.stat()
        if not S_ISREG(found.st_mode):  # a pipe or a device would never end
            return "not written by rps-bench: it is no regular file"
        if checksum(path) != matched[1]:
            return f"damaged: {found.st_size} bytes that are not those that were written"
    except OSError as error:
        return f"cannot be read ({error.strerror})"
    asked = "SELECT name, duckdb_type FROM parquet_schema(?) WHERE duckdb_type IS NOT NULL"
    try:
        types = dict(base.execute(asked, [escape(str(path))]).fetchall())
    except duckdb.Error as error:
        return f"not written by rps-bench: it is no Parquet file ({reason(error)})"
    for name in NEEDED:
        if name not in types:
            return f"of another release: it has no column {name}"
    for name, kind in COLUMNS.items():
        if types.get(name, kind) != kind:
            return f"of another release: its column {name} is {types[name]}, not {kind}"
    return RunFile(path, frozenset(types) & frozenset(COLUMNS), found)


def checksum(path: Path) -> str:
    """Return the start of a file's SHA-256, which its name holds."""
    with path.open("rb") as file:
        return file_digest(file, "sha256").hexdigest()[:16]
