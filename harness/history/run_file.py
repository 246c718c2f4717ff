"""The file of a run: its columns, its name, and whether it is what was written."""

import os
import re
from collections.abc import Sequence
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
        same = all(
            getattr(now, name) == getattr(self.stat, name)
            for name in ("st_size", "st_mtime_ns", "st_ino")
        )
        return None if same else f"{self.path.name} was changed"


def sound_files(
    base: "DuckDBPyConnection", paths: Sequence[Path]
) -> tuple[list[RunFile], list[tuple[Path, str]]]:
    """Return the files that are whole and of this bench, and the others with what is wrong."""
    whole: dict[Path, os.stat_result] = {}
    flaws: dict[Path, str] = {}
    for path in paths:
        found = _stat(path)
        if isinstance(found, str):
            flaws[path] = found
        else:
            whole[path] = found
    sound = []
    for path, types in _types(base, list(whole)).items():
        flaw = _flaw(types)
        if flaw:
            flaws[path] = flaw
        else:
            sound.append(RunFile(path, frozenset(types) & frozenset(COLUMNS), whole[path]))
    return sound, [(path, flaws[path]) for path in paths if path in flaws]


def _stat(path: Path) -> os.stat_result | str:
    """Return what the system says of a file that is as it was written, or what is wrong."""
    named = NAME.fullmatch(path.name)
    if named is None:
        return "not written by rps-bench: its name is not RUN.CHECKSUM.parquet"
    try:
        found = path.stat()
        if not S_ISREG(found.st_mode):  # a pipe or a device would never end
            return "not written by rps-bench: it is no regular file"
        if checksum(path) != named[1]:
            return f"damaged: {found.st_size} bytes that are not those that were written"
    except OSError as error:
        return f"cannot be read ({error.strerror})"
    return found


def _types(base: "DuckDBPyConnection", paths: list[Path]) -> dict[Path, dict[str, str] | str]:
    """Return the types of the columns of all files by name, or what is wrong with a file."""
    import duckdb

    asked = (
        "SELECT file_name, name, duckdb_type FROM parquet_schema($paths) "
        "WHERE duckdb_type IS NOT NULL"
    )
    names = {str(path): path for path in paths}
    found: dict[Path, dict[str, str] | str] = {path: {} for path in paths}
    if not paths:
        return found
    try:
        rows = base.execute(asked, {"paths": list(map(escape, names))}).fetchall()
    except duckdb.Error as error:
        if len(paths) > 1:  # one of them is the reason
            return {k: v for path in paths for k, v in _types(base, [path]).items()}
        return {paths[0]: f"not written by rps-bench: it is no Parquet file ({reason(error)})"}
    for name, column, kind in rows:
        types = found[names[name]]
        assert isinstance(types, dict)
        types[column] = kind
    return found


def _flaw(types: dict[str, str] | str) -> str:
    """Return what is wrong with a file's columns; "" if nothing."""
    if isinstance(types, str):
        return types
    for name in NEEDED:
        if name not in types:
            return f"of another release: it has no column {name}"
    for name, kind in COLUMNS.items():
        if types.get(name, kind) != kind:
            return f"of another release: its column {name} is {types[name]}, not {kind}"
    return ""


def checksum(path: Path) -> str:
    """Return the start of a file's SHA-256, which its name holds."""
    with path.open("rb") as file:
        return file_digest(file, "sha256").hexdigest()[:16]
