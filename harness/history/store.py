"""The history of all runs: one Parquet file a run, asked by DuckDB; no server.

A file is named RUN.CHECKSUM.parquet and never changes: whatever does not match its own checksum is
damaged or foreign, and skipped. (Parquet itself notices less than half of all flipped bits.)
"""

import os
import re
import secrets
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from glob import escape
from hashlib import file_digest
from pathlib import Path
from stat import S_ISREG
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from analytic import InputError
from harness.history.duck import Params, connect, constant, listed, named, quoted, reason, sink
from harness.history.provenance import provenance
from harness.output import staged

if TYPE_CHECKING:
    import pandas as pd
    from duckdb import DuckDBPyConnection, DuckDBPyRelation

COLUMNS = {
    name: kind
    for kind, names in (
        ("VARCHAR", "run"),
        ("TIMESTAMP", "time"),
        ("VARCHAR", "command commit release machine python numpy scipy blas case mechanism"),
        ("DOUBLE", "z_m azimuth_rad tilt_rad torsion_rad x_m y_m"),
        ("VARCHAR", "model theory settings version"),
        ("BIGINT", "mode"),
        ("DOUBLE", "frequency_hz uncertainty_hz assurance closure_m"),
        ("BIGINT", "dofs"),
        ("DOUBLE", "build_s solve_s"),
    )
    for name in names.split()
}
"""Every column and its type; `time` is UTC. What files of an older release lack is null."""
NEEDED = ("run", "time", "model", "mode", "frequency_hz")
NAME = re.compile(r"\d{8}-\d{6}\.\d{6}-[0-9a-f]{6}\.([0-9a-f]{16})\.parquet")
_PLAINER = {
    "HUGEINT$": "BIGINT",
    "^TIMESTAMP WITH TIME ZONE$": "TIMESTAMP",
    "INTERVAL|UNION|BIT": "VARCHAR",
}
"""Types that pandas or Parquet has not, or shows worse, and what stands for them."""


def append(
    folder: Path, rows: Sequence[Mapping[str, Any]], command: str, time: datetime | None = None
) -> Path:
    """Write the rows of one run as a file of its own and return it; safe in many processes at once.

    `rows` have any of `COLUMNS`. A value they give themselves (a commit, a machine; also None) wins
    over this process's. `time` is now unless given. A number that is not finite is kept as null.
    Raises `OutputError` where the folder cannot be written.
    """
    names = {name for row in rows for name in row} & set(COLUMNS) or {"mode"}
    own = provenance() | {"command": command}
    given = {
        name: np.array([row.get(name, own.get(name)) for row in rows], dtype=object)
        for name in names
    }
    with connect() as base:
        base.register("given", given)
        return append_table(folder, base, "given", command, time)


def append_table(
    folder: Path,
    base: "DuckDBPyConnection",
    table: str,
    command: str,
    time: datetime | None = None,
    listener: Callable[[str], None] = lambda _: None,
) -> Path:
    """Do as `append` with all rows of a table of `base`, which are never in memory as a whole.

    The `listener` hears the name of the run before its file is there.
    """
    # Without a zone: all times are UTC.
    time = (time or datetime.now(UTC)).astimezone(UTC).replace(tzinfo=None)
    run = f"{time:%Y%m%d-%H%M%S.%f}-{secrets.token_hex(3)}"
    listener(run)
    known = {**provenance(), "command": command, "run": run, "time": time}
    kinds = {row[0]: row[1] for row in base.execute(f"DESCRIBE {table}").fetchall()}
    given = {name: kind for name, kind in kinds.items() if name not in ("run", "time")}
    columns = []
    for name, kind in COLUMNS.items():
        if name in given:
            value = named(name)
        elif kind == "VARCHAR" and name in known:
            value = constant(known[name])
        else:
            value = quoted(known[name]) if name in known else "NULL"
        if not value.startswith("CAST") and not given.get(name, "").startswith("ENUM"):
            value = f"CAST({value} AS {kind})"
        if kind == "DOUBLE":
            value = f"CASE WHEN isfinite({value}) THEN {value} END"
        columns.append(f"{value} AS {named(name)}")
    with staged(folder, [run], "history") as (temporary,):
        sink(base, f"SELECT {', '.join(columns)} FROM {table}", temporary, ".parquet")
        path = folder / f"{run}.{checksum(temporary)}.parquet"
        temporary.replace(path)
    return path


def checksum(path: Path) -> str:
    """Return the start of a file's SHA-256, which its name holds."""
    with path.open("rb") as file:
        return file_digest(file, "sha256").hexdigest()[:16]


class RunFile(NamedTuple):
    """Of a sound file which of `COLUMNS` it has, and how it was when it was read."""

    columns: frozenset[str]
    state: tuple[int, int, int]


def _state(found: os.stat_result) -> tuple[int, int, int]:
    return found.st_size, found.st_mtime_ns, found.st_ino


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
    for name, kind in COLUMNS.items():
        if name in NEEDED and name not in types:
            return f"of another release: it has no column {name}"
        if types.get(name, kind) != kind:
            return f"of another release: its column {name} is {types[name]}, not {kind}"
    return RunFile(frozenset(types) & frozenset(COLUMNS), _state(found))


