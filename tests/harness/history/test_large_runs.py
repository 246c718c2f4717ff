"""Large runs stay on disk: as complete, as safe and as closed to other files as small ones."""

import os
import re
import subprocess
import sys
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import polars as pl
import pytest

from analytic import InputError
from harness.history import store
from harness.history.store import LARGE, append, open_history

POSES = 6_000


def poses(count: int = POSES) -> pl.LazyFrame:
    """Six rows a pose, no two of one frequency, as a sweep has them."""
    row = pl.int_range(6 * count, eager=True).alias("row")
    return row.to_frame().lazy().select(
        model=pl.lit("exudyn-cable@8"), case=pl.lit("sweep"), mode=pl.col("row") % 6 + 1,
        z_m=0.5 + (pl.col("row") // 6) / 1e7, azimuth_rad=(pl.col("row") // 6).sqrt(),
        tilt_rad=pl.lit(0.1), frequency_hz=100 + pl.col("row").sin(),
    )  # fmt: skip


@pytest.fixture
def past(tmp_path: Path) -> Path:
    """A large run between two small ones."""
    folder = tmp_path / "past"
    for day, rows in enumerate(([small("first")], poses(), [small("last")]), 1):
        append(folder, rows, f"rps-bench {day}", datetime(2026, 1, day, tzinfo=UTC))
    return folder


def small(model: str) -> dict[str, Any]:
    return {"case": "case1", "model": model, "mode": 1, "frequency_hz": 1.0, "assurance": 0.5}


def large(folder: Path) -> Path:
    (path,) = (path for path in folder.iterdir() if path.stat().st_size > LARGE)
    return path


def test_small_and_large_are_one_table(past: Path) -> None:
    history = open_history(past)
    assert history.skipped == []
    frame = history.query("SELECT * FROM rows ORDER BY time, z_m, mode")
    assert frame.schema == store.SCHEMA
    assert frame["model"][0] == "first" and frame["model"][-1] == "last"
    wanted = poses().collect()
    assert frame[1:-1].select(wanted.columns).equals(wanted)
    assert history.query("SELECT DISTINCT run FROM rows").height == 3


def test_in_the_order_of_writing_without_order_by(past: Path) -> None:
    frame = open_history(past).query("SELECT model, z_m, mode FROM rows")
    assert frame["model"][:2].to_list() == ["first", "last"]
    assert frame[2:].equals(poses().select("model", "z_m", "mode").collect())


def test_only_the_first_rows_are_fetched(past: Path) -> None:
    asked = "SELECT mode FROM rows WHERE mode <= $most ORDER BY mode DESC"
    frame, height = open_history(past).first(asked, {"most": 5}, 3)
    assert frame["mode"].to_list() == [5, 5, 5]
    assert height == 5 * POSES + 2


def test_a_large_file_of_an_older_release(past: Path) -> None:
    path = large(past)
    older = pl.read_parquet(path).drop("azimuth_rad", "settings")
    path.unlink()
    older.write_parquet(past / "staged", statistics=False)
    checksum = store.run_file.checksum(past / "staged")
    (past / "staged").rename(past / f"20250101-000000.000000-abcdef.{checksum}.parquet")
    history = open_history(past)
    assert history.skipped == []
    frame = history.query("SELECT azimuth_rad, assurance FROM rows WHERE \"case\" = 'sweep'")
    assert frame.null_count().row(0) == (6 * POSES, 6 * POSES)


def test_a_damaged_large_file_is_named_and_skipped(past: Path) -> None:
    path = large(past)
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    history = open_history(past)
    why = f"damaged: {len(content)} bytes that are not those that were written"
    assert history.skipped == [(path, why)]
    assert history.query("SELECT DISTINCT model FROM rows ORDER BY 1")["model"].to_list() == [
        "first", "last",
    ]  # fmt: skip


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:1000])


def rewritten(path: Path) -> None:
    """Of the same size, another value."""
    content = path.read_bytes()
    path.write_bytes(content[:LARGE // 2] + b"!" + content[LARGE // 2 + 1:])  # fmt: skip


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (Path.unlink, "cannot be read any more: No such file or directory"),
        (cut, "was changed"),
        (rewritten, "was changed"),
    ],
)
def test_a_large_file_that_does_not_stay(
    past: Path, change: Callable[[Path], None], why: str
) -> None:
    history = open_history(past)
    path = large(past)
    os.utime(path, (0, 0))
    history = open_history(past)
    with (
        pytest.raises(InputError) as refused,
        history.scan("SELECT mode, sum(frequency_hz) FROM rows GROUP BY 1") as table,
    ):
        change(path)  # between the question and the answer
        table.collect()
    expected = f"expected files that stay while read ({path.name} {why})"
    assert str(refused.value) == f"--history = {str(past)!r}: {expected}"
    with pytest.raises(InputError, match=re.escape(expected)):
        history.query("SELECT 1")


