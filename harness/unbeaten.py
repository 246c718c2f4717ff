"""What nothing beats in two numbers at once: which ones, and how they are drawn."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from string import ascii_lowercase
from typing import Any, TypeVar

from harness.signatures import Axes

T = TypeVar("T")


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


def draw_front(axes: Axes, points: Sequence[Point], colour: str, **how: Any) -> None:
    """Draw what nothing beats, joined; a letter beside each point stands for its name below."""
    axes.plot([p.x for p in points], [p.y for p in points], color=colour, lw=1.4, **how)
    begun = len(axes.get_legend_handles_labels()[1])
    for letter, name in zip(
        ascii_lowercase[begun:], dict.fromkeys(p.name for p in points), strict=False
    ):
        own = [(p.x, p.y) for p in points if p.name == name]
        axes.plot(*zip(*own, strict=True), ls="", color=colour, marker=f"$\\mathrm{{{letter}}}$",
                  ms=7, label=name)  # fmt: skip
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), fontsize=7, ncols=2)
