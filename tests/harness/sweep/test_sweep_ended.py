"""`rps-bench sweep` when it is killed, its processes are, its folder is taken or its disk full."""

import os
import signal
import time
from pathlib import Path
from typing import Any

import numpy as np
import psutil
import pytest

from analytic import Mechanism, Pose, condensed_frequencies
from harness.history.store import open_history
from harness.sweep.engine import AHEAD


@pytest.mark.slow
def test_a_second_sweep_into_the_same_folder_is_refused(slow_sweep: Any) -> None:
    first = slow_sweep.started()
    slow_sweep.wait_for(1)
    first.send_signal(signal.SIGSTOP)  # so that it does not end before the second begins
    status, _, err = slow_sweep.ended(slow_sweep.started())
    first.send_signal(signal.SIGCONT)
    assert status == 2
    assert "another sweep is running into this folder" in err
    assert slow_sweep.ended(first)[0] == 0
    slow_sweep.complete()


@pytest.mark.slow
@pytest.mark.parametrize("ending", [signal.SIGKILL, signal.SIGINT])
def test_an_ended_parent_loses_no_finished_job(slow_sweep: Any, ending: signal.Signals) -> None:
    first = slow_sweep.started()
    slow_sweep.wait_for(40)
    children = psutil.Process(first.pid).children()
    os.kill(first.pid, ending)
    status, _, err = slow_sweep.ended(first)
    assert status == (-ending if ending == signal.SIGKILL else 130), err
    assert "Traceback" not in err
    psutil.wait_procs(children, timeout=10)
    assert not any(child.is_running() for child in children)
    kept = slow_sweep.kept()
    # Handed out at most, so under way, or answered but not yet kept: kept is what was reported.
    handed_out = AHEAD * len(os.sched_getaffinity(0))
    assert slow_sweep.solved() - handed_out <= kept < 150
    assert not (slow_sweep.output / "frequencies.parquet").exists()
    rows = slow_sweep.goes_on(kept)
    poses = Pose(*(rows[name][::4].to_numpy() for name in ("z_m", "azimuth_rad", "tilt_rad")))
    expected = 1.0001 * condensed_frequencies(Mechanism.paper(), poses, count=4)
    np.testing.assert_allclose(rows["frequency_hz"], expected.ravel(), rtol=1e-9)


@pytest.mark.slow
def test_workers_killed_at_random_leave_every_row_once(slow_sweep: Any) -> None:
    process = slow_sweep.started("--tries", "10")
    random = np.random.default_rng(1)
    for lines in range(10, 140, 20):
        slow_sweep.wait_for(lines)
        time.sleep(random.uniform(0, 0.03))
        alive = psutil.Process(process.pid).children()
        os.kill(alive[random.integers(len(alive))].pid, signal.SIGKILL)
    status, _, err = slow_sweep.ended(process)
    assert status == 0, err
    slow_sweep.complete()
    assert slow_sweep.solved() <= 150 + 7


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(30))
def test_a_series_of_kills_ends_like_a_whole_run(slow_sweep: Any, seed: int) -> None:
    """The sweep itself, three times, at any moment from its start to its last file."""
    random = np.random.default_rng(seed)
    for _ in range(3):
        process = slow_sweep.started()
        time.sleep(random.uniform(0.3, 3.0))
        process.kill()  # of one that has ended nothing happens
        slow_sweep.ended(process)
    assert slow_sweep.ended(slow_sweep.started())[0] == 0
    rows = slow_sweep.complete()
    poses = Pose(*(rows[name][::4].to_numpy() for name in ("z_m", "azimuth_rad", "tilt_rad")))
    expected = 1.0001 * condensed_frequencies(Mechanism.paper(), poses, count=4)
    np.testing.assert_allclose(rows["frequency_hz"], expected.ravel(), rtol=1e-9)


@pytest.mark.slow
def test_a_full_disk_is_one_sentence_and_loses_nothing(slow_sweep: Any) -> None:
    """The kernel refuses writes beyond a size, in the journal and then in the rows."""
    output = slow_sweep.output
    for size in (60_000, 5_000):
        limit = f"import resource; resource.setrlimit(resource.RLIMIT_FSIZE, ({size}, {size}))"
        status, _, err = slow_sweep.ended(slow_sweep.started(before=limit))
        assert status == 2
        assert "cannot write there" in err
        assert len(err.splitlines()) == 1, err
        assert sorted(path.name for path in output.iterdir() if path.suffix == ".parquet") == []
        if size == 60_000:
            kept = slow_sweep.kept()
            assert 0 < kept < 150
            slow_sweep.goes_on(kept)
            (output / "frequencies.parquet").unlink()


@pytest.mark.slow
@pytest.mark.parametrize("moment", ["before", "after"])
def test_a_kill_where_the_history_is_written_leaves_each_row_once(
    started: Any, ended: Any, tmp_path: Path, moment: str
) -> None:
    """Right before the run's file is there, or right after, before anything else is done."""
    given = ("--models", "rayleigh@2", "--poses", "random:9:1", "--modes", "1-2")
    given += ("--output", str(tmp_path / "out"), "--history", str(tmp_path / "past"))
    kill = "os.kill(os.getpid(), signal.SIGKILL)"
    patch = "import os, signal, harness.history.store as store, harness.sweep.rows as rows; "
    if moment == "before":  # what is written has no name yet, but is known as a run
        patch += f"store.checksum = lambda path: {kill}"
    else:
        patch += "right = rows.append_table; "
        patch += f"rows.append_table = lambda *given: (right(*given), {kill})"
    assert ended(started(*given, before=patch))[0] == -signal.SIGKILL
    assert len(list((tmp_path / "past").glob("*.parquet"))) == (moment == "after")
    for _ in range(2):
        assert ended(started(*given))[0] == 0
        found = open_history(tmp_path / "past").query("SELECT run, mode FROM rows").rows()
        assert len(found) == 9 * 2 and len({row["run"] for row in found}) == 1
