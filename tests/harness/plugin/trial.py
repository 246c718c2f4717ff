"""A reference model of somebody else's, installed as a plugin, that fails in every way there is.

It answers Euler and Bernoulli's frequencies. Where the tilt is negative it does what its number of
elements says.
"""

import os
import signal
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from analytic import Continuum, Mechanism, Modes, Pose
from analytic.model import Info
from reference_models import ModelError

FINE, SLOW, CRASH, HANG, REFUSE, FLAKY, BUG, EXIT, MISS, BAD = range(1, 11)


@dataclass(frozen=True)
class Trial:
    elements: int = FINE

    @classmethod
    def info(cls) -> Info:
        return Info("made up", "trial", os.environ.get("TRIAL_VERSION", "1"), 1)

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        if self.elements == SLOW:
            time.sleep(0.02)
        elif pose.tilt < 0:
            self.fail(pose)
        modes = Continuum().modes(mechanism, pose, count + 1)
        left = np.arange(count) + (np.arange(count) >= 2) * (
            self.elements == MISS and pose.tilt < 0
        )
        log = os.environ.get("TRIAL_LOG")
        if log:
            with Path(log).open("a") as file:
                file.write(f"{pose.z!r}\n")
        frequencies = 1.0001 * modes.frequencies[left]
        if self.elements == BAD and pose.tilt < 0:
            frequencies[2] = {1: np.nan, 2: np.inf, 3: -1.0}.get(round(-1e3 * pose.tilt), 0.0)
        return replace(
            modes,
            frequencies=frequencies,
            platform=modes.platform[left],
            limbs=modes.limbs[left],
            theory="Euler-Bernoulli",
            version="trial 1",
        )

    def fail(self, pose: Pose) -> None:
        if self.elements == CRASH:
            os.kill(os.getpid(), signal.SIGSEGV)
        elif self.elements == HANG:
            signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGALRM, signal.SIGTERM])
            time.sleep(3600)
        elif self.elements == REFUSE:
            raise ModelError("trial: will not")
        elif self.elements == FLAKY:
            tried = Path(os.environ["TRIAL_TRIED"]) / repr(pose.z)
            if not tried.exists():
                tried.touch()
                os.kill(os.getpid(), signal.SIGKILL)
        elif self.elements == BUG:
            raise ZeroDivisionError("a bug")
        elif self.elements == EXIT:
            os._exit(7)
