"""A long table on its way to a file: on the disk from the start, there whole or not at all."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from shutil import rmtree
from typing import Any

import numpy as np

from harness.history.duck import connect, named, reason, sink
from harness.output import OutputError

TABLE = "long"
RECORDS = "records"
"""Rows with their texts."""


class LongTable:
    """Numbers for `file` (.parquet, .csv or .json), a row a pose and mode; to be closed.

    Columns are of `whole` numbers, or of `reals`, or, `by_mode`, of reals that differ between the
    `modes`. Blocks are kept in a base of DuckDB beside the file: in the table `wide` of `base` a
    row a pose, its columns `names`, in its view `TABLE` a row a pose and mode. The same rows give
    the same bytes. One writer at a time for a file. Raises `OutputError` with the
    reason where the folder cannot be written.
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
        # Always the same name: what a killed process left behind goes, and does not stay.
        self._own = file.with_name(f".{file.name}.parts")
        rmtree(self._own, ignore_errors=True)
        many = {name: [f"{name}_{mode}" for mode in modes] for name in by_mode}
        self._wide = {name: [name] for name in (*whole, *reals)} | many
        self.names = [each for own in self._wide.values() for each in own]
        typed = [f"{each} {'BIGINT' if each in whole else 'DOUBLE'}" for each in self.names]
        shown = [f"unnest([{', '.join(own)}]) AS {name}" for name, own in many.items()]
        shown.append(f"unnest({list(modes)})::BIGINT AS mode")
        self._held = np.empty((len(typed), 0))
        with self._writing():
            self._own.mkdir()
            self.base = connect(str(self._own / "base"), streams=True)
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
            self.base.register("block", dict(zip(self.names, held, strict=True)))
            finite = "CASE WHEN isfinite(COLUMNS(*)) THEN COLUMNS(*) END"
            self.base.execute(f"INSERT INTO wide SELECT {finite} FROM block")
            self.base.unregister("block")

    def write(self, names: Iterable[str], texts: Mapping[str, str]) -> None:
        """Make the view `RECORDS`, where numbers are `texts` in SQL too, and write columns of it;
        the file takes its name when it is complete."""
        shown = ", ".join(f"{sql} AS {named(name)}" for name, sql in texts.items())
        part = self._own / "part"
        with self._writing():
            self.base.execute(f"CREATE VIEW {RECORDS} AS SELECT *, {shown} FROM {TABLE}")
            sink(self.base, f"SELECT {', '.join(names)} FROM {RECORDS}", part, self.file.suffix)
            part.replace(self.file)

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

    def close(self) -> None:
        """Leave nothing but the file."""
        with suppress(Exception):
            self.base.close()
        rmtree(self._own, ignore_errors=True)
