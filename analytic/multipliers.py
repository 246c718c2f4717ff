"""The same mechanism the traditional way: free bodies, joints as constraints, multipliers."""

from __future__ import annotations  # scipy loads its parts when they are first used

import time
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from analytic import assembly
from analytic.chain_models import multiplier_modes
from analytic.chains import Chains, chains
from analytic.continuum import Continuum
from analytic.eigen import hertz, largest, lowest_modes
from analytic.errors import InputError
from analytic.lanczos import factor, is_sparse, lowest
from analytic.mechanism import Mechanism
from analytic.modes import Modes, check_count
from analytic.pose import Pose, one_pose
from analytic.substructure import DENSE, few, limbs_at_one, solved
from analytic.theory import OfTheory

Floats = NDArray[np.float64]

SOLVERS = ("null-space", "saddle-point")
BASES = ("revolute", "free")


@dataclass(frozen=True)
class Multipliers(OfTheory):
    """M u'' + K u + C^T mu = 0, C u = 0: what Section 3.2 sets its method against (refs. 14, 17).

    u holds all nodes of all limbs, 6 (s+1) a limb of `elements` s, and the platform's six. C has
    three rows a spherical joint and five a revolute one. `solver`:

    - "null-space": u = N x with C N = 0, then the pair (N^T K N, N^T M N); mu drops out.
    - "saddle-point": ([[K, C^T], [C, 0]] - omega^2 [[M, 0], [0, 0]]) [u; mu] = 0.

    Few coordinates are solved for by LAPACK, many by sparse elimination and Lanczos.

    Limbs of any chain are taken too (see `chain_multipliers`), up to 3,000 coordinates.

    `base="free"` leaves out the revolute joints. The paper says of its ref. 15 that it "only
    considers the deformation coordination between the moving platform and limbs, and the boundary
    conditions between limbs and the base are ignored". Taken at its word that is this: limbs free
    at B_i, tied to the platform at A_i, hence 6 + 3 n motions without stiffness (the whole, and
    each of n limbs about its A_i) and no frequency of the mechanism. What ref. 15 itself computes
    is not in the paper's text, and is not claimed here.

    `beam` and `shear` as in `Substructure`. Raises `InputError` for unknown names, or as
    `Substructure` for elements.
    """

    elements: int = 3
    beam: str = "euler-bernoulli"
    shear: str | float = "cowper"
    solver: str = "null-space"
    base: str = "revolute"

    def __post_init__(self) -> None:
        object.__setattr__(self, "elements", few(self.elements))
        super().__post_init__()
        if self.solver not in SOLVERS:
            raise InputError("solver", self.solver, f"one of {', '.join(SOLVERS)}")
        if self.base not in BASES:
            raise InputError("base", self.base, f"one of {', '.join(BASES)}")

    def limit(self) -> Continuum | None:
        """Return the exact model of the same theory; None if the base is free."""
        return Continuum(self.beam, self.shear) if self.base == "revolute" else None

    def frequencies(self, mechanism: Mechanism, poses: Pose, count: int = 6) -> NDArray[np.float64]:
        """Return the `count` lowest frequencies [Hz] at every pose, shape (*poses.shape, count)."""
        if not poses.shape:
            return self.modes(mechanism, poses, count).frequencies
        if not len(poses):
            return np.empty((*poses.shape, count))
        return np.stack([self.frequencies(mechanism, pose, count) for pose in poses])

    def matrices(self, mechanism: Mechanism, pose: Pose) -> tuple[Any, Any, Any]:
        """Return K, M, both (N, N), and C, (c, N): N = 6 n (s+1) + 6, c = 8 n (3 n, base free).

        Sparse.
        """
        parts = self._chains(mechanism, pose)
        return *_pair(parts, sparse=True), scipy.sparse.csr_array(self._joints(parts))

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        """Return the `count` lowest modes at one pose; `dofs` counts what is solved for.

        That is the coordinates N - c for "null-space", and N + c, multipliers included, for
        "saddle-point". Raises `InputError` for a pose out of reach, or more modes than N - c.
        """
        begin = time.perf_counter()
        if not one_pose(mechanism, pose).shape and not mechanism.simple:
            if self.base != "revolute":
                raise InputError("base", self.base, "'revolute' for limbs of any chain")
            theory, s = self.theory, self.elements
            return multiplier_modes(mechanism, pose, theory, s, self.solver, count)
        parts = self._chains(mechanism, pose)
        C = self._joints(parts)
        dofs = C.shape[1] - C.shape[0]
        check_count(count, dofs)
        K, M = _pair(parts, sparse=dofs > DENSE)
        built = time.perf_counter()
        # Limbs free of the base move as rigid bodies: the whole, and each about its A_i.
        free = (6 + 3 * len(parts.arms), parts.limb_scale) if self.base == "free" else None
        solver = _null_space if self.solver == "null-space" else _saddle_point
        if self.solver == "saddle-point":
            dofs = sum(C.shape)
        values, u = solved(
            parts, partial(solver, K, M, C, count, parts), M, partial(_nodes, parts), free
        )
        end = time.perf_counter()
        return Modes(
            frequencies=hertz(values),
            platform=u[-6:].T,
            limbs=parts.centre_lines(_nodes(parts, u)),
            theory=self.theory.labels(mechanism),
            model="multipliers",
            version=f"rps-bench, {self.solver}",
            elements=self.elements,
            dofs=dofs,
            residual=None,
            build_seconds=built - begin,
            solve_seconds=end - built,
        )

    def _chains(self, mechanism: Mechanism, pose: Pose) -> Chains:
        return chains(mechanism, limbs_at_one(mechanism, pose), self.elements, self.theory)

    def _joints(self, parts: Chains) -> Floats:
        return joints(parts.J, parts.frames if self.base == "revolute" else None, self.elements)


