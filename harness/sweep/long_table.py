"""A long table on its way to a file: on the disk from the start, there whole or not at all."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Self

import numpy as np

from harness.history.duck import connect, named, quoted, reason, sink
from harness.output import OutputError

TABLE = "long"


class LongTable:
    """Rows for `file` (.parquet, .csv or .json), one a pose and mode; as a context.

    `columns` have types; values of the columns `by_mode` differ between the `modes`. Blocks are
    added one after the other and kept in a base of DuckDB beside the file, a row a pose, in memory
    for one block; the table `TABLE` of `base` has them as they will be in the file. The same rows
    give the same bytes. One writer at a time for a file. Raises `OutputError` with the reason where
    the folder cannot be written.
    """

    def __init__(
        self, file: Path, columns: Mapping[str, str], by_mode: Sequence[str], modes: Sequence[int]
    ) -> None:
        self.file, self._columns, self._modes = file, columns, modes
        self._by_mode = {name: [f"{name}_{mode}" for mode in modes] for name in by_mode}
        self._memory: dict[str, np.ndarray] = {}
        # Always the same name: what a killed process left behind is overwritten, not kept.
        self._own = file.with_name(f".{file.name}.rows")
        self._part = file.with_name(f".{file.name}.part")
        self._clear()
        typed, shown = [], []
        for name, kind in columns.items():
            if name == "mode":
                shown.append(f"unnest({list(modes)})::{kind} AS mode")
                continue
            own = self._by_mode.get(name, [name])
            typed += [f"{named(each)} {kind}" for each in own]
            many = f"unnest([{', '.join(map(named, own))}]) AS {named(name)}"
            shown.append(many if name in self._by_mode else named(name))
        with self._told():
            self.base = connect(str(self._own), streams=True)
            self.base.execute("SET force_compression = 'uncompressed'")
            self.base.execute("BEGIN")  # never committed: nothing is written twice
            self.base.execute(f"CREATE TABLE wide ({', '.join(typed)})")
            self.base.execute(f"CREATE VIEW {TABLE} AS SELECT {', '.join(shown)} FROM wide")

    def add(self, block: Mapping[str, Any]) -> None:
        """Add n poses: a column is an array (n,), or (n, modes), or one text or None for all.

        A number that is not finite is kept as null.
        """
        arrays: dict[str, np.ndarray] = {}
        values = []
        for name in self._columns:
            value, own = block.get(name), self._by_mode.get(name, [name])
            if isinstance(value, np.ndarray):
                arrays |= dict(zip(own, value.T if name in self._by_mode else [value], strict=True))
                finite = (
                    "CASE WHEN isfinite({0}) THEN {0} END" if value.dtype.kind == "f" else "{0}"
                )
                values += [finite.format(named(each)) for each in own]
            elif name != "mode":
                values += ["NULL" if value is None else quoted(value)] * len(own)
        with self._told():
            self.base.register("block", {k: self._held(k, v) for k, v in arrays.items()})
            self.base.execute(f"INSERT INTO wide SELECT {', '.join(values)} FROM block")
            self.base.unregister("block")

    def _held(self, name: str, values: np.ndarray) -> np.ndarray:
        """Return `values` where the last block's were: DuckDB keeps hold of all that it read."""
        own = self._memory.get(name)
        if own is None or own.dtype != values.dtype or len(own) < len(values):
            own = self._memory[name] = np.empty(len(values), values.dtype)
        own[: len(values)] = values
        return own[: len(values)]

    def write(self, *without: str) -> None:
        """Write the file but for some columns; it takes its name when it is complete."""
        shown = ", ".join(named(name) for name in self._columns if name not in without)
        with self._told():
            sink(self.base, f"SELECT {shown} FROM {TABLE}", self._part, self.file.suffix)
            self._part.replace(self.file)

    @contextmanager
    def _told(self) -> Iterator[None]:
        """Say of whatever fails inside that the folder cannot be written, and why."""
        import duckdb

        try:
            yield
        except (OSError, duckdb.Error) as error:
            told = getattr(error, "strerror", None) or reason(error).rpartition(": ")[2]
            folder = str(self.file.parent)
            raise OutputError(f"output = {folder!r}: cannot write there ({told})") from None

    def _clear(self) -> None:
        for path in (self._own, self._own.with_name(f"{self._own.name}.wal"), self._part):
            with suppress(OSError):
                path.unlink(missing_ok=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        with suppress(Exception):
            self.base.close()
        self._clear()
