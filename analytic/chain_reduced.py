"""Many poses at once for limbs of any chain: as `reduced`, with more than one motion a direction.

Over the platform's six coordinates and those of turning joints, u (e), and the poles' q, what the
cores take from u is h_i = H_i . u, and the problem is
    [[H^T P H + springs - lambda M, -(C H)^T], [-C H, lambda_j - lambda]] [u; q] = 0,
P and C by the tables of `core_tables`.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.chain_cores import Beside, Joined
from analytic.core_tables import Table
from analytic.reduced import NODES, Chord, chord, negative

Floats = NDArray[np.float64]

TOLD = 1e-9
"""Part of omega^2 that the tables' error may be, entries erring apart from each other."""
MASSLESS = 1e-10
"""A motion with less of the mass of its coordinates than this has none."""


@dataclass(frozen=True)
class Across:
    """Entries of P off its diagonal, for n limbs alike: which `entries`, and the rows they join."""

    entries: slice
    first: slice
    second: slice


@dataclass(frozen=True)
class ChainReduced:
    """The problem above at N poses: what `condensed` asks of a `Reduced`.

    Attributes: `lengths` (N, ...), of which only the first axis matters; `vectors` H (N, r, e);
    `springs` (e,); `mass` M (N, e, e); `poles` (N, p); `coupling` C H (N, p, e); `powers`
    (degree + 1, N, k) of P's entries over 2 lambda / `caps` - 1, `caps` (N, k): first the diagonal,
    r of them, then those `across`; `error` of the tables relative to the entries of
    each row (r,).
    """

    lengths: Floats
    vectors: Floats
    springs: Floats
    mass: Floats
    poles: Floats
    coupling: Floats
    powers: Floats
    caps: Floats
    across: tuple[Across, ...]
    error: Floats

    converged = 1e-10
    """As of `Reduced`."""

    @property
    def limit(self) -> Floats:
        """Lambda up to which the tables hold, shape (N,)."""
        return np.asarray(self.caps.min(axis=1))

    @property
    def end(self) -> Floats:
        """Where the chord ends, (N,)."""
        first = self.poles.min(axis=1, initial=np.inf)
        return np.asarray(np.minimum(first, self.limit / NODES[-1]))

    def __getitem__(self, index: NDArray[Any] | slice) -> "ChainReduced":
        return ChainReduced(
            self.lengths[index],
            self.vectors[index],
            self.springs,
            self.mass[index],
            self.poles[index],
            self.coupling[index],
            self.powers[:, index],
            self.caps[index],
            self.across,
            self.error,
        )

    def smooth(self, eigenvalue: Floats) -> Floats:
        """Return the entries of P at `eigenvalue` (c, N), shape (c, N, k)."""
        t = (2 / self.caps) * eigenvalue[..., None] - 1
        top = len(self.powers) - 1
        value = self.powers[top] * t
        value += self.powers[top - 1]
        for k in range(top - 2, -1, -1):
            value *= t
            value += self.powers[k]
        return np.asarray(value)

    def times(self, entries: Floats, motion: Floats) -> Floats:
        """Return P of `entries` (..., k) times motions (..., r)."""
        result = entries[..., : motion.shape[-1]] * motion
        for one in self.across:
            own = entries[..., one.entries]
            result[..., one.first] += own * motion[..., one.second]
            result[..., one.second] += own * motion[..., one.first]
        return np.asarray(result)

    def quotient(self, entries: Floats, motion: Floats) -> Floats:
        """Return x^T P x (N, c) of `entries` (c, N, k) and motions x (c, N, r)."""
        return np.asarray(np.einsum("cnr,cnr->nc", self.times(entries, motion), motion))

    def squares(self, entries: Floats, motion: Floats) -> Floats:
        """Return x^T P x (N, q, m) of `entries` (N, q, k) and motions x (N, r, m)."""
        result = entries[..., : motion.shape[1]] @ (motion * motion)
        for one in self.across:
            both = motion[:, one.first] * motion[:, one.second]
            result += 2 * (entries[..., one.entries] @ both)
        return np.asarray(result)

    def condensed(self, entries: Floats) -> Floats:
        """Return H^T P H (N, e, e) of `entries` (N, k) of P."""
        H = self.vectors
        moved = entries[:, : H.shape[1], None] * H
        for one in self.across:
            own = entries[:, one.entries, None]
            moved[:, one.first] += own * H[:, one.second]
            moved[:, one.second] += own * H[:, one.first]
        return np.asarray(H.swapaxes(1, 2) @ moved)

    def below(self, eigenvalue: Floats) -> NDArray[np.int64]:
        """Return how many modes lie below `eigenvalue` (N,), those that move no limb's ends apart.

        Wittrick and Williams' count, the limbs' S being exact to `core_tables.EXACT`.
        """
        D = self.condensed(self.smooth(eigenvalue[None])[0])
        D -= eigenvalue[:, None, None] * self.mass
        i = np.arange(len(self.springs))
        D[:, i, i] += self.springs
        apart = self.poles - eigenvalue[:, None]
        D -= self.coupling.swapaxes(1, 2) @ (self.coupling / apart[..., None])
        return np.asarray((apart < 0).sum(axis=1) + negative(D))

    def moving(self) -> NDArray[np.bool_]:
        """Return where every coordinate has mass, (N,), as it has unless something is loose."""
        M = self.mass - self.condensed(self.chord().slope)
        own = np.einsum("nii->ni", M)
        good = (own > 0).all(axis=1)
        scale = 1 / np.sqrt(np.where(own > 0, own, 1.0))
        values = np.linalg.eigvalsh(M * scale[:, :, None] * scale[:, None, :])
        return np.asarray(good & (values[:, 0] > MASSLESS))

    def told(self, P: Floats, values: Floats, motion: Floats) -> NDArray[np.bool_]:
        """Return where the tables' error leaves `TOLD` of the lowest `values` (N, count), (N,).

        `P` (N, k) and `motion` (N, r, m) as of `pencil`. A limb that turns as a rigid body has
        large entries that cancel: their error does not.
        """
        x = motion[:, :, : values.shape[1]]
        uncertain = (self.error * P[:, : x.shape[1]])[..., None] * x * x
        return np.asarray((np.linalg.norm(uncertain, axis=1) < TOLD * values).all(axis=1))

    def chord(self) -> Chord:
        """Return the chord of P's entries from near rest to `end`, and how they depart from it."""
        return chord(self.smooth(np.outer(NODES, self.end)), self.end)

    def tangent(self, eigenvalue: Floats) -> tuple[Floats, Floats]:
        """Return the tangent of P at `eigenvalue` (N,): its value at 0 and slope, (N, k)."""
        t = 2 * eigenvalue[:, None] / self.caps - 1
        top = len(self.powers) - 1
        value, slope = self.powers[top].copy(), np.zeros_like(t)
        for k in range(top - 1, -1, -1):
            slope = slope * t + value
            value = value * t + self.powers[k]
        slope *= 2 / self.caps
        return value - slope * eigenvalue[:, None], slope

    def pencil(self, P: Floats, slope: Floats) -> tuple[Floats, Floats]:
        """Solve with P + slope lambda for P(lambda); `P` and `slope` have shape (N, k).

        Return the eigenvalues (N, m), and the motions H u of their vectors (N, r, m).
        """
        e = len(self.springs)
        M = self.mass - self.condensed(slope)
        A = self.condensed(P)
        i = np.arange(e)
        A[:, i, i] += self.springs
        # Of unit mass each, then independent.
        scale = 1 / np.sqrt(M[:, i, i])
        left = np.linalg.inv(np.linalg.cholesky(M * scale[:, :, None] * scale[:, None, :]))
        left *= scale[:, None, :]
        turned = left.swapaxes(1, 2)
        m = e + self.poles.shape[1]
        matrix = np.zeros((len(A), m, m))
        matrix[:, :e, :e] = left @ A @ turned
        matrix[:, e:, :e] = -self.coupling @ turned
        j = np.arange(e, m)
        matrix[:, j, j] = self.poles
        values, vectors = np.linalg.eigh(matrix)
        return values, self.vectors @ (turned @ vectors[:, :e])


