"""Many poses at once: the platform with its limbs' fixed-tip modes as coordinates.

With d_k(lambda) = P_k(lambda) - sum_j c_j / (lambda_j - lambda) of `limb_modes`, eliminating q from
    [[sum_k P_k a_k a_k^T - lambda M_p, -sqrt(c_j) a_k(j)], [., lambda_j - lambda]] [U; q] = 0
gives D(lambda) U = 0. Nothing here is large next to a pole, and but for the slight curvature of
P_k it is an ordinary eigenproblem of 6 and a few coordinates. As P_k falls with lambda, so do the
eigenvalues of the matrix: each has one root, and the k-th root is the k-th mode.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.chains import rigid_arms
from analytic.kinematics import limbs_at
from analytic.limb_modes import DEGREE, limb_modes, units
from analytic.mechanism import Mechanism
from analytic.pose import Pose
from analytic.theory import Theory
from analytic.waves import Sections, sections

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Constants:
    """What poses share.

    Attributes: the limbs' `rods` and, `alike`, which of them are equal, with their one rod; `unit`
    (6, 6), by which a row of `Limbs.directions` is multiplied for coordinates in which the
    platform's mass is 1, and `tips` (n, 3, 6), by which an axis in the moving frame is, for its
    row there.
    """

    rods: Sections
    alike: list[tuple[NDArray[np.intp], Sections]]
    unit: Floats
    tips: Floats


@lru_cache(maxsize=32)
def constants(mechanism: Mechanism, theory: Theory) -> Constants:
    """Return what poses share."""
    unit = np.zeros((6, 6))
    unit[:3, :3] = np.eye(3) / np.sqrt(mechanism.platform.mass)
    unit[3:, 3:] = np.linalg.inv(np.linalg.cholesky(np.array(mechanism.platform.inertia))).T
    rods = sections(mechanism, theory)
    return Constants(rods, _alike(rods), unit, rigid_arms(mechanism.platform_points) @ unit)


def geometry(known: Constants, mechanism: Mechanism, poses: Pose) -> tuple[Floats, Floats]:
    """Return lengths (N, n) [m] and vectors a_k (N, 3 n, 6) at N `poses` of any shape.

    In the moving frame, and in coordinates in which the platform's mass is the identity.
    Raises `InputError` as `position` does.
    """
    limbs = limbs_at(mechanism, poses)
    n = limbs.lengths.shape[-1]
    # One product for all poses, then one a limb.
    moved = limbs.rotation.reshape(-1, 3) @ known.tips.swapaxes(0, 1).reshape(3, -1)
    frames = limbs.frames.reshape(-1, n, 3, 3).swapaxes(2, 3)
    vectors = frames @ moved.reshape(-1, 3, n, 6).swapaxes(1, 2)
    return limbs.lengths.reshape(-1, n), vectors.reshape(-1, 3 * n, 6)


FEW = 8
"""Poses up to which fewer steps, of more operations each, cost less: the steps do, not these."""
NODES = 0.03, 0.3, 1.0, 2.0
"""Where P is interpolated, in times of `Reduced.end`: the platform's modes are near the first two
and the last two, and the chord holds at the first and the third."""
_U, _ACROSS = np.array(NODES), (np.array(NODES) - NODES[0]) * (np.array(NODES) - 1)
CUBIC = np.linalg.inv(np.stack([_U**0, _U, _ACROSS, _ACROSS * _U], axis=1))
"""From P there to its value at 0, rise and bend: see `Chord`."""
GROWTH = 10.0
"""Growth of entries in elimination up to which its signs are as good as those of eigenvalues."""


SIX = np.arange(6)


def negative(D: Floats) -> NDArray[np.int64]:
    """Return how many eigenvalues of each symmetric D (N, m, m) are negative, by Sylvester's law.

    From the pivots of an elimination of all at once; by the eigenvalues where it needs pivoting, or
    where they are few.
    """
    if len(D) <= FEW:
        return np.asarray((np.linalg.eigvalsh(D) < 0).sum(axis=1))
    A = np.ascontiguousarray(D.transpose(1, 2, 0))
    size = np.abs(A).max(axis=(0, 1))
    count, grown = np.zeros(len(D), dtype=np.int64), np.zeros(len(D), dtype=bool)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        for k in range(len(A)):
            count += A[k, k] < 0
            if k + 1 < len(A):
                A[k + 1 :, k + 1 :] -= A[k + 1 :, k, None] * (A[k, k + 1 :] / A[k, k])
                grown |= ~(np.abs(A[k + 1 :, k + 1 :]).max(axis=(0, 1)) <= GROWTH * size)
    if grown.any():
        count[grown] = (np.linalg.eigvalsh(D[grown]) < 0).sum(axis=1)
    return count


@dataclass(frozen=True)
class Chord:
    """A chord of P_k: its value at 0 `P` and its `slope` (N, 3 n), and its `bend` (N, 2, 3 n).

    P_k departs from it by about (u - NODES[0]) (u - 1) (bend_0 + bend_1 u), u = lambda /
    `Reduced.end`: with the chord this is the cubic through `NODES`.
    """

    P: Floats
    slope: Floats
    bend: Floats

    def __getitem__(self, index: NDArray[Any]) -> "Chord":
        return Chord(self.P[index], self.slope[index], self.bend[index])


def chord(values: Floats, end: Floats) -> Chord:
    """Return the chord by P's entries (4, N, k) at `NODES` times `end` (N,)."""
    P, rise, constant, by = (CUBIC @ values.reshape(4, -1)).reshape(values.shape)
    return Chord(P, rise / end[:, None], np.stack([constant, by], axis=1))


