"""Cores, and one BLAS thread: small matrices on many are slower by orders of magnitude."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS"), "1"
)
"""What libraries read when they are loaded."""


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def one_thread() -> Iterator[None]:
    """Limit the libraries that are loaded, those loaded from now on, and programs started."""
    os.environ.update(ONE_THREAD)
    if "numpy" not in sys.modules:  # nothing is loaded that does not read that
        yield
        return
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1):
        yield