@dataclass(frozen=True)
class Answer:
    """The answer to one SELECT over the history; it is worked out anew each time it is read."""

    history: "History"
    sql: str
    params: Params
    columns: tuple[str, ...] = ()

    def __len__(self) -> int:
        with self.history.asked(self) as (_, answer):
            return len(answer)

    def rows(self, most: int | None = None) -> list[dict[str, Any]]:
        """Return the rows by the names of their columns, the first `most` of them."""
        with self.history.asked(self) as (_, answer):
            some = answer if most is None else answer.limit(most)
            return [dict(zip(self.columns, row, strict=True)) for row in some.fetchall()]

    def to_frame(self) -> "pd.DataFrame":
        """Return the rows as a pandas frame."""
        with self.history.asked(self) as (_, answer):
            frame: pd.DataFrame = answer.df()
            return frame

    def write(self, path: Path) -> int:
        """Write the rows to `path`, by its ending .csv, .parquet or .json; return their number.

        They are in memory a piece after the other. Raises `InputError` for columns that the form
        cannot hold, and `OutputError` where the file cannot be written.
        """
        with (
            staged(path.parent, [path.name], "export") as (temporary,),
            self.history.asked(self, temporary) as (base, answer),
        ):
            kinds = " ".join(map(str, answer.types))
            if path.suffix != ".parquet" and "BLOB" in kinds:
                raise InputError("export", str(path), "another form (only Parquet holds bytes)")
            if path.suffix == ".csv" and re.search(r"\]|STRUCT|MAP|UNION", kinds):
                raise InputError("export", str(path), "another form (CSV has no lists)")
            sql = self.sql.strip().rstrip(";")
            height = sink(base, sql, temporary, path.suffix, self.params)
            temporary.replace(path)
        return height

    def _repr_html_(self) -> str:
        return str(self.to_frame().to_html(index=False))


class History:
    """All sound runs of a folder as one table `rows`, as it was when opened.

    The rows stay in their files, of which a query reads the columns it asks for; without ORDER BY
    they come in the order of time. Attributes: `skipped`, the files left out and why.
    """

    def __init__(self, folder: Path) -> None:
        if folder.exists() and not folder.is_dir():
            raise InputError("history", str(folder), "a folder")
        self._folder = folder
        with connect() as base:
            found = {path: read(base, path) for path in sorted(folder.glob("*.parquet"))}
        self._files = {path: file for path, file in found.items() if isinstance(file, RunFile)}
        self.skipped = [(path, why) for path, why in found.items() if isinstance(why, str)]
        self._base: DuckDBPyConnection | None = None

    def query(self, sql: str, params: Params = None) -> Answer:
        """Return the answer to one SELECT over `rows`; it can change nothing and read no file.

        `params` fill `?`, `$1` or `$name`. Raises `InputError` for anything but one good SELECT.
        """
        answer = Answer(self, sql, params)
        with self.asked(answer) as (_, found):
            return replace(answer, columns=tuple(found.columns))

    @contextmanager
    def asked(
        self, question: Answer, target: Path | None = None
    ) -> "Iterator[tuple[DuckDBPyConnection, DuckDBPyRelation]]":
        """Yield where a question is asked and its answer, not read yet; say whatever fails then.

        `target`: a file that may be written.
        """
        import duckdb

        expected = "one SELECT over the table rows"
        self._stays()
        base = self._base if target is None and self._base else self._open(target)
        self._base = self._base or base
        try:
            statements = base.extract_statements(question.sql)
            if [s.type for s in statements] != [duckdb.StatementType.SELECT]:
                raise InputError("sql", question.sql, expected)
            answer = base.sql(question.sql, params=question.params)
            if len(set(answer.columns)) < len(answer.columns):
                raise InputError("sql", question.sql, f"{expected}, of columns of different names")
            casts = [
                f"CAST({named(name)} AS {plain}) AS {named(name)}"
                for name, kind in zip(answer.columns, map(str, answer.types), strict=True)
                for pattern, plain in _PLAINER.items()
                if re.search(pattern, kind)
            ]
            yield base, answer.project(f"* REPLACE ({', '.join(casts)})" if casts else "*")
        except duckdb.Error as error:
            self._stays()
            raise InputError("sql", question.sql, f"{expected} ({reason(error)})") from None
        self._stays()

    def _open(self, target: Path | None) -> "DuckDBPyConnection":
        """Return a connection that can read the files of the history, and no other."""
        import duckdb

        base = connect(streams=target is not None)
        kinds = {file.columns for file in self._files.values()}
        columns = ", ".join(
            named(name) if any(name in some for some in kinds) else f"NULL::{kind} AS {named(name)}"
            for name, kind in COLUMNS.items()
        )
        # A name with a pattern's letters is looked up as a pattern, and read as it is.
        paths = [str(path) for path in self._files]
        sought = [escape(path) for path in paths]
        # Where all have the same columns the first one tells them.
        source = f"read_parquet([{listed(sought)}], union_by_name = {len(kinds) > 1})"
        source = f"FROM {source}" if paths else "LIMIT 0"
        try:
            base.execute(f"CREATE VIEW rows AS SELECT {columns} {source}")
        except duckdb.Error as error:
            raise self._changed(reason(error)) from None
        allowed = sorted({*paths, *sought, *([str(target)] if target else [])})
        base.execute(f"SET allowed_paths = [{listed(allowed)}]")
        base.execute("SET enable_external_access = false")
        base.execute("SET lock_configuration = true")
        return base

    def _stays(self) -> None:
        for path, file in self._files.items():
            try:
                if _state(path.stat()) != file.state:
                    raise self._changed(f"{path.name} was changed")
            except OSError as error:
                why = f"{path.name} cannot be read any more: {error.strerror}"
                raise self._changed(why) from None

    def _changed(self, why: str) -> InputError:
        return InputError("history", str(self._folder), f"files that stay while read ({why})")


def open_history(folder: Path) -> History:
    """Return the history in `folder`; one that is not there yet is empty."""
    return History(folder)
