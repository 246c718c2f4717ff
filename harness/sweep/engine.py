"""Runs jobs on all cores of this machine, or on a Dask cluster; both take them one by one."""

from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from queue import Empty, SimpleQueue
from threading import Lock
from typing import Any, NamedTuple, TypeVar

from harness.workers import Children, Failure, Task, attempt

LOOK = 1.0
"""Seconds without a finished job after which the engine is asked whether there is hope."""
FETCH = 10.0
"""Seconds to wait for the answer of a finished job before the engine is asked likewise."""
AHEAD = 3
"""Jobs handed out for each core: enough that none waits, few enough to keep memory flat."""


T = TypeVar("T", bound=Task)


class Patience(NamedTuple):
    """How long a simulator's job may take [s], and how often it is tried if its process dies."""

    limit: float = 60.0
    tries: int = 3


def run(engine: "Engine", tasks: Iterable[T]) -> Iterator[tuple[T, Any]]:
    """Yield every task with its answer, or a `Failure`, as they finish.

    Raises `InputError` where the engine is lost.
    """
    finished: SimpleQueue[tuple[T, Any]] = SimpleQueue()
    waiting = 0

    def next_done() -> tuple[T, Any]:
        done: tuple[T, Any] | None = None
        while True:
            try:
                done = done or finished.get(timeout=LOOK)
                return done[0], done[1].result(timeout=FETCH)
            except (Empty, TimeoutError):  # or its Dask worker has gone, and the answer with it
                engine.check()
            except Exception as error:  # a Dask worker that died once too often, say
                engine.check()
                assert done is not None, "a queue raises nothing else"
                why = f"{type(error).__name__}: {str(error).strip() or 'no reason'}"
                return done[0], Failure(why)

    for task in tasks:
        engine.submit(task).add_done_callback(
            lambda future, task=task: finished.put((task, future))
        )
        waiting += 1
        if waiting >= AHEAD * engine.cores:
            yield next_done()
            waiting -= 1
    for _ in range(waiting):
        yield next_done()


class Engine:
    """All cores of this machine. Tasks that are `isolated` run in processes of their own, which may
    die.

    One of the others at a time runs in this process, which is ready at once; the rest run in
    processes too, for on threads of one process they wait for each other's interpreter.
    """

    def __init__(self, cores: int, patience: Patience, children: Children) -> None:
        self.cores, self._patience, self._children = cores, patience, children
        self._here = Lock()
        self._threads = ThreadPoolExecutor(cores)

    def submit(self, task: Task) -> Any:
        """Return a future of the task's answer, or of a `Failure`."""
        return self._threads.submit(self._solve, task)

    def check(self) -> None:
        """Raise `InputError` where jobs cannot be expected to finish: on this machine they can."""

    def _solve(self, task: Any) -> object:
        if not task.isolated and self._here.acquire(blocking=False):
            try:
                return attempt(task)
            finally:
                self._here.release()
        return self._children.attempt(task, *self._patience)

    def close(self) -> None:
        """Drop what is not done and end all processes."""
        self._threads.shutdown(wait=False, cancel_futures=True)
        self._children.close()
        self._threads.shutdown()
