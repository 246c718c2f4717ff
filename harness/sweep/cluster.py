"""Where jobs run: here, or on a Dask cluster that is reached, has workers, and keeps both."""

import logging
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import closing, contextmanager, suppress
from threading import Thread
from time import monotonic
from typing import Any

from analytic import InputError
from harness.sweep.engine import Engine, Patience
from harness.workers import Children, Task

REACH = 10.0
"""Seconds that a scheduler, or its last worker, may be out of reach."""
BEATS = 20
"""Workers whose sign of life a scheduler takes in a second: of many each gives fewer."""

_of_this_worker = Children()


def _on_worker(task: Task, patience: Patience) -> object:
    return _of_this_worker.attempt(task, *patience)


class Cluster(Engine):
    """A Dask cluster. Every thread of a worker has a process of its own for its jobs.

    Raises `InputError` for an `address` without a scheduler, or one without workers.
    """

    def __init__(self, address: str, patience: Patience) -> None:
        try:
            import distributed
        except ImportError:
            expected = "Dask: pip install distributed, here and on the workers"
            raise InputError("scheduler", address, expected) from None
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
        except Exception as error:  # whatever answers there may say anything
            why = str(error).splitlines()[0] if str(error) else type(error).__name__
            expected = f"the address of a running Dask scheduler, tcp://HOST:PORT ({why})"
            raise InputError("scheduler", address, expected) from None
        self.cores = 0
        with suppress(OSError, RuntimeError, ValueError):  # the scheduler does not answer
            self.cores = sum(_within(REACH, self._client.nthreads).values())
        if not self.cores:
            self.close()
            raise InputError("scheduler", address, "a Dask cluster with at least one worker")
        self._gone: float | None = None

    def submit(self, task: Task) -> Any:
        """Return a future of the task's answer, or of a `Failure`."""
        return self._client.submit(_on_worker, task, self._patience, pure=False)

    def check(self) -> None:
        """Raise `InputError` where the scheduler, or every worker, has been gone for `REACH`.

        That is also where they are stopped: the scheduler does not answer, or has heard of no
        worker for as long.
        """

        def heard(dask_scheduler: Any = None) -> list[float]:
            """Return when each worker was last heard of, seconds ago; runs in the scheduler."""
            import time

            known = dask_scheduler.workers.values()
            return [time.time() - worker.last_seen for worker in known]

        status, now = self._client.status, monotonic()
        silent: list[float] | None = None
        if status == "running":
            with suppress(Exception):  # whatever it is, that is no answer
                silent = _within(REACH, lambda: self._client.run_on_scheduler(heard))
        if silent and min(silent) < max(REACH, len(silent) / BEATS):
            self._gone = None
            return
        self._gone = self._gone or now
        if status == "closed" or now > self._gone + REACH:
            lost = "its scheduler" if silent is None else "every worker"
            raise InputError(
                "scheduler",
                self._address,
                f"a Dask cluster that lasts as long as the sweep ({lost} has gone; "
                "finished jobs are kept: the same command again computes the others)",
            )

    def close(self) -> None:
        """Let go of the cluster; what it still holds of this run is dropped."""
        with suppress(OSError):
            _within(REACH, self._client.close)


@contextmanager
def engine(
    cores: int,
    scheduler: str | None,
    patience: Patience,
    children: Children | None = None,
) -> Iterator[Engine]:
    """Yield a cluster at the `scheduler`'s address, or else `cores` of this machine.

    `children`: its processes, some of which may have been started already.
    """
    if scheduler is None:
        chosen = Engine(cores, patience, children or Children())
    else:
        chosen = Cluster(scheduler, patience)
    with closing(chosen):
        yield chosen


def _within(seconds: float, call: Callable[[], Any]) -> Any:
    """Return what `call` does, or raise `TimeoutError`: Dask waits for ever for a silent port."""
    answer: Future[Any] = Future()

    def ask() -> None:
        try:
            answer.set_result(call())
        except BaseException as error:
            answer.set_exception(error)

    Thread(target=ask, daemon=True).start()
    try:
        return answer.result(timeout=seconds)
    except TimeoutError as error:
        raise error if str(error) else TimeoutError(f"no answer within {seconds:g} s") from None
