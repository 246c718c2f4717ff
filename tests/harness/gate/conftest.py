"""Models that are wrong in one way, and studies small enough to plant them in."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from analytic import Mechanism, Modes, Pose
from analytic.model import Info
from harness.gate.plan import Plan
from reference_models import Named

Ask = Callable[[Mechanism, Pose], tuple[Mechanism, Pose]]


@dataclass(frozen=True)
class Wrong:
    """A model of the study that asks another question, or changes the answer."""

    model: Named
    elements: Any
    ask: Ask = lambda mechanism, pose: (mechanism, pose)
    after: Callable[[Modes], Modes] = lambda modes: modes
    factor: Callable[[Mechanism, Pose], float] = lambda mechanism, pose: 1.0
    twists: bool | None = None

    @property
    def _asked(self) -> Named:
        return replace(self.model, elements=self.elements)

    @property
    def name(self) -> str:
        return self.model.name

    @property
    def settings(self) -> Any:
        return self.model.settings

    @property
    def label(self) -> str:
        return self._asked.label

    def info(self) -> Info:
        """In this process: what is planted cannot be handed to another."""
        info = replace(self._asked.info(), isolated=False)
        return info if self.twists is None else replace(info, torsion=self.twists)

    def limit(self) -> Named | None:
        return self._asked.limit()

    def build(self) -> Any:
        return self._asked.build()

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        modes = self.after(self._asked.modes(*self.ask(mechanism, pose), count))
        return replace(modes, frequencies=modes.frequencies * self.factor(mechanism, pose))

    def frequencies(self, mechanism: Mechanism, poses: Pose, count: int = 6) -> np.ndarray:
        return np.array([self.modes(mechanism, pose, count).frequencies for pose in poses])


def planted(plan: Plan, name: str, **wrong: Any) -> Plan:
    """Return the study with every mesh of one model wrong."""

    def change(models: tuple[Named, ...]) -> tuple[Any, ...]:
        return tuple(Wrong(m, m.elements, **wrong) if m.name == name else m for m in models)

    return replace(
        plan,
        ladders=tuple(change(ladder) for ladder in plan.ladders),
        singles=change(plan.singles),
        mapped=change(plan.mapped),
    )


@pytest.fixture
def plant() -> Callable[..., Plan]:
    return planted
