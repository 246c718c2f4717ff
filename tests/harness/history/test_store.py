"""The history of runs: nothing lost, nothing half-read, nothing damaged believed."""

import errno
import multiprocessing
import os
import subprocess
import sys
import time
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import polars as pl
import pytest

from analytic import InputError
from harness.output import OutputError
from harness.history import provenance as origin
from harness.history import run_file, store
from harness.history.provenance import provenance
from harness.history.store import append, open_history

PROCESSES, RUNS, MODES = 3, 8, 6


def some_rows(model: str = "euler-bernoulli@3", count: int = MODES) -> list[dict[str, Any]]:
    return [
        {"case": "case1", "mechanism": "a", "model": model, "mode": i, "frequency_hz": 100.0 * i}
        for i in range(1, count + 1)
    ]


def test_what_is_appended_comes_back(tmp_path: Path) -> None:
    """In the order of time, whatever the order of writing, with what the run ran on."""
    later = append(tmp_path / "new", some_rows("b"), "second", datetime(2026, 2, 1, tzinfo=UTC))
    append(tmp_path / "new", some_rows("a"), "first", datetime(2026, 1, 1, tzinfo=UTC))
    history = open_history(tmp_path / "new")
    assert history.skipped == []
    frame = history.query("SELECT * FROM rows")
    assert frame.schema == store.SCHEMA
    assert frame["command"].to_list() == ["first"] * MODES + ["second"] * MODES
    assert frame["mode"].to_list() == [*range(1, MODES + 1)] * 2
    assert frame["frequency_hz"].to_list() == [100.0 * i for i in range(1, MODES + 1)] * 2
    assert frame["time"][-1] == datetime(2026, 2, 1)
    assert later.name.startswith(str(frame["run"][-1]))
    for name, value in provenance().items():
        assert frame[name].unique().to_list() == [value], name


def test_times_are_utc(tmp_path: Path) -> None:
    """A zone an hour ahead is an hour less, and SQL compares times as they are written."""
    ahead = datetime.fromisoformat("2026-03-01T12:30+01:00")
    append(tmp_path, some_rows(count=1), "table", ahead)
    history = open_history(tmp_path)
    asked = "SELECT time FROM rows WHERE time = $time"
    assert history.query(asked, {"time": "2026-03-01 11:30"})["time"][0] == datetime(
        2026, 3, 1, 11, 30
    )


def test_what_is_not_finite_is_null(tmp_path: Path) -> None:
    row = some_rows(count=1)[0] | {
        "uncertainty_hz": float("nan"),
        "closure_m": float("inf"),
        "assurance": float("-inf"),
        "tilt_rad": None,
    }
    append(tmp_path, [row], "table")
    (found,) = open_history(tmp_path).query("SELECT * FROM rows").to_dicts()
    for name in ("uncertainty_hz", "closure_m", "assurance", "tilt_rad", "solve_s"):
        assert found[name] is None, name
    assert found["frequency_hz"] == 100.0


def test_a_frame_is_appended_as_rows_are(tmp_path: Path) -> None:
    """Whatever the types and the order of its columns; what it has beside COLUMNS is left out."""
    rows = [
        {**row, "uncertainty_hz": value, "commit": commit, "theory": None}
        for row, value, commit in zip(
            some_rows(count=3), (float("nan"), float("inf"), 0.5), ("a", None, "b"), strict=True
        )
    ]
    frame = pl.LazyFrame(rows).with_columns(
        pl.col("mode").cast(pl.UInt8), pl.col("frequency_hz").cast(pl.Float32),
        pl.col("model").cast(pl.Categorical), pose=7, run=pl.lit("mine"), time=pl.lit("now"),
    )  # fmt: skip
    when = datetime(2026, 1, 1, tzinfo=UTC)
    paths = [append(tmp_path, given, "sweep", when) for given in (rows, frame.select(pl.all()))]
    category = pl.selectors.categorical()
    found = [pl.read_parquet(path) for path in paths]
    assert {store.SCHEMA[n] for f in found for n in f.select(category).columns} == {pl.String()}
    first, second = (frame.with_columns(category.cast(pl.String)) for frame in found)
    assert first.schema == second.schema == pl.Schema(store.SCHEMA)
    assert second.drop("run").equals(first.drop("run"))
    assert second["commit"].to_list() == ["a", None, "b"]
    assert second["uncertainty_hz"].to_list() == [None, None, 0.5]
    assert second["machine"].unique().to_list() == [provenance()["machine"]]
    assert [path.name[:29] for path in paths] == [f["run"][0] for f in (first, second)]


