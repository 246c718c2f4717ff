"""The history of all runs: one Parquet file a run, queried with DuckDB; no server.

A file is named RUN.CHECKSUM.parquet and never changes: whatever does not match its own checksum is
damaged or foreign, and skipped. (Parquet itself notices less than half of all flipped bits.)
"""

import atexit
import gc
import re
import secrets
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from glob import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import polars as pl

from analytic import InputError
from harness.files import staged
from harness.frames import sink
from harness.history import run_file
from harness.history.provenance import provenance
from harness.history.run_file import COLUMNS as COLUMNS
from harness.history.run_file import SCHEMA as SCHEMA
from harness.history.run_file import FlawError, RunFile

if TYPE_CHECKING:
    from duckdb import DuckDBPyRelation

LARGE = 250_000
"""Bytes of a file that is still read into memory, where it takes fifty times as many."""
Params = Sequence[object] | Mapping[str, object] | None


def append(
    folder: Path,
    rows: Sequence[Mapping[str, Any]] | pl.LazyFrame,
    command: str,
    time: datetime | None = None,
) -> Path:
    """Write the rows of one run as a file of its own and return it; safe in many processes at once.

    `rows` as of `harness.run.rows`, or a frame with any of `COLUMNS`, which is never in memory as a
    whole. A value they give themselves (a commit, a machine; also null) wins over this process's.
    `time` is now unless given. What is not finite becomes null. Raises `OutputError` where the
    folder cannot be written.
    """
    # Without a zone: DuckDB needs an extension, from the network, to reckon with zones.
    time = (time or datetime.now(UTC)).astimezone(UTC).replace(tzinfo=None)
    run = f"{time:%Y%m%d-%H%M%S.%f}-{secrets.token_hex(3)}"
    own = {**provenance(), "command": command}
    if not isinstance(rows, pl.LazyFrame):
        rows = pl.LazyFrame([{**own, **row} for row in rows], SCHEMA)
    given = rows.drop("run", "time", strict=False).collect_schema()
    known = {**own, "run": run, "time": time}
    table = rows.select(
        (
            _column(name, given[name], kind) if name in given else _constant(known.get(name), kind)
        ).alias(name)
        for name, kind in SCHEMA.items()
    )
    finite = pl.selectors.float()
    table = table.with_columns(pl.when(finite.is_finite()).then(finite))
    with staged(folder, [run], "--history") as (temporary,):
        sink(table, temporary, ".parquet")
        path = folder / f"{run}.{run_file.checksum(temporary)}.parquet"
        temporary.replace(path)
    return path


def _column(name: str, given: pl.DataType, kind: pl.DataType) -> pl.Expr:
    return pl.col(name) if given == pl.Categorical else pl.col(name).cast(kind)


def _constant(value: object, kind: pl.DataType) -> pl.Expr:
    """Return one value for all rows; as a category a text costs a third of the time to write."""
    literal = pl.lit(value, dtype=kind)
    return literal.cast(pl.Categorical) if isinstance(value, str) else literal


