"""A table of plain values: its columns say how they are shown."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from harness.compare import cell
from harness.tables import Cell, Table


def laid_out(
    title: str,
    columns: Mapping[str, int | None],
    rows: Iterable[Sequence[Any]],
    notes: Iterable[str] = (),
) -> Table:
    """Return a table of `rows` under `columns`: by name, the decimals of its numbers.

    None: a column of words and whole numbers. Words are shown as they are wherever they stand, "-"
    for NaN and None.
    """

    def shown(value: Any, digits: int | None) -> Cell:
        if value is None:
            return "-"
        plain: Cell = value
        return plain if digits is None or isinstance(value, str) else cell(value, digits)

    cells = [tuple(map(shown, row, columns.values())) for row in rows]
    return Table(title, list(columns), cells, list(notes))
