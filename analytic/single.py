"""The lowest modes at one pose: what `reduced` and `correction` do with many, in few steps.

At one pose a step of numpy costs more than what it computes. Here are the same equations for one
pose and limbs that are alike, with one step of the correction and the count; where that is not
certain, the pose is left to those.
"""

from __future__ import annotations  # scipy loads its parts when they are first used

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from analytic.correction import BESIDE, CLOSE, FAINT, GRADED, SAFETY
from analytic.kinematics import Limbs
from analytic.limb_modes import DEGREE, limb_modes
from analytic.reduced import CUBIC, NODES, Constants, Floats, Reduced

NEAR = NODES[0]
POWERS = np.arange(DEGREE + 1.0)[:, None, None]
MOST = 6
"""Modes up to which one step of the correction mostly settles them."""
_NODES = np.array(NODES)


@dataclass(frozen=True)
class Single:
    """`Reduced` at one pose, without its first axis: K directions and p limb modes.

    Attributes: `vectors` a_k (K, 6); `poles`, `residues` and `owner` (p,); `powers` of P_k
    (DEGREE + 1, 1, K); `scale` (K,), P_k being a polynomial in `scale` lambda - 1 up to `limit`;
    no limb twists below `twist`.
    """

    vectors: Floats
    poles: Floats
    residues: Floats
    owner: NDArray[np.intp]
    powers: Floats
    scale: Floats
    limit: float
    twist: float

    def smooth(self, eigenvalue: Floats) -> Floats:
        """Return P_k at `eigenvalue` (c,), shape (c, K)."""
        t = eigenvalue[:, None] * self.scale - 1
        return np.asarray((t**POWERS * self.powers).sum(axis=0))

    def pencil(self, P: Floats, slope: Floats) -> tuple[Floats, Floats]:
        """Return the eigenvalues (m,) and motions (K, m) of `Reduced.pencil`.

        Raises `LinAlgError` where rounding leaves no mass.
        """
        a, m = self.vectors, 6 + len(self.poles)
        K, M = pair = np.zeros((2, m, m))
        pair[:, :6, :6] = (a.T * np.array([P, -slope])[:, None]) @ a
        K[6:, :6] = -np.sqrt(self.residues)[:, None] * a.take(self.owner, axis=0)
        K.ravel()[6 * (m + 1) :: m + 1] = self.poles
        M.ravel()[:: m + 1] += 1.0
        # By columns, as LAPACK reads, the triangle below the diagonal is the one above it.
        solve = scipy.linalg.lapack.dsygvd
        values, vectors, info = solve(K.T, M.T, uplo="U", overwrite_a=1, overwrite_b=1)
        if info:
            raise np.linalg.LinAlgError(f"a pencil that is not definite ({info})")
        return values, a @ vectors[:6]

    def below(self, eigenvalue: float) -> int:
        """Return how many modes lie below `eigenvalue`, see `Reduced.below`."""
        a, above = self.vectors, self.poles - eigenvalue
        d = self.smooth(np.array([eigenvalue]))[0]
        d -= np.bincount(self.owner, self.residues / above, len(d))
        D = (a.T * d) @ a
        D.ravel()[::7] -= eigenvalue
        values = scipy.linalg.lapack.dsyev(D, compute_v=0)[0]
        return int((values < 0).sum() + (above < 0).sum())


def lowest(
    known: Constants, limbs: Limbs, elements: int | None, count: int, *, torsion: bool
) -> Floats | None:
    """Return the lowest omega^2 (count,) of the `limbs` at one pose, or None where not certain.

    With `torsion` of limbs among the modes, that is also where one is among these.
    """
    problem = _problem(known, limbs, elements, count)
    if problem is None or 6 + len(problem.poles) < count:
        return None
    try:
        answer = _corrected(problem, count)
    except np.linalg.LinAlgError:
        return None
    if answer is None:
        return None
    found, largest = answer
    last = max(found)
    certain = (
        last * (1 + CLOSE) < problem.limit
        and not (torsion and last > problem.twist)
        and found[0] > GRADED * largest
        and problem.below(last * (1 + BESIDE)) == count
    )
    return np.array(found) if certain else None


def _problem(known: Constants, limbs: Limbs, elements: int | None, count: int) -> Single | None:
    """Return the problem, None where limbs differ, have no table or modes are many."""
    if len(known.alike) > 1 or count > MOST:
        return None
    rod, lengths = known.alike[0][1], limbs.lengths
    longest = max(lengths.tolist())
    modes = limb_modes(rod, min(lengths.tolist()), longest, elements, 1)
    if modes is None:
        return None
    poles, residues, powers, inverse = modes.scaled(lengths)
    a = limbs.frames.swapaxes(1, 2) @ limbs.rotation @ known.tips
    owner = (3 * np.arange(len(lengths))[:, None] + modes.direction).ravel()
    # Elements only stiffen a limb against torsion.
    twist = (np.pi / 2 / longest) ** 2 * float(rod.torsion_speed2[0])
    return Single(
        a.reshape(-1, 6), poles, residues, owner, powers.T[:, None], 2 * inverse,
        1 / float(inverse.max()), twist,
    )  # fmt: skip


@np.errstate(divide="ignore", invalid="ignore", over="ignore")
def _corrected(problem: Single, count: int) -> tuple[list[float], float] | None:
    """Return the roots that `correction.corrected` does, and the pencil's largest eigenvalue.

    None where one step does not settle all.
    """
    end = min(float(problem.poles.min()), problem.limit / NODES[-1])
    cubic = CUBIC @ problem.smooth(end * _NODES)
    start, V = problem.pencil(cubic[0], cubic[1] / end)
    own = cubic[2:] / end @ (V * V)
    # R_jj is about (u - near) (u - 1) (a_j + b_j u): first, where start_j + R_jj meets lambda.
    guesses, rows = [], []
    for low, a, b in zip(*np.array([start, *own])[:, :count].tolist(), strict=True):
        u = low / end
        for _ in range(2):
            line, across = a + b * u, (u - NEAR) * (u - 1)
            slower = (2 * u - 1 - NEAR) * line + across * b
            u += (low / end + across * line - u) / (1 - slower)
        if not 0 < u * end < problem.limit:
            return None
        across = (u - NEAR) * (u - 1) * end
        guesses.append((low, u * end, slower))
        rows.append((u * end, 1.0, u, -across, -across * u))
    row = np.array(rows)
    value = row[:, 0]
    # y_j (value - start_j - R_jj) = (R y)_j, where y of the mode itself is 1.
    rho = problem.smooth(value) - row[:, 1:3] @ cubic[:2]
    pushed = (rho * V.T[:count]) @ V
    y = pushed / (row[:, 3:] @ own + (value[:, None] - start))
    y[np.abs(pushed) < FAINT * value[:, None]] = 0.0
    y.ravel()[:: len(start) + 1] = 1.0
    rho *= (y @ V.T) ** 2
    y *= y
    whole = (y @ start + rho.sum(axis=1)).tolist()
    mixed = (y * np.abs(start - start[:count, None])).sum(axis=1).tolist()
    found = []
    for (low, value, slower), total, norm, mix in zip(
        guesses, whole, y.sum(axis=1).tolist(), mixed, strict=True
    ):
        change, moved = total / norm - value, abs(value - low)
        root = value + change / (1 - slower)
        unsure = min(SAFETY * abs(slower * change), moved) * abs(change)
        left = unsure + SAFETY * mix * (norm - 1) * moved
        if not (left < Reduced.converged * root * moved and norm < 1.01):
            return None
        found.append(root)
    return found, float(start[-1])