def chain_reduced(
    joined: list[Joined], beside: Beside, tables: list[Table]
) -> tuple[ChainReduced, Floats]:
    """Return the problem at N poses by the `tables` of all cores, and omega^2 of modes alone.

    The latter (N, a) move nothing but the inside of a limb.
    """
    N, e = len(beside.mass), len(beside.springs)
    top = max(table.degree for table in tables) + 1
    sizes = [(len(t.rows), one.adapting.shape[1]) for one, t in zip(joined, tables, strict=True)]
    r = sum(c * n for c, n in sizes)
    k = r + sum((t.first != t.second).sum() * n for t, (_, n) in zip(tables, sizes, strict=True))
    H = np.empty((N, r, e))
    powers, caps = np.zeros((top, N, k)), np.empty((N, k))
    poles, coupling, alone, across = [], [], [], []
    row, entry = 0, r
    for one, table, (c, n) in zip(joined, tables, sizes, strict=True):
        x, a, residues, P = table.at(one.adapting.ravel())
        poles.append(x.reshape(N, -1))
        alone.append(a.reshape(N, -1))
        for local, given in enumerate(table.rows):
            H[:, row + local * n : row + (local + 1) * n] = one.moved[given]
        C = np.zeros((N, n, table.poles, e))
        residues = residues.reshape(N, n, -1)
        for i, (pole, at) in enumerate(zip(table.pole, table.row, strict=True)):
            C[:, :, pole] += residues[:, :, i, None] * H[:, row + at * n : row + (at + 1) * n]
        coupling.append(C.reshape(N, -1, e))
        cap, P = table.caps(one.adapting), P.reshape(len(P), N, n, -1)
        # Entry after entry, limb after limb within.
        for i, (first, second) in enumerate(zip(table.first, table.second, strict=True)):
            start = row + first * n
            if first != second:
                start = entry
                entry += n
                rows = (slice(row + at * n, row + (at + 1) * n) for at in (first, second))
                across.append(Across(slice(start, start + n), *rows))
            powers[: len(P), :, start : start + n] = P[..., i]
            caps[:, start : start + n] = cap
        row += c * n
    problem = ChainReduced(
        joined[0].adapting,
        H,
        beside.springs,
        beside.mass,
        np.concatenate(poles, axis=1),
        np.concatenate(coupling, axis=1),
        powers,
        caps,
        tuple(across),
        np.concatenate([np.repeat(t.error, n) for t, (_, n) in zip(tables, sizes, strict=True)]),
    )
    return problem, np.concatenate(alone, axis=1)
