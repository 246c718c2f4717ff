"""Frequencies between two counts: fewer than k modes below one end, at least k below the other."""

from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from analytic.dynamic_stiffness import torsion_eigenvalues
from analytic.errors import NotCertifiedError
from analytic.wittrick_williams import Characteristic, Floats, Form

WIDTH = 1e-12
"""Relative width of a bracket of a frequency where rounding allows it."""
LOOSEST = 1e-9
"""A bracket wider than this, relative, is refused."""
CLOSE = 1e-8, 1e-13
"""A step of Newton's below this, relative, is the last: the next would be about its square, but
beside a pole it is not."""
STEPS = 12
"""Ratio of omega^2 between the first guesses is 10^(1 / STEPS), to begin with."""
BATCH = 2000
"""Forms made at once, so that thousands of modes need no more memory than a few."""


class Countable(Protocol):
    """A problem whose modes are counted: `Characteristic`, or `exact_chain.Exact`."""

    def form(self, omega2: Floats) -> Any:
        """Return the problem at each of `omega2` (q,), with what a `Form` has."""
        ...


def brackets(problem: Characteristic, count: int) -> tuple[Floats, NDArray[np.int64]]:
    """Return brackets of the lowest `count` omega^2, and the limb that twists in each.

    Shapes (count, 2) and (count,); -1 where the mode is not torsion of a limb. Raises
    `NotCertifiedError` as `coupled` does.
    """
    return with_torsion(problem, coupled(problem, count))


def with_torsion(problem: Characteristic, own: Floats) -> tuple[Floats, NDArray[np.int64]]:
    """Return what `brackets` does, from the brackets `own` (count, 2) of all other modes."""
    count = len(own)
    torsion = torsion_eigenvalues(problem.rods, problem.lengths, count, problem.elements)
    twisting = np.repeat(np.arange(len(problem.lengths)), torsion.shape[1])
    both = np.concatenate([own, torsion.reshape(-1, 1) * [1 - WIDTH / 2, 1 + WIDTH / 2]])
    limb = np.r_[np.full(count, -1), twisting]
    order = np.argsort(both.mean(axis=1), kind="stable")[:count]
    return both[order], limb[order]


def middles(bounds: Floats) -> Floats:
    """Return the middle of every bracket, (m,): 0 of a free motion."""
    return np.where(bounds[:, 0] > 0, bounds.mean(axis=1), 0.0)


def coupled(problem: Characteristic, count: int) -> Floats:
    """Return brackets of the lowest `count` omega^2 that are not torsion, shape (count, 2).

    (0, upper) for a free motion. Both ends are counted, with a margin for what rounding can do.
    Raises `NotCertifiedError` where a bracket would be wider than `LOOSEST`.
    """
    free = min(problem.free, count)
    found = np.zeros((count, 2))
    low, high, guess = _isolated(problem, count)
    found[:free, 1] = _rest(problem, free, float(low[free:].min(initial=high.max())))
    rank = np.arange(free, count)
    for close in CLOSE:
        x = roots(problem, rank, low[free:], high[free:], guess[free:], close)
        try:
            found[free:] = certified(problem, rank, x)
            break
        except NotCertifiedError:
            if close == CLOSE[-1]:
                raise
    return found


def _isolated(problem: Characteristic, count: int) -> tuple[Floats, Floats, Floats]:
    """Return lower and upper bounds of omega^2 by rank, and a guess between, (count,) each."""
    sigma = problem.static[0]
    poles = problem.first
    lowest = min(poles, float(sigma[sigma.size - problem.free - 1] ** 2))
    grid = lowest * 10 ** (np.arange(-0.8, 2.2, 1 / STEPS) + 0.0123)
    form = problem.form(grid)
    below, nearest = form.count, _estimates(form, grid)
    while below[0] > problem.free or below[-1] < count:
        if below[0] > problem.free:
            more = grid[0] * 10 ** np.arange(-1.5, -0.01, 0.25)
            if more[0] < 1e-26 * poles:
                raise NotCertifiedError("a motion too slow to be told from a free one")
        else:
            more = grid[-1] * 10 ** np.arange(1 / 6, 1.6, 1 / 6)
        form = problem.form(more)
        order = np.argsort(np.r_[grid, more])
        grid = np.r_[grid, more][order]
        below = np.r_[below, form.count][order]
        nearest = np.concatenate([nearest, _estimates(form, more)])[order]
    # Counts rise with omega^2 but for rounding.
    below = np.maximum.accumulate(below)
    rank = np.arange(count)
    upper = np.searchsorted(below, rank, side="right")
    lower = np.maximum(upper - 1, 0)
    low = np.where(upper > 0, grid[lower], 0.0)
    high = grid[upper]
    guess = np.sqrt(np.maximum(low, 1e-3 * high) * high)
    # The estimates of either end that fall between the ends; the closer one is the better.
    best = np.full(count, np.inf)
    for side in (lower, upper):
        k = rank - nearest[side, 0].astype(int)
        inside = (k >= 0) & (k < nearest.shape[1] - 1)
        value = (
            grid[side]
            + np.take_along_axis(nearest[side, 1:], np.where(inside, k, 0)[:, None], axis=1)[:, 0]
        )
        good = inside & (value > low) & (value < high)
        away = np.where(good, np.abs(value - grid[side]), np.inf)
        guess, best = np.where(away < best, value, guess), np.minimum(best, away)
    return low, high, guess


