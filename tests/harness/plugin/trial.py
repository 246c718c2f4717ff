"""A reference model of somebody else's, installed as a plugin, that fails in every way there is.

Where the tilt is negative it does what its number of elements says; elsewhere it answers.
"""

import os
import signal
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from analytic import Continuum, Mechanism, Modes, Pose
from reference_models import ModelError
from reference_models.protocol import Info

FINE, SLOW, CRASH, HANG, REFUSE, FLAKY, BUG, EXIT, MISS = range(1, 10)


@dataclass(frozen=True)
class Trial:
    elements: int = FINE

    @classmethod
    def info(cls) -> Info:
        return Info("made up", "trial", os.environ.get("TRIAL_VERSION", "1"), 1)

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        if self.elements == MISS:
            return self.miss(mechanism, pose, count)
        if self.elements == SLOW:
            time.sleep(0.02)
        elif pose.tilt < 0:
            self.fail(pose)
        frequencies = 100 * pose.z * np.arange(1, count + 1) + np.sin(pose.azimuth)
        shapes = np.zeros((count, 6)), np.zeros((count, len(mechanism.limbs), 11, 3))
        log = os.environ.get("TRIAL_LOG")
        if log:
            with Path(log).open("a") as file:
                file.write(f"{pose.z!r}\n")
        return Modes(
            frequencies, *shapes, "made up", "trial", "trial 1", self.elements, 1, 0.0, 0.0, 0.0
        )

    def miss(self, mechanism: Mechanism, pose: Pose, count: int) -> Modes:
        """Answer as a simulator of Euler and Bernoulli's beams, without the third mode."""
        modes = Continuum().modes(mechanism, pose, count + 1)
        left = np.arange(count) + (np.arange(count) >= 2) * (pose.tilt < 0)
        return replace(
            modes,
            frequencies=1.0001 * modes.frequencies[left],
            platform=modes.platform[left],
            limbs=modes.limbs[left],
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