@dataclass(frozen=True)
class Reduced:
    """The problem above at N poses; p limb modes are kept and m = 6 + p.

    Attributes: `lengths` (N, n); `vectors` a_k (N, 3 n, 6); `poles` (N, p) and `residues` (N, p)
    with the direction `owner` (p,) of each; `powers` (DEGREE + 1, 3 n, N), or one column where they
    are the same for all, of P_k / `stiffness` over 2 lambda / `caps` - 1; both of these (N, 3 n).
    """

    lengths: Floats
    vectors: Floats
    poles: Floats
    residues: Floats
    owner: NDArray[np.intp]
    powers: Floats
    stiffness: Floats
    caps: Floats

    converged = 5e-10
    """Estimated relative error of omega^2 at which the iteration ends."""

    @property
    def limit(self) -> Floats:
        """Lambda up to which the tables hold, shape (N,)."""
        return np.asarray(self.caps.min(axis=1))

    def __getitem__(self, index: NDArray[Any] | slice) -> "Reduced":
        return Reduced(
            self.lengths[index],
            self.vectors[index],
            self.poles[index],
            self.residues[index],
            self.owner,
            self.powers if self.powers.shape[-1] == 1 else self.powers[..., index],
            self.stiffness[index],
            self.caps[index],
        )

    def smooth(self, eigenvalue: Floats) -> Floats:
        """Return P_k at `eigenvalue` (c, N), shape (c, N, 3 n): poses are runs of memory."""
        t = np.ascontiguousarray((2 / self.caps).T)[:, None] * eigenvalue
        t -= 1
        if len(self.caps) <= FEW:
            t = t[None].repeat(DEGREE + 1, axis=0)
            t[0] = 1.0
            np.multiply.accumulate(t, axis=0, out=t)
            return np.asarray(np.einsum("jkcn,jkn->cnk", t, self.powers) * self.stiffness)
        powers = self.powers[:, :, None]
        value = powers[DEGREE] * t
        value += powers[DEGREE - 1]
        for k in range(DEGREE - 2, -1, -1):
            value *= t
            value += powers[k]
        return np.asarray(np.multiply(value.transpose(1, 2, 0), self.stiffness, order="C"))

    @staticmethod
    def times(entries: Floats, motion: Floats) -> Floats:
        """Return P of `entries` (..., 3 n) times motions (..., 3 n)."""
        return entries * motion

    @staticmethod
    def quotient(entries: Floats, motion: Floats) -> Floats:
        """Return x^T P x (N, c) of `entries` and motions x (c, N, 3 n)."""
        return np.asarray(np.einsum("cnk,cnk,cnk->nc", entries, motion, motion))

    @staticmethod
    def squares(entries: Floats, motion: Floats) -> Floats:
        """Return x^T P x (N, q, m) of `entries` (N, q, 3 n) and motions x (N, 3 n, m)."""
        return np.asarray(entries @ (motion * motion))

    @staticmethod
    def told(P: Floats, values: Floats, motion: Floats) -> NDArray[np.bool_]:
        """Say that the tables' error is small enough: limbs held by an ideal hinge only bend."""
        del P, motion
        return np.ones(len(values), dtype=bool)

    def below(self, eigenvalue: Floats) -> NDArray[np.int64]:
        """Return how many modes lie below `eigenvalue` (N,), torsion of limbs apart.

        Wittrick and Williams' count, the limbs' D being exact to `limb_modes.EXACT`.
        """
        d = self.smooth(eigenvalue[None])[0]
        share = self.residues / (self.poles - eigenvalue[:, None])
        d -= share @ (self.owner[:, None] == np.arange(d.shape[1]))
        D = (self.vectors * d[..., None]).swapaxes(1, 2) @ self.vectors
        D[:, SIX, SIX] -= eigenvalue[:, None]
        held = (self.poles < eigenvalue[:, None]).sum(axis=1)
        return np.asarray(held + negative(D))

    @property
    def end(self) -> Floats:
        """Where the chord ends, (N,): at the softest limb's first mode, as far as tables hold."""
        return np.asarray(np.minimum(self.poles.min(axis=1), self.limit / NODES[-1]))

    def chord(self) -> Chord:
        """Return the chord of P_k from near rest to `end`, and how P_k departs from it."""
        return chord(self.smooth(np.outer(NODES, self.end)), self.end)

    def tangent(self, eigenvalue: Floats) -> tuple[Floats, Floats]:
        """Return the tangent of P_k at `eigenvalue` (N,): its value at 0 and slope, (N, 3 n)."""
        t = (2 / self.caps).T * eigenvalue - 1
        value, slope = self.powers[DEGREE], np.zeros_like(t)
        for k in range(DEGREE - 1, -1, -1):
            slope = slope * t + value
            value = value * t + self.powers[k]
        P, slope = value.T * self.stiffness, slope.T * (2 / self.caps * self.stiffness)
        return P - slope * eigenvalue[:, None], slope

    def pencil(self, P: Floats, slope: Floats) -> tuple[Floats, Floats]:
        """Solve with P_k + slope_k lambda for P_k(lambda); `P` and `slope` have shape (N, 3 n).

        Return the eigenvalues (N, m), and the motions a_k . U of their vectors (N, 3 n, m).
        """
        a = self.vectors
        M = (a * -slope[..., None]).swapaxes(1, 2) @ a
        M[:, SIX, SIX] += 1.0
        root = np.linalg.cholesky(M)
        a = np.linalg.solve(root, a.swapaxes(1, 2)).swapaxes(1, 2)
        m = 6 + self.poles.shape[1]
        matrix = np.zeros((len(a), m, m))
        matrix[:, :6, :6] = (a * P[..., None]).swapaxes(1, 2) @ a
        matrix[:, 6:, :6] = -np.sqrt(self.residues)[..., None] * a[:, self.owner]
        j = np.arange(6, m)
        matrix[:, j, j] = self.poles
        values, vectors = np.linalg.eigh(matrix)
        return values, a @ vectors[:, :6]


