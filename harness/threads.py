"""One BLAS thread: small matrices on many are slower by orders of magnitude."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS"), "1"
)
"""What libraries read when they are loaded."""


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
