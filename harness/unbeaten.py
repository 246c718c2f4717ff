"""What nothing beats in two numbers at once: which ones, and how they are drawn."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

from harness.signatures import Axes

T = TypeVar("T")
CLOSE = 3.0
"""Factor in both numbers within which one name would run into the next."""
BETTER = 2.0
"""Factor in y from one name of a thinned front to the next."""


def unbeaten(points: Iterable[T], key: Callable[[T], tuple[float, float]]) -> list[T]:
    """Return the points that no other equals or betters in both numbers of `key`, the less the
    better; by the first number."""
    found: list[T] = []
    for point in sorted(points, key=key):
        if not found or key(point)[1] < key(found[-1])[1]:
            found.append(point)
    return found


@dataclass(frozen=True)
class Mark:
    """A way at `x` and `y` of a picture, and its `name`; those of one `curve` are joined."""

    x: float
    y: float
    name: str
    curve: str = ""


def draw(
    axes: Axes,
    marks: Sequence[Mark],
    fronts: Mapping[str, Sequence[Mark]],
    *,
    rises: bool = False,
    thin: bool = False,
) -> None:
    """Draw all marks faintly, those of a curve joined, and `fronts` by colour, all log-log.

    A front's marks are joined, and each way is named at its last one, beside the curve: below it to
    the left, of a first of several fronts above it to the right; the other way round where it
    `rises`. Of close neighbours names stand under each other; `thin` leaves out those that are
    hardly better than the last one named.
    """
    axes.set(xscale="log", yscale="log")
    axes.grid(alpha=0.25)
    for curve in dict.fromkeys(mark.curve for mark in marks):
        own = sorted((mark.x, mark.y) for mark in marks if mark.curve == curve)
        axes.plot(*zip(*own, strict=True), "o-" if curve else "o", color="0.82", ms=3, lw=0.8)
    for place, (colour, front) in enumerate(fronts.items(), 1):
        right = place < len(fronts)
        axes.plot([mark.x for mark in front], [mark.y for mark in front], "o-", color=colour, ms=5,
                  lw=1.4, drawstyle="steps-post" if thin else "default")  # fmt: skip
        below = 0
        before: Mark | None = None
        for mark in {mark.name: mark for mark in front}.values():
            if thin and before and mark.y > before.y / BETTER:
                continue
            close = (
                before is not None
                and mark.x < CLOSE * before.x
                and 1 / CLOSE < mark.y / before.y < CLOSE
            )
            below, before = below + 1 if close else 0, mark
            axes.annotate(
                mark.name.replace("[", "\n["), (mark.x, mark.y), fontsize=7, color=colour,
                xytext=(6 if right else -6, (2 if right != rises else -2) - 9 * below),
                textcoords="offset points", ha="left" if right else "right",
                va="bottom" if right != rises else "top",
            )  # fmt: skip
