"""A table of results as cells whose numbers say where they come from."""

from collections.abc import Callable, Sequence

from harness.report.section import Cell

Row = Sequence[str | Cell]


def number(
    text: str, form: str, unit: str, what: str, record: int | None, scale: float = 1
) -> str | Cell:
    """Return a CSV's cell as a number shown in `form`, or as it is where it is none."""
    try:
        value = scale * float(text)
    except ValueError:
        return text
    shown = format(value, form)
    if record is None:
        return shown
    return Cell(shown, f"{value!r} {unit}".strip(), what, record)


def cells(
    rows: Sequence[Sequence[str]], make: Callable[[Sequence[str], int], str | Cell]
) -> list[Row]:
    """Return every cell of `rows` through `make(row, column)`."""
    return [[make(row, k) for k in range(len(row))] for row in rows]
