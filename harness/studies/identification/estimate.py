"""Which mechanism a table belongs to: fits, what they pin down and cannot see; ranked readings."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from math import sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr

from analytic import InputError
from harness.signatures import Array
from harness.studies.identification.fit import profile_ends, rise, search
from harness.studies.identification.problem import Problem, letter

LEVEL = 0.95
"""Confidence of every interval."""
ENDS = ("alone_from", "alone_to", "together_from", "together_to", "at_bound")
READING_STARTS = 4
"""Starts of each reading's search: there are hundreds of readings."""
UNSEEN = 1e-6
"""A direction with this part of the largest singular value is one that no table can show."""
PINNED = "d / L^2 [1/m]"
"""Bending frequencies of a limb of length L and diameter d grow with it."""
STEP = 3e-4
"""Of a central difference, over the distance between the bounds."""


@dataclass(frozen=True)
class Reading:
    """A `problem` at its best: what its parameters are then, and how far off it is.

    Attributes: `x` (P,); the minimum S, `sum`; `error`, f over the table's, less 1, (cases, modes).
    """

    problem: Problem
    x: Array
    sum: float
    error: Array

    @property
    def values(self) -> Array:
        """The parameters, (P,), in the units of the names."""
        return self.problem.from_x(self.x)

    @property
    def fitted(self) -> dict[str, float]:
        """The parameters by name."""
        return dict(zip(self.problem.names, self.values.tolist(), strict=True))

    @property
    def held(self) -> NDArray[np.bool_]:
        """Which parameters end at a bound, (P,)."""
        low, high = self.problem.limits
        close = 1e-6 * (high - low)
        return (self.x <= low + close) | (self.x >= high - close)

    @property
    def rms(self) -> float:
        """Root mean square of the errors of different values, relative."""
        return sqrt(self.sum / self.problem.table.count)

    @property
    def worst(self) -> float:
        """The largest error without its sign [%]."""
        return 100 * float(np.abs(self.error).max())

    @property
    def criterion(self) -> float:
        """Akaike's, corrected for few values (lower is better); NaN where there are too few."""
        n, k = self.problem.table.count, len(self.x) + 1  # the noise is one more
        left = n - k - 1
        return 2 * n * np.log(self.rms) + 2 * k + 2 * k * (k + 1) / left if left > 0 else np.nan

    def ends(self, k: int) -> dict[str, Any]:
        """What is known of where the k-th parameter may be, by column."""
        return {ENDS[-1]: self.held[k]}

    def __str__(self) -> str:
        """What its parameters are fitted to; *: at a bound."""
        each = zip(self.fitted.items(), self.held, strict=True)
        return ", ".join(f"{n} {v:.4g}{'*' if end else ''}" for (n, v), end in each) or "nothing"


class Direction(NamedTuple):
    """A product of powers: `exponents` by parameter, the largest being 1 in size.

    `deviation` of its logarithm, 1 sigma, from the table alone; infinite where it sees nothing.
    """

    exponents: dict[str, float]
    deviation: float

    def __str__(self) -> str:
        # Equal ones stay in their order.
        ordered = sorted(self.exponents.items(), key=lambda pair: -round(abs(pair[1]), 4))
        shown = ((letter(name), e) for name, e in ordered if abs(e) >= 0.1)
        return " ".join(own if round(e, 2) == 1 else f"{own}^{e:.2g}" for own, e in shown)