def test_constant_columns_cost_next_to_nothing(tmp_path: Path) -> None:
    """The text of a row is 300 characters, the same in every row."""
    frame = pl.LazyFrame({"mode": [1], "frequency_hz": [0.0]}).select(pl.all().repeat_by(300_000))
    path = append(tmp_path, frame.explode("mode", "frequency_hz"), "sweep " + 200 * "x")
    assert pl.scan_parquet(path).select(pl.len()).collect().item() == 300_000
    assert path.stat().st_size < 30_000


def test_no_host_and_no_user_is_kept() -> None:
    import getpass
    import platform

    kept = " ".join(provenance().values()).split()
    assert platform.node() not in kept
    assert getpass.getuser() not in kept


def test_outside_a_checkout_there_is_no_commit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(origin, "ROOT", tmp_path)
    assert origin._commit() == ""
    (tmp_path / ".git").touch()  # looks like one, and is none
    assert origin._commit() == ""


def writer(folder: Path, number: int, go: Any) -> None:
    go.wait()  # for the other writers
    for k in range(RUNS):
        append(folder, some_rows(f"{number}-{k}"), "table")
        time.sleep(0.05)  # time to be read meanwhile


@pytest.mark.slow
def test_processes_append_at_once_while_another_reads(tmp_path: Path) -> None:
    context = multiprocessing.get_context("spawn")
    go = context.Barrier(PROCESSES)
    writers = [context.Process(target=writer, args=(tmp_path, n, go)) for n in range(PROCESSES)]
    for process in writers:
        process.start()
    seen = [0]
    while any(process.is_alive() for process in writers):
        history = open_history(tmp_path)
        assert history.skipped == []
        runs = history.query("SELECT run, count(*) AS n, count(DISTINCT mode) FROM rows GROUP BY 1")
        assert set(runs["n"]) <= {MODES}  # a run is there whole or not at all
        assert runs.height >= seen[-1]  # and stays
        seen.append(runs.height)
    for process in writers:
        process.join()
        assert process.exitcode == 0
    assert len(set(seen)) > 2, "read while they wrote"
    models = open_history(tmp_path).query("SELECT DISTINCT model FROM rows")["model"]
    assert sorted(models) == sorted(f"{n}-{k}" for n in range(PROCESSES) for k in range(RUNS))
    assert len(list(tmp_path.iterdir())) == PROCESSES * RUNS  # no temporary file is left


def test_a_run_is_not_seen_before_it_is_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = []

    def look(_: int) -> None:
        history = open_history(tmp_path)
        seen.append((history.skipped, history.query("SELECT * FROM rows").height))

    monkeypatch.setattr(os, "fsync", look)
    append(tmp_path, some_rows(), "table")
    assert seen == [([], 0)]
    look(0)
    assert seen[-1] == ([], MODES)


def test_a_full_disk_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OutputError, match=r"history = .*cannot write there \(No space left"):
        append(tmp_path, some_rows(), "table")
    assert list(tmp_path.iterdir()) == []


