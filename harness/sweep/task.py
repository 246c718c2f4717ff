"""What an engine runs, and what it gives where there is no answer; loads nothing heavy."""

from dataclasses import dataclass
from typing import Protocol


class Task(Protocol):
    """A job, or anything else that knows how to solve itself."""

    @property
    def safe(self) -> bool:
        """Whether it can neither crash nor hang."""
        ...

    def solve(self) -> object:
        """Return the answer, or raise what the model raises."""
        ...


@dataclass(frozen=True)
class Failure:
    """Why a job has no answer."""

    reason: str