def _pair(parts: Chains, *, sparse: bool) -> tuple[Any, Any]:
    """Return K and M of all bodies, free of each other."""
    blocks = [parts.T.swapaxes(1, 2) @ parts.element_matrices() @ parts.T]
    return assembly.free(len(parts.arms), parts.elements, sparse=sparse).pair(
        [*blocks, parts.platform]
    )


def _nodes(parts: Chains, u: Floats) -> Floats:
    return u[:-6].reshape(len(parts.arms), parts.elements + 1, 6, -1)


def joints(J: Floats, frames: Floats | None, s: int) -> Floats:
    """Return C of C u = 0, (8 n or 3 n, 6 n (s + 1) + 6), for limbs of s elements.

    Spherical at A_i, three rows a limb: Delta_A - J_i U_p = 0, Eq. (10), `J` (n, 3, 6). Revolute at
    B_i, five more, if `frames` (n, 3, 3) of the limbs are given: Delta_B = 0 and Phi_B . t = 0 for
    the two directions across the axis, x_i and z_i.
    """
    n = len(J)
    rows = 3 if frames is None else 8
    C = np.zeros((n, rows, n, s + 1, 6))
    i, k = np.arange(n)[:, None], np.arange(3)
    C[i, k, i, s, k] = 1.0
    if frames is not None:
        C[i, 3 + k, i, 0, k] = 1.0
        i = i[..., None]
        C[i, np.array([[6], [7]]), i, 0, 3 + k] = frames[:, :, [0, 2]].swapaxes(1, 2)
    platform = np.zeros((n, rows, 6))
    platform[:, :3] = -J
    return np.hstack([C.reshape(n * rows, -1), platform.reshape(n * rows, 6)])


def null_space(C: Any, unit: float = 1.0) -> scipy.sparse.csr_array:
    """Return N with C N = 0, shape (N, N - c): coordinates no joint holds stay.

    The others' columns are orthonormal once rotations are multiplied by `unit` [m].
    """
    others, held, basis = _split(C.toarray() if is_sparse(C) else C, unit)
    result = scipy.sparse.lil_array((C.shape[1], len(others) + basis.shape[1]))
    result[others, np.arange(len(others))] = 1.0
    result[held, len(others) :] = basis
    return scipy.sparse.csr_array(result)


