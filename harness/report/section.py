"""What a section of the page is, and the numbers in it that can be asked where they come from."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Section:
    """One part of the page.

    Attributes: `key`, its anchor and the name of its templates; `title`; `context` for the
    template; `data` for the script of the page; `missing`, which command makes what it needs,
    where that is not there.
    """

    key: str
    title: str
    context: Mapping[str, Any] = field(default_factory=dict)
    data: Any = None
    missing: str = ""


@dataclass(frozen=True)
class Cell:
    """A number on the page: `text` as shown, `full` with every digit and its unit, `what` it is,
    and `record`, where it comes from, in the page's ledger."""

    text: str
    full: str
    what: str
    record: int


def digits(value: float | None, number: int = 12) -> float | None:
    """Return `value` with `number` significant digits; None for what is no number."""
    if value is None or not math.isfinite(value):
        return None
    return float(f"{value:.{number}g}")
