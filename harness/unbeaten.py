"""What nothing beats in two numbers at once: which ones, and how they are drawn."""

from collections.abc import Callable, Iterable, Sequence
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
class Point:
    """A way at `x` and `y` of a picture, and its `name`; those of one `curve` are joined."""

    x: float
    y: float
    name: str
    curve: str = ""


def draw_rest(axes: Axes, points: Sequence[Point]) -> None:
    """Draw all points faintly, those of a curve joined."""
    for curve in dict.fromkeys(p.curve for p in points):
        own = sorted((p.x, p.y) for p in points if p.curve == curve)
        axes.plot(*zip(*own, strict=True), "o-" if curve else "o", color="0.82", ms=3, lw=0.8)


def draw_front(
    axes: Axes,
    points: Sequence[Point],
    colour: str,
    *,
    right: bool = False,
    rises: bool = False,
    thin: bool = False,
) -> None:
    """Draw what nothing beats, joined, each way named at its last point beside the curve.

    Names stand below the curve to their left, or above it to their `right`; the other way round
    where it `rises`. Of close neighbours names stand under each other; `thin` leaves out those that
    are hardly better than the last one named.
    """
    steps = "steps-post" if thin else "default"
    axes.plot([p.x for p in points], [p.y for p in points], "o-", color=colour, ms=5, lw=1.4,
              drawstyle=steps)  # fmt: skip
    below, before = 0, None
    for p in {p.name: p for p in points}.values():
        if thin and before and p.y > before.y / BETTER:
            continue
        close = before and p.x < CLOSE * before.x and 1 / CLOSE < p.y / before.y < CLOSE
        below, before = below + 1 if close else 0, p
        above = right != rises
        axes.annotate(
            p.name.replace("[", "\n["), (p.x, p.y),
            xytext=(6 if right else -6, (2 if above else -2) - 9 * below),
            textcoords="offset points", fontsize=7, color=colour,
            ha="left" if right else "right", va="bottom" if above else "top",
        )  # fmt: skip
