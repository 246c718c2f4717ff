"""Runs the analytic model and its simulators side by side, and says why their answers differ.

`study("table", cases="case1")` is a study from Python or a notebook; `run` solves without one.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from harness.api import study
    from harness.bench import run

__all__ = ["run", "study"]


def __getattr__(name: str) -> Any:
    """Load what is asked for only now: the command line starts without it."""
    if name in __all__:
        return getattr(import_module(f"harness.{'api' if name == 'study' else 'bench'}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
