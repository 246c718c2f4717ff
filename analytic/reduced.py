"""Many poses at once: the platform with its limbs' fixed-tip modes as coordinates.

With d_k(lambda) = P_k(lambda) - sum_j c_j / (lambda_j - lambda) of `limb_modes`, eliminating q from
    [[sum_k P_k a_k a_k^T - lambda M_p, -sqrt(c_j) a_k(j)], [., lambda_j - lambda]] [U; q] = 0
gives D(lambda) U = 0. Nothing here is large next to a pole, and but for the slight curvature of
P_k it is an ordinary eigenproblem of 6 and a few coordinates. As P_k falls with lambda, so do the
eigenvalues of the matrix: each has one root, and the k-th root is the k-th mode.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from analytic.dynamic_stiffness import Sections, sections
from analytic.limb_modes import DEGREE, limb_modes, units
from analytic.mechanism import Mechanism
from analytic.pose import Pose, position
from analytic.theory import Theory

Floats = NDArray[np.float64]


@lru_cache(maxsize=32)
def constants(mechanism: Mechanism, theory: Theory) -> tuple[Sections, Floats, Floats, Floats]:
    """Return the limbs' sections, A_i (n, 3), B_i over axes (2 n, 3), and W_i (n, 3, 6).

    a = c @ W_i turns a direction c of the moving frame into the platform's coordinates, in which
    its mass is the identity.
    """
    root = np.linalg.cholesky(np.array(mechanism.platform.inertia))
    points = mechanism.platform_points
    turned = np.linalg.solve(root, np.cross(points[:, None, :], np.eye(3)).swapaxes(1, 2))
    moved = np.broadcast_to(np.eye(3) / np.sqrt(mechanism.platform.mass), turned.shape)
    W = np.concatenate([moved, turned], axis=1).swapaxes(1, 2)
    fixed = np.concatenate([mechanism.bases, mechanism.axes])
    return sections(mechanism, theory), points, fixed, W


def geometry(mechanism: Mechanism, theory: Theory, poses: Pose) -> tuple[Sections, Floats, Floats]:
    """Return sections, lengths (N, n) [m] and vectors a_k (N, 3 n, 6) at `poses` (N,).

    As `limbs_at`, seen from the moving frame.
    """
    rods, points, fixed, W = constants(mechanism, theory)
    n, R = len(points), poses.rotation
    o = position(mechanism, poses)
    seen = fixed @ R
    limbs = (o[:, None, :] @ R) - seen[:, :n] + points
    lengths = np.sqrt(np.einsum("Nij,Nij->Ni", limbs, limbs))
    frames = np.empty((len(o), n, 3, 3))
    frames[:, :, 1] = y = seen[:, n:]
    frames[:, :, 2] = z = limbs / lengths[..., None]
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        frames[:, :, 0, i] = y[..., j] * z[..., k] - y[..., k] * z[..., j]
    vectors = (frames @ W).reshape(len(o), 3 * n, 6)
    return rods, lengths, vectors


@dataclass(frozen=True)
class Reduced:
    """The problem above at N poses; p limb modes are kept and m = 6 + p.

    Attributes: `lengths` (N, n); `vectors` a_k (N, 3 n, 6); `poles` (N, p) and `residues` (N, p)
    with the direction `owner` (p,) of each; `powers` of P_k (N, 3 n, DEGREE + 1) over
    2 lambda / `caps` - 1, `caps` (N, 3 n).
    """

    lengths: Floats
    vectors: Floats
    poles: Floats
    residues: Floats
    owner: NDArray[np.intp]
    powers: Floats
    caps: Floats

    @property
    def limit(self) -> Floats:
        """Lambda up to which the tables hold, shape (N,)."""
        return np.asarray(self.caps.min(axis=1))

    def __getitem__(self, index: NDArray[np.bool_] | slice) -> "Reduced":
        return Reduced(
            self.lengths[index],
            self.vectors[index],
            self.poles[index],
            self.residues[index],
            self.owner,
            self.powers[index],
            self.caps[index],
        )

    def smooth(self, eigenvalue: Floats) -> Floats:
        """Return P_k at `eigenvalue` (N, c), shape (N, c, 3 n)."""
        t = (2 / self.caps)[:, None, :] * eigenvalue[:, :, None] - 1
        powers = self.powers[:, None]
        value = powers[..., DEGREE] * t + powers[..., DEGREE - 1]
        for k in range(DEGREE - 2, -1, -1):
            value *= t
            value += powers[..., k]
        return np.asarray(value)

    def pencil(self, P: Floats, slope: Floats) -> tuple[Floats, Floats]:
        """Solve with P_k + slope_k lambda for P_k(lambda); `P` and `slope` have shape (N, 3 n).

        Return the eigenvalues (N, m), and the motions a_k . U of their vectors (N, 3 n, m).
        """
        a = self.vectors
        M = np.eye(6) - (a * slope[..., None]).swapaxes(1, 2) @ a
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
    rods: Sections, lengths: Floats, vectors: Floats, elements: int | None, level: int
) -> Reduced | None:
    """Return the problem at N poses with `level` bending modes of each kind a limb.

    None where the limbs' tables would not be exact.
    """
    N, n = lengths.shape
    frequency2, stiffness = units(rods, lengths)
    powers, caps = np.empty((N, n, 3, DEGREE + 1)), np.empty((N, n, 3))
    poles, residues, owner = [], [], []
    for alike in _alike(rods):
        rod = Sections(*(value[alike[:1]] for value in vars(rods).values()))
        modes = limb_modes(rod, lengths[:, alike], elements, level)
        if modes is None:
            return None
        x, c, P = modes.at(lengths[:, alike].ravel())
        powers[:, alike] = P.reshape(N, len(alike), 3, -1)
        caps[:, alike] = modes.caps
        direction = np.repeat(np.arange(3), modes.kept)
        unit = frequency2[:, alike][..., direction]
        poles.append((x.reshape(unit.shape) * unit).reshape(N, -1))
        own = c.reshape(unit.shape) * unit * stiffness[:, alike][..., direction]
        residues.append(own.reshape(N, -1))
        owner.append((3 * alike[:, None] + direction).ravel())
    powers *= stiffness[..., None]
    caps *= frequency2
    return Reduced(
        lengths,
        vectors,
        np.concatenate(poles, axis=1),
        np.concatenate(residues, axis=1),
        np.concatenate(owner),
        powers.reshape(N, 3 * n, -1),
        caps.reshape(N, 3 * n),
    )


def _alike(rods: Sections) -> list[NDArray[np.intp]]:
    """Return the limbs that have the same rod, as lists of indices."""
    rows = np.stack(list(vars(rods).values()), axis=1)
    _, which = np.unique(rows, axis=0, return_inverse=True)
    which = which.ravel()
    return [np.flatnonzero(which == k) for k in range(which.max() + 1)]