def reduced(
    known: Constants,
    lengths: Floats,
    vectors: Floats,
    elements: int | None,
    level: int,
    span: Floats | None = None,
) -> Reduced | None:
    """Return the problem at N poses with `level` bending modes of each kind a limb.

    The limbs' tables hold over `span`, by default over `lengths`. None where they would not be
    exact.
    """
    rods = known.rods
    N, n = lengths.shape
    frequency2, stiffness = units(rods, lengths)
    caps = np.empty((n, 3))
    powers, poles, residues, owner = [], [], [], []
    for limbs, rod in known.alike:
        own = lengths[:, limbs]
        over = own if span is None else span
        modes = limb_modes(rod, float(over.min()), float(over.max()), elements, level)
        if modes is None:
            return None
        # What is the same for all lengths is one row.
        x, c, P = modes.at(own.ravel())
        each = own.shape if len(x) == own.size else (1, 1)
        powers.append(P.reshape(-1, *each, 3).transpose(0, 2, 3, 1))
        caps[limbs] = modes.caps
        direction = modes.direction
        unit = frequency2[:, limbs][..., direction]
        force = stiffness[:, limbs][..., direction]
        poles.append((x.reshape(*each, -1) * unit).reshape(N, -1))
        residues.append((c.reshape(*each, -1) * unit * force).reshape(N, -1))
        owner.append((3 * limbs[:, None] + direction).ravel())
    columns = np.empty((DEGREE + 1, n, 3, max(P.shape[-1] for P in powers)))
    for (limbs, _), P in zip(known.alike, powers, strict=True):
        columns[:, limbs] = P
    return Reduced(
        lengths,
        vectors,
        np.concatenate(poles, axis=1),
        np.concatenate(residues, axis=1),
        np.concatenate(owner),
        columns.reshape(DEGREE + 1, 3 * n, -1),
        stiffness.reshape(N, 3 * n),
        (caps * frequency2).reshape(N, 3 * n),
    )


def first_level(count: int, limbs: int) -> int:
    """Return how many bending modes of each kind a limb `count` modes ask for at least."""
    return 1 + max(0, count - 6) // (2 * limbs)


def _alike(rods: Sections) -> list[tuple[NDArray[np.intp], Sections]]:
    """Return the limbs that have the same rod, by their indices, with it."""
    rows = np.stack(list(vars(rods).values()), axis=1)
    _, which = np.unique(rows, axis=0, return_inverse=True)
    which = which.ravel()
    groups = [np.flatnonzero(which == k) for k in range(which.max() + 1)]
    return [(k, Sections(*(value[k[:1]] for value in vars(rods).values()))) for k in groups]
