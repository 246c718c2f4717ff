"""Which mechanism a table of frequencies belongs to: fits with intervals, and ranked readings."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import combinations, product

import numpy as np
from numpy.typing import NDArray

from analytic import InputError
from harness.studies.identification.fit import (
    Minima,
    Profiles,
    profile_ends,
    profiles,
    rise,
    search,
)
from harness.studies.identification.parameters import INERTIAS
from harness.studies.identification.problem import Bounds, Problem
from harness.studies.identification.table import FrequencyTable
from reference_models import Named

Floats = NDArray[np.float64]

LEVEL = 0.95
"""Confidence of every interval."""
PROFILE = 25
"""Points of a profile drawn."""
READING_STARTS = 4
"""Starts of each reading's search: there are hundreds of readings."""


@dataclass(frozen=True)
class Fits:
    """All parameters of a problem fitted to T tables.

    Attributes: the `minima` in x, and how many starts `reached` them, (T,); `values` (T, P) in the
    units of the names; `alone` and `together` (T, P, 2), profile intervals of each parameter by
    itself and of all at once; `open` (T, P, 2), where a bound came first in the latter; `noise`
    (T,), the relative standard deviation of one value, `freedom` (values more than parameters).
    """

    minima: Minima
    reached: NDArray[np.intp]
    values: Floats
    alone: Floats
    together: Floats
    open: NDArray[np.bool_]
    noise: Floats
    freedom: int


def fit(
    problem: Problem,
    observed: Floats,
    *,
    noise: float | None = None,
    starts: int = 16,
    seed: int = 0,
    level: float = LEVEL,
) -> Fits:
    """Fit all parameters of `problem` to the logarithms `observed` (T, cases * modes).

    `noise` is the relative standard deviation of a value; None takes it from the residuals.
    """
    T, P = len(observed), len(problem.names)
    free = np.ones((T, P), dtype=bool)
    low, high = problem.limits
    freedom = degrees_of_freedom(problem.table, P)
    residuals = problem.residuals(observed)
    best, reached = search(residuals, problem.start, free, low, high, starts=starts, seed=seed)
    ends = []
    for together in (1, P):
        height = rise(level, together, sums=best.sums, freedom=freedom, noise=noise)
        ends.append(profile_ends(residuals, best, free, low, high, height))
    alone, both = (problem.from_x(end.at.swapaxes(1, 2)).swapaxes(1, 2) for end in ends)
    spread = np.sqrt(best.sums / freedom) if noise is None else np.full(T, noise)
    values = problem.from_x(best.points)
    return Fits(best, reached, values, alone, both, ends[1].open, spread, freedom)


def degrees_of_freedom(table: FrequencyTable, fitted: int) -> int:
    """Return how many more different values than `fitted` parameters the table has."""
    freedom = round(float(table.weights.sum())) - fitted
    if freedom < 1:
        expected = f"fewer than the {freedom + fitted} different values of the table"
        raise InputError("parameters", fitted, expected)
    return freedom


@dataclass(frozen=True)
class Reading:
    """A model with some parameters free, at its best: what it reads, and how far off it is.

    Attributes: the `problem` of just these parameters; its `x` and `values`, (k,); `error` f over
    the table's, less 1, (cases, modes); `rms` of it over different values, `worst` the largest;
    `criterion` Akaike's, corrected for few values (lower is better), NaN where there are too few;
    `held` the parameters that end at a bound.
    """

    problem: Problem
    x: Floats
    values: Floats
    error: Floats
    rms: float
    criterion: float
    held: tuple[str, ...]

    @property
    def worst(self) -> float:
        """The largest error, without its sign."""
        return float(np.abs(self.error).max())


