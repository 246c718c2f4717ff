"""Models that answer, and are wrong in what only their author can know: for `rps-bench verify`."""

from dataclasses import replace

import numpy as np
from wrong import Honest  # type: ignore[import-not-found]

from analytic import Mechanism, Modes, Pose
from analytic.model import Info


class Lopsided(Honest):
    """Its frequencies depend on where x points."""

    def spoil(self, mechanism: Mechanism, pose: Pose, count: int) -> Modes:
        modes = self.right(mechanism, pose, count)
        return replace(modes, frequencies=modes.frequencies * (1 + 1e-6 * np.sin(pose.azimuth)))


class Metres(Honest):
    """A constant in metres is left in it."""

    def spoil(self, mechanism: Mechanism, pose: Pose, count: int) -> Modes:
        modes = self.right(mechanism, pose, count)
        return replace(modes, frequencies=modes.frequencies * (1 + 1e-7 * pose.z))


class Split(Honest):
    """Level, its repeated modes are two."""

    def spoil(self, mechanism: Mechanism, pose: Pose, count: int) -> Modes:
        modes = self.right(mechanism, pose, count)
        return replace(modes, frequencies=modes.frequencies * (1 + 1e-7 * np.arange(count)))


class Twice(Honest):
    """Level, its second shape is its first."""

    def spoil(self, mechanism: Mechanism, pose: Pose, count: int) -> Modes:
        modes = self.right(mechanism, pose, count)
        if pose.tilt == 0 and count > 1:
            modes.platform[1], modes.limbs[1] = modes.platform[0], modes.limbs[0]
        return modes


class Slipped(Honest):
    """Its limbs end beside the platform's joints."""

    def spoil(self, mechanism: Mechanism, pose: Pose, count: int) -> Modes:
        modes = self.right(mechanism, pose, count)
        modes.limbs[:, :, -1] *= 0.9
        return modes


class Rude(Honest):
    """Its errors are whatever happens."""

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        1 / count
        return self.right(mechanism, pose, min(count, 20))


class SecondOrder(Honest):
    """It says that it converges at another order."""

    @classmethod
    def info(cls) -> Info:
        return replace(Honest.info(), order=2)


class Backwards(Honest):
    """What it says of itself cannot be."""

    @classmethod
    def info(cls) -> Info:
        return replace(Honest.info(), ladder=(8, 4), version="")
