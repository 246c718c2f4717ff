"""What is asked of a study, or of all: objects, parsed already; and how one says what it takes."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from math import inf, isfinite
from typing import Any

from analytic import InputError
from harness.case import Case
from reference_models import Named


@dataclass(frozen=True)
class Option:
    """An argument that a study takes beside the standard ones.

    Attributes: `name`, as in Python ("platform_mm"); `metavar` and `help` for the command line;
    `default` as text, None where there is none; `parse` makes the value of the text and raises
    `InputError` naming the argument.
    """

    name: str
    metavar: str
    help: str
    default: str | None
    parse: Callable[[str], Any]


def whole(name: str, least: int, most: int) -> Callable[[str], int]:
    """Return what reads a whole number from `least` to `most`."""

    def parse(text: str) -> int:
        if not (text.isascii() and text.isdecimal() and least <= int(text[:12]) <= most):
            raise InputError(name, text, f"a whole number from {least} to {most}")
        return int(text)

    return parse


def real(
    name: str, expected: str, least: float = -inf, most: float = inf, unit: float = 1.0
) -> Callable[[str], float]:
    """Return what reads a number from `least` to `most`, in SI: `unit` is that of the text."""

    def parse(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = inf
        if not (isfinite(value) and least <= value <= most):
            raise InputError(name, text, expected)
        return value * unit

    return parse


def one_of(name: str, *known: str) -> Callable[[str], str]:
    """Return what reads one of the words `known`."""

    def parse(text: str) -> str:
        if text not in known:
            raise InputError(name, text, f"one of {', '.join(known)}")
        return text

    return parse


@dataclass(frozen=True)
class Request:
    """What every study may be asked for.

    Attributes:
        cases: mechanisms at poses.
        theory: the model under test.
        references: what it is compared with, the first before all others.
        elements: numbers of elements s, None where each model has its own.
        shown: mode numbers from 1.
        options: values of the study's own `Option`s by name.
        absent: why references that were meant too cannot run here, by name.
    """

    cases: tuple[Case, ...]
    theory: Named
    references: tuple[Named, ...]
    elements: tuple[int, ...] | None = None
    shown: tuple[int, ...] = (1, 2, 3, 4, 5, 6)
    options: Mapping[str, Any] = field(default_factory=dict)
    absent: Mapping[str, str] = field(default_factory=dict)

    @property
    def count(self) -> int:
        """Modes solved for."""
        return max(self.shown)

    @property
    def steps(self) -> tuple[int, ...]:
        """The numbers of elements of a study that cannot do without."""
        assert self.elements is not None, "the study has a default"
        return self.elements

    def with_(self, **changes: Any) -> "Request":
        """Return this request with some of its fields changed."""
        return replace(self, **changes)


@dataclass(frozen=True)
class Plan(Request):
    """What the main job is asked for; Table I and Fig. 3 are drawn against the first reference.

    Attributes: as of `Request`; `elements` of Fig. 3; `solid`: what stands for three-dimensional
    truth, None where no solid can run; `case_file`: whether the cases are the user's own.
    """

    elements: tuple[int, ...] = tuple(range(1, 9))
    solid: Named | None = None
    case_file: bool = False

    def request(self, **changes: Any) -> Request:
        """Return what a study is asked for, some of it changed; elements are each model's own."""
        own = Request(
            self.cases, self.theory, self.references, None, self.shown, absent=self.absent
        )
        return own.with_(**changes)

    @property
    def against(self) -> tuple[Named, ...]:
        """The first reference, and the solid if there is one: a theory's peer, and the truth."""
        solid = () if self.solid is None else (self.solid,)
        return tuple(dict.fromkeys((*self.references[:1], *solid)))
