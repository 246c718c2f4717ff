"""The roots of a reduced problem from its linear pencil, corrected for the curvature of P.

In the basis V of the pencil's vectors the matrix is diag(start) - lambda + R, R = V^T rho V, with
rho(lambda) = P - chord small. Of (start_j - lambda) y_j + (R y)_j = 0 the y follow with R_jj on the
left, as the cubic of `Chord` gives it, and lambda by Rayleigh's quotient; the first guess is where
start_j + R_jj meets lambda.
"""

from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import NDArray

from analytic.reduced import NODES, Chord, Floats, Reduced

if TYPE_CHECKING:
    from analytic.chain_reduced import ChainReduced

Problem: TypeAlias = "Reduced | ChainReduced"

SAFETY = 4.0
"""How many times as large as its first term an error is taken to be."""
MOST_STEPS = 5
"""Newton's steps after which a pose is left to the roots by rank."""
FAINT = 1e-13
"""A coupling R_jk below this part of lambda is none: it moves no root by more (Weyl). Modes that
repeat for symmetry are coupled by rounding alone, a few 1e-15, over a gap that is rounding too."""

CLOSE = 1e-3
"""The last mode wanted stays this far, relative, below where the tables end."""
BESIDE = 1e-8
"""How far from the last root, relative in omega^2, modes are counted."""
GRADED = 1e-6
"""An eigenvalue below this part of the largest has lost too many digits for 1e-9."""


def corrected(
    problem: Problem,
    chord: Chord,
    start: Floats,
    motion: Floats,
    count: int,
    quick: bool = False,
) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the lowest roots (N, count) and where they are settled, (N,).

    `start` (N, m) and `motion` (N, r, m) are of the pencil with the `chord`. One step is enough
    for most poses, and is estimated to be; the others take more, unless all is to be `quick`.
    """
    found, settled = _steps(problem, chord, start, motion, count, 1)
    if not quick and not settled.all():
        k = np.flatnonzero(~settled)
        some = problem[k], chord[k], start[k], motion[k]
        found[k], settled[k] = _steps(*some, count, MOST_STEPS)
    return found, settled


@np.errstate(divide="ignore", invalid="ignore", over="ignore")
def _steps(
    problem: Problem, chord: Chord, start: Floats, motion: Floats, count: int, most: int
) -> tuple[Floats, NDArray[np.bool_]]:
    near, end, limit = NODES[0], problem.end[:, None], problem.limit
    lowest = start[:, :count]
    # R_jj is about (u - near) (u - 1) (a_j + b_j u).
    a, b = (problem.squares(chord.bend, motion) / end[:, None]).swapaxes(0, 1)
    first = lowest / end
    u = first
    for _ in range(2):
        line, across = a[:, :count] + b[:, :count] * u, (u - near) * (u - 1)
        slower = (2 * u - 1 - near) * line + across * b[:, :count]
        u = u + (first + across * line - u) / (1 - slower)
    value = u * end
    transposed = motion.swapaxes(1, 2)
    x = np.ascontiguousarray(transposed[:, :count].swapaxes(0, 1))
    own = np.arange(count)
    gap = start[:, None, :] - lowest[..., None]
    y, last, answered = gap, value, lowest
    for step in range(1, most + 1):
        at, u = value.T, value / end
        rho = problem.smooth(np.minimum(at, limit))
        rho -= chord.P
        rho -= chord.slope * at[..., None]
        bent = b[:, None] * u[..., None]
        bent += a[:, None]
        bent *= (end * (near - u) * (u - 1))[..., None]
        pushed = problem.times(rho, x).swapaxes(0, 1) @ motion
        if step > 1:
            pushed += bent * y
        bent -= gap
        bent += (value - lowest)[..., None]
        bent[:, own, own] = 1.0
        faint = np.abs(pushed) < FAINT * value[..., None]
        y = np.divide(pushed, bent, out=pushed)
        np.copyto(y, 0.0, where=faint)
        y[:, own, own] = 1.0
        x = (y @ transposed).swapaxes(0, 1)
        square = y * y
        norm = square.sum(axis=-1)
        answer = np.einsum("ncj,ncj->nc", square, gap) + problem.quotient(rho, x)
        answer = lowest + answer / norm
        change = answer - value
        if step == 1:
            # The cubic is as wrong in slope as in value.
            unsure = SAFETY * np.abs(slower * change / (value - lowest))
        else:
            # All but linear in lambda: a secant finds where the quotient meets the diagonal.
            apart = value - last
            secant = np.where(np.abs(apart) > 1e-8 * value, (answer - answered) / apart, slower)
            unsure = np.abs(secant - slower)
            slower = np.where(np.abs(secant) < 0.5, secant, 0.0)
        last, answered = value, answer
        value = value + change / (1 - slower)
        # What another step would still change: by the slope, and by what the modes mix with.
        left = np.minimum(unsure, 1) * np.abs(change)
        left += SAFETY * np.einsum("ncj,ncj->nc", square, np.abs(gap)) * (norm - 1)
        settled = ((left < problem.converged * value).all(axis=1)) & (norm.max(axis=1) < 1.01)
        if settled.all():
            break
    return value, settled
