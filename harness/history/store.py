"""The history of all runs: one Parquet file a run, asked by DuckDB; no server.

A file is named RUN.CHECKSUM.parquet and never changes: whatever does not match its own checksum is
damaged or foreign, and skipped. (Parquet itself notices less than half of all flipped bits.)
"""

import re
import secrets
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from glob import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from analytic import InputError
from harness.history.duck import Params, connect, constant, named, quoted, reason, sink
from harness.history.provenance import provenance
from harness.history.run_file import COLUMNS as COLUMNS
from harness.history.run_file import RunFile, checksum, read
from harness.output import staged

if TYPE_CHECKING:
    import pandas as pd
    from duckdb import DuckDBPyConnection, DuckDBPyRelation


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
    run: str | None = None,
) -> Path:
    """Do as `append` with all rows of a table of `base`, which are never in memory as a whole.

    `run`: its name, as `name_of` makes it, where that is known already.
    """
    # Without a zone: all times are UTC.
    time = (time or datetime.now(UTC)).astimezone(UTC).replace(tzinfo=None)
    run = run or name_of(time)
    known = {**provenance(), "command": command, "run": run, "time": time}
    given = {row[0]: row[1] for row in base.execute(f"DESCRIBE {table}").fetchall()}
    columns = ", ".join(_column(name, kind, given, known) for name, kind in COLUMNS.items())
    with staged(folder, [run], "history") as (temporary,):
        sink(base, f"SELECT {columns} FROM {table}", temporary, ".parquet")
        path = folder / f"{run}.{checksum(temporary)}.parquet"
        temporary.replace(path)
    return path


def name_of(time: datetime) -> str:
    """Return a new name for a run at `time` [UTC]."""
    return f"{time:%Y%m%d-%H%M%S.%f}-{secrets.token_hex(3)}"


def has(folder: Path, run: str) -> bool:
    """Return whether a history has the file of a run."""
    return any(folder.glob(f"{run}.*.parquet"))


def _column(name: str, kind: str, given: Mapping[str, str], known: Mapping[str, object]) -> str:
    """Return a column of a run's file as SQL: from the rows given, or the same in all."""
    if name in ("run", "time") or name not in given:
        if kind == "VARCHAR" and name in known:
            return f"{constant(known[name])} AS {named(name)}"
        value = quoted(known[name]) if name in known else "NULL"
    elif given[name].startswith("ENUM"):
        return named(name)
    else:
        value = named(name)
    value = f"CAST({value} AS {kind})"
    if kind == "DOUBLE":
        value = f"CASE WHEN isfinite({value}) THEN {value} END"
    return f"{value} AS {named(name)}"


@dataclass(frozen=True)
class Answer:
    """The answer to one SELECT over the history; it is worked out anew each time it is read."""

    history: "History"
    sql: str
    params: Params = None

    @property
    def columns(self) -> list[str]:
        """The names of the columns."""
        with self.history.asked(self) as (_, answer):
            return list(answer.columns)

    def __len__(self) -> int:
        with self.history.asked(self) as (_, answer):
            ((height,),) = answer.aggregate("count(*)").fetchall()
        return int(height)

    def rows(self, most: int | None = None) -> list[dict[str, Any]]:
        """Return the rows by the names of their columns, the first `most` of them."""
        with self.history.asked(self) as (_, answer):
            some = answer if most is None else answer.limit(most)
            return [dict(zip(answer.columns, row, strict=True)) for row in some.fetchall()]

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
            whole = self.sql.strip().rstrip(";")
            sql = f"SELECT {_plain(answer)} FROM ({whole}\n)"
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
        self._files = [file for file in found.values() if isinstance(file, RunFile)]
        self.skipped = [(path, why) for path, why in found.items() if isinstance(why, str)]
        self._base: DuckDBPyConnection | None = None

    def query(self, sql: str, params: Params = None) -> Answer:
        """Return the answer to one SELECT over `rows`; it can change nothing and read no file.

        `params` fill `?`, `$1` or `$name`. Raises `InputError` for anything but one good SELECT.
        """
        answer = Answer(self, sql, params)
        with self.asked(answer):
            return answer

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
            yield base, answer.project(_plain(answer))
        except duckdb.Error as error:
            self._stays()
            raise InputError("sql", question.sql, f"{expected} ({reason(error)})") from None
        self._stays()

    def _open(self, target: Path | None) -> "DuckDBPyConnection":
        """Return a connection that can read the files of the history, and no other."""
        import duckdb

        base = connect(streams=target is not None)
        found = frozenset().union(*(file.columns for file in self._files))
        columns = ", ".join(
            named(name) if name in found else f"NULL::{kind} AS {named(name)}"
            for name, kind in COLUMNS.items()
        )
        # A name with a pattern's letters is looked up as a pattern, and read as it is.
        paths = [str(file.path) for file in self._files]
        sought = ", ".join(quoted(escape(path)) for path in paths)
        # Where all have the same columns the first one tells them.
        union = len({file.columns for file in self._files}) > 1
        source = f"FROM read_parquet([{sought}], union_by_name = {union})" if paths else "LIMIT 0"
        try:
            base.execute(f"CREATE VIEW rows AS SELECT {columns} {source}")
        except duckdb.Error as error:
            raise self._changed(reason(error)) from None
        allowed = {*paths, *map(escape, paths), *([str(target)] if target else [])}
        base.execute(f"SET allowed_paths = [{', '.join(map(quoted, sorted(allowed)))}]")
        base.execute("SET enable_external_access = false")
        base.execute("SET lock_configuration = true")
        return base

    def _stays(self) -> None:
        for file in self._files:
            if why := file.changed():
                raise self._changed(why)

    def _changed(self, why: str) -> InputError:
        expected = f"files that stay while read ({why})"
        return InputError("history", str(self._folder), expected)


def open_history(folder: Path) -> History:
    """Return the history in `folder`; one that is not there yet is empty."""
    return History(folder)


def _plain(answer: "DuckDBPyRelation") -> str:
    """Return the columns as SQL, without the types of `_PLAINER`."""
    casts = []
    for name, kind in zip(answer.columns, map(str, answer.types), strict=True):
        for pattern, plain in _PLAINER.items():
            if re.search(pattern, kind):
                casts.append(f"CAST({named(name)} AS {plain}) AS {named(name)}")
                break
    return f"* REPLACE ({', '.join(casts)})" if casts else "*"
