"""Model names as people write them: NAME, NAME@ELEMENTS, NAME@COARSE+FINE or NAME@exact."""

from dataclasses import dataclass
from typing import Any, Protocol

from analytic import Continuum, InputError, Mechanism, Modes, Pose, Substructure
from analytic.theory import BEAMS
from reference_models import names, reference
from reference_models.protocol import find

EXACT = "exact"
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
        if not self.analytic:
            settings: dict[str, Any] = {"shear": self.shear} if takes_shear(self.name) else {}
            return reference(self.name, self.elements, **settings)
        if isinstance(self.elements, int):
            return Substructure(self.elements, self.name, self.shear)
        return Continuum(self.name, self.shear)


def takes_shear(name: str) -> bool:
    """Return whether the reference model `name` has a shear coefficient to choose."""
    return "shear" in getattr(find(name), "__dataclass_fields__", {})


def known() -> list[str]:
    """Return all model names: the analytic theories, then the reference models."""
    return [*BEAMS, *names()]


def parse(text: str, option: str, shear: str | float = "cowper") -> Spec:
    """Return the model that `text` names; `option` is named if it cannot be read.

    A bare name means three elements for an analytic model (the paper's number), and a simulator's
    own two refinements, extrapolated.
    """
    name, at, elements = text.partition("@")
    if name not in known():
        raise InputError(
            option, text, f"one of {', '.join(known())}, or such a name with @ELEMENTS"
        )
    spec = Spec(name, None, shear)
    if not at:
        if spec.analytic:
            return Spec(name, PAPER_ELEMENTS, shear)
        return Spec(name, find(name).info().refinements, shear)
    if elements == EXACT and spec.analytic:
        return spec
    numbers = [int(part) if part.isdecimal() else 0 for part in elements.split("+")]
    if len(numbers) == 1 and numbers[0] > 0:
        return Spec(name, numbers[0], shear)
    if len(numbers) == 2 and not spec.analytic and 0 < numbers[0] < numbers[1]:
        return Spec(name, (numbers[0], numbers[1]), shear)
    forms = (
        f"{name}@3 or {name}@exact"
        if spec.analytic
        else f"{name}@16, or {name}@8+16 to extrapolate"
    )
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
        return find(spec.name).info().order
    return 2 if spec.name == "timoshenko" else 4
