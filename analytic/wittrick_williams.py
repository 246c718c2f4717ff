"""Counting the modes below a frequency, with a bound on what rounding can do to the count.

With D(lambda) = sum_k d_k a_k a_k^T - lambda M_p over the limbs' three directions each, the modes
below omega are J = J_0 + (negative eigenvalues of D), Wittrick and Williams (1971).

So that the sign of every eigenvalue can be told whatever the units, the sizes and the masses, D is
written in the mechanism's own static coordinates: d_k(lambda) = d_k(0) + c_k(lambda), and
    sum_k d_k(0) a_k a_k^T = V^-T diag(sigma^2) V^-1
by singular values of sqrt(d_k(0)) a_k, in a metric to which the platform and its limbs both give
mass. Row i is then divided by the larger of sigma_i and omega: every entry is of order one, soft
motions beside stiff ones included.

D has poles, and modes sit next to them. Where c_k is large its force is kept as an unknown: in
    B = [[D without c_stiff, a_stiff], [a_stiff^T, -1 / c_stiff]]
nothing is large, and J = J_0 - (stiff c_k > 0) + (negative eigenvalues of B): the jump of J_0 at a
pole and the change of sign of 1 / c_k cancel.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.dynamic_stiffness import (
    first_pole,
    limb_response,
    softening_series,
    static_stiffness,
    torsion_counts,
)
from analytic.kinematics import Limbs, limbs_at
from analytic.mechanism import Mechanism
from analytic.pose import Pose
from analytic.reduced import Constants, constants
from analytic.theory import Theory
from analytic.waves import Sections

Floats = NDArray[np.float64]

FREE = 1e-13
"""A static singular value below this part of the largest is a free motion."""
SLOW, TERMS = 0.001, 8
"""Below this part of a limb's first pole c_k of bending is a series of so many terms."""
ROUNDING = 4 * float(np.finfo(float).eps)
"""Relative error of one entry of B; the bound on B's eigenvalues is made of it."""


class Counted:
    """Counts of modes by the negative eigenvalues of a `matrix` (q, m, m), with their rounding.

    `outside` (q,) is counted besides; `error` (q,) bounds the rounding of the eigenvalues.
    """

    matrix: Floats
    outside: NDArray[np.int64]
    error: Floats

    @cached_property
    def values(self) -> Floats:
        """The matrix's eigenvalues, ascending, (q, m)."""
        return np.asarray(np.linalg.eigvalsh(self.matrix))

    @property
    def count(self) -> NDArray[np.int64]:
        """How many modes lie below each omega^2, (q,)."""
        return np.asarray(self.outside + (self.values < 0).sum(axis=1))

    @property
    def at_least(self) -> NDArray[np.int64]:
        """How many modes lie below for certain, (q,)."""
        return np.asarray(self.outside + (self.values < -self.error[:, None]).sum(axis=1))

    @property
    def at_most(self) -> NDArray[np.int64]:
        """How many modes can lie below at most, (q,)."""
        return np.asarray(self.outside + (self.values < self.error[:, None]).sum(axis=1))


@dataclass(frozen=True)
class Form(Counted):
    """B at omega^2 of q values, and what goes with it; m = 6 + the most stiff directions.

    Attributes: `omega2` (q,); `matrix` B (q, m, m) and `mass` = -dB/d(omega^2), its 6 x 6 block
    `mass` (q, 6, 6) and its diagonal `springs` (q, m - 6); `outside`, the count outside B, torsion
    apart (q,); `error`, a bound on the rounding of B's eigenvalues (q,); `stiff` the directions of
    the border (q, m - 6), `bordered` where it is one of them (q, m - 6); `scale` (q, 6) of the
    static coordinates; `change` c_k (q, 3 n) and the square `size` (q, 3 n) of its row.
    """

    omega2: Floats
    matrix: Floats
    mass: Floats
    springs: Floats
    outside: NDArray[np.int64]
    error: Floats
    stiff: NDArray[np.intp]
    bordered: NDArray[np.bool_]
    scale: Floats
    change: Floats
    size: Floats

    @cached_property
    def pencil(self) -> tuple[Floats, Floats, Floats]:
        """(matrix, left, springs) of B x = delta (-B') x made standard, for `numpy.linalg.eigh`.

        Its eigenvalues delta estimate how far away, in omega^2, the modes are, and have B's signs.
        """
        block = self.mass + 1e-14 * np.eye(6) * self.mass.max(axis=(1, 2), keepdims=True)
        left = np.linalg.inv(np.linalg.cholesky(block))
        springs = 1 / np.sqrt(self.springs)
        B = self.matrix.copy()
        B[:, :6] = left @ B[:, :6]
        B[:, :, :6] = B[:, :, :6] @ left.swapaxes(1, 2)
        B[:, 6:] *= springs[:, :, None]
        B[:, :, 6:] *= springs[:, None, :]
        return B, left, springs


