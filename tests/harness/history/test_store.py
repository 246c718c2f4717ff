"""The history of runs: nothing lost, nothing half-read, nothing damaged believed."""

import errno
import multiprocessing
import os
import subprocess
import sys
import time
from datetime import UTC, datetime, timedelta
from pathlib import Path
from shutil import which
from typing import Any

import numpy as np
import pytest

from analytic import InputError
from harness.history.duck import connect
from harness.history.provenance import ROOT, provenance
from harness.history.store import COLUMNS, append, append_table, open_history
from harness.output import OutputError

PROCESSES, RUNS, MODES = 3, 8, 6


def some_rows(model: str = "euler-bernoulli@3", count: int = MODES) -> list[dict[str, Any]]:
    return [
        {"case": "case1", "mechanism": "a", "model": model, "mode": i, "frequency_hz": 100.0 * i}
        for i in range(1, count + 1)
    ]


def count(folder: Path) -> int:
    return len(open_history(folder).query("SELECT mode FROM rows"))


def types(folder: Path, sql: str = "FROM rows") -> dict[str, str]:
    rows = open_history(folder).query(f"SELECT * FROM (DESCRIBE {sql})").rows()
    return {row["column_name"]: row["column_type"] for row in rows}


def test_what_is_appended_comes_back(tmp_path: Path) -> None:
    """In the order of time, whatever the order of writing, with what the run ran on."""
    later = append(tmp_path / "new", some_rows("b"), "second", datetime(2026, 2, 1, tzinfo=UTC))
    append(tmp_path / "new", some_rows("a"), "it's first", datetime(2026, 1, 1, tzinfo=UTC))
    history = open_history(tmp_path / "new")
    assert history.skipped == []
    assert types(tmp_path / "new") == COLUMNS
    frame = history.query("SELECT * FROM rows").to_frame()
    assert [*frame["command"]] == ["it's first"] * MODES + ["second"] * MODES
    assert [*frame["mode"]] == [*range(1, MODES + 1)] * 2
    assert [*frame["frequency_hz"]] == [100.0 * i for i in range(1, MODES + 1)] * 2
    assert frame["time"].iloc[-1] == datetime(2026, 2, 1)
    assert later.name.startswith(frame["run"].iloc[-1])
    for name, value in provenance().items():
        assert set(frame[name]) == {value}, name


def test_times_are_utc(tmp_path: Path) -> None:
    """A zone an hour ahead is an hour less, and SQL compares times as they are written."""
    ahead = datetime.fromisoformat("2026-03-01T12:30+01:00")
    append(tmp_path, some_rows(count=1), "table", ahead)
    asked = "SELECT time FROM rows WHERE time = $time"
    found = open_history(tmp_path).query(asked, {"time": "2026-03-01 11:30"})
    assert found.rows() == [{"time": datetime(2026, 3, 1, 11, 30)}]


LAST_HOUR = """
import sys
from pathlib import Path
from harness.history.store import append, open_history
append(Path(sys.argv[1]), [{"mode": 1}], "table")
asked = "SELECT time, now() AS now FROM rows WHERE time BETWEEN now() - INTERVAL 1 HOUR AND now()"
print(len(open_history(Path(sys.argv[1])).query(asked)))
"""


@pytest.mark.parametrize("zone", ["Asia/Tokyo", "America/Los_Angeles"])
def test_now_is_utc_wherever_the_machine_is(tmp_path: Path, zone: str) -> None:
    ended = subprocess.run(
        [sys.executable, "-c", LAST_HOUR, str(tmp_path)],
        capture_output=True, text=True, check=True, env={**os.environ, "TZ": zone},
    )  # fmt: skip
    assert ended.stdout == "1\n"


def test_what_is_not_finite_is_null(tmp_path: Path) -> None:
    row = some_rows(count=1)[0] | {
        "uncertainty_hz": float("nan"),
        "closure_m": float("inf"),
        "assurance": float("-inf"),
        "tilt_rad": None,
    }
    append(tmp_path, [row], "table")
    (found,) = open_history(tmp_path).query("SELECT * FROM rows").rows()
    for name in ("uncertainty_hz", "closure_m", "assurance", "tilt_rad", "solve_s"):
        assert found[name] is None, name
    assert found["frequency_hz"] == 100.0


