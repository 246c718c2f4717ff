"""Processes of their own: what ends them ends all that they started, and nothing is left lying."""

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import pytest

from harness.workers import PREFIX, Children, Failure, sweep_up


@dataclass(frozen=True)
class Program:
    """A task that runs a program in a session of its own, as a simulator may, and waits for it."""

    note: str
    group: bool

    def solve(self) -> object:
        process = subprocess.Popen(["sleep", "60"], start_new_session=self.group)
        try:
            Path(self.note).write_text(f"{process.pid} {os.getpid()}")
            Path(tempfile.gettempdir(), "left").write_text("something")
            return process.wait()
        finally:
            process.kill()


@dataclass(frozen=True)
class Crash:
    """A task whose process ends as told."""

    how: str

    def solve(self) -> object:
        if self.how == "segmentation fault":
            os.kill(os.getpid(), signal.SIGSEGV)
        if self.how == "exit":
            sys.exit(3)
        if self.how == "exception":
            raise ValueError("no luck")
        return lambda: None  # cannot be pickled


def gone(process: int) -> bool:
    stat = Path(f"/proc/{process}/stat")
    return not stat.exists() or stat.read_text().rpartition(")")[2].split()[0] == "Z"


def soon(process: int) -> bool:
    deadline = time.monotonic() + 300
    while not gone(process) and time.monotonic() < deadline:
        time.sleep(0.02)
    return gone(process)


def folders() -> set[Path]:
    return set(Path(tempfile.gettempdir()).glob(f"{PREFIX}{os.getpid()}-*"))


@pytest.mark.parametrize("group", [False, True])
def test_a_time_limit_ends_what_the_model_started(tmp_path: Path, group: bool) -> None:
    before = folders()
    children = Children()
    try:
        found = children.attempt(Program(str(tmp_path / "note"), group), 1.0, tries=1)
    finally:
        children.close()
    assert isinstance(found, Failure) and "time limit of 1 s" in found.reason
    program, process = map(int, (tmp_path / "note").read_text().split())
    assert soon(program) and soon(process)
    assert folders() <= before


@pytest.mark.parametrize("group", [False, True])
def test_a_killed_parent_leaves_nothing_running(tmp_path: Path, group: bool) -> None:
    note = tmp_path / "note"
    script = (
        "import sys; sys.path.insert(0, sys.argv[1])\n"
        "from test_workers import Program\nfrom harness.workers import Children\n"
        f"Children().attempt(Program({str(note)!r}, {group}), 60.0)\n"
    )
    arguments = [sys.executable, "-c", script, str(Path(__file__).parent)]
    with subprocess.Popen(arguments) as parent:
        deadline = time.monotonic() + 300
        while not (note.exists() and note.read_text().count(" ")):
            assert time.monotonic() < deadline
            time.sleep(0.02)
        parent.kill()
    program, process = map(int, note.read_text().split())
    assert soon(program) and soon(process)
    sweep_up()
    assert not list(Path(tempfile.gettempdir()).glob(f"{PREFIX}{parent.pid}-*"))


def running(program: str, parent: int) -> list[int]:
    """Return the processes of a program in a temporary folder of what `parent` has started."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            name = (process / "comm").read_text()
            inside = f"{PREFIX}{parent}-".encode() in (process / "environ").read_bytes()
            if name.startswith(program) and inside and not gone(int(process.name)):
                found.append(int(process.name))
    return found


@pytest.mark.slow
@pytest.mark.skipif(
    shutil.which("ccx") is None, reason="needs CalculiX: apt-get install calculix-ccx"
)
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_no_calculix_outlives_a_command(tmp_path: Path, how: signal.Signals) -> None:
    """The real program, in the middle of its work."""
    script = "from harness.cli.main import main; main()"
    asked = ["table", "--cases", "case1", "--references", "calculix-solid@12", "--history", "none"]
    program, null = [sys.executable, "-c", script, *asked], subprocess.DEVNULL
    with subprocess.Popen(program, cwd=tmp_path, stdout=null, stderr=null) as parent:
        deadline = time.monotonic() + 120
        while not (there := running("ccx", parent.pid)):
            assert time.monotonic() < deadline and parent.poll() is None
            time.sleep(0.02)
        parent.send_signal(how)
    assert parent.returncode != 0
    assert all(map(soon, there)) and not running("ccx", parent.pid)
    sweep_up()
    assert not list(Path(tempfile.gettempdir()).glob(f"{PREFIX}{parent.pid}-*"))


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ("segmentation fault", "its process was ended by SIGSEGV"),
        ("exit", "its process ended by itself with status 3"),
        ("exception", "ValueError: no luck"),
        ("lambda", "its answer cannot be handed over"),
    ],
)
def test_a_crash_is_a_sentence_and_costs_itself_alone(how: str, said: str) -> None:
    before = folders()
    children = Children()
    try:
        found = children.attempt(Crash(how), 60.0, tries=1)
        again = children.attempt(Crash("exception"), 60.0, tries=1)
    finally:
        children.close()
    assert isinstance(found, Failure) and said in found.reason
    assert again == Failure("ValueError: no luck")
    assert folders() <= before
