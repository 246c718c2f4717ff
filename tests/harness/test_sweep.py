"""`rps-bench sweep`: rows, resuming, other machines, and what goes wrong with disks."""

import json
import os
import re
import signal
import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import psutil
import pytest

from analytic import Continuum, Mechanism, Substructure
from harness.jobs import BATCH
from harness.pose_sets import pose_set

COMMAND = [sys.executable, "-c", "from harness.cli import main; main()", "sweep"]
SLOWLY = ("--models", "trial@2", "--poses", "random:150:3", "--modes", "1-4")


def started(*arguments: str, before: str = "") -> subprocess.Popen[str]:
    """Start a sweep as a process of its own."""
    command = [*COMMAND, *arguments]
    if before:
        command[2] = f"{before}; {command[2]}"
    pipe = subprocess.PIPE
    return subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True)


def ended(process: subprocess.Popen[str]) -> tuple[int, str, str]:
    out, err = process.communicate(timeout=120)
    return process.returncode, out, err


def journalled(folder: Path) -> int:
    """How many jobs are in the journal of a process that has ended."""
    base = sqlite3.connect(folder / "journal.sqlite")
    (count,) = base.execute("SELECT count(*) FROM jobs").fetchone()
    base.close()
    return int(count)


def wait_for(log: Path, lines: int) -> None:
    """Wait until the model `trial` has been solved so many times."""
    deadline = time.monotonic() + 60
    while not log.exists() or log.read_text().count("\n") < lines:
        assert time.monotonic() < deadline
        time.sleep(0.01)


def assert_complete(folder: Path, poses: int, modes: int) -> pl.DataFrame:
    rows = pl.read_parquet(folder / "frequencies.parquet")
    assert len(rows) == poses * modes
    assert len(rows.unique(["model", "pose", "mode"])) == poses * modes
    assert not [path.name for path in folder.iterdir() if path.name.startswith(".")]
    return rows


@pytest.fixture
def log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("TRIAL_LOG", str(tmp_path / "log"))
    return tmp_path / "log"


def test_rows_hold_what_the_models_say(
    rps_bench: Callable[..., Any], tmp_path: Path, robot: Mechanism
) -> None:
    """A row a pose, model and mode, in order, with the frequencies of the one-pose models."""
    models = "timoshenko@exact,euler-bernoulli@3"
    given = ("--poses", "random:40:2", "--models", models, "--against", "timoshenko@exact")
    answer = rps_bench("sweep", *given, "--modes", "2-4", "--output", str(tmp_path))
    assert answer.status == 0, answer.err
    rows = assert_complete(tmp_path, 2 * 40, 3)
    poses = pose_set("random:40:2", robot)
    assert rows["pose"].to_list() == 2 * [i for i in range(1, 41) for _ in range(3)]
    assert rows["mode"].to_list() == 80 * [2, 3, 4]
    np.testing.assert_array_equal(rows["tilt_rad"].to_numpy()[: 3 * 40 : 3], poses.tilt)
    found = rows["frequency_hz"].to_numpy().reshape(2, 40, 3)
    models_alone = (Continuum("timoshenko"), Substructure(3))
    for k, model in enumerate(models_alone):
        for i in (0, 17, 39):
            alone = model.modes(robot, poses[i], 4).frequencies[1:]
            np.testing.assert_allclose(found[k, i], alone, rtol=1e-9)

    errors = pl.read_parquet(tmp_path / "errors.parquet")
    expected = 100 * (found[1] / found[0] - 1)
    np.testing.assert_array_equal(errors["error_percent"].to_numpy(), expected.ravel())
    table = pl.read_csv(tmp_path / "errors.csv")
    for column, values in (
        ("Largest (%)", np.abs(expected).max(axis=0)),
        ("rms (%)", np.sqrt((expected**2).mean(axis=0))),
        ("Mean (%)", expected.mean(axis=0)),
    ):
        np.testing.assert_allclose(table[column].to_numpy(), values, rtol=1e-12)


