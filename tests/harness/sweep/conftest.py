"""Sweeps as processes of their own, and what they leave."""

import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
import pytest

from harness.history.duck import connect

COMMAND = [sys.executable, "-c", "from harness.cli.main import main; main()", "sweep"]
SLOWLY = ("--models", "trial@2", "--poses", "random:150:3", "--modes", "1-4")


def _started(*arguments: str, before: str = "") -> subprocess.Popen[str]:
    """Start a sweep as a process of its own."""
    command = [*COMMAND, *arguments]
    if before:
        command[2] = f"{before}; {command[2]}"
    pipe = subprocess.PIPE
    return subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True)


def _ended(process: subprocess.Popen[str]) -> tuple[int, str, str]:
    out, err = process.communicate(timeout=120)
    return process.returncode, out, err


def _assert_complete(folder: Path, poses: int, modes: int) -> pd.DataFrame:
    with connect() as base:
        rows = base.execute(f"FROM '{folder / 'frequencies.parquet'}'").df()
    assert len(rows) == poses * modes
    assert not rows.duplicated(["model", "pose", "mode"]).any()
    assert not [path.name for path in folder.iterdir() if path.name.startswith(".")]
    return rows


@dataclass(frozen=True)
class SlowSweep:
    """A sweep of 150 poses by the model `trial`, slow enough to be ended in the middle."""

    output: Path
    log: Path

    def started(self, *options: str, before: str = "") -> subprocess.Popen[str]:
        return _started(*SLOWLY, "--output", str(self.output), *options, before=before)

    def ended(self, process: subprocess.Popen[str]) -> tuple[int, str, str]:
        return _ended(process)

    def kept(self) -> int:
        """How many jobs are in the journal of a process that has ended."""
        base = sqlite3.connect(self.output / "journal.sqlite")
        (count,) = base.execute("SELECT count(*) FROM jobs").fetchone()
        base.close()
        return int(count)

    def solved(self) -> int:
        """How many poses were solved, some perhaps in vain, since the log was removed."""
        return self.log.read_text().count("\n") if self.log.exists() else 0

    def wait_for(self, poses: int) -> None:
        deadline = time.monotonic() + 300
        while self.solved() < poses:
            assert time.monotonic() < deadline
            time.sleep(0.01)

    def goes_on(self, kept: int) -> pd.DataFrame:
        """Once more: what was kept is not solved again, and every row is there."""
        self.log.unlink()
        assert self.ended(self.started())[0] == 0
        assert self.solved() == 150 - kept
        return self.complete()

    def complete(self) -> pd.DataFrame:
        return _assert_complete(self.output, 150, 4)


@pytest.fixture
def started() -> Callable[..., subprocess.Popen[str]]:
    return _started


@pytest.fixture
def ended() -> Callable[..., tuple[int, str, str]]:
    return _ended


@pytest.fixture
def assert_complete() -> Callable[[Path, int, int], pd.DataFrame]:
    return _assert_complete


@pytest.fixture
def log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the model `trial` writes a line for every pose that it solves."""
    monkeypatch.setenv("TRIAL_LOG", str(tmp_path / "log"))
    return tmp_path / "log"


@pytest.fixture
def slow_sweep(tmp_path: Path, log: Path, plugin: None) -> SlowSweep:
    return SlowSweep(tmp_path / "out", log)
