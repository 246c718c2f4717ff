"""Runs jobs on all cores of this machine, or on a Dask cluster; both take them one by one."""

import logging
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from queue import SimpleQueue
from threading import Semaphore
from time import monotonic
from typing import Any, Protocol, TypeVar

from analytic import InputError
from harness.child import Children, answer
from harness.jobs import Failure, Task

HERE = 2
"""Analytic tasks at once in this process, on threads: numpy lets other threads run meanwhile."""
START = 0.5
"""Seconds of analytic work before a process is started for what exceeds that."""
T = TypeVar("T", bound=Task)

AHEAD = 3
"""Jobs handed out for each core: enough that none waits, few enough to keep memory flat."""


@dataclass(frozen=True)
class Patience:
    """How long a simulator's job may take [s], and how often it is tried if its process dies."""

    limit: float = 60.0
    tries: int = 3


class Engine(Protocol):
    """Where jobs run."""

    cores: int

    def submit(self, task: Task) -> Any:
        """Return a future of the task's answer, or of a `Failure`."""
        ...


def run(engine: Engine, tasks: Iterable[T]) -> Iterator[tuple[T, Any]]:
    """Yield every task with its answer, or a `Failure`, as they finish."""
    finished: SimpleQueue[tuple[T, Any]] = SimpleQueue()
    waiting = 0

    def next_done() -> tuple[T, Any]:
        task, future = finished.get()
        try:
            return task, future.result()
        except Exception as error:  # a Dask worker that died once too often, say
            return task, Failure(f"{type(error).__name__}: {str(error).strip() or 'no reason'}")

    def tell(task: T) -> Callable[[Any], None]:
        return lambda future: finished.put((task, future))

    for task in tasks:
        engine.submit(task).add_done_callback(tell(task))
        waiting += 1
        if waiting >= AHEAD * engine.cores:
            yield next_done()
            waiting -= 1
    for _ in range(waiting):
        yield next_done()


class Local:
    """All cores of this machine. Simulators run in processes of their own, which may die.

    `HERE` analytic tasks at a time run in this process: it is ready at once. The others wait for
    that at first, for a process of their own takes longer to start than a small sweep to end.
    """

    def __init__(self, cores: int, patience: Patience) -> None:
        self.cores = cores
        self._patience = patience
        self._children = Children()
        self._here = Semaphore(HERE)
        self._began = monotonic()
        self._threads = ThreadPoolExecutor(cores)

    def submit(self, task: Task) -> Any:
        """Return a future of the task's answer, or of a `Failure`."""
        return self._threads.submit(self._solve, task)

    def _solve(self, task: Task) -> object:
        if task.safe and self._here.acquire(blocking=monotonic() < self._began + START):
            try:
                return answer(task)
            finally:
                self._here.release()
        return self._children.attempt(task, self._patience.limit, self._patience.tries)

    def close(self) -> None:
        """Drop what is not done and end all processes."""
        self._threads.shutdown(wait=False, cancel_futures=True)
        self._children.close()
        self._threads.shutdown()


_of_this_worker = Children()


def _on_worker(task: Task, patience: Patience) -> object:
    return _of_this_worker.attempt(task, patience.limit, patience.tries)


class Cluster:
    """A Dask cluster. Every thread of a worker has a process of its own for its jobs."""

    def __init__(self, address: str, patience: Patience) -> None:
        try:
            import distributed
        except ImportError:
            raise InputError(
                "--scheduler", address, "Dask: install rps-bench[cluster] here and on the workers"
            ) from None
        client: Any = distributed.Client  # untyped
        # Its own log repeats, with a traceback, what becomes one sentence here.
        logging.getLogger("distributed").setLevel(logging.CRITICAL)
        try:
            self._client = client(address, timeout=10, set_as_default=False)
        except (OSError, ValueError, TypeError) as error:
            why = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise InputError(
                "--scheduler", address, f"the address of a running Dask scheduler ({why})"
            ) from None
        self._patience = patience
        self.cores = sum(self._client.nthreads().values())
        if not self.cores:
            self._client.close()
            raise InputError("--scheduler", address, "a Dask cluster with at least one worker")

    def submit(self, task: Task) -> Any:
        """Return a future of the task's answer, or of a `Failure`."""
        return self._client.submit(_on_worker, task, self._patience, pure=False)

    def close(self) -> None:
        """Let go of the cluster; what it still holds of this run is dropped."""
        self._client.close()


@contextmanager
def engine(cores: int, scheduler: str | None, patience: Patience) -> Iterator[Engine]:
    """Yield a cluster at the `scheduler`'s address, or else `cores` of this machine."""
    chosen = Local(cores, patience) if scheduler is None else Cluster(scheduler, patience)
    try:
        yield chosen
    finally:
        chosen.close()
