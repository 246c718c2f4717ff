"""Sweeps as processes of their own, and what they leave."""

import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import polars as pl
import pytest

COMMAND = [sys.executable, "-c", "from harness.cli import main; main()", "sweep"]
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


def _journalled(folder: Path) -> int:
    """How many jobs are in the journal of a process that has ended."""
    base = sqlite3.connect(folder / "journal.sqlite")
    (count,) = base.execute("SELECT count(*) FROM jobs").fetchone()
    base.close()
    return int(count)


def _wait_for(log: Path, lines: int) -> None:
    """Wait until the model `trial` has been solved so many times."""
    deadline = time.monotonic() + 60
    while not log.exists() or log.read_text().count("\n") < lines:
        assert time.monotonic() < deadline
        time.sleep(0.01)


def _assert_complete(folder: Path, poses: int, modes: int) -> pl.DataFrame:
    rows = pl.read_parquet(folder / "frequencies.parquet")
    assert len(rows) == poses * modes
    assert len(rows.unique(["model", "pose", "mode"])) == poses * modes
    assert not [path.name for path in folder.iterdir() if path.name.startswith(".")]
    return rows


@pytest.fixture
def started() -> Callable[..., subprocess.Popen[str]]:
    return _started


@pytest.fixture
def ended() -> Callable[..., tuple[int, str, str]]:
    return _ended


@pytest.fixture
def journalled() -> Callable[[Path], int]:
    return _journalled


@pytest.fixture
def wait_for() -> Callable[[Path, int], None]:
    return _wait_for


@pytest.fixture
def assert_complete() -> Callable[[Path, int, int], pl.DataFrame]:
    return _assert_complete


@pytest.fixture
def slowly() -> tuple[str, ...]:
    return SLOWLY


@pytest.fixture
def log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("TRIAL_LOG", str(tmp_path / "log"))
    return tmp_path / "log"
