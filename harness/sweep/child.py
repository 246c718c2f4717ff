"""A process of its own for what may crash or hang; it costs no more than the job it holds.

Started as a program, not by `multiprocessing`: that works inside a Dask worker too, and the
environment is set before numpy is imported. Loads nothing heavy itself, so that a process can be
started first and loads while its parent does.
"""

import gc
import math
import os
import signal
import subprocess
import sys
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from threading import Lock

from harness.sweep.task import Failure, Task
from harness.threads import ONE_THREAD

START = 120.0
"""A process that is not ready after this many seconds never will be."""


class DiedError(RuntimeError):
    """The process ended before its answer, or had to be ended; says how."""


class Child:
    """One process that solves one task at a time."""

    def __init__(self) -> None:
        self._line, theirs = Pipe()
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", "harness.sweep.child", str(theirs.fileno())],
                pass_fds=(theirs.fileno(),),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                env=os.environ | ONE_THREAD,
                start_new_session=True,  # Ctrl-C is for the parent to act on
            )
        self._ready = False

    def solve(self, task: Task, limit: float) -> object:
        """Return the answer within `limit` seconds, or raise `DiedError`; then it is of no use."""
        try:
            self._ready = self._ready or self._receive(START) == "ready"
            self._line.send((task, limit))
            return self._receive(limit)
        except (EOFError, OSError):
            raise DiedError(self._ended(limit)) from None

    def _receive(self, limit: float) -> object:
        if not self._line.poll(limit):
            self.close()
            raise DiedError(f"gave no answer within the time limit of {limit:g} s")
        return self._line.recv()

    def _ended(self, limit: float) -> str:
        self._line.close()
        status = self._process.wait()
        if status == -signal.SIGALRM:
            return f"gave no answer within the time limit of {limit:g} s"
        if status < 0:
            return f"its process was ended by {signal.Signals(-status).name}"
        return f"its process ended by itself with status {status}"

    def kill(self) -> None:
        """End the process, whatever it is doing; safe while another thread waits for it."""
        self._process.kill()
        self._process.wait()

    def close(self) -> None:
        """End the process and let go of it."""
        self.kill()
        self._line.close()


class Children:
    """The processes of one parent, kept for the next job; any number of threads may ask.

    One is started when there is a job for it, if not before.
    """

    def __init__(self) -> None:
        self._idle: list[Child] = []
        self._all: set[Child] = set()
        self._lock = Lock()
        self._closed = False

    def start(self, number: int) -> None:
        """Start processes ahead of their jobs until there are `number`."""
        with self._lock:
            new = [Child() for _ in range(number - len(self._all))]
            self._idle += new
            self._all.update(new)

    def attempt(self, task: Task, limit: float, tries: int) -> object:
        """Solve `task`; where its process dies, try anew up to `tries` times, then say why."""
        reason = ""
        for _ in range(tries):
            child = self._take()
            if child is None:
                return Failure("interrupted")
            try:
                answer = child.solve(task, limit)
            except DiedError as error:
                reason = str(error)
                with self._lock:
                    self._all.discard(child)
                continue
            with self._lock:
                self._idle.append(child)
                closed = self._closed
            if closed:
                child.close()
            return answer
        return Failure(f"{reason} ({tries} of {tries} tries)")

    def _take(self) -> Child | None:
        with self._lock:
            if self._closed:
                return None
            child = self._idle.pop() if self._idle else Child()
            self._all.add(child)
            return child

    def close(self) -> None:
        """End all processes; jobs under way fail."""
        with self._lock:
            self._closed = True
            idle, running = self._idle, self._all.difference(self._idle)
        for child in idle:
            child.close()
        for child in running:
            child.kill()


def answer(task: Task) -> object:
    """Solve `task` in this process; what the model raises becomes a `Failure`."""
    from analytic.errors import InputError
    from reference_models import ModelError, UnavailableError

    try:
        return task.solve()
    except (ModelError, UnavailableError, InputError) as error:
        return Failure(str(error))
    except Exception as error:
        return Failure(f"{type(error).__name__}: {error}")


def _serve(line: Connection) -> None:
    gc.set_threshold(100_000)  # as in harness.cli
    import harness.sweep.jobs  # noqa: F401  what every task needs: before it is ready

    with line, suppress(EOFError, BrokenPipeError):
        line.send("ready")
        while True:
            task, limit = line.recv()
            # Without a parent nobody would end a hanging task.
            signal.alarm(math.ceil(limit) + 1)
            reply = answer(task)
            signal.alarm(0)
            line.send(reply)


if __name__ == "__main__":
    _serve(Connection(int(sys.argv[1])))
