"""Processes of their own for what may crash or hang; one costs no more than the job it holds.

A process is started as a program, not by `multiprocessing`: that works inside a Dask worker too,
and the environment is set before numpy is imported. It leads a process group and has a temporary
folder of its own; both end with it, whatever the model in it has started or left there.
"""

import io
import os
import pickle
import platform
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import Pipe
from pathlib import Path
from threading import Lock
from typing import Any, Protocol

from harness.threads import ONE_THREAD

LIMIT = 600.0
"""Seconds that a simulator may take for one pose unless said otherwise."""
START = 120.0
"""A process that is not ready after this many seconds never will be."""
TRIES = 2
"""How often a job is tried whose process dies."""
LONG = 1000
"""Letters of an error that are passed on."""
GRACE = 1.0
"""Seconds that a process has to end what it runs, before it is ended itself."""
LOOK = 0.5
"""Seconds after which a process looks whether its parent is still there."""
OURS = ""
"""The owner of the bench's own tasks; others are named by their package."""
KNOWN = ("analytic", "harness", "reference_models", "numpy")
"""Packages whose objects may be in an answer."""
BUILT_IN = {("builtins", name) for name in ("complex", "frozenset", "set", "slice", "range")}
"""What else may be."""
POSIX = {"killpg", "SIGKILL", "alarm", "SIGALRM"}
"""What of `os` and `signal` these processes need."""
PREFIX = "rps-bench-"
"""What the names of temporary folders begin with; the parent's process number follows."""


class Task(Protocol):
    """Anything that can be pickled and knows how to solve itself.

    One that has a `model` with an `owner` that is not `OURS` shares its process with that owner's
    alone: it may change numpy, the working folder or whatever else others count on.
    """

    def solve(self) -> object:
        """Return the answer, or raise what the model raises."""
        ...


@dataclass(frozen=True)
class Failure:
    """Why a task has no answer; `refused`: it is of a kind that the model cannot take."""

    reason: str
    refused: bool = False


class Plain(pickle.Unpickler):
    """Reads what a process sends: numbers, texts and what this bench defines, nobody's else."""

    def find_class(self, module: str, name: str) -> Any:
        """Return a class; raises `UnpicklingError` where another package would be imported."""
        if module.partition(".")[0] in KNOWN or (module, name) in BUILT_IN:
            return super().find_class(module, name)
        raise pickle.UnpicklingError(f"it holds {module}.{name}")


class DiedError(RuntimeError):
    """The process ended before its answer, or had to be ended; says how."""


def attempt(task: Task) -> object:
    """Solve `task` in this process; what the model raises becomes a `Failure`."""
    from analytic.errors import InputError, RefusedError
    from reference_models import ModelError, UnavailableError

    try:
        return task.solve()
    except (ModelError, UnavailableError, InputError) as error:
        return Failure(_short(str(error)), isinstance(error, RefusedError))
    except Exception as error:
        return Failure(f"{type(error).__name__}: {_short(str(error)) or 'no reason given'}")


def _short(words: str) -> str:
    """Return `words` on one line, and not more than fit a sentence."""
    words = " ".join(words[:LONG].split())
    return words if len(words) < LONG else f"{words[: LONG - 4]} ..."


class Child:
    """One process that solves one task at a time.

    `launcher`: the program that runs Python and its options, by default this process's own.
    """

    def __init__(self, launcher: Sequence[str] = ()) -> None:
        if not _posix():
            from analytic import InputError

            wanted = "Linux, macOS or WSL: models run in processes that POSIX signals can end"
            raise InputError("system", platform.system(), wanted)
        self._line, theirs = Pipe()
        self._folder = tempfile.mkdtemp(prefix=f"{PREFIX}{os.getpid()}-")
        # Another environment finds modules by itself.
        path = {} if launcher else {"PYTHONPATH": _path()}
        python = launcher or [sys.executable]
        with theirs:
            self._process = subprocess.Popen(
                [*python, "-P", "-m", "harness.child", str(theirs.fileno())],
                pass_fds=(theirs.fileno(),),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                cwd=self._folder,
                env=os.environ | ONE_THREAD | {"TMPDIR": self._folder} | path,
                start_new_session=True,  # Ctrl-C is for the parent to act on
            )
        self._ready = self._busy = False
        self.owner = OURS

    def solve(self, task: Task, limit: float) -> object:
        """Return the answer within `limit` seconds, or raise `DiedError`; then only `close` it."""
        try:
            self._busy = True
            self._ready = self._ready or self._receive(START) == "ready"
            self._line.send((task, limit))
            answer = self._receive(limit)
            self._busy = False
            return answer
        except (EOFError, OSError):
            status = self._process.wait()
        if status == -signal.SIGALRM:
            raise DiedError(f"gave no answer within the time limit of {limit:g} s")
        if status < 0:
            raise DiedError(f"its process was ended by {signal.Signals(-status).name}")
        raise DiedError(f"its process ended by itself with status {status}")

    def _receive(self, limit: float) -> object:
        if not self._line.poll(limit):
            raise DiedError(f"gave no answer within the time limit of {limit:g} s")
        try:
            return Plain(io.BytesIO(self._line.recv_bytes())).load()
        except (EOFError, OSError):
            raise
        except Exception as error:  # whoever writes into the line, or is no longer what it was
            why = f"{type(error).__name__}: {_short(str(error))}"
            raise DiedError(f"its answer cannot be read ({why})") from None

    def kill(self) -> None:
        """End the process and all it started; safe while another thread waits for it.

        In the middle of a task it is asked first: a program that it runs may be in a group of its
        own, which only it can end.
        """
        with suppress(ProcessLookupError, PermissionError, subprocess.TimeoutExpired):
            if self._busy and self._process.poll() is None:
                self._process.terminate()
                self._process.wait(GRACE)
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()
        end_all_of(self._folder)

    def close(self) -> None:
        """End the process and let go of it."""
        self.kill()
        self._line.close()


