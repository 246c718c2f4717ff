"""A long table on its way to a file: on the disk from the start, there whole or not at all."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Self

import numpy as np

from harness.history.duck import connect, reason, sink
from harness.output import OutputError

TABLE = "long"


class LongTable:
    """Numbers for `file` (.parquet, .csv or .json), a row a pose and mode; as a context.

    Columns are of `whole` numbers, or of `reals`, or, `by_mode`, of reals that differ between the
    `modes`. Blocks are kept in a base of DuckDB beside the file: in the table `wide` of `base` a
    row a pose, in its view `TABLE` a row a pose and mode. The same rows give the same bytes. One
    writer at a time for a file. Raises `OutputError` with the reason where the folder cannot be
    written.
    """

    def __init__(
        self,
        file: Path,
        whole: Collection[str],
        reals: Collection[str],
        by_mode: Collection[str],
        modes: Sequence[int],
    ) -> None:
        self.file = file
        # Always the same names: what a killed process left behind is overwritten, not kept.
        self._own, self._part = (file.with_name(f".{file.name}.{end}") for end in ("rows", "part"))
        self._clear()
        many = {name: [f"{name}_{mode}" for mode in modes] for name in by_mode}
        self._wide = {name: [name] for name in (*whole, *reals)} | many
        self._names = [each for own in self._wide.values() for each in own]
        typed = [f"{each} {'BIGINT' if each in whole else 'DOUBLE'}" for each in self._names]
        shown = [f"unnest([{', '.join(own)}]) AS {name}" for name, own in many.items()]
        shown.append(f"unnest({list(modes)})::BIGINT AS mode")
        self._held = np.empty((len(typed), 0))
        with self._writing():
            self.base = connect(str(self._own), streams=True)
            self.base.execute("SET force_compression = 'uncompressed'")
            self.base.execute("BEGIN")  # never committed: nothing is written twice
            self.base.execute(f"CREATE TABLE wide ({', '.join(typed)})")
            self.base.execute(f"CREATE VIEW {TABLE} AS SELECT *, {', '.join(shown)} FROM wide")

    def add(self, block: Mapping[str, Any]) -> None:
        """Add n poses: of a column an array (n,), or (n, modes), or one number or None for all.

        A number that is not finite is kept as null.
        """
        height = len(block["pose"])
        if self._held.shape[1] < height:
            self._held = np.empty((len(self._held), height))
        held = self._held[:, :height]  # the same memory: DuckDB keeps hold of all that it read
        np.concatenate(
            [
                np.broadcast_to(np.asarray(block[name], dtype=float).T, (len(own), height))
                for name, own in self._wide.items()
            ],
            out=held,
        )
        with self._writing():
            self.base.register("block", dict(zip(self._names, held, strict=True)))
            finite = "CASE WHEN isfinite(COLUMNS(*)) THEN COLUMNS(*) END"
            self.base.execute(f"INSERT INTO wide SELECT {finite} FROM block")
            self.base.unregister("block")

    def write(self, columns: Mapping[str, str]) -> None:
        """Write the file, its columns in SQL; it takes its name when it is complete."""
        shown = ", ".join(f"{sql} AS {name}" for name, sql in columns.items())
        with self._writing():
            sink(self.base, f"SELECT {shown} FROM {TABLE}", self._part, self.file.suffix)
            self._part.replace(self.file)

    @contextmanager
    def _writing(self) -> Iterator[None]:
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
