"""Limbs that come as tables: any number of poses at a cost that the mesh behind does not enter.

With d_k(lambda) of `limb_table`, eliminating q from
    [[sum_k P_k a_k a_k^T - lambda (M_p + sum_k Q_k a_k a_k^T), -sqrt(c_j) a_k(j)],
     [., lambda_j - lambda]] [U; q] = 0
gives (sum_k d_k a_k a_k^T - lambda M_p) U = 0: an eigenproblem of 6 and a few coordinates a limb.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analytic.errors import InputError
from analytic.errors import count as whole
from analytic.mechanism import Mechanism
from analytic.modes import Modes, check_count
from analytic.pose import Pose
from reference_models.placement import Placement, place
from reference_models.protocol import hertz
from reference_models.solid.table import DIRECTIONS, OCTAVES, Columns, LimbTable

Array = NDArray[np.float64]

NAME = "solid-limb"
CLOSE = 1e-3
"""Eigenvalues this close, relative, may mix their modes."""
SAFETY = 2.0
"""Over errors found at the extremes of interpolation: between these they may be larger."""
CHUNK = 500
"""Poses solved at once: what fits into the processor's cache."""


@dataclass(frozen=True)
class SolidLimb:
    """The mechanism on limbs known by tables; `tables(poisson, octave)` returns one.

    `theory`, `version` and `elements` say what the tables were made from.
    """

    tables: Callable[[float, int], LimbTable]
    theory: str
    version: str
    elements: int | None = None

    def frequencies(self, mechanism: Mechanism, poses: Pose, count: int = 6) -> Array:
        """Return the `count` lowest frequencies [Hz] at every pose, (*poses.shape, count).

        Raises `InputError` for a pose out of reach, a limb shorter than 2 or longer than 64
        diameters, or more modes than coordinates.
        """
        flat = Pose(*(np.ravel(value) for value in (poses.z, poses.azimuth, poses.tilt)))
        result = np.empty((len(flat), whole("count", count)))
        for start in range(0, len(flat), CHUNK):
            part = slice(start, start + CHUNK)
            problem = self._problem(mechanism, flat[part])
            check_count(count, problem.size)
            values = np.linalg.eigvalsh(problem.matrix)
            every = np.concatenate([values, problem.columns.twist], axis=1)
            result[part] = hertz(NAME, np.sort(every, axis=1)[:, :count], problem.rounding)
        return result.reshape(*poses.shape, count)

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        """Return the `count` lowest modes at one pose; raises as `frequencies`."""
        if pose.shape:
            raise InputError("pose", f"{pose.shape} poses", "one pose: frequencies() takes many")
        begin = time.perf_counter()
        one = Pose(*(np.array([value]) for value in (pose.z, pose.azimuth, pose.tilt)))
        problem = self._problem(mechanism, one)
        check_count(count, problem.size)
        built = time.perf_counter()
        values, vectors = np.linalg.eigh(problem.matrix[0])
        twist = problem.columns.twist[0]
        both = np.concatenate([values, twist])
        order = np.argsort(both, kind="stable")[:count]
        lam = both[order]
        # A twisting limb moves neither the platform nor its own axis.
        vectors = np.pad(vectors, ((0, 0), (0, len(twist))))[:, order]
        platform, limbs = problem.shapes(lam, vectors)
        frequencies = hertz(NAME, lam, problem.rounding[0])
        moved = self._moved(mechanism, problem, lam, vectors, order - problem.size)
        error = None if moved is None else hertz(NAME, lam + moved, 0.0) - frequencies
        return Modes(
            frequencies=frequencies,
            platform=platform,
            limbs=limbs,
            theory=self.theory,
            model=NAME,
            version=self.version,
            elements=self.elements,
            dofs=problem.size,
            residual=None,
            build_seconds=built - begin,
            solve_seconds=time.perf_counter() - built,
            uncertainty=error,
        )

    def _moved(
        self,
        mechanism: Mechanism,
        problem: "Problem",
        lam: Array,
        vectors: Array,
        twisting: NDArray[np.intp],
    ) -> Array | None:
        """Return a bound on how far the tables' errors move each omega^2 = `lam` (k,), or None.

        In a mode of unit modal mass, a column of `vectors` (m, k), an error of d_k moves omega^2
        by its own t_k^2, t_k = a_k . U: to first order, and errors are millionths. `twisting` is
        the number of a twisting mode, below zero for others. The mesh's own error is not in it.
        None where a mode lies higher than the tables were compared with rods.
        """
        columns, owner, n = problem.columns, problem.owner, len(mechanism.limbs)
        t = problem.tips(vectors).T
        by_direction = np.arange(DIRECTIONS * n) == owner[:, None]
        modal = vectors[6:].T ** 2
        P, Q, x = columns.P[0], columns.Q[0], lam[:, None]
        # |d| + lambda |d'|, each times t^2: finite at the poles too.
        d = np.abs((P - Q * x) * t**2 - (modal * (columns.poles[0] - x)) @ by_direction)
        size = d + x * (np.abs(Q) * t**2 + modal @ by_direction)
        moved = np.zeros(len(lam))
        for i, limb in enumerate(mechanism.limbs):
            rod, length = limb.rod, problem.limbs.lengths[0, i]
            table = self.tables(rod.material.poisson, int(octaves_of(length / rod.diameter)))
            first = columns.poles[0, np.flatnonzero(owner == DIRECTIONS * i)[0]]
            level = np.searchsorted(table.levels, lam / first)
            if level.max() == len(table.levels):
                return None
            errors = table.errors[level]
            own = slice(DIRECTIONS * i, DIRECTIONS * (i + 1))
            moved += (errors[:, :DIRECTIONS] * size[:, own]).sum(axis=1)
            turns = (twisting >= 0) & (twisting * n // columns.twist.shape[1] == i)
            moved += errors[:, DIRECTIONS] * lam * turns
        # Modes that lie close mix: what moves one may move another.
        close = np.abs(lam - x) <= CLOSE * np.abs(x)
        return np.asarray(SAFETY * (close @ moved) + 2 * problem.rounding[0])

    def _problem(self, mechanism: Mechanism, poses: Pose) -> "Problem":
        """Return the eigenproblem at N poses, its mass made the identity."""
        limbs = place(mechanism, poses)
        columns, owner = self._columns(mechanism, limbs.lengths)
        a = directions(limbs)
        M = platform_masses(mechanism, limbs) + (a * columns.Q[..., None]).swapaxes(1, 2) @ a
        root = np.asarray(np.linalg.cholesky(M), dtype=float)
        turned = np.linalg.solve(root, a.swapaxes(1, 2)).swapaxes(1, 2)
        size = 6 + len(owner)
        matrix = np.zeros((len(a), size, size))
        matrix[:, :6, :6] = (turned * columns.P[..., None]).swapaxes(1, 2) @ turned
        force = columns.poles * columns.couplings
        matrix[:, 6:, :6] = -force[..., None] * turned[:, owner]
        matrix[:, :6, 6:] = matrix[:, 6:, :6].swapaxes(1, 2)
        j = np.arange(6, size)
        matrix[:, j, j] = columns.poles
        return Problem(matrix, root, a, limbs, columns, owner)

    def _columns(self, mechanism: Mechanism, lengths: Array) -> tuple[Columns, NDArray[np.intp]]:
        """Return all limbs' numbers at N poses side by side, and each pole's direction a_k."""
        found: list[Columns] = []
        owners = []
        for i, limb in enumerate(mechanism.limbs):
            octaves = octaves_of(lengths[:, i] / limb.rod.diameter)
            parts: dict[int, Columns] = {}
            for octave in np.unique(octaves).tolist():
                table = self.tables(limb.rod.material.poisson, octave)
                parts[octave] = table.at(limb.rod, lengths[octaves == octave, i])
            owners.append(table.owner + DIRECTIONS * i)
            found.append(_merged(parts, octaves))
        names = vars(found[0])
        merged = {name: np.concatenate([vars(c)[name] for c in found], axis=1) for name in names}
        return Columns(**merged), np.concatenate(owners)


@dataclass(frozen=True)
class Problem:
    """The module's eigenproblem at N poses of n limbs.

    Attributes: `matrix` (N, m, m); `root` (N, 6, 6), the Cholesky factor of the platform's mass;
    `vectors` a_k (N, 3 n, 6); `limbs`; `columns`; `owner` (p,).
    """

    matrix: Array
    root: Array
    vectors: Array
    limbs: Placement
    columns: Columns
    owner: NDArray[np.intp]

    @property
    def size(self) -> int:
        """The number of coordinates."""
        return int(self.matrix.shape[-1])

    @property
    def rounding(self) -> Array:
        """How far eigenvalues are known, of N poses: (N, 1)."""
        largest = np.abs(self.matrix).max(axis=(1, 2))[:, None]
        return np.asarray(self.size * np.finfo(float).eps * largest)

    def tips(self, vectors: Array) -> Array:
        """Return t_k of every direction, (3 n, k), in `vectors` (m, k) of the first pose."""
        return np.asarray(self.vectors[0] @ np.linalg.solve(self.root[0].T, vectors[:6]))

    def shapes(self, eigenvalues: Array, vectors: Array) -> tuple[Array, Array]:
        """Return platform (k, 6) and limbs (k, n, 11, 3) in `vectors` (m, k) of the first pose."""
        U = np.linalg.solve(self.root[0].T, vectors[:6])
        t = self.vectors[0] @ U
        own = vectors[6:] - self.columns.couplings[0][:, None] * t[self.owner]
        line = self.columns.static[0][..., None] * t[:, None, :]
        np.add.at(line, self.owner, self.columns.shapes[0][..., None] * own[:, None, :])
        frames = self.limbs.frames[0]
        local = line.reshape(len(frames), DIRECTIONS, *line.shape[1:])
        return U.T, np.einsum("ndsk,ncd->knsc", local, frames)


def directions(limbs: Placement) -> Array:
    """Return a_k, (N, 3 n, 6): a limb's tip moves a_k . U along its k-th axis, U at o."""
    axes = limbs.frames.swapaxes(-1, -2)
    moments = np.cross(limbs.arms[..., None, :], axes)
    return np.concatenate([axes, moments], axis=-1).reshape(len(axes), -1, 6)


def platform_masses(mechanism: Mechanism, placed: Placement) -> Array:
    """Return M_p about o in global axes, Eqs. (7)-(9), at N poses, shape (N, 6, 6)."""
    R = placed.rotation
    M = np.zeros((len(R), 6, 6))
    M[:, :3, :3] = mechanism.platform.mass * np.eye(3)
    M[:, 3:, 3:] = R @ np.array(mechanism.platform.inertia) @ R.swapaxes(-1, -2)
    return M


def octaves_of(aspects: Array) -> NDArray[np.intp]:
    """Return the octave of every length over diameter, or raise `InputError`."""
    octaves = np.floor(np.log2(aspects)).astype(np.intp)
    if octaves.min() < OCTAVES.start or octaves.max() >= OCTAVES.stop:
        worst = aspects.min() if octaves.min() < OCTAVES.start else aspects.max()
        limits = f"{2**OCTAVES.start} to {2**OCTAVES.stop} diameters of its rod"
        raise InputError("limb length", f"{worst:.3g} diameters", limits)
    return np.asarray(octaves)


def _merged(parts: dict[int, Columns], octaves: NDArray[np.intp]) -> Columns:
    """Return the rows of every octave's table in the order of the poses."""
    first, *others = parts.values()
    if not others:
        return first
    merged = {}
    for name, example in vars(first).items():
        rows = np.empty((len(octaves), *example.shape[1:]))
        for octave, part in parts.items():
            rows[octaves == octave] = vars(part)[name]
        merged[name] = rows
    return Columns(**merged)