def test_a_table_is_appended_as_rows_are(tmp_path: Path) -> None:
    """Whatever the types and the order of its columns; what it has beside COLUMNS is left out."""
    rows = [
        {**row, "uncertainty_hz": value, "commit": commit, "theory": None}
        for row, value, commit in zip(
            some_rows(count=3), (float("nan"), float("inf"), 0.5), ("a", None, "b"), strict=True
        )
    ]
    when = datetime(2026, 1, 1, tzinfo=UTC)
    append(tmp_path / "rows", rows, "sweep", when)
    with connect() as base:
        columns = {name: np.array([row[name] for row in rows], dtype=object) for name in rows[0]}
        base.register("given", columns)
        base.execute(
            "CREATE TABLE mine AS SELECT * REPLACE (mode::UTINYINT AS mode), 7 AS pose, "
            "'mine' AS run, 'now' AS time FROM given"
        )
        append_table(tmp_path / "table", base, "mine", "sweep", when)
    first, second = (
        open_history(tmp_path / name).query("SELECT * EXCLUDE run FROM rows").rows()
        for name in ("rows", "table")
    )
    assert first == second
    assert [row["commit"] for row in second] == ["a", None, "b"]
    assert [row["uncertainty_hz"] for row in second] == [None, None, 0.5]
    assert {row["machine"] for row in second} == {provenance()["machine"]}
    assert types(tmp_path / "rows") == types(tmp_path / "table") == COLUMNS


def test_constant_columns_cost_next_to_nothing(tmp_path: Path) -> None:
    """The text of a row is 300 characters, the same in every row."""
    with connect() as base:
        base.execute("CREATE TABLE t AS SELECT 1 AS mode, 0.0 AS frequency_hz FROM range(300000)")
        path = append_table(tmp_path, base, "t", "sweep " + 200 * "x")
    assert count(tmp_path) == 300_000
    assert path.stat().st_size < 60_000


def test_no_host_and_no_user_is_kept() -> None:
    import getpass
    import platform

    kept = " ".join(provenance().values()).split()
    assert platform.node() not in kept
    assert getpass.getuser() not in kept


COMMIT = "from harness.history.provenance import provenance; print(provenance()['commit'])"


@pytest.mark.skipif(not (ROOT / ".git").exists() or not which("git"), reason="no checkout, no git")
def test_a_hook_of_another_repository_does_not_change_the_commit(tmp_path: Path) -> None:
    """Git tells a hook's programs by GIT_DIR which repository they are called for."""
    for command in (["init", "-q"], ["commit", "-q", "--allow-empty", "-m", "other"]):
        who = ["-c", "user.name=a", "-c", "user.email=a@b"]
        subprocess.run(["git", "-C", str(tmp_path), *who, *command], check=True)
    found = [
        subprocess.run(
            [sys.executable, "-c", COMMIT], capture_output=True, text=True, check=True, cwd=ROOT,
            env={**os.environ, **more},
        ).stdout
        for more in ({}, {"GIT_DIR": str(tmp_path / ".git"), "GIT_WORK_TREE": str(tmp_path)})
    ]  # fmt: skip
    assert found[0] == found[1] != "\n"


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
        sizes = [row["n"] for row in runs.rows()]
        assert set(sizes) <= {MODES}  # a run is there whole or not at all
        assert len(sizes) >= seen[-1]  # and stays
        seen.append(len(sizes))
    for process in writers:
        process.join()
        assert process.exitcode == 0
    assert len(set(seen)) > 2, "read while they wrote"
    models = open_history(tmp_path).query("SELECT DISTINCT model FROM rows ORDER BY 1").rows()
    wanted = sorted(f"{n}-{k}" for n in range(PROCESSES) for k in range(RUNS))
    assert [row["model"] for row in models] == wanted
    assert len(list(tmp_path.iterdir())) == PROCESSES * RUNS  # no temporary file is left


def test_a_run_is_not_seen_before_it_is_whole(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen = []

    def look(_: int) -> None:
        seen.append((open_history(tmp_path).skipped, count(tmp_path)))

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
from harness.history.duck import connect
from harness.history.store import append_table
from harness.output import OutputError
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
base = connect()
base.execute("CREATE VIEW t AS SELECT i AS mode, sqrt(i) AS frequency_hz FROM range(100000) t(i)")
try:
    append_table(Path(sys.argv[1]), base, "t", "sweep")
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
    assert count(tmp_path / "absent") == 0
    assert types(tmp_path / "absent") == COLUMNS
    assert not (tmp_path / "absent").exists()
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match=r"history = .*file': expected a folder"):
        open_history(tmp_path / "file")


def test_names_that_look_like_patterns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for folder in (Path("h[1]*?"), Path("it's {a,b} %20")):
        append(folder, some_rows(), "sweep")
        assert count(folder) == MODES


SECRET = "it is a secret"


