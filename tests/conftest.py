"""Shared by all tests: processes, one BLAS thread, and the poses everything is checked at."""

import signal
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import settings

from analytic import Mechanism, Pose
from harness.threads import one_thread

# No test may fail because the machine was busy.
settings.register_profile("bench", deadline=None)
settings.load_profile("bench")
_limits = one_thread()
_limits.__enter__()
# A shell that runs the tests in the background has them ignore Ctrl-C, and so all that they start.
if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """Folders on two processes; files and single tests in this one, where that is quicker."""
    return 0 if all(".py" in argument for argument in config.args) else 2


@pytest.fixture(autouse=True)
def no_history(monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs of the tests are no history of anyone's, unless a test says where it is kept."""
    monkeypatch.setenv("RPS_BENCH_HISTORY", "none")


@pytest.fixture(scope="session")
def robot() -> Mechanism:
    return Mechanism.paper()


@pytest.fixture(scope="session")
def case1() -> Pose:
    return Pose(0.49)


@pytest.fixture(scope="session")
def case2() -> Pose:
    return Pose(0.49, np.radians(10), np.radians(-12))


def random_poses(count: int, seed: int) -> Pose:
    """Poses across the workspace: z 0.35-0.7 m, any azimuth, tilt to 20 degrees."""
    random = np.random.default_rng(seed)
    return Pose(
        z=random.uniform(0.35, 0.7, count),
        azimuth=random.uniform(-np.pi, np.pi, count),
        tilt=random.uniform(-np.radians(20), np.radians(20), count),
    )


@pytest.fixture(scope="session")
def workspace_poses() -> Callable[[int, int], Pose]:
    """`random_poses(count, seed)`, for tests that cannot import this file."""
    return random_poses
