"""The history of runs: nothing lost, nothing half-read, nothing damaged believed."""

import errno
import multiprocessing
import os
import random
import subprocess
import sys
import time
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import polars as pl
import pytest

from analytic import InputError
from harness.files import OutputError
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


def test_a_full_disk_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OutputError, match=r"--history = .*cannot write there \(No space left"):
        append(tmp_path, some_rows(), "table")
    assert list(tmp_path.iterdir()) == []


FILLING = """
import resource, signal, sys
from pathlib import Path
import polars as pl
from harness.files import OutputError
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
    expected = f"--history = {str(tmp_path)!r}: cannot write there (File too large)\n"
    assert (ended.stdout, ended.stderr) == (expected, "")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_not_there_is_empty(tmp_path: Path) -> None:
    history = open_history(tmp_path / "absent")
    assert history.query("SELECT * FROM rows").schema == store.SCHEMA
    assert not (tmp_path / "absent").exists()
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match=r"--history = .*file': expected a folder"):
        open_history(tmp_path / "file")


def test_a_file_that_is_removed_meanwhile(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    append(tmp_path, some_rows(), "table")
    read = run_file.read

    def removing(path: Path) -> run_file.RunFile:
        found = read(path)
        path.unlink()
        return found

    monkeypatch.setattr(run_file, "read", removing)
    with pytest.raises(InputError, match=r"--history = .*files that stay while read"):
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
