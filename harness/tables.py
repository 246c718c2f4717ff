"""A table people read: in the terminal, as Markdown, LaTeX and CSV, from the same cells."""

import csv
import io
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from harness.plain import plain

if TYPE_CHECKING:
    import pandas as pd
    import rich.table
    from rich.console import Group

KEPT = 4
"""Decimals that files keep beyond those shown: what machines agree on, and no more."""
LONGEST = 40
"""Characters of a cell that LaTeX still sets in one line."""
PARAGRAPHS = 0.8
"""Part of LaTeX's line that all longer columns share."""
NEEDS = r"needs \usepackage{booktabs,graphicx}"
FLOAT = r"""%(comments)s\begin{table}
\centering\footnotesize
\caption{%(caption)s}
\label{tab:%(label)s}
\sbox0{\begin{tabular}{%(columns)s}
\toprule
%(head)s
\midrule
%(body)s
\bottomrule
\end{tabular}}%%
\ifdim\wd0>\linewidth\resizebox{\linewidth}{!}{\usebox0}\else\usebox0\fi
\end{table}
"""
LATEX = str.maketrans(
    {letter: "\\" + letter for letter in "&%$#_{}"}
    | {letter: f"{{{letter}}}" for letter in "[]*"}
    | {letter: rf"\text{name}{{}}" for letter, name in zip(
        "\\~^<>|", ("backslash", "asciitilde", "asciicircum", "less", "greater", "bar"),
        strict=True)}
)  # fmt: skip
"""What LaTeX must be told is meant as it stands."""
NARROW = 12
"""Characters a column of text keeps at least, however narrow the terminal."""
GAP = 3
"""Spaces between columns."""
FORMULA = re.compile(r"[=@\t\r]|[+-](?![\d.]*(e[+-]?\d+)?( %)?$)")
"""How a text begins that a spreadsheet may take for a formula: `history.duck` has it as well."""


@dataclass(frozen=True)
class Number:
    """A number shown with `digits` decimals (`signed`: always with its sign)."""

    value: float
    digits: int = 3
    signed: bool = False

    def __str__(self) -> str:
        return f"{self.value:{'+' if self.signed else ''}.{self.digits}f}"

    @property
    def kept(self) -> str:
        """The number as files keep it."""
        return f"{self.value:.{self.digits + KEPT}f}"


Cell = str | int | Number


