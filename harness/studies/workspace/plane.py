"""Maps over a plane of two of x, y and z, out to where the limits end: of hexapods and others."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic import InputError, Limits, Pose
from analytic.model import Model
from analytic.workspace import in_plane, rim
from harness.bench import Bench, label
from harness.case import Case
from harness.poses import cells, columns, headings
from harness.request import Option
from harness.result import Result
from harness.rows import PLANE
from harness.signatures import Array, Figure
from harness.studies.workspace.map import ORDER, Answers, limits_met, limits_said, solve
from harness.tables import Cell, Number, Table

MANY, FEW = (72, 9), (12, 4)
"""Directions and steps of models that run in this process, and of those in one of their own."""
LEAST = 1e-6
"""A platform that can go no farther than this anywhere does not move in the plane [m]."""
PLANES = "x,y", "x,z", "y,z"


def two(text: str) -> tuple[str, str]:
    """Return the two coordinates that `text` names, as in "x,y"."""
    if text not in PLANES:
        raise InputError("plane", text, f"one of {' '.join(PLANES)}")
    first, second = text.split(",")
    return first, second


OPTION = Option(
    "plane", "A,B", f"Map a plane of o's coordinates instead: {' '.join(PLANES)}.", None, two
)


@dataclass(frozen=True)
class Plane:
    """Poses of one case in a plane: from its own outwards, to where the limits end.

    Attributes: `case`; `names` of two coordinates; `limits`; `direction` (A,), evenly round from
    the first coordinate's axis [rad]; `far` (A, R), from 0 to the rim by equal steps [m].
    """

    case: Case
    names: tuple[str, str]
    limits: Limits
    direction: Array
    far: Array

    @classmethod
    def of(
        cls, case: Case, names: tuple[str, str], limits: Limits, directions: int, steps: int
    ) -> "Plane":
        """Return `steps` from 0 to the rim in so many directions.

        Raises `InputError` for a case outside its limits, or one that cannot move in the plane.
        """
        direction = 2 * np.pi * np.arange(directions) / directions
        ends = rim(case.mechanism, case.pose, names, direction, limits)
        asked = ",".join(names)
        if np.isnan(ends).any():
            raise InputError("plane", asked, f"a case within its limits, which {case.name} is not")
        if ends.max() < LEAST:
            raise InputError("plane", asked, f"one in which the platform of {case.name} can move")
        return cls(case, names, limits, direction, np.outer(ends, np.linspace(0, 1, steps)))

    @property
    def poses(self) -> Pose:
        """The poses of `far`, (A, R)."""
        return in_plane(self.case.pose, self.names, self.far, self.direction[:, None])

    @cached_property
    def wanted(self) -> NDArray[np.bool_]:
        """Which of `poses` to solve: the case's own once."""
        wanted = np.ones(self.far.shape, dtype=bool)
        wanted[1:, 0] = False
        return wanted

    def spread(self, values: Array) -> Array:
        """Return the `values` (n, ...) at the `wanted` poses as those of all, (A, R, ...)."""
        found = np.empty((*self.far.shape, *values.shape[1:]))
        found[self.wanted] = values
        found[:, 0] = found[0, 0]
        return found

    def filled(self, axes: Any, values: Array) -> Any:
        """Draw contours of `values` (A, R), and what the axes are; return them for a colour bar."""
        from harness.studies.workspace.figures import filled

        at, closed = self.poses, [*range(len(self.direction)), 0]
        x, y = (1000 * getattr(at, name)[closed] for name in self.names)
        axes.set(aspect="equal", xlabel=f"${self.names[0]}$ [mm]", ylabel=f"${self.names[1]}$ [mm]")
        axes.tick_params(labelsize=8)
        return filled(axes, x, y, values[closed])

    def sentence(self) -> str:
        """Return how far the platform goes in the plane."""
        ends = 1000 * self.far[:, -1]
        first, second = self.names
        return (
            f"In the plane of {first} and {second} the platform of {self.case.name} reaches "
            f"{ends.min():.1f} to {ends.max():.1f} mm from its pose, all else as there."
        )


