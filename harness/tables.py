"""A table people read: in the terminal, as Markdown, LaTeX and CSV, from the same cells."""

import csv
import io
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Group


@dataclass(frozen=True)
class Number:
    """A number shown with `digits` decimals (`signed`: always with its sign), stored in full."""

    value: float
    digits: int = 3
    signed: bool = False

    def __str__(self) -> str:
        return f"{self.value:{'+' if self.signed else ''}.{self.digits}f}"


Cell = str | int | Number
LONGEST = 40
"""Characters of a cell that LaTeX still sets in one line."""
PARAGRAPHS = 0.8
"""Part of LaTeX's line that all longer columns share."""
BEGIN = r"\begin{tabular}"


@dataclass(frozen=True)
class Table:
    """Rows under columns, with a title and notes that say where the numbers come from."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    notes: tuple[str, ...] = ()

    def _text(self) -> list[list[str]]:
        return [[str(cell) for cell in row] for row in self.rows]

    def _numeric(self) -> list[bool]:
        """Return which columns hold numbers; these are set flush right."""
        return [
            any(isinstance(row[k], (int, Number)) for row in self.rows)
            for k in range(len(self.columns))
        ]

    def _tabulated(self, style: str) -> str:
        from tabulate import tabulate

        sides = ["right" if numeric else "left" for numeric in self._numeric()]
        return tabulate(
            self._text(), self.columns, tablefmt=style, colalign=sides, disable_numparse=True
        )

    def markdown(self) -> str:
        """Return the table as GitHub-flavoured Markdown with title and notes."""
        notes = "".join(f"- {note}\n" for note in self.notes)
        body = f"## {self.title}\n\n{self._tabulated('github')}\n"
        return f"{body}\n{notes}" if notes else body

    def latex(self) -> str:
        """Return a booktabs tabular; title and notes are comments above it.

        Columns of text with a cell longer than `LONGEST` are paragraphs that share the line.
        """
        comments = "".join(f"% {line}\n" for line in (self.title, *self.notes))
        numeric = self._numeric()
        long = [
            not numeric[k] and any(len(str(row[k])) > LONGEST for row in self.rows)
            for k in range(len(self.columns))
        ]
        width = f"p{{{PARAGRAPHS / max(1, sum(long)):.2f}\\linewidth}}"
        columns = "".join(
            width if wide else "r" if flush_right else "l"
            for wide, flush_right in zip(long, numeric, strict=True)
        )
        begin, _, body = self._tabulated("latex_booktabs").partition("\n")
        assert begin.startswith(BEGIN), "tabulate sets the columns in its first line"
        return f"{comments}{BEGIN}{{{columns}}}\n{body}\n"

    def csv(self) -> str:
        """Return the cells with every digit they have; no title or notes."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.columns)
        for row in self.rows:
            writer.writerow([c.value if isinstance(c, Number) else c for c in row])
        return text.getvalue()

    def terminal(self) -> "Group":
        """Return what rich prints."""
        import rich.table
        from rich.box import SIMPLE_HEAD
        from rich.console import Group
        from rich.text import Text

        title = Text(self.title, style="bold")
        table = rich.table.Table(title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False)
        for name, numeric in zip(self.columns, self._numeric(), strict=True):
            table.add_column(
                name, justify="right" if numeric else "left", no_wrap=numeric, overflow="fold"
            )
        first = [str(row[0]) for row in self.rows]
        grouped = len(set(first)) < len(first)
        for k, row in enumerate(self._text()):
            if grouped and k and first[k] != first[k - 1]:
                table.add_section()
            table.add_row(*(Text(cell) for cell in row))
        return Group(table, *(Text(f"  {note}", style="dim") for note in self.notes))

    def files(self, stem: str) -> dict[str, bytes]:
        """Return `stem` with .csv, .md and .tex as files to write."""
        forms = {"csv": self.csv(), "md": self.markdown(), "tex": self.latex()}
        return {f"{stem}.{suffix}": text.encode() for suffix, text in forms.items()}


def table_files(tables: Mapping[str, Table]) -> dict[str, bytes]:
    """Return all `tables` as files to write, by the stem of their names."""
    return {
        name: text for stem, table in tables.items() for name, text in table.files(stem).items()
    }
