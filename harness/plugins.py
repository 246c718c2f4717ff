"""Models of other packages are loaded, and asked what they are, in processes of their own.

One that crashes, hangs, exits, prints or eats memory while it is imported or says what it is costs
its own answers. Importing this module makes it so for all that asks in this process.
"""

import atexit
import sys
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from harness.workers import Children, Failure
from reference_models import Named, UnavailableError
from reference_models.catalogue import ask, imported, known

PATIENCE = 60.0
"""Seconds that a package may take to be imported, and a model to say what it is."""


@dataclass(frozen=True)
class Question:
    """What a function finds of a model, as a process of the model's owner answers it."""

    model: Named
    what: Callable[[Named], Any]

    def solve(self) -> object:
        """Return the answer."""
        return self.what(self.model)


class Owners(Children):
    """The processes of the packages on one `sys.path`, and what they have answered."""

    def __init__(self) -> None:
        super().__init__()
        self.path = tuple(sys.path)
        self._answers: dict[object, Any] = {}

    def once(self, key: object, question: Question) -> Any:
        """Return an answer, or a `Failure`; each question is asked once, as its `key` tells."""
        if key not in self._answers:
            self._answers[key] = self.attempt(question, PATIENCE, tries=1)
        return self._answers[key]


_owners: Owners | None = None


def elsewhere(what: Callable[[Named], Any], named: Named) -> object:
    """Return `what(named)` from a process of the model's owner.

    Raises `UnavailableError` where there is none: the process dies, or takes longer than
    `PATIENCE`, or `what` raises.
    """
    global _owners
    if _owners is None or _owners.path != tuple(sys.path):
        close()
        _owners = Owners()
    # A module is imported once for all that is in it: it may have hung.
    lacking = _owners.once(known(named.name, "model").module, Question(named, imported))
    if isinstance(lacking, Failure):
        raise UnavailableError(f"it cannot be imported: {lacking.reason}")
    if lacking:
        raise UnavailableError(lacking)
    question = Question(named, what)
    found: object = _owners.once(question, question)
    if isinstance(found, Failure):
        raise UnavailableError(found.reason)
    return found


def close() -> None:
    """End the processes; the next question starts new ones."""
    global _owners
    if _owners is not None:
        _owners.close()
    _owners = None


atexit.register(close)
ask(elsewhere)