@dataclass(frozen=True)
class Table:
    """Rows under columns, with a title and notes that say where the numbers come from."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    notes: tuple[str, ...] = ()

    def _text(self) -> list[list[str]]:
        return [[plain(str(cell)) for cell in row] for row in self.rows]

    def _numeric(self) -> list[bool]:
        """Return which columns hold numbers; these are set flush right and never broken."""
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
        notes = "".join(f"- {plain(note)}\n" for note in self.notes)
        body = f"## {plain(self.title)}\n\n{self._tabulated('github')}\n"
        return f"{body}\n{notes}" if notes else body

    def latex(self, label: str = "table") -> str:
        """Return a LaTeX table with its title as the caption and \\label{tab:`label`}.

        Columns of text with a cell longer than `LONGEST` are paragraphs that share the line, and
        what is wider than the line all the same is made smaller. The notes are comments above it.
        """
        comments = "".join(f"% {plain(line)}\n" for line in (NEEDS, *self.notes))
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
        head, *body = (
            " & ".join(map(_for_latex, row)) + r" \\" for row in (self.columns, *self._text())
        )
        return FLOAT % {
            "comments": comments,
            "caption": _for_latex(plain(self.title)),
            "label": label,
            "columns": columns,
            "head": head,
            "body": "\n".join(body),
        }

    def csv(self) -> str:
        """Return the cells, numbers with the digits that are significant; no title or notes."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(map(harmless, self.columns))
        for row in self.rows:
            writer.writerow([c.kept if isinstance(c, Number) else harmless(c) for c in row])
        return text.getvalue()

    def to_frame(self) -> "pd.DataFrame":
        """Return the cells as a pandas frame, numbers with every digit they have."""
        import pandas as pd

        rows = [[c.value if isinstance(c, Number) else c for c in row] for row in self.rows]
        return pd.DataFrame(rows, columns=list(self.columns))

    def files(self, stem: str) -> dict[str, bytes]:
        """Return `stem` with .csv, .md and .tex as files to write."""
        forms = {"csv": self.csv(), "md": self.markdown(), "tex": self.latex(stem)}
        return {f"{stem}.{suffix}": text.encode() for suffix, text in forms.items()}

    def terminal(self, width: int | None = None) -> "Group":
        """Return what rich prints; where `width` is too small, the columns stand in blocks.

        Every block repeats the columns that say what a row is, so that no number is ever cut or
        left without its row; a column that says nothing is left out there. None: as wide as it
        needs to be.
        """
        from rich.console import Group
        from rich.text import Text

        blocks = [self._block(block) for block in self._blocks(width)]
        title = Text(plain(self.title), style="bold")
        return Group(
            title, *blocks, *(Text(f"  {plain(note)}", style="dim") for note in self.notes)
        )

    def width(self) -> int:
        """Return the characters of the widest line, nothing broken."""
        notes = max((len(note) + 2 for note in (self.title, *self.notes)), default=0)
        return max(notes, sum(self._widths()) + GAP * len(self.columns) + 1)

    def _widths(self) -> list[int]:
        text = self._text()
        return [
            max([len(name), *(len(row[k]) for row in text)]) for k, name in enumerate(self.columns)
        ]

    def _leading(self) -> int:
        """Return how many columns say what a row is: the first that tell all rows apart, or all."""
        text, most = self._text(), max(1, len(self.columns) - 1)
        apart = (k for k in range(1, most) if len({tuple(row[:k]) for row in text}) == len(text))
        return next(apart, most)

    def _blocks(self, width: int | None) -> Iterator[Mapping[int, int]]:
        """Yield the columns of every block with their widths."""
        text, numeric, natural = self._text(), self._numeric(), self._widths()
        if width is None or sum(natural) + GAP * len(natural) + 1 <= width:
            yield dict(enumerate(natural))
            return
        room = width - 1
        numbers = (w for w, flush in zip(natural, numeric, strict=True) if flush)
        widest = GAP + max(NARROW, *numbers, 0)

        def taken(block: Mapping[int, int]) -> int:
            return sum(block.values()) + GAP * len(block)

        def own(k: int, most: int) -> int:
            return natural[k] if numeric[k] else min(natural[k], max(NARROW, most))

        keys: dict[int, int] = {}
        for k in range(self._leading()):
            if keys and taken(keys) + own(k, room // 3) + GAP + widest > room:
                break
            keys[k] = own(k, room // 3)
        block, left = dict(keys), room - taken(keys) - GAP
        for k in range(len(natural)):
            if k not in keys and any(row[k].strip() for row in text):
                if taken(block) + own(k, left) + GAP > room and len(block) > len(keys):
                    yield block
                    block = dict(keys)
                block[k] = own(k, left)
        yield block

    def _block(self, columns: Mapping[int, int]) -> "rich.table.Table":
        import rich.table
        from rich.box import SIMPLE_HEAD
        from rich.text import Text

        numeric, text = self._numeric(), self._text()
        table = rich.table.Table(box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1))
        for k, width in columns.items():
            table.add_column(
                Text(self.columns[k]),
                justify="right" if numeric[k] else "left",
                no_wrap=numeric[k],
                overflow="fold",
                min_width=width,
                max_width=width,
            )
        first = [str(row[0]) for row in self.rows]
        grouped = len(set(first)) < len(first)
        for number, row in enumerate(text):
            if grouped and number and first[number] != first[number - 1]:
                table.add_section()
            table.add_row(*(Text(row[k]) for k in columns))
        return table


def table_files(tables: Mapping[str, Table]) -> dict[str, bytes]:
    """Return all `tables` as files to write, by the stem of their names."""
    return {
        name: text for stem, table in tables.items() for name, text in table.files(stem).items()
    }


def _for_latex(text: str) -> str:
    """Return `text` for LaTeX: two hyphens are no dash, and one before a digit is a minus."""
    return re.sub("^-(?=[0-9])", "$-$", text.translate(LATEX).replace("--", "-{}-"))


def harmless(cell: Any) -> Any:
    """Return a cell that no spreadsheet takes for a formula; a text that is a number stays one."""
    if not isinstance(cell, str):
        return cell
    return f"'{plain(cell)}" if FORMULA.match(cell) else plain(cell)
