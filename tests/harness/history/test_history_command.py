"""`rps-bench history`, and what the commands leave in it."""

import errno
import json
import os
import subprocess
import sys
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from harness.history.duck import connect
from harness.history.store import append, open_history

Bench = Callable[..., Any]


@pytest.fixture
def past(tmp_path: Path) -> Path:
    """Two runs of two models at two cases."""
    folder = tmp_path / "past"
    for day, command in ((1, "rps-bench table"), (2, "rps-bench refine --modes 1-2")):
        rows = [
            {
                "case": case, "model": model, "mode": mode, "version": "exudyn 1",
                "frequency_hz": 100.0 * mode + day,
            }
            for case in ("case1", "case2")
            for model in ("exudyn-cable@4", "exudyn-cable@8", "exudyn-beam@4")
            for mode in (1, 2)
        ]  # fmt: skip
        append(folder, rows, command, datetime(2026, 1, day, 12, tzinfo=UTC))
    return folder


def exported(bench: Bench, past: Path, *arguments: str) -> pd.DataFrame:
    file = past.parent / "out" / "rows.parquet"
    answer = bench("history", "--history", str(past), "--export", str(file), *arguments)
    assert answer.status == 0
    with connect() as base:
        rows = base.execute(f"FROM '{file}'").df()
    assert answer.out == f"wrote {file}: {len(rows)} rows\n"
    return rows


@pytest.mark.parametrize(
    ("filters", "count"),
    [
        ([], 24),
        (["--model", "exudyn-cable"], 16),
        (["--model", "exudyn-cable@8,exudyn-beam"], 16),
        (["--model", "exudyn"], 0),
        (["--case", "case2"], 12),
        (["--mode", "2"], 12),
        (["--mode", "1-2", "--case", "case1,case2"], 24),
        (["--run", "20260102"], 12),
        (["--run", "latest", "--model", "exudyn-beam"], 4),
        (["--since", "2026-01-02"], 12),
        (["--since", "2026-01-01T12:00"], 24),
        (["--since", "2026-01-01T12:00+00:00"], 24),
        (["--since", "2026-01-01T12:00-01:00"], 12),
        (["--command", "refine"], 12),
        (["--command", "refine,table"], 24),
        (["--command", "ref"], 0),
    ],
)
def test_filters(rps_bench: Bench, past: Path, filters: list[str], count: int) -> None:
    frame = exported(rps_bench, past, *filters)
    assert len(frame) == count
    if "latest" in filters:
        assert set(frame["time"].dt.day) == {2}


def test_runs_are_listed(rps_bench: Bench, past: Path) -> None:
    answer = rps_bench("history", "--history", str(past))
    assert answer.status == 0
    first, second = [line for line in answer.out.splitlines() if "2026-01-0" in line]
    assert "2026-01-01 12:00:00   table " in first
    assert "   refine --modes 1-2 " in second
    for line in (first, second):
        assert " 12 " in line
        assert ", exudyn 1" in line


def test_rows_and_sql(rps_bench: Bench, past: Path) -> None:
    answer = rps_bench(
        "history", "--history", str(past), "--rows", "--mode", "2", "--run", "latest"
    )
    assert answer.out.count("202.000") == 6
    asked = "SELECT mode, max(frequency_hz) AS top FROM rows GROUP BY mode ORDER BY mode"
    answer = rps_bench("history", "--history", str(past), "--sql", asked)
    assert [line.split() for line in answer.out.splitlines() if "2.000" in line] == [
        ["1", "102.000"],
        ["2", "202.000"],
    ]


