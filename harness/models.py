"""Model names as people write them: NAME, NAME@ELEMENTS, NAME@COARSE+FINE or NAME@exact."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from analytic import (
    Continuum,
    InputError,
    Mechanism,
    Modes,
    Pose,
    Substructure,
    condensed_frequencies,
)
from analytic.theory import BEAMS
from reference_models import names, reference
from reference_models.protocol import find

EXACT = "exact"
SOLID_LIMB = "solid-limb"
"""Solid rods as tables over their length: 3-D accuracy at analytic cost."""
MADE_FROM = "ngsolve-solid"  # whose meshes those tables are made from
SOLID_ELEMENTS = 4
PAPER_ELEMENTS = 3  # what the paper settles on, Section 3.3


class Model(Protocol):
    """What analytic models and simulators have in common."""

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        """Return the `count` lowest modes at one pose."""
        ...


@dataclass(frozen=True)
class Spec:
    """One model with its number of elements: None for exact, two numbers for extrapolation."""

    name: str
    elements: int | tuple[int, int] | None
    shear: str | float = "cowper"

    @property
    def label(self) -> str:
        """The name that `parse` reads back."""
        match self.elements:
            case None:
                return f"{self.name}@{EXACT}"
            case (coarse, fine):
                return f"{self.name}@{coarse}+{fine}"
            case _:
                return f"{self.name}@{self.elements}"

    @property
    def analytic(self) -> bool:
        """Whether this is a model of `analytic`, not a simulator."""
        return self.name in BEAMS

    def build(self) -> Model:
        """Return the model; raises `UnavailableError` where its program is missing."""
        if self.name == SOLID_LIMB:
            from harness.solid_cache import solid_limb  # meshes and scipy: half a second

            assert isinstance(self.elements, int), "parse allows nothing else"
            return solid_limb(self.elements)
        if not self.analytic:
            settings: dict[str, Any] = {"shear": self.shear} if takes_shear(self.name) else {}
            return reference(self.name, self.elements, **settings)
        if isinstance(self.elements, int):
            return Substructure(self.elements, self.name, self.shear)
        return Continuum(self.name, self.shear)


def batch_solver(spec: Spec) -> Callable[[Mechanism, Pose, int], NDArray[np.float64]] | None:
    """Return what gives frequencies (len(poses), count) [Hz] of many poses a call.

    None for a model that takes one pose at a time.
    """
    if spec.analytic:
        elements = spec.elements if isinstance(spec.elements, int) else None
        theory: dict[str, Any] = {"beam": spec.name, "shear": spec.shear}
        return lambda mechanism, poses, count: condensed_frequencies(
            mechanism, poses, elements, count=count, **theory
        )
    if spec.name == SOLID_LIMB:
        from harness.solid_cache import solid_limb

        assert isinstance(spec.elements, int), "parse allows nothing else"
        return solid_limb(spec.elements).frequencies
    return None


def takes_shear(name: str) -> bool:
    """Return whether the reference model `name` has a shear coefficient to choose."""
    return "shear" in getattr(find(name), "__dataclass_fields__", {})


def known() -> list[str]:
    """Return all model names: the theories, the solid limb, then the reference models."""
    return [*BEAMS, SOLID_LIMB, *names()]


def parse(text: str, option: str, shear: str | float = "cowper") -> Spec:
    """Return the model that `text` names; `option` is named if it cannot be read.

    A bare name means three elements for an analytic model (the paper's number), and a simulator's
    own two refinements, extrapolated.
    """
    name, at, elements = text.partition("@")
    if name not in BEAMS and name not in known():
        raise InputError(
            option, text, f"one of {', '.join(known())}, or such a name with @ELEMENTS"
        )
    spec = Spec(name, None, shear)
    if not at:
        if spec.analytic:
            return Spec(name, PAPER_ELEMENTS, shear)
        if name == SOLID_LIMB:
            return Spec(name, SOLID_ELEMENTS, shear)
        return Spec(name, find(name).info().refinements, shear)
    if elements == EXACT and spec.analytic:
        return spec
    numbers = [int(part) if part.isdecimal() else 0 for part in elements.split("+")]
    if len(numbers) == 1 and numbers[0] > 0:
        return Spec(name, numbers[0], shear)
    single = spec.analytic or name == SOLID_LIMB
    if len(numbers) == 2 and not single and 0 < numbers[0] < numbers[1]:
        return Spec(name, (numbers[0], numbers[1]), shear)
    forms = f"{name}@16, or {name}@8+16 to extrapolate"
    if single:
        forms = f"{name}@3 or {name}@exact" if spec.analytic else f"{name}@{SOLID_ELEMENTS}"
    raise InputError(option, text, f"elements as in {forms}")


def parse_analytic(text: str, option: str, shear: str | float = "cowper") -> Spec:
    """Return the analytic model that `text` names, as `parse`; a simulator is refused."""
    spec = parse(text, option, shear)
    if not spec.analytic:
        raise InputError(option, text, f"an analytic model: {', '.join(BEAMS)}")
    return spec


def formal_order(spec: Spec) -> float:
    """Return the order at which a model's frequencies converge in the elements."""
    if not spec.analytic:
        return find(MADE_FROM if spec.name == SOLID_LIMB else spec.name).info().order
    return 2 if spec.name == "timoshenko" else 4
