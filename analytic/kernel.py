"""The inner loop of `condensed` for a compiler (numba), where one is installed.

The same steps as `Reduced.pencil` and `correction.corrected` in numpy, a pose at a time: Cholesky,
Householder's tridiagonal form, implicit QL (Golub and Van Loan, 8.3), then the correction. Only the
vectors' part that moves the platform is carried along.
"""

import importlib
import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.limb_modes import DEGREE
from analytic.reduced import NODES

Floats = NDArray[np.float64]
NEAR, BESIDE, _, BEYOND = NODES
USUAL = DEGREE + 1, 9, 6, 6
"""Powers, directions, poles and modes wanted of most calls, for which all loops are unrolled."""


@lru_cache(maxsize=1)
def compiled() -> Callable[..., Any] | None:
    """Return `solve_poses` compiled, or None without numba. The first call of it takes seconds."""
    try:
        numba = importlib.import_module("numba")
    except ImportError:
        return None
    settings = {"error_model": "numpy", "fastmath": {"reassoc", "contract", "arcp", "nsz"}}
    result: Callable[..., Any]
    try:
        result = numba.njit(cache=True, **settings)(solve_poses)
    except RuntimeError:  # no folder to keep it in: neither the package's nor the user's
        result = numba.njit(**settings)(solve_poses)
    return result


