"""`rps-bench sweep` when it is killed, its processes are, its folder is taken or its disk full."""

import os
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import polars as pl
import psutil
import pytest

from harness.sweep.engine import AHEAD


@pytest.mark.slow
def test_a_second_sweep_into_the_same_folder_is_refused(
    started: Callable[..., subprocess.Popen[str]],
    ended: Callable[..., tuple[int, str, str]],
    wait_for: Callable[[Path, int], None],
    assert_complete: Callable[[Path, int, int], pl.DataFrame],
    slowly: tuple[str, ...],
    tmp_path: Path,
    log: Path,
    plugin: None,
) -> None:
    output = tmp_path / "out"
    first = started(*slowly, "--output", str(output))
    wait_for(log, 1)
    first.send_signal(signal.SIGSTOP)  # so that it does not end before the second begins
    status, _, err = ended(started(*slowly, "--output", str(output)))
    first.send_signal(signal.SIGCONT)
    assert status == 2
    assert "another sweep is running into this folder" in err
    assert ended(first)[0] == 0
    assert_complete(output, 150, 4)


@pytest.mark.slow
@pytest.mark.parametrize("ending", [signal.SIGKILL, signal.SIGINT])
def test_an_ended_parent_loses_no_finished_job(
    started: Callable[..., subprocess.Popen[str]],
    ended: Callable[..., tuple[int, str, str]],
    journalled: Callable[[Path], int],
    wait_for: Callable[[Path, int], None],
    assert_complete: Callable[[Path, int, int], pl.DataFrame],
    slowly: tuple[str, ...],
    ending: signal.Signals,
    tmp_path: Path,
    log: Path,
    plugin: None,
) -> None:
    output = tmp_path / "out"
    first = started(*slowly, "--output", str(output))
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
    # Handed out at most, so under way, or answered but not yet kept: kept is what was reported.
    handed_out = AHEAD * len(os.sched_getaffinity(0))
    assert solved - handed_out <= kept < 150
    assert not (output / "frequencies.parquet").exists()
    log.unlink()
    assert ended(started(*slowly, "--output", str(output)))[0] == 0
    assert log.read_text().count("\n") == 150 - kept
    rows = assert_complete(output, 150, 4)
    expected = 100 * rows["z_m"] * rows["mode"] + rows["azimuth_rad"].sin()
    np.testing.assert_allclose(rows["frequency_hz"], expected, rtol=1e-14)


@pytest.mark.slow
def test_workers_killed_at_random_leave_every_row_once(
    started: Callable[..., subprocess.Popen[str]],
    ended: Callable[..., tuple[int, str, str]],
    wait_for: Callable[[Path, int], None],
    assert_complete: Callable[[Path, int, int], pl.DataFrame],
    slowly: tuple[str, ...],
    tmp_path: Path,
    log: Path,
    plugin: None,
) -> None:
    output = tmp_path / "out"
    process = started(*slowly, "--tries", "10", "--output", str(output))
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
    started: Callable[..., subprocess.Popen[str]],
    ended: Callable[..., tuple[int, str, str]],
    journalled: Callable[[Path], int],
    assert_complete: Callable[[Path, int, int], pl.DataFrame],
    slowly: tuple[str, ...],
    tmp_path: Path,
    log: Path,
    plugin: None,
) -> None:
    """The kernel refuses writes beyond a size, in the journal and then in the rows."""
    output = tmp_path / "out"
    for size in (60_000, 5_000):
        limit = f"import resource; resource.setrlimit(resource.RLIMIT_FSIZE, ({size}, {size}))"
        status, _, err = ended(started(*slowly, "--output", str(output), before=limit))
        assert status == 2
        assert "cannot write there" in err
        assert len(err.splitlines()) == 1, err
        assert sorted(path.name for path in output.iterdir() if path.suffix == ".parquet") == []
        if size == 60_000:
            kept = journalled(output)
            assert 0 < kept < 150
            log.unlink()
            assert ended(started(*slowly, "--output", str(output)))[0] == 0
            assert log.read_text().count("\n") == 150 - kept
            assert_complete(output, 150, 4)
            (output / "frequencies.parquet").unlink()
