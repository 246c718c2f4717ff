"""Least squares within bounds, hundreds of fits at once: minima, profiles and directions.

A model that takes many designs a call makes one call of all fits' Jacobians cheaper than any fit
alone. All functions take `residuals(points (M, P), owner (M,)) -> (M, m)`: rows of parameters, and
which fit each row belongs to. What is minimised is S, the sum of their squares.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, f, qmc

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
Residuals = Callable[[Floats, NDArray[np.intp]], Floats]

STEP = 1e-5
"""Of a one-sided difference, over the distance between the bounds."""
SETTLED = 1e-8
"""Part of S that the next step promises to gain where a fit has converged."""
SAMPLE = 4
"""Points looked at for each start."""
EARLY = 4
"""Steps after which only the better starts go on."""
CLOSE = 1e-3
"""Relative error of a profile's height at an end."""


@dataclass(frozen=True)
class Minima:
    """Where B fits ended: `points` (B, P), S `sums` (B,), and whether they `settled` (B,)."""

    points: Floats
    sums: Floats
    settled: Flags


def minimise(
    residuals: Residuals,
    start: Floats,
    free: Flags,
    lower: Floats,
    upper: Floats,
    owner: NDArray[np.intp] | None = None,
    steps: int = 60,
) -> Minima:
    """Return the minima that Levenberg's and Marquardt's steps reach from `start` (B, P).

    Only parameters that are `free` (B, P) move, within `lower` and `upper` (P,). At a bound that
    the gradient points through, a parameter rests. `owner` (B,) is what `residuals` is told, by
    default the row.
    """
    points = np.where(free, np.clip(start, lower, upper), start)
    owner = np.arange(len(points)) if owner is None else owner
    values = residuals(points, owner)
    sums = (values**2).sum(axis=1)
    J = np.zeros((*values.shape, points.shape[1]))
    damping, fresh = np.full(len(points), 1e-3), np.ones(len(points), dtype=bool)
    scale = np.zeros(points.shape)
    left, settled = np.arange(len(points)), np.zeros(len(points), dtype=bool)
    for _ in range(steps):
        new = left[fresh[left]]
        inwards = _inwards(points[new], lower, upper)
        J[new] = jacobian(residuals, points[new], values[new], free[new], inwards, owner[new])
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
        settled[left[done]] = True
        left = left[~done]
        if not left.size:
            break
    return Minima(points, sums, settled)


def jacobian(
    residuals: Residuals,
    points: Floats,
    values: Floats,
    free: Flags,
    steps: Floats,
    owner: NDArray[np.intp],
) -> Floats:
    """Return d residuals / d points (B, m, P), zero where not `free`, by one-sided differences.

    `steps` (B, P) may have either sign; the mean of both signs is a central difference.
    """
    row, column = np.nonzero(free)
    J = np.zeros((*points.shape, values.shape[1]))
    if not len(row):
        return np.asarray(J.swapaxes(1, 2))
    ahead, size = points[row], steps[row, column]
    ahead[np.arange(len(row)), column] += size
    J[row, column] = (residuals(ahead, owner[row]) - values[row]) / size[:, None]
    return np.asarray(J.swapaxes(1, 2))


def central_jacobian(residuals: Residuals, point: Floats, lower: Floats, upper: Floats) -> Floats:
    """Return d residuals / d point (m, P) at one `point` (P,), to 1e-6 and better."""
    steps = np.broadcast_to(30 * STEP * (upper - lower), (1, len(point)))
    one, owner = point[None], np.zeros(1, dtype=np.intp)
    values, free = residuals(one, owner), np.ones((1, len(point)), dtype=bool)
    sides = [jacobian(residuals, one, values, free, h, owner)[0] for h in (steps, -steps)]
    return np.asarray((sides[0] + sides[1]) / 2)