@pytest.mark.parametrize("form", ["csv", "json", "parquet"])
def test_exports_agree(rps_bench: Bench, past: Path, tmp_path: Path, form: str) -> None:
    file = tmp_path / f"rows.{form}"
    asked = "SELECT run, mode, frequency_hz FROM rows ORDER BY ALL"
    rps_bench("history", "--history", str(past), "--sql", asked, "--export", str(file))
    with connect() as base:
        found = base.execute(f"FROM '{file}'").fetchall()
    expected = [tuple(row.values()) for row in open_history(past).query(asked).rows()]
    assert found == expected and len({row[2] for row in found}) == 4
    if form == "json":
        assert [tuple(row.values()) for row in json.loads(file.read_text())] == expected


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--mode", "0"], "--mode = '0': expected whole numbers"),
        (["--model", "a,,b"], "--model = 'a,,b': expected names"),
        (["--since", "soon"], "--since = 'soon': expected a date as in 2026-01-31"),
        (["--history", "none"], "--history = 'none': expected a folder to read runs from"),
        (["--sql", "DROP TABLE rows"], "--sql = 'DROP TABLE rows': expected one SELECT"),
        (["--sql", "", "--export", "rows.csv"], "--sql = '': expected one SELECT"),
        (["--sql", "SELECT 1", "--mode", "1"], "--sql = 'SELECT 1': expected no filter beside it"),
        (["--sql", "SELECT 1", "--rows"], "--sql = 'SELECT 1': expected no filter beside it"),
        (["--export", "rows.xls"], "--export = 'rows.xls': expected a file that ends in one of"),
        (["--sql", "SELECT [mode] FROM rows", "--export", "rows.csv"], "--export = 'rows.csv'"),
    ],
    ids=" ".join,
)
def test_bad_input(
    rps_bench: Bench, past: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], said: str
) -> None:
    monkeypatch.chdir(past.parent)
    answer = rps_bench("history", "--history", str(past), *arguments)
    assert answer.status == 2
    assert answer.out == ""
    (line,) = answer.err.splitlines()
    assert line.startswith(f"rps-bench: {said}")
    assert [path.name for path in past.parent.iterdir()] == ["past"]


@pytest.mark.slow
def test_a_process_ends_in_silence(past: Path) -> None:
    """Nothing on the error stream: duckdb complains of what is not collected before the end."""
    command = [sys.executable, "-c", "from harness.cli.main import main; main()"]
    ended = subprocess.run(
        [*command, "history", "--history", str(past)], capture_output=True, text=True, check=False
    )
    assert (ended.returncode, ended.stderr) == (0, "")
    assert "refine --modes 1-2" in ended.stdout


def test_skipped_files_are_named(rps_bench: Bench, past: Path, tmp_path: Path) -> None:
    broken = sorted(past.iterdir())[0]
    broken.write_bytes(b"")
    (past / "table.parquet").write_text("a,b\n1,2\n")
    shown = rps_bench("history", "--history", str(past))
    written = rps_bench("history", "--history", str(past), "--export", str(tmp_path / "rows.csv"))
    for text in (" ".join(shown.out.split()), written.err):
        assert f"skipped {broken}: damaged: 0 bytes" in text
        assert f"skipped {past / 'table.parquet'}: not written by rps-bench" in text
    assert written.out.endswith(": 12 rows\n")
    assert broken.exists()


def test_nothing_yet(rps_bench: Bench, tmp_path: Path) -> None:
    for more in ([], ["--rows"]):
        answer = rps_bench("history", "--history", str(tmp_path / "absent"), *more)
        assert answer.status == 0
        assert "found in" in answer.out
    assert not (tmp_path / "absent").exists()


def test_the_environment_names_the_history(
    rps_bench: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    asked = ["table", "--references", "rayleigh@1", "--cases", "case1"]
    rps_bench(*asked)
    assert list(tmp_path.iterdir()) == []  # the tests' own default is none
    monkeypatch.setenv("RPS_BENCH_HISTORY", "named")
    rps_bench(*asked, "--history", "none")
    assert list(tmp_path.iterdir()) == []
    rps_bench(*asked)
    assert len(open_history(tmp_path / "named").query("SELECT mode FROM rows")) > 0
    monkeypatch.delenv("RPS_BENCH_HISTORY")
    rps_bench(*asked)
    assert len(open_history(tmp_path / "history").query("SELECT mode FROM rows")) > 0


def test_a_history_that_cannot_be_written_costs_nothing_else(
    rps_bench: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The results are written and shown; one sentence says what is not kept."""
    real, synced = os.fsync, []

    def full(handle: int) -> None:
        synced.append(handle)
        if "past" in str(Path(f"/proc/self/fd/{handle}").readlink()):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        real(handle)

    monkeypatch.setattr(os, "fsync", full)
    out, past = tmp_path / "out", tmp_path / "past"
    answer = rps_bench(
        "table", "--references", "rayleigh@1",
        "--output", str(out), "--history", str(past),
    )  # fmt: skip
    assert answer.status == 2
    assert answer.err == (
        f"rps-bench: --history = {str(past)!r}: cannot write there (No space left on device)\n"
    )
    assert (out / "table1.csv").exists()
    assert list(past.iterdir()) == []
    assert len(synced) > 1
