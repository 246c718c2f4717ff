"""Least squares within bounds, hundreds of fits at once: minima and profiles.

A model that takes many designs a call makes one call of all fits' Jacobians cheaper than any fit
alone. All functions take `residuals(points (M, P), owner (M,)) -> (M, m)`: rows of parameters, and
which fit each row belongs to. What is minimised is S, the sum of their squares.
"""

from collections.abc import Callable
from math import ceil, log2

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, f, qmc

from harness.signatures import Array

Flags = NDArray[np.bool_]
Whole = NDArray[np.intp]
Residuals = Callable[[Array, Whole], Array]

STEP = 1e-5
"""Of a one-sided difference, over the distance between the bounds."""
SETTLED = 1e-8
"""Part of S that the next step promises to gain where a fit has converged."""
SAMPLE = 4
"""Points looked at for each start."""
EARLY = 4
"""Steps after which only the better starts go on."""
UNSEEN = 1e-12
"""A smaller variance, for residuals of deviation 1, is none: S does not know the parameter."""
CLOSE = 1e-3
"""Relative error of a profile's height at an end."""


def minimise(
    residuals: Residuals,
    start: Array,
    free: Flags,
    lower: Array,
    upper: Array,
    owner: Whole | None = None,
    steps: int = 60,
) -> tuple[Array, Array]:
    """Return minima (B, P) that Levenberg's and Marquardt's steps reach from `start`, and S (B,).

    Only parameters that are `free` (B, P) move, within `lower` and `upper` (P,). At a bound that
    the gradient points through, a parameter rests. `owner` (B,) is what `residuals` is told, by
    default the row.
    """
    points = np.where(free, np.clip(start, lower, upper), start)
    left = np.arange(len(points))
    owner = left if owner is None else owner
    values = residuals(points, owner)
    sums = (values**2).sum(axis=1)
    J, scale = np.zeros((*values.shape, points.shape[1])), np.zeros(points.shape)
    damping, fresh = np.full(len(points), 1e-3), np.ones(len(points), dtype=bool)
    for _ in range(steps):
        new = left[fresh[left]]
        J[new] = jacobian(residuals, points[new], values[new], free[new], lower, upper, owner[new])
        g = np.einsum("bmp,bm->bp", J[left], values[left])
        A = np.einsum("bmp,bmq->bpq", J[left], J[left])
        at = points[left]
        # A parameter that has mattered keeps its scale where it matters no more.
        scale[left] = np.maximum(scale[left], np.einsum("bpp->bp", A))
        still = ~free[left] | ((at <= lower) & (g > 0)) | ((at >= upper) & (g < 0))
        g[still] = 0.0
        A[still[:, :, None] | still[:, None, :]] = 0.0
        damped = A.copy()
        diagonal = np.einsum("bpp->bp", damped)
        diagonal += damping[left, None] * scale[left] + 1e-300
        diagonal[still] = 1.0
        move = -np.linalg.solve(damped, g[..., None])[..., 0]
        move = np.where(still, 0.0, np.clip(at + move, lower, upper) - at)
        trial = at + move
        found = residuals(trial, owner[left])
        after = (found**2).sum(axis=1)
        better = after < sums[left]
        promised = -(2 * (g * move).sum(axis=1) + np.einsum("bp,bpq,bq->b", move, A, move))
        small = promised <= SETTLED * sums[left] + SETTLED**2
        done = (small & (damping[left] < 1)) | (damping[left] > 1e10)
        won = left[better]
        points[won], values[won], sums[won] = trial[better], found[better], after[better]
        damping[left] *= np.where(better, 0.2, 8.0)
        fresh[left] = better
        left = left[~done]
        if not left.size:
            break
    return points, sums


def jacobian(
    residuals: Residuals,
    points: Array,
    values: Array,
    free: Flags,
    lower: Array,
    upper: Array,
    owner: Whole,
) -> Array:
    """Return d residuals / d points (B, m, P), zero where not `free`, by differences inwards."""
    row, column = np.nonzero(free)
    size = STEP * (upper - lower)
    size = np.where(points + size > upper, -size, size)[row, column]
    ahead = points[row]
    ahead[np.arange(len(row)), column] += size
    J = np.zeros((*values.shape, points.shape[1]))
    J[row, :, column] = (residuals(ahead, owner[row]) - values[row]) / size[:, None]
    return J


