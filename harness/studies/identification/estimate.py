"""Which mechanism a table of frequencies belongs to: fits with intervals, and ranked readings."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic import InputError
from harness.studies.identification.directions import (
    Direction,
    Quantity,
    directions,
    quantities,
    sensitivities,
)
from harness.studies.identification.fit import profile_ends, rise, search
from harness.studies.identification.problem import Problem

Floats = NDArray[np.float64]

LEVEL = 0.95
"""Confidence of every interval."""
ENDS = ("alone_from", "alone_to", "together_from", "together_to")
READING_STARTS = 4
"""Starts of each reading's search: there are hundreds of readings."""


@dataclass(frozen=True)
class Reading:
    """A `problem` at its best: what its parameters are then, and how far off it is.

    Attributes: `x` (P,); the minimum S, `sum`; `error`, f over the table's, less 1, (cases, modes).
    """

    problem: Problem
    x: Floats
    sum: float
    error: Floats

    @property
    def values(self) -> Floats:
        """The parameters, (P,), in the units of the names."""
        return self.problem.from_x(self.x)

    @property
    def fitted(self) -> dict[str, float]:
        """The parameters by name."""
        return dict(zip(self.problem.names, self.values.tolist(), strict=True))

    @property
    def held(self) -> tuple[str, ...]:
        """The parameters that end at a bound."""
        low, high = self.problem.limits
        close = 1e-6 * (high - low)
        ends = (self.x <= low + close) | (self.x >= high - close)
        return tuple(name for name, end in zip(self.problem.names, ends, strict=True) if end)

    @property
    def rms(self) -> float:
        """Root mean square of the errors of different values, relative."""
        return float(np.sqrt(self.sum / self.problem.table.weights.sum()))

    @property
    def worst(self) -> float:
        """The largest error without its sign [%]."""
        return 100 * float(np.abs(self.error).max())

    @property
    def criterion(self) -> float:
        """Akaike's, corrected for few values (lower is better); NaN where there are too few."""
        n, k = float(self.problem.table.weights.sum()), len(self.x) + 1  # the noise is one more
        left = n - k - 1
        return 2 * n * np.log(self.rms) + 2 * k + 2 * k * (k + 1) / left if left > 0 else np.nan

    def ends(self, k: int) -> dict[str, Any]:
        """What is known of where the k-th parameter may be, by column."""
        return {"at_bound": self.problem.names[k] in self.held}

    def __str__(self) -> str:
        """What its parameters are fitted to; *: at a bound."""
        held = self.held
        text = ", ".join(f"{n} {v:.4g}{'*' if n in held else ''}" for n, v in self.fitted.items())
        return text or "nothing"


@dataclass(frozen=True)
class Fit(Reading):
    """A reading whose parameters have intervals.

    Attributes: how many starts `reached` the minimum; `alone` and `together` (P, 2), profile
    intervals of each parameter by itself and of all at once, in the units of the names; `open`
    (P, 2), where a bound came first in the latter; `heights` (2,), by which S rises to the ends of
    either; `noise`, the relative standard deviation of one
    value, `assumed` or, where that is None, the residuals' own; `freedom`, values more than
    parameters.
    """

    reached: int
    alone: Floats
    together: Floats
    open: NDArray[np.bool_]
    heights: Floats
    noise: float
    assumed: float | None
    freedom: int

    def ends(self, k: int) -> dict[str, Any]:
        """95 % intervals of the k-th parameter alone, and of all together, by column."""
        found = zip(ENDS, (*self.alone[k], *self.together[k]), strict=True)
        return {**dict(found), "at_bound": bool(self.open[k].any())}

    @cached_property
    def _slopes(self) -> tuple[Problem, Floats, Floats]:
        return sensitivities(self.problem, self.fitted)

    @cached_property
    def directions(self) -> list[Direction]:
        """The products of powers that the table tells apart at the fit, best known first."""
        whole, _, J = self._slopes
        return directions(whole.names, J, self.noise)

    @cached_property
    def left(self) -> list[Direction]:
        """The products of powers of what is fitted alone, best known first."""
        _, _, J = sensitivities(self.problem, self.fitted, self.problem.names)
        return directions(self.problem.names, J, self.noise)

    @cached_property
    def quantities(self) -> list[Quantity]:
        """The named combinations, and how well they are known."""
        return quantities(*self._slopes, self.noise)


def fit(
    problem: Problem, observed: Floats, noise: float | None = None, starts: int = 16, seed: int = 0
) -> list[Fit]:
    """Fit all parameters of `problem` to each of the logarithms `observed` (T, cases * modes)."""
    T, P = len(observed), len(problem.names)
    freedom = values_of(problem) - P
    if freedom < 1:
        expected = f"fewer than the {freedom + P} different values of the table"
        raise InputError("parameters", P, expected)
    residuals, limits = problem.residuals(observed), problem.limits
    free = np.ones((T, P), dtype=bool)
    x, sums, reached = search(residuals, problem.start, free, *limits, starts=starts, seed=seed)
    heights = [rise(LEVEL, k, sums=sums, freedom=freedom, noise=noise) for k in (1, P)]
    ends = []
    for height in heights:
        at, opened = profile_ends(residuals, x, sums, *limits, height)
        ends.append(problem.from_x(at.swapaxes(1, 2)).swapaxes(1, 2))
    error = problem.frequencies(x) / problem.table.frequencies - 1
    spread = np.sqrt(sums / freedom) if noise is None else np.full(T, noise)
    return [
        Fit(problem, x[t], float(sums[t]), error[t], int(reached[t]), ends[0][t], ends[1][t],
            opened[t], np.array(heights)[:, t], float(spread[t]), noise, freedom)
        for t in range(T)
    ]  # fmt: skip


def values_of(problem: Problem) -> int:
    """Return how many different values the table of a problem has."""
    return round(float(problem.table.weights.sum()))


def identify(problem: Problem, noise: float | None = None, starts: int = 16, seed: int = 0) -> Fit:
    """Return the parameters of `problem` with intervals.

    `noise` None: rounding, if the fit is as good as that, else the residuals' own.
    """
    table = problem.table
    (found,) = fit(problem, table.logarithms[None], noise, starts, seed)
    if noise is None and found.noise <= table.rounding:
        (found,) = fit(problem, table.logarithms[None], table.rounding, starts, seed)
    return found


def readings(
    wholes: Sequence[Problem],
    most: int,
    seed: int = 0,
    done: Callable[[str], None] = lambda _: None,
) -> list[Reading]:
    """Return every choice of at most `most` parameters of each problem, fitted; best first."""
    found = []
    for whole in wholes:
        P, most_here = len(whole.names), min(most, values_of(whole) - 1, len(whole.names))
        chosen = [c for k in range(most_here + 1) for c in combinations(range(P), k)]
        free = np.array([[k in columns for k in range(P)] for columns in chosen])
        residuals = whole.residuals(whole.table.logarithms[None])
        points, sums, _ = search(
            residuals, whole.start, free, *whole.limits, starts=READING_STARTS, seed=seed
        )
        error = whole.frequencies(points) / whole.table.frequencies - 1
        for row, columns in enumerate(chosen):
            own = replace(whole, names=tuple(whole.names[k] for k in columns))
            x = points[row, list(columns)]
            found.append(Reading(own, x, float(sums[row]), error[row]))
        done(whole.label)
    return sorted(found, key=lambda reading: (len(reading.x), reading.rms))
