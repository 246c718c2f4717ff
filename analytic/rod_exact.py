"""The dynamic stiffness of a piece of rod below its modes with both ends held.

Bending of a plane in y = (w / L, theta, V L^2 / EI, M L / EI) over x / L is y' = A y with
A^4 = -b A^2 - c: exp(A) = f0 + f1 A + f2 A^2 + f3 A^3, where the f are entire functions of b and c,
by their power series. There are no waves to tell apart and nothing cancels at low frequency.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic import rod_chain
from analytic.rod_chain import matrix
from analytic.rod_elements import AXIAL, BENDING, TORSION, Properties, element_matrices

Array = NDArray[Any]
Floats = NDArray[np.float64]

TERMS = 16
"""Of the power series: enough below the first mode with ends held, b and c below about 100."""


def pieces(
    rods: Properties, lengths: Floats, omega2: float | Floats, elements: int | None = None
) -> int:
    """Return into how many pieces rods are cut to have no mode below `omega2` with ends held.

    By a bound on each piece's lowest: 1 / omega^2 <= m L^4 / (pi^4 EI) + m L^2 / (pi^2 kappa G A) +
    rho I L^2 / (pi^2 EI) for bending (Dunkerley), pi^2 EA / (m L^2) along it and alike in torsion.
    Of `elements`, whose modes are higher, each piece has ceil(elements / pieces), the last what is
    left; single ones have no mode.
    """
    n = 1
    while elements is None or n < elements:
        p = ((lengths / n) / np.pi) ** 2
        bending = (
            rods.mass[:, None] * (p[:, None] ** 2 + rods.shear * p[:, None])
            + rods.rotary * p[:, None]
        ) / rods.EI
        inverse = np.maximum(
            bending.max(axis=-1), p * np.maximum(rods.mass / rods.EA, rods.polar / rods.GJ)
        )
        if (omega2 * inverse < 1).all():
            break
        n = max(n + 1, int(1.1 * n))
    return n if elements is None else -(-elements // max(1, elements // n))


def dynamic_stiffness(
    rods: Properties, lengths: Floats, omega2: Array, elements: int | None = None
) -> Array:
    """Return D_e of a piece of each rod, (q, n, 12, 12), of `lengths` (n,) at `omega2` (q,).

    Or at `omega2` (q, n), one of every rod. With `elements`, of so many equal ones in every piece,
    condensed onto its ends.

    Complex of complex `omega2`: derivatives by complex step.
    """
    lam = omega2[:, None] if omega2.ndim == 1 else omega2
    L = lengths
    if elements == 1:  # at any frequency
        K, M = element_matrices(rods, L)
        return np.asarray(K - lam[..., None, None] * M)
    D = np.zeros((len(omega2), len(L), 12, 12), dtype=np.result_type(omega2, float))
    for plane, (dofs, sign) in enumerate(BENDING):
        EI = rods.EI[:, plane]
        mu, r, phi = _numbers(rods, L, lam, plane)
        if elements is None:
            T = transition(mu, r, phi)
        else:
            rotary = rods.rotary[:, plane] / (rods.mass * L**2)
            T = rod_chain.transition(mu, rotary, phi, elements)
        D[..., np.array(dofs)[:, None], dofs] = _bending(EI, L, T) * np.outer(sign, sign)
    for line, stiffness, inertia in (
        (AXIAL, rods.EA, rods.mass),
        (TORSION, rods.GJ, rods.polar),
    ):
        x = lam * inertia * L**2 / stiffness
        near, far = bar(x) if elements is None else rod_chain.bar(x, elements)
        rows = matrix([[near, far], [far, near]])
        D[..., np.array(line)[:, None], line] = rows * (stiffness / L)[:, None, None]
    return D


def _numbers(rods: Properties, L: Floats, lam: Array, plane: int) -> tuple[Array, Array, Floats]:
    """Return mu = lambda m L^4 / EI, r = lambda rho I L^2 / EI and phi = EI / (kappa G A L^2)."""
    EI = rods.EI[:, plane]
    mu = lam * rods.mass * L**4 / EI
    return mu, lam * rods.rotary[:, plane] * L**2 / EI, rods.shear[:, plane] / L**2


def transition(mu: Array, r: Array, phi: Floats) -> Array:
    """Return exp(A), shape (..., 4, 4), over one length; see the module and `_numbers`."""
    b, c = r + mu * phi, mu * (phi * r - 1)
    a_k, b_k = np.ones_like(b), np.zeros_like(b)
    f = [np.zeros_like(b) for _ in range(4)]
    weight = 1.0
    for k in range(TERMS):
        f[0] += weight * a_k
        f[2] += weight * b_k
        f[1] += weight / (2 * k + 1) * a_k
        f[3] += weight / (2 * k + 1) * b_k
        weight /= (2 * k + 1) * (2 * k + 2)
        a_k, b_k = -c * b_k, a_k - b * b_k
    f0, f1, f2, f3 = f
    o = np.zeros_like(b)
    A = matrix([[o, o + 1, o + phi, o], [o, o, o, o + 1], [-mu, o, o, o], [o, -r, o - 1, o]])
    A2 = A @ A
    i = np.eye(4)
    one = f0[..., None, None] * i + f1[..., None, None] * A
    return np.asarray(one + f2[..., None, None] * A2 + f3[..., None, None] * (A2 @ A))


def _bending(EI: Floats, L: Floats, T: Array) -> Array:
    """Return D of (w, theta, w, theta) by the transition `T`, both of shape (..., 4, 4)."""
    # The far end's motion is T_dd d + T_df f: with it given, f = T_df^-1 (d1 - T_dd d0).
    a, b, c, d = T[..., 0, 2], T[..., 0, 3], T[..., 1, 2], T[..., 1, 3]
    determinant = a * d - b * c
    flexible = matrix([[d, -b], [-c, a]]) / determinant[..., None, None]
    near = flexible @ T[..., :2, :2]
    far = -flexible
    # Symmetric, and the same seen from the other end.
    D = np.empty_like(T)
    mirror = np.array([1.0, -1.0])
    D[..., :2, :2] = near
    D[..., 2:, 2:] = near * np.outer(mirror, mirror)
    D[..., :2, 2:], D[..., 2:, :2] = far, far.swapaxes(-1, -2)
    D = (D + D.swapaxes(-1, -2)) / 2
    size = np.stack([1 / L, np.ones_like(L), 1 / L, np.ones_like(L)], axis=-1)
    return np.asarray(D * (EI / L)[:, None, None] * size[:, :, None] * size[:, None, :])


def bar(x: Array) -> tuple[Array, Array]:
    """Return k cot k and -k / sin k of k^2 = x > 0."""
    k = np.sqrt(x)
    over = np.where(np.abs(x) < 1e-16, 1.0, k / np.where(np.abs(x) < 1e-16, 1.0, np.sin(k)))
    return np.cos(k) * over, -over