def search(
    residuals: Residuals,
    base: Array,
    free: Flags,
    lower: Array,
    upper: Array,
    *,
    starts: int = 8,
    seed: int = 0,
) -> tuple[Array, Array, Whole]:
    """Return each fit's lowest minimum (F, P), its S, and how many starts reached it, (F,).

    `base` (P,) holds what is not `free` (F, P). Of `base` and SAMPLE Sobol points a start within
    the bounds each fit starts from its best `starts`; after EARLY steps the worse half is left.
    """
    F, P = free.shape
    count = 2 ** ceil(log2(SAMPLE * starts))
    unit = qmc.Sobol(P, rng=np.random.default_rng(seed)).random(count)
    sobol = np.where(free[:, None], lower + unit * (upper - lower), base)
    points = np.concatenate([np.broadcast_to(base, (F, 1, P)), sobol], axis=1)
    owner = np.repeat(np.arange(F), count + 1)
    sums = (residuals(points.reshape(-1, P), owner) ** 2).sum(axis=1).reshape(F, -1)
    for keep, steps in ((starts, EARLY), ((starts + 1) // 2, 60)):
        best = np.argsort(sums, axis=1, kind="stable")[:, :keep]
        chosen = np.take_along_axis(points, best[..., None], axis=1).reshape(-1, P)
        owner = np.repeat(np.arange(F), keep)
        ends, heights = minimise(residuals, chosen, free[owner], lower, upper, owner, steps)
        points, sums = ends.reshape(F, -1, P), heights.reshape(F, -1)
    lowest = sums.min(axis=1)
    reached = (sums <= lowest[:, None] * (1 + 1e-6) + 1e-18).sum(axis=1)
    return points[np.arange(F), sums.argmin(axis=1)], lowest, reached


def rise(level: float, together: int, *, sums: Array, freedom: int, noise: float | None) -> Array:
    """Return how far S may rise above its minima `sums` (B,) at confidence `level`, (B,).

    With residuals of known standard deviation `noise` by chi-square, else by F, the noise taken
    from S with `freedom` values more than parameters. One parameter alone: `together` = 1. With all
    k of them, `together` = k, the intervals hold the k true values at once at least that often.
    """
    if noise is not None:
        return np.full(len(sums), noise**2 * chi2.ppf(level, together))
    return sums / freedom * together * f.ppf(level, together, freedom)


def profile_ends(
    residuals: Residuals, best: Array, sums: Array, lower: Array, upper: Array, height: Array
) -> tuple[Array, Flags]:
    """Return where S, minimised over all other parameters, has risen by `height` (B,).

    From minima `best` (B, P) with S `sums`; ends (B, P, 2), lower and upper, and where a bound came
    first. By a bracketed secant on sqrt(S - S_min), which is all but linear in the parameter.
    """
    B, P = best.shape
    owner = np.arange(B)
    free = np.ones((B, P), dtype=bool)
    J = jacobian(residuals, best, residuals(best, owner), free, lower, upper, owner)
    covariance = np.linalg.pinv(np.einsum("bmp,bmq->bpq", J, J), rcond=1e-14, hermitian=True)
    fit, j, which = (index.ravel() for index in np.indices((B, P, 2)))
    side = 2.0 * which - 1
    centre, target, variance = best[fit, j], np.sqrt(height[fit]), covariance[fit, j, j]
    unseen = variance < UNSEEN
    direction = np.where(unseen, 0.0, covariance[fit, :, j].T / np.maximum(variance, UNSEEN)).T
    # How far from the centre; at a distance of zero sqrt(S - S_min) is zero too.
    reach = np.abs(np.where(side < 0, lower[j], upper[j]) - centre)
    distance = np.where(unseen, reach, np.minimum(np.sqrt(variance) * target, reach))
    points = best[fit] + direction * (side * distance)[:, None]
    # Distance and sqrt(S - S_min) on both sides of each end, as far as they are known.
    near, far = np.zeros((2, len(fit))), np.full((2, len(fit)), np.inf)
    shut = reach <= 0
    left = np.flatnonzero(~shut)
    for _ in range(25):
        points[left, j[left]] = (centre + side * distance)[left]
        others = np.arange(P) != j[left, None]
        points[left], S = minimise(residuals, points[left], others, lower, upper, fit[left])
        u = np.sqrt(np.maximum(S - sums[fit[left]], 0))
        short = u < target[left]
        for end, own in ((near, short), (far, ~short)):
            end[:, left[own]] = distance[left[own]], u[own]
        shut[left] = short & (distance[left] >= reach[left])
        left = left[~shut[left] & (np.abs(u - target[left]) >= CLOSE * target[left])]
        if not left.size:
            break
        # The next to try lies between the two, or beyond `near` if nothing is.
        (a, u_a), (b, u_b), wanted = near[:, left], far[:, left], target[left]
        with np.errstate(invalid="ignore", divide="ignore"):
            inside = a + np.clip((wanted - u_a) / (u_b - u_a), 0.1, 0.9) * (b - a)
            beyond = np.minimum(a * np.clip(1.05 * wanted / u_a, 1.2, 4.0), reach[left])
        distance[left] = np.where(np.isfinite(b), inside, beyond)
    return (centre + side * distance).reshape(B, P, 2), shut.reshape(B, P, 2)