def test_a_worst_pose_is_seen_again_by_the_command_printed(
    rps_bench: Callable[..., Any], tmp_path: Path
) -> None:
    given = ("--poses", "random:30:4", "--models", "euler-bernoulli@3", "--modes", "1-3")
    output = tmp_path / "first"
    first = rps_bench(
        "sweep", *given, "--against", "timoshenko@exact", "--shear", "0.9", "--output", str(output)
    )
    commands = [line.split() for line in re.findall(r"rps-bench (sweep .*--shear 0\.9)", first.out)]
    worst = pl.read_csv(output / "worst.csv")
    assert len(commands) == len(set(worst["Pose"]))
    again = tmp_path / "again"
    for command in commands:
        assert rps_bench(*command, "--output", str(again)).status == 0
        rows = pl.read_csv(again / "errors.csv").join(worst, on=["Model", "Mode"])
        close = np.abs(rows["Mean (%)"].to_numpy() / rows["Error (%)"].to_numpy() - 1) < 1e-9
        assert close.any()
    by_shape = worst["Error (%)"].to_numpy() - worst["By shape (%)"].to_numpy()
    assert np.abs(by_shape).max() < 1e-7


def test_a_simulator_that_misses_a_mode_is_found_out(
    rps_bench: Callable[..., Any], tmp_path: Path, plugin: None
) -> None:
    """The third of six is missing at two poses: there the number of modes is wrong from f3 on."""
    poses = tmp_path / "poses.csv"
    poses.write_text("z_mm,azimuth_deg,tilt_deg\n400,10,5\n410,20,-6\n420,30,7\n430,40,-8\n")
    given = ("--poses", str(poses), "--models", "trial@9", "--against", "euler-bernoulli@exact")
    answer = rps_bench("sweep", *given, "--output", str(tmp_path))
    assert answer.status == 0, answer.err
    table = pl.read_csv(tmp_path / "errors.csv")
    assert table["Miscounted"].to_list() == ["0 of 4"] * 2 + ["2 of 4"] * 4
    assert "trial@9: poses with a wrong mode count: 2 of 4: 2, 4" in answer.out


@pytest.mark.slow
def test_the_same_again_computes_nothing_and_more_only_what_is_missing(
    rps_bench: Callable[..., Any], tmp_path: Path, log: Path, plugin: None
) -> None:
    given = ("sweep", "--models", "trial@1", "--output", str(tmp_path / "out"))
    assert rps_bench(*given, "--poses", "random:20:1").status == 0
    first = (tmp_path / "out" / "frequencies.parquet").read_bytes()
    dry = rps_bench(*given, "--poses", "random:25:1", "--dry-run")
    assert re.search(r"trial@1\s+25\s+20\s+5\s", dry.out)
    log.unlink()
    assert rps_bench(*given, "--poses", "random:20:1").status == 0
    assert not log.exists()
    assert (tmp_path / "out" / "frequencies.parquet").read_bytes() == first
    assert rps_bench(*given, "--poses", "random:25:1").status == 0
    assert log.read_text().count("\n") == 5
    assert_complete(tmp_path / "out", 25, 6)


@pytest.mark.slow
def test_failures_are_listed_by_reason_with_status_1(
    rps_bench: Callable[..., Any], tmp_path: Path, plugin: None
) -> None:
    poses = tmp_path / "poses.csv"
    poses.write_text("z_mm,azimuth_deg,tilt_deg\n400,0,1\n410,0,-1\n420,0,1\n430,0,-1\n")
    given = ("--poses", str(poses), "--models", "trial@1,trial@5", "--output", str(tmp_path))
    answer = rps_bench("sweep", *given, "--against", "euler-bernoulli@exact", "--modes", "1-2")
    assert answer.status == 1
    table = pl.read_csv(tmp_path / "failures.csv")
    assert table.rows() == [("trial@5", 2, "2, 4", "trial: will not")]
    assert "trial: will not" in answer.out
    rows = pl.read_parquet(tmp_path / "frequencies.parquet")
    assert rows.filter(model="trial@5")["pose"].unique().to_list() == [1, 3]
    assert rows["model"].value_counts().sort("model")["count"].to_list() == [8, 8, 4]