@dataclass(frozen=True)
class PlaneMap(Result):
    """Frequencies of a model over a plane.

    Attributes: `plane`; `model`; `shown` mode numbers; `frequencies` (A, R, count) [Hz], ascending,
    NaN where it failed; `answers` of the model at the wanted poses.
    """

    plane: Plane
    model: Model
    shown: tuple[int, ...]
    frequencies: Array
    answers: Answers

    def records(self) -> Iterator[dict[str, Any]]:
        """Return one row a mode and pose: where it is, whether it is at the rim, frequency."""
        at, last = self.plane.poses, self.frequencies.shape[1] - 1
        where = np.argwhere(self.plane.wanted & np.isfinite(self.frequencies[..., 0])).tolist()
        for mode in self.shown:
            for k, j in where:
                yield {
                    "model": label(self.model), **columns(at[k, j]), "rim": j == last,
                    "mode": mode, "frequency_hz": self.frequencies[k, j, mode - 1],
                }  # fmt: skip

    def tables(self) -> dict[str, Table]:
        """Return where each mode is lowest and highest, and what ends the plane."""
        rows: list[tuple[Cell, ...]] = []
        at, f = self.plane.poses, self.frequencies
        shown = [f"{name}_m" for name in self.plane.names]
        for mode in self.shown:
            for word, find in (("lowest", np.nanargmin), ("highest", np.nanargmax)):
                if not np.isfinite(f[..., mode - 1]).any():
                    continue
                k, j = np.unravel_index(find(f[..., mode - 1]), f.shape[:2])
                place = cells(columns(at[int(k), int(j)]), shown)
                rows.append((f"f{mode}", word, Number(f[k, j, mode - 1], 3), *place))
        mechanism, limits, ends = (
            self.plane.case.mechanism,
            self.plane.limits,
            self.plane.far[:, -1],
        )
        met = limits_met(mechanism, limits, at[int(ends.argmin()), -1])
        notes = (
            limits_said(mechanism, limits),
            f"nearest end, {1000 * ends.min():.2f} mm away: {met}",
            ORDER,
        )
        title = f"{self.plane.case.name} over {' and '.join(self.plane.names)}: {label(self.model)}"
        heads = ("Mode", "", "f [Hz]", *headings(shown))
        return {"": Table(title, heads, tuple(rows), notes)}

    def figures(self) -> dict[str, Figure]:
        """Return contours, a panel a mode, each with its own scale; none without an answer."""
        from matplotlib.ticker import MaxNLocator

        from harness.figures import panels

        if not np.isfinite(self.frequencies).any():
            return {}
        title = f"{label(self.model)}: frequencies of {self.plane.case.name}"
        figure, grid = panels(title, 1, len(self.shown), (3.4, 3.6))
        for axes, mode in zip(grid[0], self.shown, strict=True):
            drawn = self.plane.filled(axes, self.frequencies[..., mode - 1])
            bar = figure.colorbar(drawn, ax=axes, location="bottom", shrink=0.85)
            bar.locator = MaxNLocator(4)
            bar.update_ticks()
            bar.set_label(f"$f_{{{mode}}}$ [Hz]")
        return {"": figure}

    def sentences(self) -> list[str]:
        """Return the reach, and the range of every mode."""
        f = self.frequencies[..., [mode - 1 for mode in self.shown]]
        if not np.isfinite(f).any():
            return [self.plane.sentence()]
        low, high = np.nanmin(f, axis=(0, 1)), np.nanmax(f, axis=(0, 1))
        ranges = ", ".join(
            f"f{mode} {a:.2f} to {b:.2f} Hz"
            for mode, a, b in zip(self.shown, low, high, strict=True)
        )
        return [self.plane.sentence(), f"There {label(self.model)} finds {ranges}."]

    def rows(self) -> list[dict[str, Any]]:
        """Return one row a pose and mode for the history."""
        poses, mechanism = self.plane.poses[self.plane.wanted], self.plane.case.mechanism
        return self.answers.rows(self.model, mechanism, poses, PLANE)

    def failures(self) -> dict[str, str]:
        """Return the poses without an answer, and why."""
        return self.answers.failures


def plane_map(where: Plane, model: Model, shown: Sequence[int], bench: Bench) -> PlaneMap:
    """Return the frequencies of `model` over a plane."""
    poses = where.poses[where.wanted]
    answers = solve(model, where.case.mechanism, poses, max(shown), bench)
    return PlaneMap(where, model, tuple(shown), where.spread(answers.frequencies), answers)
