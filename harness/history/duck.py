"""DuckDB as the history and the sweep use it: no network, times in UTC, flat memory."""

import atexit
import gc
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from duckdb import DuckDBPyConnection

ROW_GROUP = 100_000
FORMS = {
    # Dictionaries of more than a thousand numbers take longer to make than they save.
    ".parquet": f"FORMAT parquet, COMPRESSION zstd, COMPRESSION_LEVEL 1, "
    f"DICTIONARY_SIZE_LIMIT 1000, ROW_GROUP_SIZE {ROW_GROUP}",
    ".csv": "FORMAT csv",
    ".json": "FORMAT json, ARRAY true",
}
"""How each kind of file is written, by its ending."""
Params = Sequence[object] | Mapping[str, object] | None


def connect(path: str = ":memory:", *, streams: bool = False) -> "DuckDBPyConnection":
    """Return a connection to a base of its own, which loads nothing from the network.

    `streams`: long tables go through it, in order, in memory for a piece after the other.
    """
    import duckdb  # a tenth of a second

    # Left to the end of the process uncollected, duckdb would complain of leaks there.
    atexit.unregister(gc.freeze)
    base = duckdb.connect(path, config={"autoinstall_known_extensions": False})
    base.execute("SET TimeZone = 'UTC'")
    base.execute("SET enable_progress_bar = false")
    if streams:  # to keep the order of many threads, whatever they have read waits in memory
        base.execute("SET threads = 1")
        base.execute("SET memory_limit = '32MB'")  # what is more waits on the disk
        base.execute("SET preserve_insertion_order = false")
    return base


def sink(
    base: "DuckDBPyConnection", sql: str, path: Path, suffix: str, params: Params = None
) -> int:
    """Write the answer to `sql` to `path` in the form of `suffix` and return how many rows it has.

    The rows are in memory a piece after the other, and on the disk at the end. Raises `OSError` for
    what the system refused, which DuckDB tells only in the text of an error.
    """
    import duckdb

    if suffix == ".csv":
        sql = _harmless(base, sql, params)
    try:
        told = base.execute(
            f"COPY ({sql}\n) TO {quoted(path)} ({FORMS[suffix]}, USE_TMP_FILE false)", params
        )
        ((height,),) = told.fetchall()
    except duckdb.IOException as error:
        # Some of its errors come as JSON, with what the system said in the middle.
        raise OSError(reason(error).partition('","errno"')[0].rpartition(": ")[2]) from None
    with path.open("rb") as file:
        os.fsync(file.fileno())
    return int(height)


def _harmless(base: "DuckDBPyConnection", sql: str, params: Params) -> str:
    """Return a query whose texts no spreadsheet takes for a formula, as `harness.tables` does."""
    shown, places = [], []
    for k, (name, kind, *_) in enumerate(base.execute(f"DESCRIBE {sql}", params).fetchall()):
        value, text = f"c{k}", f"c{k}::VARCHAR"
        places.append(value)  # an answer may have two columns of one name
        if kind == "VARCHAR" or (kind.startswith("ENUM") and kind.endswith(")")):
            value = (
                f"CASE WHEN regexp_matches({text}, '^[=@\\t\\r+-]') AND "
                f"try_cast({text} AS DOUBLE) IS NULL THEN '''' || {text} ELSE {text} END"
            )
        shown.append(f"{value} AS {named(name)}")
    return f"SELECT {', '.join(shown)} FROM ({sql}\n) AS answer({', '.join(places)})"


def quoted(text: object) -> str:
    """Return a text as SQL writes it."""
    return "'" + str(text).replace("'", "''") + "'"


def listed(texts: Iterable[object]) -> str:
    """Return texts as SQL writes a list of them."""
    return ", ".join(map(quoted, texts))


def constant(text: object) -> str:
    """Return a text that is the same in all rows; as an enumeration it is written once, not hashed
    for every row, and is a text in the file."""
    return f"CAST({quoted(text)} AS ENUM({quoted(text)}))"


def one_of(texts: Sequence[str], number: str) -> str:
    """Return that of some texts whose `number` from 0 a column says; "" where there are none."""
    if len({*texts}) < 2:
        return constant("".join({*texts}))
    return f"CAST([{listed(texts)}][{number} + 1] AS ENUM({listed(dict.fromkeys(texts))}))"


def named(name: str) -> str:
    """Return a column's name as SQL writes it."""
    return '"' + name.replace('"', '""') + '"'


def reason(error: Exception) -> str:
    """Return the first line of what DuckDB says."""
    return str(error).splitlines()[0]