def _split(C: Floats, unit: float) -> tuple[NDArray[np.intp], NDArray[np.intp], Floats]:
    """Return the coordinates in no joint, those in one, and a basis of what C lets these do.

    The last columns of Q of C^T = Q R; of the others, which `numpy.linalg.qr` makes too, none is.
    """
    touched = C.any(axis=0)
    held, others = np.flatnonzero(touched), np.flatnonzero(~touched)
    scale = np.where(held % 6 < 3, 1.0, 1 / unit)[:, None]
    size, rows = len(held), len(C)
    lapack = scipy.linalg.lapack
    reflectors, scales, _, _ = lapack.dgeqrf(C.T[held] * scale)
    last = np.eye(size, size - rows, -rows)
    basis, _, _ = lapack.dormqr("L", "N", reflectors, scales, last, 64 * size)
    return others, held, scale * basis


def _null_space(
    K: Any, M: Any, C: Floats, count: int, parts: Chains, shift: float
) -> tuple[Floats, Floats]:
    """Return omega^2 and u, mass-normalised, from the pair that the null space of C leaves."""
    if is_sparse(K):
        N = null_space(C, parts.unit)
        values, x = lowest_modes(N.T @ K @ N, N.T @ M @ N, count, shift)
        return values, N @ x
    others, held, basis = _split(C, parts.unit)
    a, size = len(others), len(others) + basis.shape[1]
    reduced = np.empty((2, size, size))
    for A, own in zip((K, M), reduced, strict=True):
        right = A.take(held, axis=1) @ basis
        own[:a, :a] = A.take(others, axis=0).take(others, axis=1)
        own[:a, a:] = right.take(others, axis=0)
        own[a:, :a] = own[:a, a:].T
        own[a:, a:] = basis.T @ right.take(held, axis=0)
    values, x = lowest_modes(reduced[0], reduced[1], count, shift)
    u = np.empty((len(K), count))
    u[others], u[held] = x[:a], basis @ x[a:]
    return values, u


def _saddle_point(
    K: Any, M: Any, C: Floats, count: int, parts: Chains, shift: float
) -> tuple[Floats, Floats]:
    """Return omega^2 and u, mass-normalised, by inverting [[K + shift M, C^T], [C, 0]]."""
    shift = shift or parts.limb_scale
    size, held = K.shape[0], len(C)
    if not is_sparse(K):
        # Multipliers in the unit of K, or elimination would mistake one for zero.
        C = C * np.diag(K).max()
        whole = np.block([[K + shift * M, C.T], [C, np.zeros((held, held))]])
        L = np.linalg.cholesky(M)
        # M = L L^T: the flexibility's eigenvalues in L^T u.
        inner = L.T @ np.linalg.solve(whole, np.vstack([L, np.zeros((held, size))]))[:size]
        mu, y = largest(inner, count)
        u, _ = scipy.linalg.lapack.dtrtrs(L, y[:, ::-1], lower=1, trans=1)
        return 1 / mu[::-1] - shift, u
    joint = scipy.sparse.csr_array(C)
    blocks: list[list[Any]] = [[K + shift * M, joint.T], [joint, None]]
    inverse = factor(scipy.sparse.csr_array(scipy.sparse.block_array(blocks)))

    def solve(force: Floats) -> Floats:
        padded = np.zeros((size + held, force.shape[1]))
        padded[:size] = force
        return np.asarray(inverse.solve(padded)[:size])

    # Only the count is made on the null space: of free limbs, pivots vanish at the modes sought.
    N = null_space(C, parts.unit)
    return lowest(K, M, count, solve, (N.T @ K @ N, N.T @ M @ N))
