"""One table, four ways to read it."""

from harness.tables import Number, Table

TABLE = Table(
    "Title",
    ("Case", "Error (%)", "Note"),
    (("case1", Number(1.23456789, 2, signed=True), "a & b"), ("case1", Number(-2.0, 2), "50 %")),
    ("from here",),
)


def test_text_rounds_and_csv_does_not() -> None:
    assert "| case1  |       +1.23 | a & b  |" in TABLE.markdown()
    assert TABLE.markdown().startswith("## Title\n")
    assert TABLE.markdown().endswith("- from here\n")
    assert TABLE.csv().splitlines()[1] == "case1,1.23456789,a & b"


def test_latex_escapes() -> None:
    text = TABLE.latex()
    assert r"a \& b" in text and r"50 \%" in text and r"Error (\%)" in text
    assert text.startswith("% Title\n% from here\n\\begin{tabular}")


def test_latex_breaks_long_text() -> None:
    """Columns of long text share the line; numbers and short text stay as they are."""
    rows = (("case1", Number(1.0), "x" * 41, "y" * 40, "z" * 90),)
    text = Table("Title", ("Case", "f1", "Long", "Short", "Longer"), rows).latex()
    assert text.splitlines()[1] == r"\begin{tabular}{lrp{0.40\linewidth}lp{0.40\linewidth}}"
    assert text.splitlines()[2] == r"\toprule" and text.endswith("\\end{tabular}\n")
    assert r"\begin{tabular}{lrl}" in TABLE.latex()


def test_files_are_all_forms() -> None:
    assert sorted(TABLE.files("t")) == ["t.csv", "t.md", "t.tex"]
