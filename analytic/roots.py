"""The lowest roots of a reduced problem at many poses, and where they are certain to be these."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.correction import BESIDE, CLOSE, FAINT, GRADED, MOST_STEPS, SAFETY, Problem, corrected
from analytic.kernel import USUAL
from analytic.reduced import Floats, Reduced

Loop = Callable[..., Any]
"""The compiled loop of `kernel`."""


def solve(
    problem: Problem, count: int, loop: Loop | None, quick: bool = False
) -> tuple[Floats, NDArray[np.bool_]]:
    """Return omega^2 (N, count), and where they are certain to be the lowest, (N,).

    `quick`: what all poses take; those that ask for more are not certain.
    """
    N = len(problem.lengths)
    if loop is None:
        chord = problem.chord()
        start, motion = problem.pencil(chord.P, chord.slope)
        found, settled = corrected(problem, chord, start, motion, count, quick)
        told, below = problem.told(chord.P, start[:, :count], motion), None
    else:
        assert isinstance(problem, Reduced)
        told = np.ones(N, dtype=bool)
        start, found = np.empty((N, 6 + problem.poles.shape[1])), np.empty((N, count))
        settled, below = np.empty(N, dtype=bool), np.empty(N, dtype=np.int64)
        poles = problem.poles, problem.residues, problem.owner
        smooth = problem.powers, problem.stiffness, problem.caps
        stops = problem.converged, SAFETY, MOST_STEPS, BESIDE, FAINT
        sizes = len(problem.powers), problem.vectors.shape[1], problem.poles.shape[1], count
        usual = True if sizes == USUAL else None
        loop(problem.vectors, *poles, *smooth, *stops, usual, start, found, settled, below)
    found = np.where(settled[:, None], found, start[:, :count])
    inside = found[:, -1] * (1 + CLOSE) < problem.limit
    inside &= told
    poor = inside & ~settled
    if quick:
        inside &= settled
    elif poor.any():
        found[poor] = _by_rank(problem[poor], start[poor, :count])
        below = None
    inside &= found[:, 0] > GRADED * start[:, -1]
    return found, inside & _certain(problem, found, below)


def _by_rank(problem: Problem, guess: Floats) -> Floats:
    """Return the roots by rank: the k-th eigenvalue of the matrix frozen at the k-th root itself.

    Newton's iteration on each, safe for roots that (nearly) repeat.
    """
    N, count = guess.shape
    every = problem[np.repeat(np.arange(N), count)]
    rank, value = np.tile(np.arange(count), N), guess.ravel().copy()
    for _ in range(8):
        P, slope = every.tangent(np.minimum(value, every.limit))
        previous = value
        value = every.pencil(P, slope)[0][np.arange(len(rank)), rank]
        if (np.abs(value - previous) < problem.converged * value).all():
            break
    return value.reshape(N, count)


def _certain(problem: Problem, found: Floats, below: NDArray[np.int64] | None) -> NDArray[np.bool_]:
    """Say where the last root has the rank it should have among all modes, (N,).

    As many modes below it (`below`, counted here if None) as were found proves that none was
    missed, for those found differ: their vectors are all but orthogonal. Where it repeats and more
    lie below, fewer must lie just before it.
    """
    count = found.shape[1]
    if below is None:
        below = problem.below(found[:, -1] * (1 + BESIDE))
    certain = below == count
    more = below > count
    if more.any():
        certain[more] = problem[more].below(found[more, -1] * (1 - BESIDE)) < count
    return np.asarray(certain)