def search(
    residuals: Residuals,
    base: Floats,
    free: Flags,
    lower: Floats,
    upper: Floats,
    *,
    starts: int = 8,
    seed: int = 0,
) -> tuple[Minima, NDArray[np.intp]]:
    """Return the lowest minimum of each of F fits, and how many of its starts reached it, (F,).

    `base` (P,) holds what is not `free` (F, P). Of `base` and SAMPLE Sobol points a start within
    the bounds each fit starts from its best `starts`; after EARLY steps the worse half is left.
    """
    F, P = free.shape
    count = 2 ** int(np.ceil(np.log2(SAMPLE * starts)))
    unit = qmc.Sobol(P, rng=np.random.default_rng(seed)).random(count)
    sobol = np.where(free[:, None], lower + unit * (upper - lower), base)
    points = np.concatenate([np.broadcast_to(base, (F, 1, P)), sobol], axis=1)
    owner = np.repeat(np.arange(F), count + 1)
    sums = (residuals(points.reshape(-1, P), owner) ** 2).sum(axis=1).reshape(F, -1)
    for keep, steps in ((starts, EARLY), ((starts + 1) // 2, 60)):
        best = np.argsort(sums, axis=1, kind="stable")[:, :keep]
        chosen = np.take_along_axis(points, best[..., None], axis=1).reshape(-1, P)
        owner = np.repeat(np.arange(F), keep)
        found = minimise(residuals, chosen, free[owner], lower, upper, owner, steps)
        sums, points = found.sums.reshape(F, -1), found.points.reshape(F, -1, P)
    rows = np.arange(F) * keep + sums.argmin(axis=1)
    reached = (sums <= sums.min(axis=1, keepdims=True) * (1 + 1e-6) + 1e-18).sum(axis=1)
    return Minima(found.points[rows], found.sums[rows], found.settled[rows]), reached


def rise(level: float, together: int, *, sums: Floats, freedom: int, noise: float | None) -> Floats:
    """Return how far S may rise above its minima `sums` (B,) at confidence `level`, (B,).

    With residuals of known standard deviation `noise` by chi-square, else by F, the noise taken
    from S with `freedom` values more than parameters. One parameter alone: `together` = 1. With all
    k of them, `together` = k, the intervals hold the k true values at once at least that often.
    """
    if noise is not None:
        return np.full(len(sums), noise**2 * chi2.ppf(level, together))
    return np.asarray(sums / freedom * together * f.ppf(level, together, freedom))


@dataclass(frozen=True)
class Ends:
    """Ends of profile intervals, lower and upper: `at` (B, P, 2); `open` where a bound came first.

    NaN for parameters that are not free. `sums` is the lowest S met on the way, (B,).
    """

    at: Floats
    open: Flags
    sums: Floats


def profile_ends(
    residuals: Residuals,
    best: Minima,
    free: Flags,
    lower: Floats,
    upper: Floats,
    height: Floats,
) -> Ends:
    """Return where S, minimised over all other parameters, has risen by `height` (B,).

    By a bracketed secant on sqrt(S - S_min), which is all but linear in the parameter.
    """
    B, P = best.points.shape
    owner = np.arange(B)
    J = jacobian(
        residuals, best.points, residuals(best.points, owner), free,
        _inwards(best.points, lower, upper), owner,
    )  # fmt: skip
    covariance = np.linalg.pinv(np.einsum("bmp,bmq->bpq", J, J), rcond=1e-14, hermitian=True)
    fit, j = (np.repeat(index, 2) for index in np.nonzero(free))
    side = np.tile([-1.0, 1.0], len(fit) // 2)
    each = np.arange(len(fit))
    wall = np.where(side < 0, lower[j], upper[j])
    centre, target = best.points[fit, j], np.sqrt(height[fit])
    deviation = np.sqrt(np.maximum(covariance[fit, j, j], 1e-30))
    direction = covariance[fit, :, j] / deviation[:, None] ** 2
    # How far from the centre; at a distance of zero sqrt(S - S_min) is zero too.
    reach = np.abs(wall - centre)
    near, near_u = np.zeros(len(fit)), np.zeros(len(fit))
    far, far_u = np.full(len(fit), np.inf), np.full(len(fit), np.inf)
    distance = np.minimum(deviation * target, reach)
    points = best.points[fit] + direction * (side * distance)[:, None]
    lowest, shut = best.sums.copy(), reach <= 0
    left = np.flatnonzero(~shut)
    for _ in range(25):
        points[left, j[left]] = (centre + side * distance)[left]
        others = free[fit[left]]
        others[np.arange(len(left)), j[left]] = False
        found = minimise(residuals, points[left], others, lower, upper, fit[left])
        points[left] = found.points
        np.minimum.at(lowest, fit[left], found.sums)
        u = np.sqrt(np.maximum(found.sums - best.sums[fit[left]], 0))
        short = u < target[left]
        near[left] = np.where(short, distance[left], near[left])
        near_u[left] = np.where(short, u, near_u[left])
        far[left] = np.where(short, far[left], distance[left])
        far_u[left] = np.where(short, far_u[left], u)
        shut[left] = short & (distance[left] >= reach[left])
        done = shut[left] | (np.abs(u - target[left]) < CLOSE * target[left])
        left = left[~done]
        if not left.size:
            break
        distance[left] = _next(near, near_u, far, far_u, target, reach)[left]
    at, opened = np.full((B, P, 2), np.nan), np.zeros((B, P, 2), dtype=bool)
    which = each % 2
    at[fit, j, which] = centre + side * distance
    opened[fit, j, which] = shut
    return Ends(at, opened, lowest)


@dataclass(frozen=True)
class Profiles:
    """S minimised over all other parameters: `at` (P, points) of each, `sums` (P, points)."""

    at: Floats
    sums: Floats


def profiles(
    residuals: Residuals, best: Floats, lower: Floats, upper: Floats, span: Floats, points: int
) -> Profiles:
    """Return the profile of every parameter over `span` (P, 2), from the minimum `best` (P,).

    Each goes outwards from `best` on both sides, from one minimum to the next.
    """
    P, half = len(best), points // 2
    at = np.empty((P, 2, half + 1))
    at[:, 0] = np.linspace(best, span[:, 0], half + 1, axis=1)
    at[:, 1] = np.linspace(best, span[:, 1], half + 1, axis=1)
    sums = np.empty_like(at)
    j = np.repeat(np.arange(P), 2)
    others = np.ones((2 * P, P), dtype=bool)
    others[np.arange(2 * P), j] = False
    moving, owner = np.tile(best, (2 * P, 1)), np.zeros(2 * P, dtype=np.intp)
    for k in range(half + 1):
        moving[np.arange(2 * P), j] = at[:, :, k].ravel()
        found = minimise(residuals, moving, others, lower, upper, owner)
        moving, sums[:, :, k] = found.points, found.sums.reshape(P, 2)
    joined = [np.concatenate([x[:, 0, :0:-1], x[:, 1]], axis=1) for x in (at, sums)]
    return Profiles(*joined)


def _next(
    near: Floats, near_u: Floats, far: Floats, far_u: Floats, target: Floats, reach: Floats
) -> Floats:
    """Return the next distance to try: between `near` and `far`, or beyond `near` if none is."""
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.clip((target - near_u) / (far_u - near_u), 0.1, 0.9)
        inside = near + share * (far - near)
        beyond = near * np.clip(1.05 * target / near_u, 1.2, 4.0)
    return np.where(np.isfinite(far), inside, np.minimum(beyond, reach))


def _inwards(points: Floats, lower: Floats, upper: Floats) -> Floats:
    size = STEP * (upper - lower)
    return np.where(points + size > upper, -size, size)
