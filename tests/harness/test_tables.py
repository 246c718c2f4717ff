"""One table, five ways to read it; however narrow the terminal, no number is cut."""

import csv
import io
import shutil
import subprocess
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rich.console import Console

from harness.api import study
from harness.result import Result
from harness.tables import NEEDS, Cell, Number, Table

TABLE = Table(
    "Title",
    ("Case", "Error (%)", "Note"),
    (("case1", Number(1.23456789, 2, signed=True), "a & b"), ("case1", Number(-2.0, 2), "50 %")),
    ("from here",),
)
WIDTHS = (60, 80, 120)


def printed(table: Table, width: int | None) -> str:
    """Return what a terminal of so many characters shows."""
    file = io.StringIO()
    wide = table.width() if width is None else width
    console = Console(file=file, width=wide, highlight=False, markup=False)
    console.print(table.terminal(width))
    return file.getvalue()


def holds(text: str, table: Table) -> None:
    """Every number of the table is whole in `text`, and as often; so is every letter."""
    seen = Counter(text.split())
    numbers = Counter(
        str(cell) for row in table.rows for cell in row if isinstance(cell, (int, Number))
    )
    cut = {n: (times, seen[n]) for n, times in numbers.items() if seen[n] < times}
    assert not cut, cut
    letters = Counter("".join(text.split()))
    for letter, times in Counter("".join(str(c) for row in table.rows for c in row)).items():
        assert letter.isspace() or letters[letter] >= times, letter
    for name in table.columns:
        assert all(part in text for part in name.split()), name
    # A line break may fall into a cell of text, never into a number of the file.
    for row, cells in zip(list(csv.reader(io.StringIO(table.csv())))[1:], table.rows, strict=True):
        for kept, cell in zip(row, cells, strict=True):
            if isinstance(cell, Number):
                assert abs(float(kept) - float(str(cell))) <= 0.51 * 10**-cell.digits


@pytest.fixture(scope="module")
def many_modes() -> Result:
    return study("table", references="timoshenko@exact,rayleigh@exact", modes="1-12", cases="case1")


@pytest.mark.parametrize("width", [*WIDTHS, None])
def test_twelve_modes_are_whole_at_any_width(many_modes: Result, width: int | None) -> None:
    for table in many_modes.tables().values():
        text = printed(table, width)
        if width is not None:
            assert max(map(len, text.splitlines())) <= width
        holds(text, table)
    assert "135.824" in printed(many_modes.table(), width)
    blocks = printed(many_modes.table(), width).count("Case ")
    assert printed(many_modes.table(), width).count("Method") == blocks, "a row is not named"
    assert "[Hz]" in printed(many_modes.table(), width)


WORDS = st.text(st.sampled_from("abc xyz[]()%-_/"), max_size=30)
CELLS = st.one_of(
    WORDS,
    st.integers(-(10**9), 10**9),
    st.builds(Number, st.floats(-1e7, 1e7), st.integers(0, 6), st.booleans()),
)


@settings(max_examples=40)
@given(data=st.data(), columns=st.integers(1, 15), width=st.sampled_from(WIDTHS))
def test_no_number_is_cut(data: st.DataObject, columns: int, width: int) -> None:
    names = tuple(f"c{k} [mm]" for k in range(columns))
    kinds = [data.draw(st.sampled_from([WORDS, CELLS])) for _ in names]
    rows = tuple(tuple(data.draw(kind) for kind in kinds) for _ in range(3))
    text = printed(Table("t", names, rows), width)
    seen = Counter(text.split())
    for row in rows:
        for k, cell in enumerate(row):
            numeric = any(isinstance(r[k], (int, Number)) for r in rows)
            if isinstance(cell, (int, Number)) and numeric:
                assert seen[str(cell)], (str(cell), text)
    for k in range(columns):
        if any(str(row[k]).strip() for row in rows):
            assert f"c{k}" in seen and "[mm]" in seen


SIZES = st.sampled_from([1, 2, 3, Number(0.05), Number(0.1)])
ROWS = st.lists(st.tuples(st.sampled_from("ab"), SIZES, st.sampled_from("xyz")),
                min_size=2, max_size=18, unique=True)  # fmt: skip


