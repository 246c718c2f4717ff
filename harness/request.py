"""What is asked of a study: objects, parsed already; and how a study says what it takes."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from harness.cases import Case
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
    """

    cases: tuple[Case, ...]
    theory: Named
    references: tuple[Named, ...]
    elements: tuple[int, ...] | None = None
    shown: tuple[int, ...] = (1, 2, 3, 4, 5, 6)
    options: Mapping[str, Any] = field(default_factory=dict)

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