def _estimates(form: Form, grid: Floats) -> Floats:
    """Return the count outside, and estimates of 12 roots relative to `grid`, (q, 13)."""
    values = np.linalg.eigvalsh(form.pencil[0])
    result = np.full((len(grid), 13), np.inf)
    result[:, 0] = form.outside
    kept = min(12, values.shape[1])
    result[:, 1 : 1 + kept] = values[:, :kept]
    return result


def _rest(problem: Characteristic, free: int, below: float) -> float:
    """Return a small omega^2 below which `free` modes lie for certain."""
    if not free:
        return 0.0
    grid = np.asarray(below * 10.0 ** np.arange(-20, 1), dtype=np.float64)
    good = problem.form(grid).at_least >= free
    if not good.any():
        raise NotCertifiedError(f"{free} free motions")
    return float(grid[good][0])


def roots(
    problem: Countable,
    rank: NDArray[np.intp],
    low: Floats,
    high: Floats,
    guess: Floats,
    close: float,
) -> Floats:
    """Return the omega^2 of the modes of `rank`, each between `low` and `high`.

    Newton's iteration on B x = delta (-B') x, whose eigenvalue of the rank sought has the sign of
    the count: what leaves the bracket, or closes it too slowly, is bisected.
    """
    x, low, high = guess.copy(), low.copy(), high.copy()
    going = np.arange(len(rank))
    for step in range(200):
        if not going.size:
            break
        moved = np.empty(len(going))
        for first in range(0, len(going), BATCH):
            some = going[first : first + BATCH]
            form = problem.form(x[some])
            values = np.linalg.eigvalsh(form.pencil[0])
            k = rank[some] - form.outside
            inside = (k >= 0) & (k < values.shape[1])
            delta = np.take_along_axis(values, np.where(inside, k, 0)[:, None], axis=1)[:, 0]
            moved[first : first + BATCH] = np.where(inside, delta, np.where(k < 0, -np.inf, np.inf))
        above = moved > 0
        before = x[going]
        low[going] = np.where(above, before, low[going])
        high[going] = np.where(above, high[going], before)
        target = before + moved
        a, b = low[going], high[going]
        middle = np.sqrt(np.maximum(a, 1e-3 * b) * b)
        bad = ~((target > a) & (target < b)) | (step % 8 == 7)
        x[going] = np.where(bad, middle, target)
        settled = (np.abs(moved) < close * before) | (b - a < WIDTH / 20 * b)
        x[going[settled]] = np.where(bad, before, target)[settled]
        going = going[~settled]
    return x


def certified(problem: Countable, rank: NDArray[np.intp], roots: Floats) -> Floats:
    """Return brackets (m, 2) about `roots` (m,) with at most rank modes below, more than it above.

    As narrow as WIDTH, or as rounding allows; a root off centre is moved by the secant. Raises
    `NotCertifiedError` where one would be wider than `LOOSEST`.
    """
    x, half = roots.copy(), np.full(len(roots), WIDTH * 0.98)
    result = np.empty((len(roots), 2))
    going = np.arange(len(roots))
    while going.size:
        ends = x[going, None] * (1 + half[going, None] * [-1.0, 1.0])
        y, good = np.empty(ends.shape), np.empty(ends.shape, dtype=bool)
        for first in range(0, len(going), BATCH // 2):
            part = slice(first, first + BATCH // 2)
            form = problem.form(ends[part].ravel())
            shape = ends[part].shape
            at_most, at_least = form.at_most.reshape(shape), form.at_least.reshape(shape)
            good[part, 0] = at_most[:, 0] <= rank[going[part]]
            good[part, 1] = at_least[:, 1] > rank[going[part]]
            k = np.repeat(rank[going[part]], 2) - form.outside
            k = np.clip(k, 0, form.values.shape[1] - 1)
            y[part] = np.take_along_axis(form.values, k[:, None], axis=1)[:, 0].reshape(shape)
        result[going] = ends
        going, y = going[~good.all(axis=1)], y[~good.all(axis=1)]
        across = (y[:, 0] > 0) & (y[:, 1] < 0)
        shift = np.where(across, (y[:, 0] + y[:, 1]) / np.where(across, y[:, 0] - y[:, 1], 1.0), 0)
        beyond = np.where(y[:, 1] > 0, 1.0, np.where(y[:, 0] < 0, -1.0, 0.0))
        x[going] *= 1 + half[going] * (shift + beyond)
        half[going] *= 2
        if (half[going] > LOOSEST).any():
            raise NotCertifiedError(
                f"mode {int(rank[going].min()) + 1} to {LOOSEST:g} (torsion of limbs not counted)"
            )
    return result