class Children:
    """The processes of one parent, kept for the next job; any number of threads may ask.

    One is started when there is a job for it, if not before; `launcher` as of `Child`.
    """

    def __init__(self, launcher: Sequence[str] = ()) -> None:
        self._launcher = launcher
        self._idle: list[Child] = []
        self._busy: set[Child] = set()
        self._lock = Lock()
        self._closed = False

    def start(self, number: int) -> None:
        """Start processes ahead of their jobs until there are `number`."""
        with self._lock:
            lacking = number - len(self._idle) - len(self._busy)
            self._idle += [Child(self._launcher) for _ in range(lacking)]

    def attempt(self, task: Task, limit: float, tries: int = TRIES) -> object:
        """Solve `task`; where its process dies, try anew up to `tries` times, then say why."""
        reason = ""
        for number in range(1, tries + 1):
            child = self._take(getattr(getattr(task, "model", None), "owner", OURS))
            if child is None:
                return Failure("interrupted")
            try:
                answer = child.solve(task, limit)
            except BaseException as error:  # Ctrl-C too: amid a job a process is of no use
                child.close()
                with self._lock:
                    self._busy.discard(child)
                if not isinstance(error, DiedError):
                    raise
                reason = f"{error} ({number} of {tries} tries)" if tries > 1 else str(error)
                continue
            with self._lock:
                self._busy.discard(child)
                self._idle.append(child)
                closed = self._closed
            if closed:
                child.close()
            return answer
        return Failure(reason)

    def _take(self, owner: str) -> Child | None:
        with self._lock:
            if self._closed:
                return None
            if not self._idle and not self._busy:
                sweep_up()
            fit = [child for child in self._idle if child.owner in (owner, OURS)]
            # One that knows the owner's modules already, if there is one.
            child = max(fit, key=lambda one: one.owner == owner, default=None)
            if child is None:
                child = Child(self._launcher)
            else:
                self._idle.remove(child)
            child.owner = owner
            self._busy.add(child)
            return child

    def close(self) -> None:
        """End all processes; jobs under way fail."""
        with self._lock:
            self._closed = True
            idle, self._idle = self._idle, []
            busy = [*self._busy]
        for child in idle:
            child.close()
        for child in busy:
            child.kill()


def sweep_up() -> None:
    """Remove temporary folders whose parent was killed before it could."""
    if not _posix():
        return
    for folder in Path(tempfile.gettempdir()).glob(f"{PREFIX}*-*"):
        owner = folder.name.removeprefix(PREFIX).partition("-")[0]
        if owner.isdecimal() and not _alive(int(owner)):
            end_all_of(str(folder))


def _posix() -> bool:
    return {*dir(os), *dir(signal)} >= POSIX


def end_all_of(folder: str) -> None:
    """End the processes whose temporary folder is `folder`, whatever group they are in; remove it.

    What leaves its group and outlives its parent is found by its environment, where the system
    shows that (Linux).
    """
    mark = f"TMPDIR={folder}".encode()
    for about in Path("/proc").glob("[0-9]*/environ"):
        with suppress(OSError):
            process = int(about.parent.name)
            if process != os.getpid() and mark in about.read_bytes().split(b"\0"):
                os.kill(process, signal.SIGKILL)
    shutil.rmtree(folder, ignore_errors=True)


def _alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except OSError as error:  # of another user's process, too
        return not isinstance(error, ProcessLookupError)
    return True


def _path() -> str:
    """Return where this process finds modules: the child starts in another folder."""
    return os.pathsep.join(str(Path(entry).resolve()) for entry in sys.path if entry)
