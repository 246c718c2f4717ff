"""Files of the history that are not what was written, or not of this release."""

import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import polars as pl
import pytest

from harness.history import run_file, store
from harness.history.store import append, open_history

MODES = 6


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
    assert history.query("SELECT DISTINCT model FROM rows")["model"].to_list() == ["good"]
    ((path, why),) = history.skipped
    assert path == bad
    assert why == f"damaged: {len(spoilt)} bytes that are not those that were written"
    assert bad.read_bytes() == spoilt
    assert good.exists()


def test_every_flipped_bit_is_noticed(tmp_path: Path) -> None:
    """Parquet itself lets through more than half of them."""
    path = append(tmp_path, some_rows(), "table")
    content = path.read_bytes()
    positions = random.Random(2).sample(range(8 * len(content)), 25)
    for bit in positions:
        spoilt = bytearray(content)
        spoilt[bit // 8] ^= 1 << bit % 8
        path.write_bytes(spoilt)
        assert len(open_history(tmp_path).skipped) == 1, bit


def test_foreign_files_are_named_and_skipped(tmp_path: Path) -> None:
    ours = append(tmp_path, some_rows(), "table")
    (tmp_path / "table.parquet").write_text("a,b\n1,2\n")
    pl.DataFrame({"a": [1]}).write_parquet(tmp_path / "other.parquet")
    (tmp_path / "copy of run.parquet").write_bytes(ours.read_bytes())
    (tmp_path / "folder.parquet").mkdir()
    (tmp_path / "notes.txt").write_text("none of ours")
    history = open_history(tmp_path)
    assert history.query("SELECT count(*) AS n FROM rows")["n"].item() == MODES
    assert [path.name for path, _ in history.skipped] == [
        "copy of run.parquet", "folder.parquet", "other.parquet", "table.parquet",
    ]  # fmt: skip
    assert {why for _, why in history.skipped} == {
        "not written by rps-bench: its name is not RUN.CHECKSUM.parquet"
    }


def test_a_whole_file_that_is_no_parquet(tmp_path: Path) -> None:
    (tmp_path / "staged").write_text("a,b\n1,2\n")
    checksum = run_file.checksum(tmp_path / "staged")
    path = tmp_path / f"20250101-000000.000000-abcdef.{checksum}.parquet"
    (tmp_path / "staged").rename(path)
    why = "not written by rps-bench: it is no Parquet file"
    assert open_history(tmp_path).skipped == [(path, why)]


def write_as_another_release(folder: Path, frame: pl.DataFrame) -> Path:
    """A file that is whole, of a release with other columns."""
    staged = folder / "staged"
    frame.write_parquet(staged)
    checksum = run_file.checksum(staged)
    path = folder / f"20250101-000000.000000-abcdef.{checksum}.parquet"
    staged.rename(path)
    return path


def test_an_older_release_still_reads_and_a_newer_one(tmp_path: Path) -> None:
    whole = pl.read_parquet(append(tmp_path, some_rows(), "table"))
    older = whole.drop("assurance", "settings", "blas").with_columns(run=pl.lit("older"))
    write_as_another_release(tmp_path, older.with_columns(colour=pl.lit("red")))
    history = open_history(tmp_path)
    assert history.skipped == []
    frame = history.query("SELECT * FROM rows WHERE run = 'older'")
    assert frame.schema == store.SCHEMA
    assert frame["frequency_hz"].to_list() == whole["frequency_hz"].to_list()
    for name in ("assurance", "settings", "blas"):
        assert frame[name].null_count() == MODES
    assert history.query("SELECT count(*) FROM rows").item() == 2 * MODES


def test_only_older_files(tmp_path: Path) -> None:
    """Also where no file has the column."""
    source = append(tmp_path, some_rows(), "table")
    older = pl.read_parquet(source).drop("assurance")
    source.unlink()
    write_as_another_release(tmp_path, older)
    assert open_history(tmp_path).query("SELECT assurance FROM rows").null_count().item() == MODES


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (lambda f: f.drop("frequency_hz"), "of another release: it has no column frequency_hz"),
        (
            lambda f: f.with_columns(mode=pl.lit("first")),
            "of another release: its column mode is String, not Int64",
        ),
    ],
)
def test_columns_of_another_kind_are_said(
    tmp_path: Path, change: Callable[[pl.DataFrame], pl.DataFrame], why: str
) -> None:
    whole = pl.read_parquet(append(tmp_path, some_rows(), "table"))
    path = write_as_another_release(tmp_path, change(whole))
    history = open_history(tmp_path)
    assert history.skipped == [(path, why)]
    assert history.query("SELECT count(*) FROM rows").item() == MODES
