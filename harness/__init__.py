"""Runs the analytic model and its simulators side by side, and says why their answers differ.

`study("table", cases="case1")` is a study from Python or a notebook; `run` solves without one.
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from harness.api import study
    from harness.bench import run

__all__ = ["run", "study"]


def __getattr__(name: str) -> Any:
    """Load what is asked for only now: the command line starts without it."""
    if name == "study":
        from harness.api import study

        return study
    if name == "run":
        from harness.bench import run

        return run
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