def test_a_dry_run_leaves_nothing_behind(rps_bench: Callable[..., Any], tmp_path: Path) -> None:
    output = tmp_path / "out"
    given = ("--poses", f"random:{BATCH + 1}", "--models", "rayleigh@2", "--dry-run")
    answer = rps_bench("sweep", *given, "--output", str(output))
    assert answer.status == 0
    assert re.search(r"rayleigh@2\s+2\s+0\s+2\s+[\d.]+\s+[\d.e-]+ s", answer.out)
    assert not output.exists()


def test_a_damaged_journal_is_one_sentence(rps_bench: Callable[..., Any], tmp_path: Path) -> None:
    given = ("sweep", "--poses", "random:9", "--models", "rayleigh@1", "--output", str(tmp_path))
    assert rps_bench(*given).status == 0
    journal = tmp_path / "journal.sqlite"
    whole = journal.read_bytes()
    at = whole.index(b"Rayleigh")
    damages = (b"not a journal" * 1000, whole[:at] + b"rayleigH" + whole[at + 8 :], whole[:5000])
    for content in damages:
        journal.write_bytes(content)
        answer = rps_bench(*given)
        assert answer.status == 2
        assert "journal.sqlite is damaged" in answer.err
        assert len(answer.err.splitlines()) == 1
        assert journal.read_bytes() == content


@pytest.mark.slow
def test_a_second_sweep_into_the_same_folder_is_refused(
    tmp_path: Path, log: Path, plugin: None
) -> None:
    output = tmp_path / "out"
    first = started(*SLOWLY, "--output", str(output))
    wait_for(log, 1)
    first.send_signal(signal.SIGSTOP)  # so that it does not end before the second begins
    status, _, err = ended(started(*SLOWLY, "--output", str(output)))
    first.send_signal(signal.SIGCONT)
    assert status == 2
    assert "another sweep is running into this folder" in err
    assert ended(first)[0] == 0
    assert_complete(output, 150, 4)


@pytest.mark.slow
@pytest.mark.parametrize("ending", [signal.SIGKILL, signal.SIGINT])
def test_an_ended_parent_loses_no_finished_job(
    ending: signal.Signals, tmp_path: Path, log: Path, plugin: None
) -> None:
    output = tmp_path / "out"
    first = started(*SLOWLY, "--output", str(output))
    wait_for(log, 40)
    children = psutil.Process(first.pid).children()
    os.kill(first.pid, ending)
    status, _, err = ended(first)
    assert status == (-ending if ending == signal.SIGKILL else 130), err
    assert "Traceback" not in err
    psutil.wait_procs(children, timeout=10)
    assert not any(child.is_running() for child in children)
    solved = log.read_text().count("\n")
    kept = journalled(output)
    assert solved - 4 <= kept < 150  # but for those under way, or just answered
    assert not (output / "frequencies.parquet").exists()
    log.unlink()
    assert ended(started(*SLOWLY, "--output", str(output)))[0] == 0
    assert log.read_text().count("\n") == 150 - kept
    rows = assert_complete(output, 150, 4)
    expected = 100 * rows["z_m"] * rows["mode"] + rows["azimuth_rad"].sin()
    np.testing.assert_allclose(rows["frequency_hz"], expected, rtol=1e-14)


