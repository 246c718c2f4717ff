"""Small matrices want one BLAS thread, also of libraries that are loaded later."""

import os
import subprocess
import sys

from harness.threads import ONE_THREAD

LATER = """
from harness.threads import one_thread
with one_thread():
    import scipy.linalg
    from threadpoolctl import threadpool_info
    print(sorted({pool["num_threads"] for pool in threadpool_info()}), len(threadpool_info()))
"""


def test_libraries_loaded_later_have_one_thread() -> None:
    free = {name: value for name, value in os.environ.items() if name not in ONE_THREAD}
    many = free | dict.fromkeys(ONE_THREAD, "2")
    done = subprocess.run(
        [sys.executable, "-c", LATER], env=many, capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["[1]", "2"]  # numpy's and scipy's
