"""Files of the history that are not what was written, or not of this release."""

import os
import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from analytic import InputError
from harness.history.duck import connect
from harness.history.store import COLUMNS, append, checksum, open_history

MODES = 6
NAMED = "20250101-000000.000000-abcdef.{}.parquet"


def some_rows(model: str = "euler-bernoulli@3", count: int = MODES) -> list[dict[str, Any]]:
    return [
        {"case": "case1", "mechanism": "a", "model": model, "mode": i, "frequency_hz": 100.0 * i}
        for i in range(1, count + 1)
    ]


def cut(content: bytes) -> bytes:
    return content[: len(content) // 2]


def flipped(content: bytes) -> bytes:
    where = random.Random(1).randrange(len(content))
    return content[:where] + bytes([content[where] ^ 1]) + content[where + 1 :]


@pytest.mark.parametrize("damage", [cut, flipped, lambda _: b"", lambda _: b"run,time\n1,2\n"])
def test_damage_is_named_skipped_and_left_alone(
    tmp_path: Path, damage: Callable[[bytes], bytes]
) -> None:
    good, bad = (append(tmp_path, some_rows(model), "table") for model in ("good", "bad"))
    spoilt = damage(bad.read_bytes())
    bad.write_bytes(spoilt)
    history = open_history(tmp_path)
    assert history.query("SELECT DISTINCT model FROM rows").rows() == [{"model": "good"}]
    ((path, why),) = history.skipped
    assert path == bad
    assert why == f"damaged: {len(spoilt)} bytes that are not those that were written"
    assert bad.read_bytes() == spoilt
    assert good.exists()


def test_every_flipped_bit_is_noticed(tmp_path: Path) -> None:
    """Parquet itself lets through more than half of them."""
    path = append(tmp_path, some_rows(), "table")
    content = path.read_bytes()
    for bit in random.Random(2).sample(range(8 * len(content)), 25):
        spoilt = bytearray(content)
        spoilt[bit // 8] ^= 1 << bit % 8
        path.write_bytes(spoilt)
        assert len(open_history(tmp_path).skipped) == 1, bit


def test_foreign_files_are_named_and_skipped(tmp_path: Path) -> None:
    ours = append(tmp_path, some_rows(), "table")
    (tmp_path / "table.parquet").write_text("a,b\n1,2\n")
    (tmp_path / "copy of run.parquet").write_bytes(ours.read_bytes())
    (tmp_path / "folder.parquet").mkdir()
    (tmp_path / "notes.txt").write_text("none of ours")
    history = open_history(tmp_path)
    assert len(history.query("SELECT mode FROM rows")) == MODES
    names = ["copy of run.parquet", "folder.parquet", "table.parquet"]
    assert [path.name for path, _ in history.skipped] == names
    assert {why for _, why in history.skipped} == {
        "not written by rps-bench: its name is not RUN.CHECKSUM.parquet"
    }


def test_what_would_never_end_is_not_read(tmp_path: Path) -> None:
    """A pipe waits for a writer, /dev/zero has no end; both bear the name of a run."""
    append(tmp_path, some_rows(), "table")
    os.mkfifo(tmp_path / NAMED.format("0123456789abcdef"))
    (tmp_path / NAMED.format("0123456789abcdee")).symlink_to("/dev/zero")
    (tmp_path / NAMED.format("0123456789abcded")).symlink_to("nowhere")
    history = open_history(tmp_path)
    assert [why for _, why in history.skipped] == [
        "cannot be read (No such file or directory)",
        *["not written by rps-bench: it is no regular file"] * 2,
    ]
    assert len(history.query("SELECT mode FROM rows")) == MODES


def under_its_checksum(staged: Path) -> Path:
    return staged.rename(staged.parent / NAMED.format(checksum(staged)))


def test_a_whole_file_that_is_no_parquet(tmp_path: Path) -> None:
    append(tmp_path, some_rows(), "table")
    (tmp_path / "staged").write_text("a,b\n1,2\n")
    path = under_its_checksum(tmp_path / "staged")
    history = open_history(tmp_path)
    ((found, why),) = history.skipped
    assert found == path
    assert why.startswith("not written by rps-bench: it is no Parquet file")
    assert len(history.query("SELECT mode FROM rows")) == MODES


def of_another_release(folder: Path, columns: str) -> Path:
    """Write what a run in the folder holds as a file with other columns."""
    (source,) = folder.glob("*.parquet")
    with connect() as base:
        base.execute(
            f"COPY (SELECT {columns} FROM '{source}') TO '{folder / 'staged'}' (FORMAT parquet)"
        )
    return under_its_checksum(folder / "staged")


def test_an_older_release_still_reads_and_a_newer_one(tmp_path: Path) -> None:
    append(tmp_path, some_rows(), "table")
    missing = ("assurance", "settings", "blas")
    of_another_release(
        tmp_path,
        f"* EXCLUDE ({', '.join(missing)}) REPLACE ('older' AS run), 'red' AS colour",
    )
    history = open_history(tmp_path)
    assert history.skipped == []
    rows = history.query("SELECT * FROM rows WHERE run = 'older'").rows()
    assert [*rows[0]] == [*COLUMNS]
    assert [row["frequency_hz"] for row in rows] == [100.0 * i for i in range(1, MODES + 1)]
    assert {row[name] for row in rows for name in missing} == {None}
    assert len(history.query("SELECT mode FROM rows")) == 2 * MODES


def test_only_older_files(tmp_path: Path) -> None:
    """Also where no file has the column."""
    source = append(tmp_path, some_rows(), "table")
    of_another_release(tmp_path, "* EXCLUDE assurance")
    source.unlink()
    rows = open_history(tmp_path).query("SELECT assurance FROM rows").rows()
    assert rows == [{"assurance": None}] * MODES


@pytest.mark.parametrize(
    ("columns", "why"),
    [
        ("* EXCLUDE frequency_hz", "of another release: it has no column frequency_hz"),
        (
            "* REPLACE ('first' AS mode)",
            "of another release: its column mode is VARCHAR, not BIGINT",
        ),
    ],
)
def test_columns_of_another_kind_are_said(tmp_path: Path, columns: str, why: str) -> None:
    append(tmp_path, some_rows(), "table")
    path = of_another_release(tmp_path, columns)
    history = open_history(tmp_path)
    assert history.skipped == [(path, why)]
    assert len(history.query("SELECT mode FROM rows")) == MODES


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (Path.unlink, "cannot be read any more: No such file or directory"),
        (lambda path: path.write_bytes(path.read_bytes()[:1000]), "was changed"),
        (lambda path: path.write_bytes(path.read_bytes()), "was changed"),
    ],
)
def test_a_file_that_does_not_stay(
    tmp_path: Path, change: Callable[[Path], None], why: str
) -> None:
    path = append(tmp_path, some_rows(), "table")
    os.utime(path, (0, 0))
    answer = open_history(tmp_path).query("SELECT mode, sum(frequency_hz) FROM rows GROUP BY 1")
    change(path)  # between the question and the answer
    expected = f"expected files that stay while read ({path.name} {why})"
    for read in (answer.to_frame, answer.rows, lambda: answer.write(tmp_path / "out.csv")):
        with pytest.raises(InputError) as refused:
            read()
        assert str(refused.value) == f"history = {str(tmp_path)!r}: {expected}"