@pytest.mark.slow
def test_workers_killed_at_random_leave_every_row_once(
    tmp_path: Path, log: Path, plugin: None
) -> None:
    output = tmp_path / "out"
    process = started(*SLOWLY, "--tries", "10", "--output", str(output))
    random = np.random.default_rng(1)
    for lines in range(10, 140, 20):
        wait_for(log, lines)
        time.sleep(random.uniform(0, 0.03))
        alive = psutil.Process(process.pid).children()
        os.kill(alive[random.integers(len(alive))].pid, signal.SIGKILL)
    status, _, err = ended(process)
    assert status == 0, err
    assert_complete(output, 150, 4)
    assert log.read_text().count("\n") <= 150 + 7


@pytest.mark.slow
def test_a_full_disk_is_one_sentence_and_loses_nothing(
    tmp_path: Path, log: Path, plugin: None
) -> None:
    """The kernel refuses writes beyond a size, in the journal and then in the rows."""
    output = tmp_path / "out"
    for size in (60_000, 5_000):
        limit = f"import resource; resource.setrlimit(resource.RLIMIT_FSIZE, ({size}, {size}))"
        status, _, err = ended(started(*SLOWLY, "--output", str(output), before=limit))
        assert status == 2
        assert "cannot write there" in err
        assert len(err.splitlines()) == 1, err
        assert sorted(path.name for path in output.iterdir() if path.suffix == ".parquet") == []
        if size == 60_000:
            kept = journalled(output)
            assert 0 < kept < 150
            log.unlink()
            assert ended(started(*SLOWLY, "--output", str(output)))[0] == 0
            assert log.read_text().count("\n") == 150 - kept
            assert_complete(output, 150, 4)
            (output / "frequencies.parquet").unlink()


@contextmanager
def cluster(workers: int = 2) -> Iterator[tuple[str, psutil.Popen]]:
    """A Dask cluster of worker processes, as people run it; its address and process.

    The process ends all workers at a first line of input, and itself where the input ends.
    """
    script = (
        "import sys, json\n"
        "from distributed import LocalCluster\n"
        "if __name__ == '__main__':\n"
        f"    with LocalCluster(n_workers={workers}, threads_per_worker=1,\n"
        "                      dashboard_address=None) as c:\n"
        "        print(json.dumps(c.scheduler_address), flush=True)\n"
        "        sys.stdin.readline()\n"
        "        c.scale(0)\n"
        "        sys.stdin.read()\n"
    )
    pipe = subprocess.PIPE
    process = psutil.Popen(
        [sys.executable, "-c", script],
        stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, text=True,
    )  # fmt: skip
    try:
        yield json.loads(process.stdout.readline()), process
    finally:
        process.communicate(timeout=60)


