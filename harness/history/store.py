"""The history of all runs: one Parquet file a run, queried with DuckDB; no server.

A file is named RUN.CHECKSUM.parquet and never changes: whatever does not match its own checksum is
damaged or foreign, and skipped. (Parquet itself notices less than half of all flipped bits.)
"""

import atexit
import gc
import re
import secrets
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from glob import escape
from hashlib import file_digest
from pathlib import Path
from typing import Any

import polars as pl

from analytic import InputError
from harness.files import staged
from harness.frames import sink
from harness.history.provenance import provenance

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
MANY_POSES = ("workspace", "map", "sweep")
"""What `case` says of poses without a name: those of `check`, `workspace` and `sweep`."""
NEEDED = ("run", "time", "model", "mode", "frequency_hz")
_TYPES: dict[str, pl.DataType] = {
    "VARCHAR": pl.String(),
    "DOUBLE": pl.Float64(),
    "BIGINT": pl.Int64(),
    "TIMESTAMP": pl.Datetime("us"),
}
SCHEMA = {name: _TYPES[kind] for name, kind in COLUMNS.items()}
_NAME = re.compile(r"\d{8}-\d{6}\.\d{6}-[0-9a-f]{6}\.([0-9a-f]{16})\.parquet")


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
        (pl.col(name) if name in given else pl.lit(known.get(name))).cast(kind).alias(name)
        for name, kind in SCHEMA.items()
    )
    finite = pl.selectors.float()
    table = table.with_columns(pl.when(finite.is_finite()).then(finite))
    with staged(folder, [run], "--history") as (temporary,):
        sink(table, temporary, ".parquet")
        path = folder / f"{run}.{_checksum(temporary)}.parquet"
        temporary.replace(path)
    return path


def _checksum(path: Path) -> str:
    with path.open("rb") as file:
        return file_digest(file, "sha256").hexdigest()[:16]


class History:
    """All sound runs of a folder as one table `rows` in memory, as it was when opened.

    Attributes: `skipped`, the files left out and why.
    """

    def __init__(self, folder: Path) -> None:
        import duckdb  # a tenth of a second that commands which only append can do without

        # Left to the end of the process uncollected, duckdb would complain of leaks there.
        atexit.unregister(gc.freeze)
        if folder.exists() and not folder.is_dir():
            raise InputError("--history", str(folder), "a folder")
        self.skipped: list[tuple[Path, str]] = []
        sound: list[str] = []
        columns: set[str] = set()
        for path in sorted(folder.glob("*.parquet")):
            try:
                columns |= _columns(path)
                sound.append(escape(str(path)))
            except _FlawError as flaw:
                self.skipped.append((path, str(flaw)))
        self._base = duckdb.connect(config={"autoinstall_known_extensions": False})
        typed = ", ".join(f'"{name}" {kind}' for name, kind in COLUMNS.items())
        self._base.execute(f"CREATE TABLE rows ({typed})")
        if sound:
            kept = ", ".join(f'"{name}"' for name in COLUMNS if name in columns)
            try:
                self._base.execute(
                    f"INSERT INTO rows BY NAME SELECT {kept} "
                    "FROM read_parquet($1, union_by_name = true) ORDER BY time, run",
                    [sound],
                )
            except duckdb.Error as error:
                expected = f"files that stay while they are read ({str(error).splitlines()[0]})"
                raise InputError("--history", str(folder), expected) from None
        self._base.execute("SET enable_external_access = false")
        self._base.execute("SET lock_configuration = true")

    def query(
        self, sql: str, params: Sequence[object] | Mapping[str, object] | None = None
    ) -> pl.DataFrame:
        """Return the answer to one SELECT over `rows`; it can change nothing and read no file.

        `params` fill `?`, `$1` or `$name`. Raises `InputError` for anything but one good SELECT.
        """
        import duckdb

        expected = "one SELECT over the table rows"
        try:
            statements = self._base.extract_statements(sql)
            if [s.type for s in statements] != [duckdb.StatementType.SELECT]:
                raise InputError("--sql", sql, expected)
            answer = self._base.sql(sql, params=params)
            # Row by row: polars does not let go of an Arrow stream, which duckdb complains of too.
            types = [_TYPES.get(str(kind)) for kind in answer.types]
            schema = list(zip(answer.columns, types, strict=True))
            return pl.DataFrame(answer.fetchall(), schema, orient="row", infer_schema_length=None)
        except (duckdb.Error, pl.exceptions.DuplicateError) as error:
            reason = str(error).splitlines()[0]
            raise InputError("--sql", sql, f"{expected} ({reason})") from None


def open_history(folder: Path) -> History:
    """Return the history in `folder`; one that is not there yet is empty."""
    return History(folder)


class _FlawError(Exception):
    """Why a file is not part of the history."""


def _columns(path: Path) -> set[str]:
    """Return which of `COLUMNS` a sound file has."""
    named = _NAME.fullmatch(path.name)
    if named is None:
        raise _FlawError("not written by rps-bench: its name is not RUN.CHECKSUM.parquet")
    try:
        size = path.stat().st_size
        whole = _checksum(path) == named[1]
    except OSError as error:
        raise _FlawError(f"cannot be read ({error.strerror})") from None
    if not whole:
        raise _FlawError(f"damaged: {size} bytes that are not those that were written")
    with path.open("rb") as file:  # its name may look like a pattern
        schema = pl.read_parquet_schema(file)
    for name in NEEDED:
        if name not in schema:
            raise _FlawError(f"of another release: it has no column {name}")
    for name, kind in SCHEMA.items():
        if name in schema and schema[name] != kind:
            raise _FlawError(f"of another release: its column {name} is {schema[name]}, not {kind}")
    return set(schema) & set(SCHEMA)