def solve_poses(
    a: Floats,
    poles: Floats,
    residues: Floats,
    owner: NDArray[np.intp],
    powers: Floats,
    stiffness: Floats,
    caps: Floats,
    tolerance: float,
    safety: float,
    most: int,
    past: float,
    faint: float,
    usual: bool | None,
    start: Floats,
    found: Floats,
    settled: NDArray[np.bool_],
    below: NDArray[np.int64],
) -> None:
    """Fill `start` (N, m), `found` (N, count), `settled` and `below` (N,), see `condensed`.

    `tolerance`, `safety`, `most` and `faint` are of `correction`; modes are counted `past` the last
    root. `usual`: all sizes are `USUAL`; None: they are the arrays'. Numba compiles the two apart,
    for it drops the branch that None, a type of its own, rules out.
    """
    N, columns = len(a), powers.shape[2]
    if usual is None:
        terms, K, p, count = len(powers), a.shape[1], poles.shape[1], found.shape[1]
    else:
        terms, K, p, count = USUAL
    m = 6 + p
    C = np.empty((6, 6))
    at = np.empty((K, 6))
    A = np.empty((m, m))
    Q = np.empty((m, m))
    Z = np.empty((m, 6))
    d, e, v, w = np.empty(m), np.empty(m), np.empty(m), np.empty(m)
    beta = np.empty(m)
    V = np.empty((K, m))
    x, rho, t, y = np.empty(K), np.empty(K), np.empty(K), np.empty(m)
    order = np.empty(m, dtype=np.int64)
    P, slope, scale = np.empty(K), np.empty(K), np.empty(K)
    bend, by = np.empty(K), np.empty(K)
    power = np.empty((terms, K))
    for n in range(N):
        # The chord of P and its bend, with this pose's powers side by side.
        limit, end = np.inf, np.inf
        for k in range(K):
            limit = min(limit, caps[n, k])
            scale[k] = 2.0 / caps[n, k]
        column = n if columns > 1 else 0
        for j in range(terms):
            for k in range(K):
                power[j, k] = powers[j, k, column] * stiffness[n, k]
        for q in range(p):
            end = min(end, poles[n, q])
        end = min(end, limit / BEYOND)
        for k in range(K):
            P[k] = slope[k] = bend[k] = by[k] = power[terms - 1, k]
        for j in range(terms - 2, -1, -1):
            for k in range(K):
                unit = end * scale[k]
                P[k] = P[k] * (NEAR * unit - 1.0) + power[j, k]
                bend[k] = bend[k] * (BESIDE * unit - 1.0) + power[j, k]
                slope[k] = slope[k] * (unit - 1.0) + power[j, k]
                by[k] = by[k] * (BEYOND * unit - 1.0) + power[j, k]
        for k in range(K):
            rise = (slope[k] - P[k]) / (1.0 - NEAR)
            P[k] -= NEAR * rise
            slope[k] = rise / end
            bend[k] = (bend[k] - P[k] - BESIDE * rise) / ((BESIDE - NEAR) * (BESIDE - 1.0))
            by[k] = (by[k] - P[k] - BEYOND * rise) / ((BEYOND - NEAR) * (BEYOND - 1.0))
            by[k] = (by[k] - bend[k]) / (BEYOND - BESIDE)
            bend[k] -= BESIDE * by[k]
        # C C^T = I - sum slope_k a_k a_k^T, and the directions in those coordinates.
        for i in range(6):
            for j in range(i + 1):
                total = 1.0 if i == j else 0.0
                for k in range(K):
                    total -= slope[k] * a[n, k, i] * a[n, k, j]
                for k in range(j):
                    total -= C[i, k] * C[j, k]
                C[i, j] = math.sqrt(total) if i == j else total / C[j, j]
        for k in range(K):
            for i in range(6):
                total = a[n, k, i]
                for j in range(i):
                    total -= C[i, j] * at[k, j]
                at[k, i] = total / C[i, i]
        A[:, :] = 0.0
        # Limb modes first, then the platform: graded from large to small.
        for i in range(6):
            for j in range(i + 1):
                total = 0.0
                for k in range(K):
                    total += P[k] * at[k, i] * at[k, j]
                A[p + i, p + j] = total
                A[p + j, p + i] = total
        for q in range(p):
            A[q, q] = poles[n, q]
            root = math.sqrt(residues[n, q])
            for i in range(6):
                A[q, p + i] = -root * at[owner[q], i]
                A[p + i, q] = A[q, p + i]
        # Householder: A = Q T Q^T; the reflections stay below the diagonal of A.
        for k in range(m - 2):
            norm = 0.0
            for i in range(k + 1, m):
                norm += A[i, k] * A[i, k]
            norm = math.sqrt(norm)
            d[k] = A[k, k]
            beta[k] = 0.0
            if norm == 0.0:
                e[k] = 0.0
                continue
            alpha = -norm if A[k + 1, k] > 0 else norm
            e[k] = alpha
            beta[k] = 1.0 / (norm * norm - alpha * A[k + 1, k])
            A[k + 1, k] -= alpha
            dot = 0.0
            for i in range(k + 1, m):
                total = 0.0
                for j in range(k + 1, m):
                    total += A[i, j] * A[j, k]
                w[i] = beta[k] * total
                dot += w[i] * A[i, k]
            for i in range(k + 1, m):
                v[i] = A[i, k]
                w[i] -= 0.5 * beta[k] * dot * v[i]
            for i in range(k + 1, m):
                for j in range(k + 1, m):
                    A[i, j] -= v[i] * w[j] + w[i] * v[j]
        d[m - 2], d[m - 1] = A[m - 2, m - 2], A[m - 1, m - 1]
        e[m - 2], e[m - 1] = A[m - 1, m - 2], 0.0
        # The platform's six rows of Q: the reflections applied to unit rows in turn.
        for i in range(m):
            for j in range(6):
                Q[j, i] = 1.0 if i == p + j else 0.0
        for k in range(m - 2):
            if beta[k] != 0.0:
                for j in range(6):
                    total = 0.0
                    for i in range(k + 1, m):
                        total += Q[j, i] * A[i, k]
                    total *= beta[k]
                    for i in range(k + 1, m):
                        Q[j, i] -= total * A[i, k]
        # QL keeps the digits of small eigenvalues where they come first: turn T around.
        for i in range(m):
            for j in range(6):
                Z[i, j] = Q[j, m - 1 - i]
        for i in range(m // 2):
            d[i], d[m - 1 - i] = d[m - 1 - i], d[i]
        for i in range((m - 1) // 2):
            e[i], e[m - 2 - i] = e[m - 2 - i], e[i]
        for first in range(m):
            for _ in range(60):
                last = first
                while last < m - 1 and abs(e[last]) > 1.1e-16 * (abs(d[last]) + abs(d[last + 1])):
                    last += 1
                if last == first:
                    break
                g = (d[first + 1] - d[first]) / (2.0 * e[first])
                r = math.sqrt(g * g + 1.0)
                g = d[last] - d[first] + e[first] / (g + (r if g >= 0 else -r))
                s, c, lift = 1.0, 1.0, 0.0
                whole = True
                for i in range(last - 1, first - 1, -1):
                    f, b = s * e[i], c * e[i]
                    r = math.sqrt(f * f + g * g)
                    e[i + 1] = r
                    if r == 0.0:
                        d[i + 1] -= lift
                        e[last] = 0.0
                        whole = False
                        break
                    s, c = f / r, g / r
                    g = d[i + 1] - lift
                    r = (d[i] - g) * s + 2.0 * c * b
                    lift = s * r
                    d[i + 1] = g + lift
                    g = c * r - b
                    for j in range(6):
                        f = Z[i + 1, j]
                        Z[i + 1, j] = s * Z[i, j] + c * f
                        Z[i, j] = c * Z[i, j] - s * f
                if whole:
                    d[first] -= lift
                    e[first] = g
                    e[last] = 0.0
        for i in range(m):
            order[i] = i
        for i in range(1, m):
            j, moved = i, order[i]
            while j > 0 and d[order[j - 1]] > d[moved]:
                order[j] = order[j - 1]
                j -= 1
            order[j] = moved
        for i in range(m):
            start[n, i] = d[order[i]]
            for k in range(K):
                total = 0.0
                for j in range(6):
                    total += at[k, j] * Z[order[i], j]
                V[k, i] = total
        # The correction for the curvature of P_k, as in `correction.corrected`.
        for j in range(m):
            d[j] = start[n, j]
            v[j], w[j] = 0.0, 0.0
        for k in range(K):
            for j in range(m):
                v[j] += bend[k] / end * V[k, j] * V[k, j]
                w[j] += by[k] / end * V[k, j] * V[k, j]
        settled[n] = True
        for i in range(count):
            u, slower = d[i] / end, 0.0
            for _ in range(2):
                line, across = v[i] + w[i] * u, (u - NEAR) * (u - 1.0)
                slower = (2.0 * u - 1.0 - NEAR) * line + across * w[i]
                u += (d[i] / end + across * line - u) / (1.0 - slower)
            value = u * end
            for k in range(K):
                x[k] = V[k, i]
            last, answered = value, value
            good = False
            for step in range(1, most + 1):
                at_most = min(value, limit)
                u = value / end
                for k in range(K):
                    t[k] = at_most * scale[k] - 1.0
                    rho[k] = power[terms - 1, k]
                for j in range(terms - 2, -1, -1):
                    for k in range(K):
                        rho[k] = rho[k] * t[k] + power[j, k]
                for k in range(K):
                    rho[k] -= P[k] + slope[k] * value
                    t[k] = rho[k] * x[k]
                across = end * (NEAR - u) * (u - 1.0)
                for j in range(m):
                    beta[j] = across * (v[j] + w[j] * u)
                    y[j] = beta[j] * y[j] if step > 1 else 0.0
                for k in range(K):
                    for j in range(m):
                        y[j] += t[k] * V[k, j]
                norm, quotient, mixed, least = 0.0, 0.0, 0.0, faint * value
                for j in range(m):
                    y[j] = y[j] / (beta[j] - d[j] + value) if abs(y[j]) >= least else 0.0
                    y[j] = 1.0 if j == i else y[j]
                    norm += y[j] * y[j]
                    quotient += y[j] * y[j] * (d[j] - d[i])
                    mixed += y[j] * y[j] * abs(d[j] - d[i])
                for k in range(K):
                    total = 0.0
                    for j in range(m):
                        total += y[j] * V[k, j]
                    x[k] = total
                for k in range(K):
                    quotient += rho[k] * x[k] * x[k]
                answer = d[i] + quotient / norm
                change = answer - value
                if step == 1:
                    unsure = safety * abs(slower * change / (value - d[i]))
                else:
                    secant = slower
                    if abs(value - last) > 1e-8 * value:
                        secant = (answer - answered) / (value - last)
                    unsure = abs(secant - slower)
                    slower = secant if abs(secant) < 0.5 else 0.0
                last, answered = value, answer
                value += change / (1.0 - slower)
                left = min(unsure, 1.0) * abs(change) + safety * mixed * (norm - 1.0)
                good = left < tolerance * value and norm < 1.01
                if good:
                    break
            found[n, i] = value
            settled[n] = settled[n] and good
        # Wittrick and Williams: poles, and negative pivots of D, below a point just past the last.
        value = found[n, count - 1] * (1.0 + past)
        below[n] = 0
        for k in range(K):
            rho[k] = power[terms - 1, k]
            t[k] = value * scale[k] - 1.0
        for j in range(terms - 2, -1, -1):
            for k in range(K):
                rho[k] = rho[k] * t[k] + power[j, k]
        for q in range(p):
            rho[owner[q]] -= residues[n, q] / (poles[n, q] - value)
            if poles[n, q] < value:
                below[n] += 1
        for i in range(6):
            for j in range(i + 1):
                total = -value if i == j else 0.0
                for k in range(K):
                    total += rho[k] * a[n, k, i] * a[n, k, j]
                for k in range(j):
                    total -= C[i, k] * C[j, k] * w[k]
                C[i, j] = total / w[j] if j < i else 1.0
                if i == j:
                    w[i] = total
                    if total < 0:
                        below[n] += 1
