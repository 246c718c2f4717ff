"""Somebody else's models, installed as a plug-in: one honest, the others wrong in one way each."""

import ctypes
import sys
import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from analytic import Mechanism, Modes, Pose, Substructure
from analytic.model import Info


@dataclass(frozen=True)
class Honest:
    """The paper's own elements, under another name."""

    elements: int = 4

    @classmethod
    def info(cls) -> Info:
        return Info(
            "Euler-Bernoulli",
            "made up",
            "1",
            order=4,
            refinements=(4, 8),
            ladder=(2, 4, 8),
            limit="euler-bernoulli",
        )

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Any:
        return self.spoil(mechanism, pose, count)

    def spoil(self, mechanism: Mechanism, pose: Pose, count: int) -> Any:
        return self.right(mechanism, pose, count)

    def right(self, mechanism: Mechanism, pose: Pose, count: int) -> Modes:
        return Substructure(self.elements).modes(mechanism, pose, count)


def wrong(name: str) -> Any:
    """Return a decorator that makes a class of a function of the right modes."""

    def make(function: Any) -> type[Honest]:
        def spoil(self: Honest, mechanism: Mechanism, pose: Pose, count: int) -> Any:
            return function(self.right(mechanism, pose, count))

        return dataclass(frozen=True)(type(name, (Honest,), {"spoil": spoil}))

    return make


def scaled(factor: float) -> Any:
    return lambda modes: replace(modes, frequencies=factor * modes.frequencies)


def _nan(modes: Modes) -> Modes:
    frequencies = modes.frequencies.copy()
    frequencies[2] = np.nan
    return replace(modes, frequencies=frequencies)


def _raise(_: Modes) -> Modes:
    raise ValueError("a bug")


Kilohertz = wrong("Kilohertz")(scaled(1e-3))
Radians = wrong("Radians")(scaled(2 * np.pi))
Percent = wrong("Percent")(scaled(1.01))
Few = wrong("Few")(lambda modes: modes.first(len(modes.frequencies) - 1))
NotANumber = wrong("NotANumber")(_nan)
Raises = wrong("Raises")(_raise)
Crashes = wrong("Crashes")(lambda _: ctypes.string_at(0))
Exits = wrong("Exits")(lambda _: sys.exit(0))
Hangs = wrong("Hangs")(lambda _: time.sleep(600))
Shape = wrong("Shape")(lambda modes: replace(modes, limbs=modes.limbs[:, :, :5]))
Zero = wrong("Zero")(
    lambda modes: replace(modes, platform=0 * modes.platform, limbs=0 * modes.limbs)
)
Unsorted = wrong("Unsorted")(lambda modes: replace(modes, frequencies=modes.frequencies[::-1]))
Array = wrong("Array")(lambda modes: modes.frequencies)
Large = wrong("Large")(
    lambda modes: replace(modes, platform=1000 * modes.platform, limbs=1000 * modes.limbs)
)
Gap = wrong("Gap")(lambda modes: replace(modes, residual=1e-3))


class Many(Honest):
    def spoil(self, mechanism: Mechanism, pose: Pose, count: int) -> Modes:
        return self.right(mechanism, pose, count + 1)


class Missing(Honest):
    """Without its third mode, at every pose."""

    def spoil(self, mechanism: Mechanism, pose: Pose, count: int) -> Modes:
        modes = self.right(mechanism, pose, count + 1)
        left = [i for i in range(count + 1) if i != 2]
        return replace(
            modes,
            frequencies=modes.frequencies[left],
            platform=modes.platform[left],
            limbs=modes.limbs[left],
        )


class NoElements:
    def __init__(self) -> None:
        """Take nothing."""

    info = Honest.info

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        return Substructure(4).modes(mechanism, pose, count)


class NoInfo(Honest):
    @classmethod
    def info(cls) -> Info:
        raise RuntimeError("its licence has run out")
