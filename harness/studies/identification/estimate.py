"""Which mechanism a table of frequencies belongs to: fits with intervals, and ranked readings."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from analytic import InputError
from harness.studies.identification.fit import profile_ends, rise, search
from harness.studies.identification.problem import Problem
from harness.studies.identification.table import FrequencyTable

Floats = NDArray[np.float64]

LEVEL = 0.95
"""Confidence of every interval."""
READING_STARTS = 4
"""Starts of each reading's search: there are hundreds of readings."""


@dataclass(frozen=True)
class Fit:
    """All parameters of a `problem` fitted to T tables, one where not said otherwise.

    Attributes: minima `x` (T, P) and their S `sums`; how many starts `reached` them, (T,); `alone`
    and `together` (T, P, 2), profile intervals of each parameter by itself and of all at once, in
    the units of the names; `open` (T, P, 2), where a bound came first in the latter; `noise` (T,),
    the relative standard deviation of one value, `assumed` or, where that is None, the residuals'
    own; `freedom`, values more than parameters.
    """

    problem: Problem
    x: Floats
    sums: Floats
    reached: NDArray[np.intp]
    alone: Floats
    together: Floats
    open: NDArray[np.bool_]
    noise: Floats
    assumed: float | None
    freedom: int

    @property
    def values(self) -> Floats:
        """The parameters, (T, P), in the units of the names."""
        return self.problem.from_x(self.x)

    @property
    def fitted(self) -> dict[str, float]:
        """The parameters of the one table by name."""
        return dict(zip(self.problem.names, self.values[0].tolist(), strict=True))

    @property
    def error(self) -> Floats:
        """F over the one table's, less 1, (cases, modes)."""
        return np.asarray(self.problem.frequencies(self.x)[0] / self.problem.table.frequencies - 1)

    @property
    def rms(self) -> float:
        """Root mean square of the errors of different values, relative."""
        return float(np.sqrt(self.sums[0] / self.problem.table.weights.sum()))


def fit(
    problem: Problem, observed: Floats, noise: float | None = None, starts: int = 16, seed: int = 0
) -> Fit:
    """Fit all parameters of `problem` to the logarithms `observed` (T, cases * modes)."""
    T, P = len(observed), len(problem.names)
    freedom = values_of(problem.table) - P
    if freedom < 1:
        expected = f"fewer than the {freedom + P} different values of the table"
        raise InputError("parameters", P, expected)
    residuals, limits = problem.residuals(observed), problem.limits
    free = np.ones((T, P), dtype=bool)
    x, sums, reached = search(residuals, problem.start, free, *limits, starts=starts, seed=seed)
    ends = []
    for together in (1, P):
        height = rise(LEVEL, together, sums=sums, freedom=freedom, noise=noise)
        at, opened = profile_ends(residuals, x, sums, *limits, height)
        ends.append(problem.from_x(at.swapaxes(1, 2)).swapaxes(1, 2))
    spread = np.sqrt(sums / freedom) if noise is None else np.full(T, noise)
    return Fit(problem, x, sums, reached, ends[0], ends[1], opened, spread, noise, freedom)


def values_of(table: FrequencyTable) -> int:
    """Return how many different values a table has."""
    return round(float(table.weights.sum()))


def identify(problem: Problem, noise: float | None = None, starts: int = 16, seed: int = 0) -> Fit:
    """Return the parameters of `problem` with intervals.

    `noise` None: rounding, if the fit is as good as that, else the residuals' own.
    """
    table = problem.table
    found = fit(problem, table.logarithms[None], noise, starts, seed)
    if noise is None and found.noise[0] <= table.rounding:
        return fit(problem, table.logarithms[None], table.rounding, starts, seed)
    return found


@dataclass(frozen=True)
class Reading:
    """A model with some parameters free, at its best: what it reads, and how far off it is.

    Attributes: the `problem` of just these parameters; its `x`, (k,); `error` f over the table's,
    less 1, (cases, modes); `rms` of it over different values; `criterion` Akaike's, corrected for
    few values (lower is better), NaN where there are too few; `held` the parameters that end at a
    bound.
    """

    problem: Problem
    x: Floats
    error: Floats
    rms: float
    criterion: float
    held: tuple[str, ...]

    @property
    def fitted(self) -> dict[str, float]:
        """The parameters by name, in the units of the names."""
        values = self.problem.from_x(self.x).tolist()
        return dict(zip(self.problem.names, values, strict=True))


def readings(
    wholes: Sequence[Problem],
    most: int,
    seed: int = 0,
    done: Callable[[str], None] = lambda _: None,
) -> list[Reading]:
    """Return every choice of at most `most` parameters of each problem, fitted; best first."""
    found = []
    for whole in wholes:
        table, P, (low, high) = whole.table, len(whole.names), whole.limits
        n = float(table.weights.sum())
        chosen = [
            columns
            for k in range(min(most, values_of(table) - 1, P) + 1)
            for columns in combinations(range(P), k)
        ]
        free = np.array([[k in columns for k in range(P)] for columns in chosen])
        residuals = whole.residuals(table.logarithms[None])
        points, sums, _ = search(
            residuals, whole.start, free, low, high, starts=READING_STARTS, seed=seed
        )
        error = whole.frequencies(points) / table.frequencies - 1
        close = 1e-6 * (high - low)
        held = free & ((points <= low + close) | (points >= high - close))
        names = np.array(whole.names)
        for row, pick in enumerate(free):
            k = pick.sum() + 1  # the noise is one parameter more
            own = replace(whole, names=tuple(names[pick].tolist()))
            rms, left = float(np.sqrt(sums[row] / n)), n - k - 1
            criterion = 2 * n * np.log(rms) + 2 * k + 2 * k * (k + 1) / left if left > 0 else np.nan
            at_bound = tuple(names[held[row]].tolist())
            found.append(Reading(own, points[row, pick], error[row], rms, criterion, at_bound))
        done(whole.label)
    return sorted(found, key=lambda reading: (len(reading.x), reading.rms))