@dataclass(frozen=True)
class Characteristic:
    """The frequency-dependent problem of one mechanism at one pose.

    Attributes: limb `lengths` (n,) [m], their `rods`, `vectors` a_k over coordinates in which the
    platform's mass is the identity, shape (n, 3, 6), `elements` a limb or None (continuum). For
    counting alone, `lengths` (q, n) and `vectors` (q, n, 3, 6) give every omega^2 its own pose.
    """

    rods: Sections
    lengths: Floats
    vectors: Floats
    elements: int | None

    @property
    def scale(self) -> Floats:
        """Static stiffness 3 EI / L^3 (twice) and EA / L, shape (n, 3) [N/m]."""
        bending = 3 * self.rods.EI / self.lengths**3
        return np.stack([bending, bending, self.rods.EA / self.lengths], axis=-1)

    @cached_property
    def held(self) -> Floats:
        """d_k(0), shape (..., 3 n) [N/m]."""
        return self._flat(static_stiffness(self.rods, self.lengths))

    @cached_property
    def static(self) -> tuple[Floats, Floats, Floats, Floats]:
        """(sigma, W, N, back): the mechanism at rest, in its own coordinates y.

        `sigma` (..., 6) falls, sigma_i^2 being about omega^2 of limbs without mass; `W` (..., 3 n,
        6) are the a_k in y, `N` (..., 6, 6) is the platform's mass, `back` (..., 6, 6) turns y into
        the coordinates of `vectors`.
        """
        a = self.vectors.reshape(*self.lengths.shape[:-1], -1, 6)
        weight = self._flat(np.repeat((self.rods.line_mass * self.lengths / 3)[..., None], 3, -1))
        metric = np.eye(6) + (a * weight[..., None]).swapaxes(-1, -2) @ a
        inverse = np.linalg.inv(np.linalg.cholesky(metric)).swapaxes(-1, -2)
        u = a @ inverse
        rows = u * np.sqrt(self.held)[..., None]
        missing = max(0, 6 - rows.shape[-2])
        rows = np.concatenate([rows, np.zeros((*rows.shape[:-2], missing, 6))], axis=-2)
        _, sigma, V = np.linalg.svd(rows, full_matrices=False)
        V = V.swapaxes(-1, -2)
        back = inverse @ V
        return sigma, u @ V, back.swapaxes(-1, -2) @ back, back

    @property
    def free(self) -> int:
        """How many free motions the mechanism has: those that no limb resists at rest."""
        sigma = self.static[0]
        return int((sigma <= FREE * sigma[..., :1]).sum(axis=-1).max())

    @property
    def first(self) -> float:
        """omega^2 of the softest limb's first mode between pins."""
        return float(self._pole.min())

    @cached_property
    def _pole(self) -> Floats:
        return np.asarray(first_pole(self.rods, self.lengths))

    @cached_property
    def _series(self) -> Floats:
        return softening_series(self.rods, self.lengths, self.elements, TERMS)

    def _flat(self, of_limbs: Floats) -> Floats:
        return np.asarray(of_limbs.reshape(*self.lengths.shape[:-1], -1))

    def changes(self, omega2: Floats) -> tuple[Floats, Floats, NDArray[np.int64]]:
        """Return c_k, its derivative, and the modes of every direction held, (q, 3 n) each."""
        q, step = len(omega2), 1e-30
        d, counts = limb_response(
            self.rods, self.lengths, omega2[:, None] * (1 + 1j * step), self.elements
        )
        change = d.real - self.held.reshape(d.shape[-2:] if self.lengths.ndim == 1 else d.shape)
        slope = d.imag / (step * omega2[:, None, None])
        part = omega2[:, None] / self._pole
        if part.min() < SLOW:
            # Bending loses digits as 1 / sqrt(part); along the limb nothing cancels.
            slow = (part < SLOW)[..., None]
            x = np.where(slow, part[..., None], 0.0)
            value, tangent = np.zeros((2, *part.shape, 2))
            for k in range(TERMS - 1, -1, -1):
                tangent = tangent * x + (k + 1) * self._series[k]
                value = value * x + self._series[k]
            change[..., :2] = np.where(slow, value * x, change[..., :2])
            slope[..., :2] = np.where(slow, tangent / self._pole[..., None], slope[..., :2])
        return change.reshape(q, -1), slope.reshape(q, -1), counts.reshape(q, -1)

    def form(self, omega2: Floats) -> Form:
        """Return B and its derivative at each of `omega2` (q,) > 0."""
        sigma, W, N, _ = self.static
        c, slope, counts = self.changes(omega2)
        scale = 1 / np.maximum(sigma, np.sqrt(omega2)[:, None])
        w = W * scale[:, None, :]
        size = (w * w).sum(axis=-1)
        t = np.abs(c) * size
        large = t > 1
        N = N * (scale[:, :, None] * scale[:, None, :])
        soft = np.where(large, 0.0, c)
        top = (w * soft[..., None]).swapaxes(1, 2) @ w - omega2[:, None, None] * N
        i = np.arange(6)
        top[:, i, i] += (sigma * scale) ** 2
        mass = N - (w * np.where(large, 0.0, slope)[..., None]).swapaxes(1, 2) @ w
        p = int(large.sum(axis=1).max(initial=0))
        stiff = np.argsort(-t, axis=1)[:, :p]
        row = np.arange(len(omega2))[:, None]
        own = np.asarray(large[row, stiff])
        of_c, of_size, of_slope = (x[row, stiff] for x in (c, size, slope))
        B = np.zeros((len(omega2), 6 + p, 6 + p))
        B[:, :6, :6] = top
        border = w[row, stiff]
        border *= np.where(own, 1 / np.sqrt(of_size), 0.0)[..., None]
        B[:, 6:, :6], B[:, :6, 6:] = border, border.swapaxes(1, 2)
        j = 6 + np.arange(p)
        # A row that only fills the matrix up counts as positive, and as a mode far above.
        inverse = np.where(own, 1 / (np.where(own, of_c, 1.0) * of_size), 0.0)
        B[:, j, j] = np.where(own, -inverse, 1.0)
        springs = np.where(own, -of_slope * inverse**2 * of_size, 0.1 / omega2[:, None])
        outside = np.asarray(counts.sum(axis=1) - (large & (c > 0)).sum(axis=1))
        entries = (np.abs(c) + 2 * self.held + omega2[:, None] * np.abs(slope)) * size
        entries = np.where(large, entries / np.maximum(t, 1.0) ** 2, entries)
        error = 4 + p + sigma[..., 0] * scale.max(axis=1) + entries.sum(axis=1)
        return Form(omega2, B, mass, springs, outside, ROUNDING * error, stiff, own, scale, c, size)

    def count(self, omega2: Floats) -> NDArray[np.int64]:
        """Return the number of modes below each of `omega2` (q,), torsion included."""
        return self.coupled_count(omega2) + self.twists(omega2)

    def coupled_count(self, omega2: Floats) -> NDArray[np.int64]:
        """Return the number of modes below each of `omega2` (q,), without torsion."""
        return self.form(omega2).count

    def twists(self, omega2: Floats) -> NDArray[np.int64]:
        """Return the number of modes of torsion below each of `omega2` (q,)."""
        counts = torsion_counts(self.rods, self.lengths, omega2[:, None], self.elements)
        return np.asarray(counts.sum(axis=1))

    def eigenspace(
        self, omega2: Floats, sizes: NDArray[Any]
    ) -> list[tuple[Floats, Floats, Floats, Floats]]:
        """Return the modes next to each of `omega2` (q,), `sizes` (q,) of them, of modal mass 1.

        For each the omega^2 that a step of Newton's leads to (size,), the platform (size, 6) in the
        coordinates of `vectors`, and the tips' motion and force (size, n, 3) along and of every
        direction. For free motions give a small omega^2.
        """
        form = self.form(omega2)
        _, W, _, back = self.static
        B, left, springs = form.pencil
        values, vectors = np.linalg.eigh(B)
        found = []
        for i, size in enumerate(sizes):
            closest = np.sort(np.argsort(np.abs(values[i]))[:size])
            x = vectors[i][:, closest]
            y = (form.scale[i][:, None] * (left[i].T @ x[:6])).T
            w = y @ W.T
            force = form.change[i] * w
            own = form.bordered[i]
            k = form.stiff[i][own]
            # The unknown of a stiff direction is its force, of which 1 / c_k makes a motion.
            forces = (springs[i][:, None] * x[6:])[own].T / np.sqrt(form.size[i][k])
            force[:, k], w[:, k] = forces, forces / form.change[i][k]
            force += self.held * w
            shape = (len(y), -1, 3)
            roots = omega2[i] + values[i][closest]
            found.append((roots, y @ back.T, w.reshape(shape), force.reshape(shape)))
        return found


def characteristic(
    mechanism: Mechanism, pose: Pose, theory: Theory, elements: int | None = None
) -> Characteristic:
    """Return the problem at one pose. Raises `InputError` for a pose out of reach."""
    return of_limbs(constants(mechanism, theory), limbs_at(mechanism, pose), elements)


def of_limbs(known: Constants, limbs: Limbs, elements: int | None = None) -> Characteristic:
    """Return the problem of `limbs` at one pose."""
    return Characteristic(known.rods, limbs.lengths, limbs.directions @ known.unit, elements)