def test_names_that_look_like_patterns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for folder in (Path("h[1]*?"), Path("it's {a,b} %20")):
        append(folder, poses(), "sweep")
        asked = "SELECT count(*) FROM rows"
        assert open_history(folder).query(asked).item() == 6 * POSES


@pytest.mark.parametrize(
    "sql",
    [
        "SELECT * FROM read_text('{past}/secret.txt')",
        "SELECT * FROM read_csv('{past}/secret.txt')",
        "SELECT * FROM '{past}/secret.txt'",
        "SELECT * FROM read_parquet('{past}/*.parquet')",
        "SELECT * FROM read_parquet('{past}/other.parquet')",
        "SELECT * FROM '{large}/../secret.txt'",
        "SELECT * FROM read_text('{large}/../secret.txt')",
        "SELECT * FROM glob('{past}/*')",
        "SELECT * FROM query('COPY rows TO ''{large}''')",
        "COPY rows TO '{large}' (FORMAT parquet)",
        "COPY rows TO '{past}/new.parquet'",
        "INSERT INTO rows SELECT * FROM rows",
        "CREATE OR REPLACE VIEW rows AS SELECT 1",
        "SET allowed_paths = ['{past}/secret.txt']",
        "RESET allowed_paths",
        "SELECT set_config('allowed_paths', '{past}', false)",
    ],
)
def test_a_query_only_reads_the_rows(past: Path, sql: str) -> None:
    (past / "secret.txt").write_text("secret\n")
    pl.DataFrame({"a": [1]}).write_parquet(past / "other.parquet")
    before = {path.name: path.read_bytes() for path in past.iterdir()}
    history = open_history(past)
    with pytest.raises(InputError) as refused:
        history.query(sql.format(past=past, large=large(past)))
    assert len(str(refused.value).splitlines()) == 1
    assert {path.name: path.read_bytes() for path in past.iterdir()} == before
    assert history.query("SELECT count(*) FROM rows").item() == 6 * POSES + 2


@pytest.mark.parametrize(
    ("sql", "found"),
    [
        ("SELECT sum(mode) AS v FROM rows", 21 * POSES + 2),
        ("SELECT max(time) - min(time) AS v FROM rows", "2 days"),
        ("SELECT [max(time) - min(time)] AS v FROM rows", "[2 days]"),
        ("SELECT max(time) AS v FROM rows", datetime(2026, 1, 3)),
        ('SELECT count(*) AS "a ""v""" FROM rows;', 6 * POSES + 2),
    ],
)
def test_types_that_polars_has_not(past: Path, sql: str, found: object) -> None:
    frame = open_history(past).query(sql)
    assert frame.row(0) == (found,)


def test_an_error_amid_the_answer_is_one_sentence(past: Path) -> None:
    asked = "SELECT CASE WHEN z_m > 0.5002 THEN CAST(model AS INTEGER) ELSE mode END FROM rows"
    with pytest.raises(InputError, match=r"\(Conversion Error: Could not convert") as refused:
        open_history(past).query(asked)
    assert len(str(refused.value).splitlines()) == 1


MEASURED = """
import resource, sys
from pathlib import Path
import polars as pl
from harness.history.store import append, open_history
from harness.history.command import history
folder, rows = Path(sys.argv[1]), int(sys.argv[2])
table = pl.LazyFrame({"mode": pl.int_range(rows, eager=True)})
append(folder, table.with_columns(frequency_hz=pl.col("mode").sqrt()), "sweep " + 300 * "x")
asked = "SELECT command, count(*) AS n, sum(frequency_hz) FROM rows GROUP BY ALL"
assert open_history(folder).query(asked)["n"].item() == rows
out = folder.parent / "rows.parquet"
history.main(["--history", str(folder), "--export", str(out)], standalone_mode=False)
assert pl.scan_parquet(out).select(pl.len()).collect().item() == rows
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024)
"""


@pytest.mark.slow
def test_memory_does_not_grow_with_a_run(tmp_path: Path) -> None:
    """In memory, four million rows of a command of 300 characters alone are 1.2 GB."""
    peaks = []
    for rows in (1_000_000, 4_000_000):
        ended = subprocess.run(
            [sys.executable, "-c", MEASURED, str(tmp_path / str(rows) / "past"), str(rows)],
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert ended.returncode == 0, ended.stderr
        peaks.append(int(ended.stdout.splitlines()[-1]))
    assert max(peaks) < 1000, f"{peaks} MiB"