FILLING = """
import resource, signal, sys
from pathlib import Path
import polars as pl
from harness.output import OutputError
from harness.history.store import append
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
frame = pl.LazyFrame({"mode": pl.int_range(100_000, eager=True)})
try:
    append(Path(sys.argv[1]), frame.with_columns(frequency_hz=pl.col("mode").sqrt()), "sweep")
except OutputError as error:
    print(error)
"""


@pytest.mark.slow
def test_a_disk_that_is_full_halfway_leaves_nothing(tmp_path: Path) -> None:
    """A limit that the system sets a file stands for the end of the disk."""
    ended = subprocess.run(
        [sys.executable, "-c", FILLING, str(tmp_path)], capture_output=True, text=True, check=False
    )
    expected = f"history = {str(tmp_path)!r}: cannot write there (File too large)\n"
    assert (ended.stdout, ended.stderr) == (expected, "")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_not_there_is_empty(tmp_path: Path) -> None:
    history = open_history(tmp_path / "absent")
    assert history.query("SELECT * FROM rows").schema == store.SCHEMA
    assert not (tmp_path / "absent").exists()
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match=r"history = .*file': expected a folder"):
        open_history(tmp_path / "file")


def test_a_file_that_is_removed_meanwhile(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    append(tmp_path, some_rows(), "table")
    read = run_file.read

    def removing(path: Path) -> run_file.RunFile:
        found = read(path)
        path.unlink()
        return found

    monkeypatch.setattr(run_file, "read", removing)
    with pytest.raises(InputError, match=r"history = .*files that stay while read"):
        open_history(tmp_path)


def test_names_that_look_like_patterns(tmp_path: Path) -> None:
    folder = tmp_path / "h[1]*?"
    append(folder, some_rows(), "table")
    assert open_history(folder).query("SELECT count(*) FROM rows").item() == MODES


@pytest.mark.parametrize(
    ("sql", "why"),
    [
        ("DROP TABLE rows", "one SELECT over the table rows"),
        ("DELETE FROM rows", "one SELECT"),
        ("UPDATE rows SET mode = 1", "one SELECT"),
        ("SELECT 1; DROP TABLE rows", "one SELECT"),
        ("COPY rows TO 'stolen.csv'", "one SELECT"),
        ("ATTACH 'other.db'", "one SELECT"),
        ("", "one SELECT"),
        ("SELEC mode FROM rows", "syntax error"),
        ("SELECT colour FROM rows", "colour"),
        ("SELECT 1 AS a, 2 AS a", "one SELECT"),
        ("SELECT mode FROM rows WHERE model = $who", "one SELECT"),
        (f"SELECT * FROM read_text('{__file__}')", "disabled by configuration"),
        (f"SELECT * FROM '{__file__}'", "does not exist"),
    ],
)
def test_a_query_only_reads_the_rows(tmp_path: Path, sql: str, why: str) -> None:
    append(tmp_path, some_rows(), "table")
    history = open_history(tmp_path)
    with pytest.raises(InputError, match=why) as refused:
        history.query(sql)
    assert len(str(refused.value).splitlines()) == 1
    assert history.query("SELECT count(*) FROM rows").item() == MODES


def test_columns_keep_their_type_where_nothing_is_found(tmp_path: Path) -> None:
    frame = open_history(tmp_path).query("SELECT time, model, mode, frequency_hz FROM rows")
    assert frame.schema == {
        name: store.SCHEMA[name] for name in ("time", "model", "mode", "frequency_hz")
    }


@pytest.mark.slow
def test_a_hundred_thousand_rows(tmp_path: Path) -> None:
    """500 runs of 200 rows: all there, none skipped, and every run its own."""
    start = datetime(2026, 1, 1, tzinfo=UTC)
    for k in range(500):
        append(tmp_path, some_rows(count=200), "table", start + timedelta(hours=k))
    history = open_history(tmp_path)
    assert history.skipped == []
    runs = history.query("SELECT run, count(*) AS n FROM rows GROUP BY run")
    assert runs.height == 500
    assert set(runs["n"]) == {200}
