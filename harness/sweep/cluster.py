"""The jobs of a sweep on a Dask cluster: one that is reached, has workers, and keeps both."""

import logging
from collections.abc import Callable
from contextlib import suppress
from queue import Empty, SimpleQueue
from threading import Thread
from time import monotonic
from typing import Any

from analytic import InputError
from harness.sweep.engine import Patience
from harness.workers import Children, Task

REACH = 10.0
"""Seconds that a scheduler, or its last worker, may be out of reach."""

_of_this_worker = Children()


def _on_worker(task: Task, patience: Patience) -> object:
    return _of_this_worker.attempt(task, patience.limit, patience.tries)


class Cluster:
    """A Dask cluster. Every thread of a worker has a process of its own for its jobs.

    Raises `InputError` for an `address` without a scheduler, or one without workers.
    """

    def __init__(self, address: str, patience: Patience) -> None:
        try:
            import distributed
        except ImportError:
            raise self._refused(
                address, "Dask: install rps-bench[cluster] here and on the workers"
            ) from None
        dask: Any = distributed  # untyped
        # Its own log repeats, with a traceback, what becomes one sentence here.
        for name in ("distributed", "distributed.client", "asyncio"):
            logging.getLogger(name).setLevel(logging.CRITICAL)
        self._address, self._patience = address, patience
        try:
            # First, for a client that cannot read its address is never quite closed.
            dask.comm.get_address_host_port(address)
            self._client = _within(
                2 * REACH, lambda: dask.Client(address, timeout=REACH, set_as_default=False)
            )
        except (OSError, ValueError, TypeError) as error:
            why = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise self._refused(
                address, f"the address of a running Dask scheduler, tcp://HOST:PORT ({why})"
            ) from None
        self.cores = self._threads()
        if not self.cores:
            self.close()
            raise self._refused(address, "a Dask cluster with at least one worker")
        self._gone: float | None = None

    @staticmethod
    def _refused(address: str, expected: str) -> InputError:
        return InputError("scheduler", address, expected)

    def _threads(self) -> int:
        """Return how many threads all workers have; 0 where the scheduler does not answer."""
        try:
            return sum(_within(REACH, self._client.nthreads).values())
        except (OSError, RuntimeError, ValueError):
            return 0

    def submit(self, task: Task) -> Any:
        """Return a future of the task's answer, or of a `Failure`."""
        return self._client.submit(_on_worker, task, self._patience, pure=False)

    def check(self) -> None:
        """Raise `InputError` where the scheduler, or every worker, has been gone for `REACH`."""
        status, now = self._client.status, monotonic()
        if status == "running" and self._threads():
            self._gone = None
            return
        self._gone = self._gone or now
        if status == "closed" or now > self._gone + REACH:
            lost = "every worker" if status == "running" else "its scheduler"
            raise self._refused(
                self._address,
                f"a Dask cluster that lasts as long as the sweep ({lost} has gone; "
                "finished jobs are kept: the same command again computes the others)",
            )

    def close(self) -> None:
        """Let go of the cluster; what it still holds of this run is dropped."""
        with suppress(OSError):
            _within(REACH, self._client.close)


def _within(seconds: float, call: Callable[[], Any]) -> Any:
    """Return what `call` does, or raise `TimeoutError`: Dask waits for ever for a silent port."""
    answers: SimpleQueue[Any] = SimpleQueue()

    def ask() -> None:
        try:
            answers.put((call(), None))
        except BaseException as error:
            answers.put((None, error))

    Thread(target=ask, daemon=True).start()
    try:
        answer, error = answers.get(timeout=seconds)
    except Empty:
        raise TimeoutError(f"no answer within {seconds:g} s") from None
    if error is not None:
        raise error
    return answer