class History:
    """All sound runs of a folder as one table `rows`, as it was when opened.

    Small files are read into memory; those above `LARGE` bytes stay where they are. Without ORDER
    BY, the rows of small files come first, in the order of time; then those of large ones.

    Attributes: `skipped`, the files left out and why.
    """

    def __init__(self, folder: Path) -> None:
        import duckdb  # a tenth of a second that commands which only append can do without

        # Left to the end of the process uncollected, duckdb would complain of leaks there.
        atexit.unregister(gc.freeze)
        if folder.exists() and not folder.is_dir():
            raise InputError("--history", str(folder), "a folder")
        self._folder = folder
        self.skipped: list[tuple[Path, str]] = []
        sound: list[RunFile] = []
        for path in sorted(folder.glob("*.parquet")):
            try:
                sound.append(run_file.read(path))
            except FlawError as flaw:
                self.skipped.append((path, str(flaw)))
        small = [file for file in sound if file.stat.st_size <= LARGE]
        self._large = [file for file in sound if file.stat.st_size > LARGE]
        self._base = duckdb.connect(config={"autoinstall_known_extensions": False})
        typed = ", ".join(f'"{name}" {kind}' for name, kind in COLUMNS.items())
        self._base.execute(f"CREATE TABLE small ({typed})")
        view = "SELECT * FROM small"
        try:
            if small:
                order = 'time, run, "case", model, mode'
                self._base.execute(f"INSERT INTO small BY NAME {_select(small)} ORDER BY {order}")
            if self._large:
                view += f" UNION ALL BY NAME {_select(self._large)}"
            self._base.execute(f"CREATE VIEW rows AS {view}")
        except duckdb.Error as error:
            raise self._changed(_reason(error)) from None
        # A name with a pattern's letters is looked up as a pattern, and read as it is.
        paths = [str(file.path) for file in self._large]
        allowed = ", ".join(map(_quoted, {*paths, *map(escape, paths)}))
        self._base.execute(f"SET allowed_paths = [{allowed}]")
        self._base.execute("SET enable_external_access = false")
        self._base.execute("SET lock_configuration = true")

    def query(self, sql: str, params: Params = None) -> pl.DataFrame:
        """Return the answer to one SELECT over `rows`; it can change nothing and read no file.

        `params` fill `?`, `$1` or `$name`. Raises `InputError` for anything but one good SELECT.
        """
        with self.scan(sql, params) as table:
            return table.collect()

    def first(self, sql: str, params: Params, most: int) -> tuple[pl.DataFrame, int]:
        """Return the first `most` rows of what `query` returns, and how many rows that has."""
        with self._asked(sql, params) as answer:
            ((height,),) = answer.aggregate("count(*)").fetchall()
            return pl.scan_arrow_c_stream(answer.limit(most)).collect(), height

    @contextmanager
    def scan(self, sql: str, params: Params = None) -> Iterator[pl.LazyFrame]:
        """Yield what `query` returns, to be read once, a piece after the other."""
        with self._asked(sql, params) as answer:
            yield pl.scan_arrow_c_stream(answer)

    @contextmanager
    def _asked(self, sql: str, params: Params) -> "Iterator[DuckDBPyRelation]":
        """Yield the answer, not read yet; say of whatever fails meanwhile what it was."""
        import duckdb

        expected = "one SELECT over the table rows"
        self._stays()
        try:
            # Of its own, in case an answer is never read to its end.
            base = self._base.cursor()
            statements = base.extract_statements(sql)
            if [s.type for s in statements] != [duckdb.StatementType.SELECT]:
                raise InputError("--sql", sql, expected)
            yield _plain(base.sql(sql, params=params))
        except (duckdb.Error, pl.exceptions.PolarsError) as error:
            self._stays()
            raise InputError("--sql", sql, f"{expected} ({_reason(error)})") from None
        self._stays()

    def _stays(self) -> None:
        for file in self._large:
            if why := file.changed():
                raise self._changed(why)

    def _changed(self, why: str) -> InputError:
        return InputError("--history", str(self._folder), f"files that stay while read ({why})")


def open_history(folder: Path) -> History:
    """Return the history in `folder`; one that is not there yet is empty."""
    return History(folder)


def _select(files: Sequence[RunFile]) -> str:
    """Return the SELECT of all rows of some files, of the columns that any of them has."""
    found = frozenset().union(*(file.columns for file in files))
    kept = ", ".join(f'"{name}"' for name in COLUMNS if name in found)
    paths = ", ".join(_quoted(escape(str(file.path))) for file in files)
    return f"SELECT {kept} FROM read_parquet([{paths}], union_by_name = true)"


def _quoted(text: str) -> str:
    return "'" + text.replace("'", "''") + "'"


def _plain(answer: "DuckDBPyRelation") -> "DuckDBPyRelation":
    """Return the answer without the types that polars has not, or shows worse."""
    casts = []
    for name, kind in zip(answer.columns, map(str, answer.types), strict=True):
        plain = "BIGINT" if kind.endswith("HUGEINT") else "VARCHAR"
        if plain == "BIGINT" or re.search("INTERVAL|UNION|BIT", kind):
            quoted = '"' + name.replace('"', '""') + '"'
            casts.append(f"CAST({quoted} AS {plain}) AS {quoted}")
    return answer.project(f"* REPLACE ({', '.join(casts)})") if casts else answer


def _reason(error: Exception) -> str:
    return str(error).splitlines()[0].removeprefix("got external error: ")