def readings(
    table: FrequencyTable,
    names: Sequence[str],
    models: Sequence[Named],
    bounds: Bounds,
    *,
    most: int,
    frames: Sequence[bool] = (False, True),
    seed: int = 0,
    done: Callable[[str], None] = lambda _: None,
) -> list[Reading]:
    """Return every choice of at most `most` of `names`, fitted, under every model; best first.

    Theories are `models` with one slip at most: Eq. 8's inertia, or mirrored frames where `frames`
    has True.
    """
    found = []
    most = min(most, round(float(table.weights.sum())) - 1, len(names))
    chosen = [s for k in range(most + 1) for s in combinations(range(len(names)), k)]
    free = np.zeros((len(chosen), len(names)), dtype=bool)
    for row, columns in enumerate(chosen):
        free[row, list(columns)] = True
    slips = [(form, slip) for form in INERTIAS for slip in frames if form == "disc" or not slip]
    for model, (inertia, mirrored) in product(models, slips):
        whole = Problem(table, model, tuple(names), inertia, mirrored, bounds)
        low, high = whole.limits
        residuals = whole.residuals(table.logarithms[None])
        best, _ = search(residuals, whole.start, free, low, high, starts=READING_STARTS, seed=seed)
        f = whole.frequencies(best.points)
        for row, columns in enumerate(chosen):
            found.append(_reading(whole, columns, best.points[row], float(best.sums[row]), f[row]))
        done(f"{model.label}, {inertia}{', mirrored' if mirrored else ''}")
    return sorted(found, key=lambda reading: (len(reading.x), reading.rms))


def _reading(
    whole: Problem, columns: tuple[int, ...], x: Floats, sums: float, f: Floats
) -> Reading:
    table, pick = whole.table, list(columns)
    names = tuple(whole.names[k] for k in columns)
    bounds = {name: pair for name, pair in whole.bounds.items() if name in names}
    own = Problem(table, whole.model, names, whole.inertia, whole.mirrored, bounds)
    low, high = whole.limits
    close = 1e-6 * (high - low)
    at_bound = (x <= low + close) | (x >= high - close)
    n = float(table.weights.sum())
    # The noise is one parameter more.
    k, left = len(columns) + 1, n - len(columns) - 2
    spread = n * np.log(sums / n) + 2 * k
    return Reading(
        problem=own,
        x=x[pick],
        values=whole.from_x(x)[pick],
        error=f / table.frequencies - 1,
        rms=float(np.sqrt(sums / n)),
        criterion=float(spread + 2 * k * (k + 1) / left) if left > 0 else np.nan,
        held=tuple(whole.names[j] for j in columns if at_bound[j]),
    )


@dataclass(frozen=True)
class Fitted:
    """What a table says of some parameters under one model.

    Attributes: the `problem`; `fits` of the one table; `error` (cases, modes), f over the table's,
    less 1; `profiles` of each parameter for a figure; `assumed` noise, or None where it is the
    residuals' own.
    """

    problem: Problem
    fits: Fits
    error: Floats
    profiles: Profiles
    assumed: float | None

    @property
    def fitted(self) -> dict[str, float]:
        """The parameters' values by name."""
        return dict(zip(self.problem.names, self.fits.values[0].tolist(), strict=True))

    @property
    def rms(self) -> float:
        """Root mean square of the errors of different values, relative."""
        return float(np.sqrt(self.fits.minima.sums[0] / self.problem.table.weights.sum()))


def identify(
    problem: Problem, *, noise: float | None = None, starts: int = 16, seed: int = 0
) -> Fitted:
    """Return the parameters of `problem` with intervals and profiles.

    `noise` None: rounding, if the fit is as good as that, else the residuals' own.
    """
    table = problem.table
    observed = table.logarithms[None]
    fits = fit(problem, observed, noise=noise, starts=starts, seed=seed)
    if noise is None and fits.noise[0] <= table.rounding:
        noise = table.rounding
        fits = fit(problem, observed, noise=noise, starts=starts, seed=seed)
    low, high = problem.limits
    error = problem.frequencies(fits.minima.points)[0] / table.frequencies - 1
    own = fits.minima.points[0]
    ends = np.array(
        [
            [problem.to_x(name, value) for value in pair]
            for name, pair in zip(problem.names, fits.together[0], strict=True)
        ]
    )
    span = np.clip(own[:, None] + 1.3 * (ends - own[:, None]), low[:, None], high[:, None])
    drawn = profiles(problem.residuals(observed), own, low, high, span, PROFILE)
    return Fitted(problem, fits, error, drawn, noise)
