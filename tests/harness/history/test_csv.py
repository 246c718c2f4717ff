"""Answers to SQL as CSV: no text is a formula, and what a query calls its columns is its own."""

from pathlib import Path

import pytest

from harness.history.duck import connect, sink


@pytest.mark.parametrize(
    ("asked", "written"),
    [
        ("'=1+1' AS a, '-3.5' AS b, '@x' AS c, 'x=1' AS d", "a,b,c,d\n'=1+1,-3.5,'@x,x=1\n"),
        ("'=q'::ENUM('=q', 'b') AS a, NULL AS b, -2 AS c", "a,b,c\n'=q,,-2\n"),
        ("'=1' AS a, '=2' AS a", "a,a_1\n'=1,'=2\n"),
        ("['=1'] AS a", "a\n['=1']\n"),
    ],
)
def test_texts_are_no_formulas(asked: str, written: str, tmp_path: Path) -> None:
    file = tmp_path / "answer.csv"
    with connect() as base:
        assert sink(base, f"SELECT {asked}", file, ".csv") == 1
    assert file.read_text() == written
