"""A table people read: in the terminal, as Markdown, LaTeX and CSV, from the same cells."""

import csv
import io
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
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
Row = Sequence[Cell]


@dataclass(frozen=True)
class Table:
    """Rows under columns, with a title and notes that say where the numbers come from."""

    title: str
    columns: Sequence[str]
    rows: Sequence[Row]
    notes: Sequence[str] = ()

    @cached_property
    def _text(self) -> list[list[str]]:
        return [[plain(str(cell)) for cell in row] for row in self.rows]

    @cached_property
    def _numeric(self) -> list[bool]:
        """Which columns hold numbers; these are set flush right and never broken."""
        return [
            any(isinstance(row[k], (int, Number)) for row in self.rows)
            for k in range(len(self.columns))
        ]

    @cached_property
    def _widths(self) -> list[int]:
        return [max(map(len, texts)) for texts in zip(self.columns, *self._text, strict=True)]

    def markdown(self) -> str:
        """Return the table as GitHub-flavoured Markdown with title and notes."""
        from tabulate import tabulate

        sides = ["right" if numeric else "left" for numeric in self._numeric]
        body = tabulate(
            self._text, self.columns, tablefmt="github", colalign=sides, disable_numparse=True
        )
        notes = "".join(f"- {plain(note)}\n" for note in self.notes)
        return f"## {plain(self.title)}\n\n{body}\n" + (notes and f"\n{notes}")

    def latex(self, label: str = "table") -> str:
        """Return a LaTeX table with its title as the caption and \\label{tab:`label`}.

        Columns of text with a cell longer than `LONGEST` are paragraphs that share the line, and
        what is wider than the line all the same is made smaller. The notes are comments above it.
        """
        kinds = [
            "r" if numeric else "p" if any(len(str(row[k])) > LONGEST for row in self.rows) else "l"
            for k, numeric in enumerate(self._numeric)
        ]
        wide = f"p{{{PARAGRAPHS / max(1, kinds.count('p')):.2f}\\linewidth}}"
        head, *body = (
            " & ".join(map(_for_latex, row)) + r" \\" for row in (self.columns, *self._text)
        )
        return FLOAT % {
            "comments": "".join(f"% {plain(line)}\n" for line in (NEEDS, *self.notes)),
            "caption": _for_latex(plain(self.title)),
            "label": label,
            "columns": "".join(kinds).replace("p", wide),
            "head": head,
            "body": "\n".join(body),
        }

    def csv(self) -> str:
        """Return the cells, numbers with the digits that are significant; no title or notes."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        for row in (self.columns, *self.rows):
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

        return Group(
            Text(plain(self.title), style="bold"),
            *map(self._block, self._blocks(width)),
            *(Text(f"  {plain(note)}", style="dim") for note in self.notes),
        )

    def width(self) -> int:
        """Return the characters of the widest line, nothing broken."""
        notes = max(len(note) + 2 for note in (self.title, *self.notes))
        return max(notes, sum(self._widths) + GAP * len(self.columns) + 1)

    def _blocks(self, width: int | None) -> Iterator[dict[int, int]]:
        """Yield the columns of every block with their widths."""
        text, natural = self._text, dict(enumerate(self._widths))

        def taken(block: dict[int, int]) -> int:
            return sum(block.values()) + GAP * len(block)

        def own(k: int, most: int) -> int:
            return natural[k] if self._numeric[k] else min(natural[k], max(NARROW, most))

        if width is None or taken(natural) < width:
            yield natural
            return
        room = width - 1
        widest = max(NARROW, *(w for k, w in natural.items() if self._numeric[k]), 0)
        # The first columns that tell all rows apart say what a row is; else all but the last.
        most = max(1, len(natural) - 1)
        apart = (k for k in range(1, most) if len({tuple(row[:k]) for row in text}) == len(text))
        keys: dict[int, int] = {}
        for k in range(next(apart, most)):
            if keys and taken(keys) + own(k, room // 3) + 2 * GAP + widest > room:
                break
            keys[k] = own(k, room // 3)
        block, left = dict(keys), room - taken(keys) - GAP
        for k in natural:
            if k not in keys and any(row[k].strip() for row in text):
                if taken(block) + own(k, left) + GAP > room and len(block) > len(keys):
                    yield block
                    block = dict(keys)
                block[k] = own(k, left)
        yield block

    def _block(self, widths: dict[int, int]) -> "rich.table.Table":
        import rich.table
        from rich.box import SIMPLE_HEAD
        from rich.text import Text

        table = rich.table.Table(box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1))
        for k, width in widths.items():
            numeric = self._numeric[k]
            table.add_column(Text(self.columns[k]), justify="right" if numeric else "left",
                             no_wrap=numeric, overflow="fold", width=width)  # fmt: skip
        first = [str(row[0]) for row in self.rows]
        grouped = len(set(first)) < len(first)
        for row, name, after in zip(self._text, first, [*first, ""][1:], strict=True):
            table.add_row(*(Text(row[k]) for k in widths), end_section=grouped and name != after)
        return table


def table_files(tables: Mapping[str, Table]) -> dict[str, bytes]:
    """Return all `tables` as files to write, by the stem of their names."""
    files: dict[str, bytes] = {}
    for stem, table in tables.items():
        files |= table.files(stem)
    return files


def _for_latex(text: str) -> str:
    """Return `text` for LaTeX: two hyphens are no dash, and one before a digit is a minus."""
    return re.sub("^-(?=[0-9])", "$-$", text.translate(LATEX).replace("--", "-{}-"))


def harmless(cell: Any) -> Any:
    """Return a cell that no spreadsheet takes for a formula; a text that is a number stays one."""
    if not isinstance(cell, str):
        return cell
    return ("'" if FORMULA.match(cell) else "") + plain(cell)