@pytest.mark.parametrize(
    ("address", "why"),
    [
        ("tcp://127.0.0.1:1", "Timed out"),
        ("nonsense", "missing port"),
        ("ftp://127.0.0.1:1", "unknown address scheme"),
        ("", "missing port"),
    ],
)
def test_an_address_without_a_scheduler_is_one_sentence(
    rps_bench: Callable[..., Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    address: str,
    why: str,
) -> None:
    monkeypatch.setattr("harness.cluster.REACH", 0.3)
    given = ("--poses", "pose:490,0,0", "--models", "rayleigh@1", "--scheduler", address)
    answer = rps_bench("sweep", *given, "--output", str(tmp_path / "out"))
    assert answer.status == 2
    expected = "the address of a running Dask scheduler, tcp://HOST:PORT"
    assert answer.err.startswith(f"rps-bench: --scheduler = {address!r}: expected {expected} (")
    assert why in answer.err
    assert len(answer.err.splitlines()) == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_a_cluster_without_workers_is_one_sentence(tmp_path: Path) -> None:
    with cluster(workers=0) as (address, _):
        given = ("--poses", "pose:490,0,0", "--models", "rayleigh@1", "--scheduler", address)
        status, _, err = ended(started(*given, "--output", str(tmp_path / "out")))
    assert status == 2
    expected = "a Dask cluster with at least one worker"
    assert err == f"rps-bench: --scheduler = {address!r}: expected {expected}\n"
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
@pytest.mark.parametrize("lost", ["its scheduler", "every worker"])
def test_a_cluster_that_ends_loses_no_finished_job(
    lost: str, tmp_path: Path, log: Path, plugin: None
) -> None:
    output = tmp_path / "out"
    with cluster() as (address, dask):
        short = "import harness.cluster; harness.cluster.REACH = 3.0"
        process = started(*SLOWLY, "--scheduler", address, "--output", str(output), before=short)
        wait_for(log, 40)
        if lost == "its scheduler":
            dask.kill()
        else:
            dask.stdin.write("\n")
            dask.stdin.flush()
        status, _, err = ended(process)
    assert status == 2
    assert err.startswith(f"rps-bench: --scheduler = {address!r}: expected a Dask cluster that ")
    assert f"({lost} has gone; finished jobs are kept" in err
    assert len(err.splitlines()) == 1, err
    kept = journalled(output)
    assert 30 <= kept < 150
    log.unlink()
    assert ended(started(*SLOWLY, "--output", str(output)))[0] == 0
    assert log.read_text().count("\n") == 150 - kept
    assert_complete(output, 150, 4)


@pytest.mark.slow
def test_a_cluster_whose_workers_are_killed_leaves_every_row_once(
    tmp_path: Path, log: Path, plugin: None
) -> None:
    """Kills a process that holds a job, then a Dask worker; both come back."""
    output = tmp_path / "out"
    with cluster() as (address, dask):
        given = (*SLOWLY, "--scheduler", address, "--tries", "10", "--output", str(output))
        process = started(*given)
        for lines, of_harness in ((20, True), (60, False), (100, True)):
            wait_for(log, lines)
            workers = [
                other
                for other in dask.children(recursive=True)
                if ("harness.child" in other.cmdline()) == of_harness
                and (of_harness or any("spawn_main" in word for word in other.cmdline()))
            ]
            workers[0].kill()
        status, _, err = ended(process)
    assert status == 0, err
    assert_complete(output, 150, 4)


@pytest.mark.slow
def test_the_same_bytes_on_one_core_on_two_and_on_a_cluster(tmp_path: Path) -> None:
    """Analytic models and simulators; the order in which jobs finish does not matter."""
    models = "timoshenko@exact,euler-bernoulli@3,exudyn-cable@4,exudyn-beam@6,mujoco-cable@4+8"
    given = ("--models", models, "--poses", "random:12:5", "--against", "timoshenko@exact")
    files = ("frequencies.parquet", "errors.parquet", "errors.csv", "worst.csv")
    found: dict[str, list[bytes]] = {}

    def sweep(name: str, *options: str) -> None:
        output = tmp_path / name
        status, _, err = ended(started(*given, "--output", str(output), *options))
        assert status == 0, err
        found[name] = [(output / file).read_bytes() for file in files]

    sweep("one", "--cores", "1")
    sweep("two", "--cores", "2")
    with cluster() as (address, _):
        sweep("dask", "--scheduler", address)
    assert found["one"] == found["two"]
    assert found["one"] == found["dask"]


@pytest.mark.slow
def test_memory_does_not_grow_with_the_poses(tmp_path: Path) -> None:
    """The poses themselves are held, 24 bytes each, and copied once; rows and answers are not."""
    peak = (
        "import atexit, resource; "
        "atexit.register(lambda: print('peak', "
        "resource.getrusage(resource.RUSAGE_SELF).ru_maxrss))"
    )
    used = []
    for count in (60_000, 160_000):
        output = str(tmp_path / str(count))
        given = ("--poses", f"random:{count}", "--models", "euler-bernoulli@exact")
        status, out, err = ended(started(*given, "--output", output, before=peak))
        assert status == 0, err
        used.append(1024 * int(out.split()[-1]))
    rows = 6 * 100_000 * (8 * 5 + 8)  # what the additional rows alone would take
    assert used[1] - used[0] < 24e6 < rows