@pytest.mark.parametrize(
    "sql",
    [
        "",
        "SELEC mode FROM rows",
        "SELECT colour FROM rows",
        "SELECT 1 AS a, 2 AS a",
        "SELECT mode FROM rows WHERE model = $who",
        "SELECT 1; DROP TABLE rows",
        "DROP TABLE rows",
        "DELETE FROM rows",
        "ATTACH 'other.db'",
        "SELECT * FROM read_text('{past}/secret.txt')",
        "SELECT * FROM '{past}/secret.txt'",
        "SELECT * FROM read_parquet('{past}/*.parquet')",
        "SELECT * FROM '{run}/../secret.txt'",
        "SELECT * FROM glob('{past}/*')",
        "SELECT * FROM query('COPY rows TO ''{run}''')",
        "COPY rows TO '{run}' (FORMAT parquet)",
        "COPY rows TO '{past}/new.parquet'",
        "INSERT INTO rows SELECT * FROM rows",
        "CREATE OR REPLACE VIEW rows AS SELECT 1",
        "SET allowed_paths = ['{past}/secret.txt']",
        "RESET allowed_paths",
        "SELECT set_config('allowed_paths', '{past}', false)",
    ],
)
def test_a_query_only_reads_the_rows(tmp_path: Path, sql: str) -> None:
    run = append(tmp_path, some_rows(), "table")
    (tmp_path / "secret.txt").write_text(SECRET)
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    history = open_history(tmp_path)
    with pytest.raises(InputError, match="one SELECT over the table rows") as refused:
        history.query(sql.format(past=tmp_path, run=run)).rows()
    assert len(str(refused.value).splitlines()) == 1
    assert SECRET not in str(refused.value)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before
    assert len(history.query("SELECT mode FROM rows")) == MODES


@pytest.mark.parametrize(
    ("sql", "found"),
    [
        ("SELECT sum(mode) AS v FROM rows", 21),
        ("SELECT INTERVAL 2 DAY AS v", "2 days"),
        ("SELECT [INTERVAL 2 DAY] AS v", "[2 days]"),
        ("SELECT max(time) AS v FROM rows", datetime(2026, 1, 3)),
        ("SELECT TIMESTAMPTZ '2026-01-01 01:00:00+01' AS v", datetime(2026, 1, 1)),
        ('SELECT count(*) AS "a ""v""" FROM rows;', 6),
    ],
)
def test_types_that_frames_have_not(tmp_path: Path, sql: str, found: object) -> None:
    append(tmp_path, some_rows(), "table", datetime(2026, 1, 3, tzinfo=UTC))
    answer = open_history(tmp_path).query(sql)
    assert [*answer.rows()[0].values()] == [found]
    assert answer.to_frame().iloc[0, 0] == found


def test_only_the_first_rows_are_fetched(tmp_path: Path) -> None:
    append(tmp_path, some_rows(), "table")
    asked = "SELECT mode FROM rows WHERE mode <= $most ORDER BY mode DESC"
    answer = open_history(tmp_path).query(asked, {"most": 5})
    assert [row["mode"] for row in answer.rows(3)] == [5, 4, 3]
    assert len(answer) == 5


def test_an_error_amid_the_answer_is_one_sentence(tmp_path: Path) -> None:
    append(tmp_path, some_rows(), "table")
    asked = "SELECT CASE WHEN mode > 4 THEN CAST(model AS INTEGER) ELSE mode END AS v FROM rows"
    answer = open_history(tmp_path).query(asked)
    with pytest.raises(InputError, match=r"\(Conversion Error: Could not convert") as refused:
        answer.to_frame()
    assert len(str(refused.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("sql", "suffix", "said"),
    [
        ("SELECT 'a'::BLOB AS v", ".json", "only Parquet holds bytes"),
        ("SELECT ['a'::BLOB] AS v", ".csv", "only Parquet holds bytes"),
        ("SELECT [1] AS v", ".csv", "CSV has no lists"),
        ("SELECT {'a': 1} AS v", ".csv", "CSV has no lists"),
    ],
)
def test_what_a_form_cannot_hold_is_said(tmp_path: Path, sql: str, suffix: str, said: str) -> None:
    target = tmp_path / f"out{suffix}"
    with pytest.raises(InputError, match=said):
        open_history(tmp_path / "past").query(sql).write(target)
    assert list(tmp_path.iterdir()) == []
    target = tmp_path / "out.parquet"
    assert open_history(tmp_path / "past").query(sql).write(target) == 1


@pytest.mark.slow
def test_a_hundred_thousand_rows(tmp_path: Path) -> None:
    """500 runs of 200 rows: all there, none skipped, and every run its own."""
    start = datetime(2026, 1, 1, tzinfo=UTC)
    for k in range(500):
        append(tmp_path, some_rows(count=200), "table", start + timedelta(hours=k))
    history = open_history(tmp_path)
    assert history.skipped == []
    runs = history.query("SELECT run, count(*) AS n FROM rows GROUP BY run").rows()
    assert len(runs) == 500
    assert {row["n"] for row in runs} == {200}
