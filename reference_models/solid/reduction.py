"""One solid rod, reduced to what its two joints see: Craig and Bampton (1968).

In a family of motions the joints see one displacement t, of the tip. With the rod's fixed-tip
modes, lambda_j and their mass coupling m_j to t, its dynamic stiffness is
    d(lambda) = k - lambda m - lambda^2 sum_j m_j^2 / (lambda_j - lambda).
The modes come from a Lanczos process started from that coupling: all that the tip can see
appears, once. Eigenvalues of a Jacobi matrix are simple, whatever the rod's length; so, in
ascending order, they and their couplings (made positive) are smooth functions of it, and a mode
keeps its name. The first few are kept. All others share one more that has their first two
moments, sum m_j^2 / lambda_j and sum m_j^2 / lambda_j^2.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from reference_models.solid.faces import Held

Array = NDArray[np.float64]

PARTS = 4
"""The whole rod's stiffness and mass over those of a quarter, whose units all numbers here have."""
STEPS = 40
"""Lanczos steps: the modes kept are exact long before."""


@dataclass(frozen=True)
class Statics:
    """A held family at one length, u = q + psi t: no stiffness couples q and t.

    Attributes: `factor` solves K_qq; `mass` M_qq, shape (q, q); `shape` psi (q,); `coupling`
    M_qq psi + M_qt (q,); `tip` stiffness k and mass m of t. "twist" has no t: these are zero.
    """

    factor: Any
    mass: sp.csr_array
    shape: Array
    coupling: Array
    tip: tuple[float, float]


def statics(held: Held, stretch: float) -> Statics:
    """Return a held family of a rod `stretch` times as long as its mesh."""
    A, B, C = held.stiffness
    K, M = sp.csc_array(stretch * A + B + C / stretch), sp.csc_array(stretch * held.mass)
    n = K.shape[0] - held.driven
    factor = splu(
        K[:n, :n],
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    mass = sp.csr_array(M[:n, :n])
    if not held.driven:
        return Statics(factor, mass, np.zeros(n), np.zeros(n), (0.0, 0.0))
    K_qt, M_qt = (part[:n, [n]].toarray()[:, 0] for part in (K, M))
    psi = -factor.solve(K_qt)
    coupling = mass @ psi + M_qt
    tip = float(K[n, n] + K_qt @ psi), float(M[n, n] + M_qt @ psi + psi @ coupling)
    return Statics(factor, mass, psi, coupling, tip)


@dataclass(frozen=True)
class Spectrum:
    """What the tip sees of one family: `tip` as in `Statics`, modes in ascending order.

    Attributes: `poles` lambda_j and `couplings` m_j > 0, shape (j,); `static` (11,) and `shapes`
    (j, 11): the axis' motion along the family's direction under t = 1 and in every mode.
    """

    tip: tuple[float, float]
    poles: Array
    couplings: Array
    static: Array
    shapes: Array

    def stiffness(self, eigenvalue: Array) -> Array:
        """Return d at every `eigenvalue`, the equation above."""
        lam = np.asarray(eigenvalue)[..., None]
        modal = (lam**2 * self.couplings**2 / (self.poles - lam)).sum(axis=-1)
        k, m = self.tip
        return np.asarray(k - eigenvalue * m - modal)

    def kept(self, count: int) -> "Spectrum":
        """Return the first `count` modes, and one more in place of all others."""
        first, rest = slice(count), slice(count, None)
        poles, couplings = self.poles[rest], self.couplings[rest]
        once, twice = ((couplings**2 / poles**power).sum() for power in (1, 2))
        pole = once / twice
        coupling = np.sqrt(once * pole)
        # The shape the others take together, below their own frequencies.
        shape = pole / coupling * ((couplings / poles) @ self.shapes[rest])
        return Spectrum(
            self.tip,
            np.append(self.poles[first], pole),
            np.append(self.couplings[first], coupling),
            self.static,
            np.vstack([self.shapes[first], shape]),
        )


def spectrum(held: Held, stretch: float) -> Spectrum:
    """Return the modes of a held family; of "twist", which has no t, those of any start."""
    part = statics(held, stretch)
    n = len(part.shape)
    line = held.line[:, :n]
    start = part.factor.solve(part.coupling if held.driven else np.ones(n))
    Q, MQ = np.zeros((STEPS, n)), np.zeros((STEPS, n))
    alpha, beta = np.zeros(STEPS), np.zeros(STEPS)
    Q[0], size = _unit(part, start)
    for i in range(STEPS):
        MQ[i] = part.mass @ Q[i]
        w = part.factor.solve(MQ[i])
        alpha[i] = w @ MQ[i]
        if i + 1 < STEPS:
            for _ in range(2):  # once is not enough for orthogonality to the last digit
                w -= (MQ[: i + 1] @ w) @ Q[: i + 1]
            Q[i + 1], beta[i] = _unit(part, w)
    inverse, S = scipy.linalg.eigh_tridiagonal(alpha, beta[:-1])
    real = inverse[::-1] > 1e-12 * inverse[-1]
    poles, S = 1 / inverse[::-1][real], S[:, ::-1][:, real]
    S *= np.where(S[0] < 0, -1.0, 1.0)
    shapes = S.T @ (Q @ line.T)
    if not held.driven:
        return Spectrum(part.tip, poles, np.zeros(len(poles)), np.zeros(len(line)), shapes)
    # q_1 = K^-1 p / size, so that p . phi_j = lambda_j size (q_1 . M phi_j).
    static = line @ part.shape + held.line[:, n]
    return Spectrum(part.tip, poles, poles * size * S[0], static, shapes)


def _unit(part: Statics, w: Array) -> tuple[Array, float]:
    size = float(np.sqrt(w @ (part.mass @ w)))
    return w / size, size