@dataclass(frozen=True)
class Fit(Reading):
    """A reading whose parameters have intervals.

    Attributes: how many starts `reached` the minimum; `alone` and `together` (P, 2), profile
    intervals of each parameter by itself and of all at once, in the units of the names; `open`
    (P, 2), where a bound came first in the latter; `heights` (2,), by which S rises to the ends of
    either; `noise`, the relative standard deviation of one value, `assumed` or, where that is None,
    the residuals' own; `freedom`, values more than parameters.
    """

    reached: int
    alone: Array
    together: Array
    open: NDArray[np.bool_]
    heights: Array
    noise: float
    assumed: float | None
    freedom: int

    @property
    def named(self) -> bool:
        """Whether combinations of its parameters have names."""
        return self.problem.whole and self.problem.regular

    def intervals(self) -> Iterator[tuple[Any, ...]]:
        """Return of every parameter name, value, what is given, `alone`, `together` and `open`."""
        found, ends = self.problem, (self.alone, self.together, self.open)
        return zip(found.names, self.values, found.given, *ends, strict=True)

    def ends(self, k: int) -> dict[str, Any]:
        """95 % intervals of the k-th parameter alone, and of all together, by column."""
        ends = (*self.alone[k], *self.together[k], self.open[k].any())
        return dict(zip(ENDS, ends, strict=True))

    @cached_property
    def _slopes(self) -> tuple[Problem, Array, Array]:
        return sensitivities(self.problem, self.fitted)

    @cached_property
    def directions(self) -> list[Direction]:
        """The products of powers that the table tells apart at the fit, best known first."""
        whole, _, J = self._slopes
        return directions(whole.names, J, self.noise)

    @cached_property
    def left(self) -> list[Direction]:
        """The products of powers of what is fitted alone, best known first."""
        whole, _, J = sensitivities(self.problem, self.fitted, self.problem.names)
        return directions(whole.names, J, self.noise)

    @cached_property
    def quantities(self) -> dict[str, tuple[float, float, float]]:
        """The named combinations, and how well they are known, as `quantities`."""
        return quantities(*self._slopes, self.noise)


def fit(
    problem: Problem, observed: Array, noise: float | None = None, starts: int = 16, seed: int = 0
) -> list[Fit]:
    """Fit all parameters of `problem` to each of the logarithms `observed` (T, cases * modes)."""
    T, P = len(observed), len(problem.names)
    freedom = problem.table.count - P
    if freedom < 1:
        expected = f"fewer than the {freedom + P} different values of the table"
        raise InputError("parameters", P, expected)
    residuals, limits = problem.residuals(observed), problem.limits
    free = np.ones((T, P), dtype=bool)
    x, sums, reached = search(residuals, problem.start, free, *limits, starts=starts, seed=seed)
    heights = [rise(LEVEL, k, sums=sums, freedom=freedom, noise=noise) for k in (1, P)]
    profiles = [profile_ends(residuals, x, sums, *limits, height) for height in heights]
    alone, together = (problem.from_x(at.swapaxes(1, 2)).swapaxes(1, 2) for at, _ in profiles)
    error = problem.frequencies(x) / problem.table.frequencies - 1
    spread = np.sqrt(sums / freedom) if noise is None else np.full(T, noise)
    each = zip(x, sums.tolist(), error, reached, alone, together, profiles[1][1],
               np.transpose(heights), spread.tolist(), strict=True)  # fmt: skip
    return [Fit(*(problem, *found, noise, freedom)) for found in each]


def identify(problem: Problem, noise: float | None = None, starts: int = 16, seed: int = 0) -> Fit:
    """Return the parameters of `problem` with intervals.

    `noise` None: rounding, if the fit is as good as that, else the residuals' own.
    """
    table = problem.table
    (found,) = fit(problem, table.logarithms[None], noise, starts, seed)
    if noise is None and found.noise <= table.rounding:
        return identify(problem, table.rounding, starts, seed)
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
        P, table = len(whole.names), whole.table
        sizes = range(min(most, table.count - 1, P) + 1)
        chosen = [list(columns) for k in sizes for columns in combinations(range(P), k)]
        free = np.array([[k in columns for k in range(P)] for columns in chosen])
        residuals = whole.residuals(table.logarithms[None])
        points, sums, _ = search(
            residuals, whole.start, free, *whole.limits, starts=READING_STARTS, seed=seed
        )
        error = whole.frequencies(points) / table.frequencies - 1
        for row, columns in enumerate(chosen):
            own = replace(whole, names=tuple(whole.names[k] for k in columns))
            found.append(Reading(own, points[row, columns], float(sums[row]), error[row]))
        done(whole.label)
    return sorted(found, key=lambda reading: (len(reading.x), reading.rms))


