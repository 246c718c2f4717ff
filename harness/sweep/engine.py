"""Runs jobs on all cores of this machine, or on a Dask cluster; both take them one by one."""

from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, contextmanager
from dataclasses import dataclass
from queue import Empty, SimpleQueue
from threading import Lock
from typing import Any, Protocol, TypeVar

from harness.workers import Children, Failure, Task, attempt

LOOK = 1.0
"""Seconds without a finished job after which the engine is asked whether there is hope."""
FETCH = 10.0
"""Seconds to wait for the answer of a finished job before the engine is asked likewise."""


AHEAD = 3
"""Jobs handed out for each core: enough that none waits, few enough to keep memory flat."""


class Work(Task, Protocol):
    """A task that says whether it must run in a process of its own: it may crash or hang."""

    @property
    def isolated(self) -> bool: ...  # noqa: D102


T = TypeVar("T", bound=Work)


@dataclass(frozen=True)
class Patience:
    """How long a simulator's job may take [s], and how often it is tried if its process dies."""

    limit: float = 60.0
    tries: int = 3


class Engine(Protocol):
    """Where jobs run."""

    cores: int

    def submit(self, task: Work) -> Any:
        """Return a future of the task's answer, or of a `Failure`."""
        ...

    def check(self) -> None:
        """Raise `InputError` where jobs can no longer be expected to finish."""
        ...


def run(engine: Engine, tasks: Iterable[T]) -> Iterator[tuple[T, Any]]:
    """Yield every task with its answer, or a `Failure`, as they finish.

    Raises `InputError` where the engine is lost.
    """
    finished: SimpleQueue[tuple[T, Any]] = SimpleQueue()
    waiting = 0

    def next_done() -> tuple[T, Any]:
        taken: tuple[T, Any] | None = None
        while True:
            try:
                taken = taken or finished.get(timeout=LOOK)
                return taken[0], taken[1].result(timeout=FETCH)
            except (Empty, TimeoutError):  # or its Dask worker has gone, and the answer with it
                engine.check()
            except Exception as error:  # a Dask worker that died once too often, say
                engine.check()
                assert taken is not None, "a queue raises nothing else"
                why = f"{type(error).__name__}: {str(error).strip() or 'no reason'}"
                return taken[0], Failure(why)

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


class Local:
    """All cores of this machine. Simulators run in processes of their own, which may die.

    One task that is safe at a time runs in this process, which is ready at once; the others run in
    processes too, for on threads of one process they wait for each other's interpreter.
    """

    def __init__(self, cores: int, patience: Patience, children: Children) -> None:
        self.cores = cores
        self._patience = patience
        self._children = children
        self._here = Lock()
        self._threads = ThreadPoolExecutor(cores)

    def submit(self, task: Work) -> Any:
        """Return a future of the task's answer, or of a `Failure`."""
        return self._threads.submit(self._solve, task)

    def check(self) -> None:
        """Do nothing: this machine is here."""

    def _solve(self, task: Work) -> object:
        if not task.isolated and self._here.acquire(blocking=False):
            try:
                return attempt(task)
            finally:
                self._here.release()
        return self._children.attempt(task, self._patience.limit, self._patience.tries)

    def close(self) -> None:
        """Drop what is not done and end all processes."""
        self._threads.shutdown(wait=False, cancel_futures=True)
        self._children.close()
        self._threads.shutdown()


@contextmanager
def engine(
    cores: int,
    scheduler: str | None,
    patience: Patience,
    simulations: int = 0,
    children: Children | None = None,
) -> Iterator[Engine]:
    """Yield a cluster at the `scheduler`'s address, or else `cores` of this machine.

    `simulations`: how many jobs need a process; as many as can be of use are started at once.
    `children`: its processes, some of which may have been started already.
    """
    chosen: Any
    if scheduler is None:
        children = Children() if children is None else children
        children.start(min(cores, simulations))
        chosen = Local(cores, patience, children)
    else:
        from harness.sweep.cluster import Cluster

        chosen = Cluster(scheduler, patience)
    with closing(chosen):
        yield chosen
