"""Where the seconds of an answer go: the simulator's own code, and ours by phase.

Models name their phases; nothing is kept unless somebody records.
"""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

SIMULATOR = "simulator"
PHASES = (SIMULATOR, "building", "linearising", "projection", "eigen-solution", "shapes")
"""The simulator's own code; ours that describes the mechanism to it, differentiates its forces,
projects, solves for eigenvalues, and reads shapes."""


class Record:
    """Seconds by phase; "" is what no phase is named for. A phase within one is not part of it."""

    def __init__(self) -> None:
        self.seconds = dict.fromkeys(("", *PHASES), 0.0)
        self._under_way = ""
        self._since = time.perf_counter()

    def turn(self, phase: str) -> str:
        """Begin `phase` and return the one that it interrupts."""
        now, before = time.perf_counter(), self._under_way
        self.seconds[before] += now - self._since
        self._under_way, self._since = phase, now
        return before


_record: ContextVar[Record | None] = ContextVar("record", default=None)


@contextmanager
def recorded() -> Iterator[Record]:
    """Record the phases of what runs within."""
    record = Record()
    token = _record.set(record)
    try:
        yield record
        record.turn("")
    finally:
        _record.reset(token)


@contextmanager
def phase(name: str) -> Iterator[None]:
    """Count what runs within as the phase `name`, one of `PHASES`."""
    record = _record.get()
    if record is None:
        yield
        return
    before = record.turn(name)
    try:
        yield
    finally:
        record.turn(before)