def sensitivities(
    problem: Problem, values: Mapping[str, float], names: Sequence[str] = ()
) -> tuple[Problem, Array, Array]:
    """Return the problem of `names`, its x at `values`, and weighted d ln f / d ln p there.

    Shape (cases * modes, parameters); of what may be zero, and is, d ln f / dp over its bounds. By
    default of all parameters of the most tilted case that can move: but for the angles if none is
    tilted, and a disc's density, which would only repeat its thickness.
    """
    k = np.argmax([abs(case.pose.tilt) for case in problem.table.cases])
    known, tilted = problem.known[k], problem.table.cases[k].pose.tilt
    away = {"platform_density_kg_m3"} | (set() if tilted else {"azimuth_deg", "tilt_deg"})
    names = names or [n for n in sorted(known, key=lambda n: known[n].linear) if n not in away]
    whole = replace(problem, names=tuple(names), bounds={})
    there = {**problem.at(values)[k], **values}
    own = np.array([there[name] for name in names])
    x, (low, high) = whole.to_x(own), whole.limits
    steps = STEP * (high - low)
    both = np.concatenate([x + np.diag(steps), x - np.diag(steps)])
    up, down = np.split(np.log(whole.frequencies(both)).reshape(len(both), -1), 2)
    scale = np.where(whole.linear, np.where(own, own, (high - low) / 2), 1.0)
    J = np.sqrt(problem.table.weights)[:, None] * ((up - down) / (2 * steps[:, None])).T * scale
    kept = np.isfinite(J).all(axis=0)
    if kept.all():
        return whole, x, J
    return sensitivities(problem, values, [n for n, can in zip(names, kept, strict=True) if can])


def directions(names: Sequence[str], J: Array, noise: float) -> list[Direction]:
    """Return the products of powers that J (values, names) tells apart, best known first."""
    _, s, rows = np.linalg.svd(J, full_matrices=True)
    s = np.append(s, np.zeros(len(rows) - len(s)))
    nothing = s <= UNSEEN * s[0]
    if nothing.any():
        # Any mixture is unseen as well: take those that share as few parameters as can be.
        pivots = np.sort(qr(rows[nothing], mode="r", pivoting=True)[1][: nothing.sum()])
        rows[nothing] = np.linalg.solve(rows[nothing][:, pivots], rows[nothing])
    found = []
    for size, row, unseen in zip(s, rows, nothing, strict=True):
        largest = row[np.abs(row).argmax()]
        deviation = np.inf if unseen else noise / (size * abs(largest))
        found.append(Direction(dict(zip(names, row / largest, strict=True)), deviation))
    return found


def quantities(
    whole: Problem, x: Array, J: Array, noise: float
) -> dict[str, tuple[float, float, float]]:
    """Return the named combinations, with young and density known and all else within bounds.

    By name the value, and the 1 sigma deviation of its logarithm as the bounds of all parameters
    leave it, and when the table is known too.
    """
    low, high = whole.limits
    own = whole.from_x(x)
    keep = [k for k, name in enumerate(whole.names) if name not in ("young_GPa", "density_kg_m3")]
    prior = ((high - low) / np.sqrt(12) / np.where(whole.linear, np.abs(own), 1.0))[keep] ** 2
    covariance = np.linalg.inv(J[:, keep].T @ J[:, keep] / noise**2 + np.diag(1 / prior))
    # Their values, and those a small step of the logarithm of each parameter up and down.
    steps = 1e-5 * np.eye(len(x))[keep]
    steps = np.concatenate([0 * steps[:1], steps, -steps])
    tilted = max(whole.at(dict(zip(whole.names, (own * np.exp(steps)).T, strict=True))),
                 key=lambda values: np.abs(values["tilt_deg"]).max())  # fmt: skip
    found = {}
    for name, values in whole.groups(tilted).items():
        if values.all():  # without tilt one of them is zero
            up, down = np.split(np.log(np.abs(values[1:])), 2)
            slope = (up - down) / 2e-5
            after = np.sqrt(slope @ covariance @ slope)
            found[name] = values[0], np.sqrt(slope**2 @ prior), after
    return found