@given(rows=ROWS, numbers=st.integers(1, 12), width=st.sampled_from(WIDTHS))
def test_every_row_of_every_block_is_named(
    rows: list[tuple[str, Cell, str]], numbers: int, width: int
) -> None:
    """Whatever it takes to tell rows apart, text or numbers, stands again before every number."""
    table = Table("t", ("Case", "s", "Part", *(f"f{k}" for k in range(numbers))),
                  tuple((*row, *(Number(1.5),) * numbers) for row in rows))  # fmt: skip
    names = [tuple(w for w in line.split() if w != "1.500")
             for line in printed(table, width).splitlines() if "1.5" in line]  # fmt: skip
    for first in range(0, len(names), len(rows)):
        assert len(set(names[first : first + len(rows)])) == len(rows)


def test_cases_stand_apart() -> None:
    """An empty line before every other case, and none within one."""
    table = Table("t", ("Case", "f"), [(name, Number(float(k))) for k, name in enumerate("aabbc")])
    body = printed(table, 80).partition("\u2500 \n")[2].splitlines()
    assert [line.strip()[:1] for line in body] == ["a", "a", "", "b", "b", "", "c", ""]


def test_text_rounds_and_files_keep_more() -> None:
    assert "| case1  |       +1.23 | a & b  |" in TABLE.markdown()
    assert TABLE.markdown().startswith("## Title\n")
    assert TABLE.markdown().endswith("- from here\n")
    assert TABLE.csv().splitlines()[1] == "case1,1.234568,a & b"
    assert TABLE.to_frame()["Error (%)"].tolist() == [1.23456789, -2.0]


def test_latex_breaks_long_text() -> None:
    """Columns of long text share the line; numbers and short text stay as they are."""
    rows = (("case1", Number(1.0), "x" * 41, "y" * 40, "z" * 90),)
    text = Table("Title", ("Case", "f1", "Long", "Short", "Longer"), rows).latex()
    assert r"\begin{tabular}{lrp{0.40\linewidth}lp{0.40\linewidth}}" in text
    assert r"\begin{tabular}{lrl}" in TABLE.latex()


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="needs LaTeX: apt-get install "
                    "texlive-latex-recommended")  # fmt: skip
def test_a_paper_can_take_the_tables(many_modes: Result, tmp_path: Path) -> None:
    """LaTeX itself: captions, references to labels, every letter as it is, nothing off the page."""
    letters = " ".join(map(chr, range(33, 127)))
    odd = Table(f"All of {letters}", ("[a]", "*"), (("[b] --c", Number(-1.5)), ("*", letters)))
    long = Table("Long", ("a", "b"), (("word " * 60, "word " * 40),))
    tables = {"odd_one": odd, "long": long, "mine": TABLE, "wide": many_modes.table()}
    for name, table in tables.items():
        (tmp_path / f"{name}.tex").write_bytes(table.files(name)[f"{name}.tex"])
    parts = "".join(rf"Table~\ref{{tab:{name}}}: \input{{{name}}}" for name in tables)
    (tmp_path / "paper.tex").write_text(
        r"\documentclass{article}"
        rf"\{NEEDS.partition(chr(92))[2]}\begin{{document}}{parts}\end{{document}}"
    )
    for _ in range(2):
        ended = subprocess.run(["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "paper"],
                               cwd=tmp_path, capture_output=True, text=True)  # fmt: skip
        assert ended.returncode == 0, ended.stdout[-2000:]
    log = (tmp_path / "paper.log").read_text()
    for sign in ("Overfull", "undefined", "multiply", "Missing character", "too large"):
        assert sign not in log, log
    assert (tmp_path / "paper.aux").read_text().count("newlabel") == len(tables)


def test_files_are_all_forms() -> None:
    assert sorted(TABLE.files("t")) == ["t.csv", "t.md", "t.tex"]


@pytest.mark.parametrize("text", ["\x1b[31mred", "two\nlines", "a\tb", "bell\x07"])
def test_what_would_steer_a_terminal_is_shown_escaped(text: str) -> None:
    row: tuple[Cell, ...] = (text, Number(1.0))
    table = Table("t", ("Case", "f"), (row,))
    for said in (printed(table, 80), table.markdown(), table.csv()):
        assert text not in said and repr(text)[1:-1] in said


@pytest.mark.parametrize("text", ["=1+1", "@sum", "\t=1"])
def test_no_cell_is_a_formula(text: str) -> None:
    said = Table("t", ("Case",), ((text,),)).csv().splitlines()[1]
    assert said.strip('"').startswith("'")
