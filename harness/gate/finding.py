"""The one row of everything that the gate looks at, and its verdict."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from harness.gate.plan import group
from harness.rows import GATE

HELD, FAILED, BETTER, NOTED = "held", "failed", "better", "noted"
"""`BETTER` fails as well (a two-way ratchet), but is accepted without a reason."""
KINDS = ("frequency", "uncertainty", "shape", "mode count", "order", "missing", "property",
         "timing", "failure", "source")  # fmt: skip
"""Every kind of row, in the order in which tables show them."""
COMPARED = ("frequency", "uncertainty", "shape", "mode count", "order", "property", "timing")
"""Kinds of which there is a row for everything that was looked at, and not only for what fails."""


@dataclass(frozen=True)
class Finding:
    """One thing that is as it was, or as it must be, or not.

    Attributes: `kind`, one of `KINDS`; `model`, `case`, `mode` (from 1; None where it concerns
    all); `quantity`; its value `before` and `after`; `tolerance`, the change allowed; `verdict`;
    `cause`, as far as it can be seen. Of a property `quantity` is its name, `after` the relative
    deviation where it is worst, `tolerance` the bound, and `cause` what the bound comes from.
    """

    kind: str
    model: str
    case: str
    mode: int | None
    quantity: str
    before: float | str | None = None
    after: float | str | None = None
    tolerance: float | None = None
    verdict: str = FAILED
    cause: str = ""

    @property
    def fails(self) -> bool:
        """Whether it makes the check fail."""
        return self.verdict in (FAILED, BETTER)

    @property
    def moved(self) -> float | None:
        """The change: relative for frequencies and seconds, else the difference."""
        if not (isinstance(self.before, float) and isinstance(self.after, float)):
            return None
        if self.kind in ("frequency", "uncertainty", "timing") and self.before:
            return self.after / self.before - 1
        return self.after - self.before


def judged(holds: bool, better: bool = False) -> str:
    """Return the verdict on what `holds` or not; `better`: it moved towards what is right."""
    return HELD if holds else BETTER if better else FAILED


def condense(findings: Sequence[Finding]) -> list[tuple[Finding, int]]:
    """Return what a table shows: of the map's poses each model's worst, and how many it is of.

    Worst: the largest change over its tolerance; what has no such change is worst of all.
    """

    def excess(one: Finding) -> float:
        return abs(one.moved) / one.tolerance if one.moved is not None and one.tolerance else np.inf

    shown: list[tuple[Finding, int]] = []
    groups: dict[tuple[str, str, str], list[Finding]] = {}
    for one in findings:
        if group(one.case) == GATE and one.case != GATE:
            groups.setdefault((one.kind, one.model, one.verdict), []).append(one)
        else:
            shown.append((one, 1))
    return shown + [(max(some, key=excess), len(some)) for some in groups.values()]
