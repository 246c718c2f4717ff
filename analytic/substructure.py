"""The paper's model: substructure synthesis over independent displacement coordinates."""

from __future__ import annotations  # scipy loads its parts when they are first used

import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from analytic import assembly
from analytic.chain_models import element_modes
from analytic.chains import MOST_ELEMENTS, Chains, chains, rigid_arms, turning
from analytic.condensed import condensed_frequencies
from analytic.continuum import HasLimit
from analytic.eigen import hertz, lowest_modes, lowest_values, refined
from analytic.errors import InputError, NotCertifiedError
from analytic.errors import count as whole
from analytic.exact_chain import exact
from analytic.kinematics import Limbs, limbs_at
from analytic.lanczos import is_sparse
from analytic.mechanism import Mechanism
from analytic.modes import Modes, check_count
from analytic.pose import Pose, check_poses, one_pose

Floats = NDArray[np.float64]

SOLVERS = ("automatic", "dense", "sparse")
DENSE = 280
"""Coordinates up to which LAPACK was measured to be quicker than Lanczos: 15 elements, 3 limbs."""
EXACT = 8
"""Elements up to which rounding of K leaves twelve digits of the lowest modes."""


@dataclass(frozen=True)
class Substructure(HasLimit):
    """Eqs. (4)-(24) with `elements` s a limb.

    `beam` and `shear` choose the theory (see `Theory`; the paper: Euler-Bernoulli). `solver` is
    "dense", "sparse" or "automatic", the quicker one. Raises `InputError` for unknown names, fewer
    than one element or more than can be told from rounding.
    """

    elements: int = 3
    beam: str = "euler-bernoulli"
    shear: str | float = "cowper"
    solver: str = "automatic"

    def __post_init__(self) -> None:
        object.__setattr__(self, "elements", few(self.elements))
        super().__post_init__()
        if self.solver not in SOLVERS:
            raise InputError("solver", self.solver, f"one of {', '.join(SOLVERS)}")

    def frequencies(self, mechanism: Mechanism, poses: Pose, count: int = 6) -> Floats:
        """Return the `count` lowest frequencies [Hz] at every pose, shape (*poses.shape, count).

        At one pose from the matrices; at many by `condensed_frequencies`, the same to 1e-9.
        """
        check_poses(mechanism, poses)
        if poses.shape:
            return condensed_frequencies(
                mechanism, poses, self.elements, beam=self.beam, shear=self.shear, count=count
            )
        if not mechanism.simple:
            return self.modes(mechanism, poses, count).frequencies
        parts = self._chains(mechanism, poses)
        K, M = self._pair(parts)
        count = check_count(count, K.shape[0])
        if self.elements <= EXACT and not is_sparse(K):
            with suppress(np.linalg.LinAlgError):
                values = lowest_values(K, M, count)
                if parts.well_held(values):
                    return hertz(values)
        return hertz(self._solved(parts, K, M, count)[0])

    def matrices(self, mechanism: Mechanism, pose: Pose) -> tuple[Any, Any]:
        """Return K = Q^T K_r Q and M = Q^T M_r Q of Eq. (22), sparse, n (6 s - 2) + 6 square.

        The order is U of Eq. (19): for every limb its independent angle at B_i, its inner nodes
        and Phi_Ai; last Delta_p and Phi_p. Of limbs of any chain, limb after limb from the base on.
        """
        if not one_pose(mechanism, pose).shape and not mechanism.simple:
            problem = exact(mechanism, pose, self.theory)
            return problem.pair(problem.split(self.elements), sparse=True)
        return self._pair(self._chains(mechanism, pose), sparse=True)

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        """Return the `count` lowest modes at one pose, Eqs. (23)-(24).

        Raises `InputError` for a pose out of reach, or more modes than coordinates.
        """
        if not one_pose(mechanism, pose).shape and not mechanism.simple:
            return element_modes(mechanism, pose, self.theory, self.elements, count)
        begin = time.perf_counter()
        parts = self._chains(mechanism, pose)
        K, M = self._pair(parts)
        count = check_count(count, K.shape[0])
        built = time.perf_counter()
        eigenvalues, U = self._solved(parts, K, M, count)
        solved = time.perf_counter()
        solver = "sparse" if is_sparse(K) else "dense"
        return Modes(
            frequencies=hertz(eigenvalues),
            platform=U[-6:].T,
            limbs=parts.centre_lines(nodes(parts, U)),
            theory=self.theory.labels(mechanism),
            model="substructure",
            version=f"rps-bench, {solver}",
            elements=self.elements,
            dofs=K.shape[0],
            residual=None,
            build_seconds=built - begin,
            solve_seconds=solved - built,
        )

    def _chains(self, mechanism: Mechanism, pose: Pose) -> Chains:
        return chains(mechanism, limbs_at_one(mechanism, pose), self.elements, self.theory)

    def _pair(self, parts: Chains, *, sparse: bool | None = None) -> tuple[Any, Any]:
        n, s = len(parts.arms), self.elements
        if sparse is None:
            size = n * (6 * s - 2) + 6
            sparse = self.solver == "sparse" or (self.solver == "automatic" and size > DENSE)
        element = parts.element_matrices()
        blocks = [P.swapaxes(1, 2) @ element @ P for P in independent_ends(parts)]
        return assembly.joined(n, s, sparse=sparse).pair([*blocks, parts.platform])

    def _solved(self, parts: Chains, K: Any, M: Any, count: int) -> tuple[Floats, Floats]:
        return solved(parts, partial(lowest_modes, K, M, count), M, partial(nodes, parts))


def solved(
    parts: Chains,
    solve: Callable[[float], tuple[Floats, Floats]],
    M: Any,
    motion: Callable[[Floats], Floats],
    free: tuple[int, float] | None = None,
) -> tuple[Floats, Floats]:
    """Return omega^2 and vectors of `solve(shift)`, refined where that is needed.

    `motion` turns vectors into those of the limbs' nodes; `free` as of `Chains.free_motions`.
    Raises `NotCertifiedError` where rounding leaves nothing.
    """
    alone = 0.0  # K by itself, unless it is too close to singular
    if free is None:
        try:
            values, U = solve(0.0)
            if parts.well_held(values):
                if parts.elements <= EXACT:
                    return values, U
                return refined(M, U, lambda u: parts.strains(motion(u)), 0, 0.0)
        except np.linalg.LinAlgError:
            alone = parts.limb_scale
        free = parts.free_motions()
    number, shift = free[0], free[1] or alone
    try:
        values, U = solve(shift)
        return refined(M, U, lambda u: parts.strains(motion(u)), number, shift)
    except np.linalg.LinAlgError:
        raise NotCertifiedError("modes of rods so thin that K is rounding") from None


def few(elements: int) -> int:
    """Return a number of elements that K can be told from rounding with, or refuse."""
    s = whole("elements", elements)
    if s > MOST_ELEMENTS:
        raise InputError("elements", elements, f"at most {MOST_ELEMENTS}: K of more is rounding")
    return s


def limbs_at_one(mechanism: Mechanism, pose: Pose) -> Limbs:
    """Return the limbs at a single pose; raises `InputError` for anything else."""
    return limbs_at(mechanism, one_pose(mechanism, pose))


def independent_ends(parts: Chains) -> list[Floats]:
    """Return what turns coordinates of U into an element's own in limb axes, each (n, 12, d).

    Of the first element, an inner one and the last (of one alone, where s = 1; no inner one where
    s = 2): the rows of T_i^T H_i Q that belong to it, without columns of zeros. At B_i, Delta = 0
    and Phi = (e / e_k) phi_k, Eqs. (14) and (17)-(18); at A_i, Delta = J_i U_p, Eq. (10).
    """
    n, s = len(parts.arms), parts.elements
    R = parts.R
    base, tip = R @ parts.turns[..., None], R @ parts.J
    if s == 1:
        alone = np.zeros((n, 12, 10))
        alone[:, 3:6, :1], alone[:, 6:9, 4:], alone[:, 9:, 1:4] = base, tip, R
        return [alone]
    first, last = np.zeros((n, 12, 7)), np.zeros((n, 12, 15))
    first[:, 3:6, :1], first[:, 6:9, 1:4], first[:, 9:, 4:] = base, R, R
    last[:, :3, :3], last[:, 3:6, 3:6], last[:, 6:9, 9:], last[:, 9:, 6:9] = R, R, tip, R
    return [first, parts.T, last] if s > 2 else [first, last]


def nodes(parts: Chains, U: Floats) -> Floats:
    """Return the motions of the limbs' nodes, (n, s + 1, 6, m), from those of U (dofs, m)."""
    n, s = len(parts.arms), parts.elements
    own = U[:-6].reshape(n, 6 * s - 2, -1)
    motion = np.zeros((n, s + 1, 6, U.shape[1]))
    motion[:, 0, 3:] = parts.turns[..., None] * own[:, :1]
    motion[:, 1:s] = own[:, 1:-3].reshape(n, s - 1, 6, U.shape[1])
    motion[:, s, :3], motion[:, s, 3:] = parts.J @ U[-6:], own[:, -3:]
    return motion


def platform_mass(mechanism: Mechanism, pose: Pose) -> NDArray[np.float64]:
    """Return M_p = T_p ^oM_p T_p^T about o in global axes, Eqs. (7)-(9), shape (6, 6)."""
    turn = np.kron(np.eye(2), pose.rotation)
    return np.asarray(turn @ mechanism.platform.mass_matrix @ turn.T)


def rigid_arm(arm: Floats) -> Floats:
    """Return J_i = [E_3, [A_i o x]] of Eq. (10), shape (3, 6); `arm` is o to A_i [m]."""
    return np.asarray(rigid_arms(arm))


def limb_selection(i: int, n: int, s: int, arm: NDArray[np.float64]) -> scipy.sparse.csr_array:
    """Return H_i of Eq. (12), shape (6 (s+1), n (6 s + 3) + 6), for limb `i` of `n`.

    Rows are the limb's nodes; columns are U-bar: for every limb Delta_B, Phi_B, inner nodes and
    Phi_A, then the platform. Delta_A is the platform's motion, J_i U_p; all else is copied.
    """
    own = 6 * s + 3
    size = 6 * (s + 1)
    copied = np.r_[0 : 6 * s, 6 * s + 3 : size]
    rows = np.r_[copied, 6 * s + np.repeat(np.arange(3), 6)]
    columns = np.r_[i * own + np.arange(own), n * own + np.tile(np.arange(6), 3)]
    entries = np.r_[np.ones(own), rigid_arm(arm).ravel()]
    return scipy.sparse.csr_array(
        scipy.sparse.coo_array((entries, (rows, columns)), shape=(size, n * own + 6))
    )


def platform_selection(n: int, s: int) -> scipy.sparse.csr_array:
    """Return H_p of Eq. (12), shape (6, n (6 s + 3) + 6): the last six of U-bar."""
    return scipy.sparse.csr_array(scipy.sparse.eye_array(6, n * (6 * s + 3) + 6, k=n * (6 * s + 3)))


def independent_coordinates(axes: Floats, s: int) -> scipy.sparse.csr_array:
    """Return the map from U, Eq. (19), to U-bar, Eq. (11): Q of Eq. (21) with the zero rows kept.

    Shape (n (6 s + 3) + 6, n (6 s - 2) + 6). At B_i, Delta = 0 and Phi = (e / e_k) phi_k.
    """
    n, own, kept = len(axes), 6 * s + 3, 6 * s - 2
    Q = scipy.sparse.lil_array((n * own + 6, n * kept + 6))
    for i, turn in enumerate(turning(axes)):
        Q[i * own + 3 : i * own + 6, [i * kept]] = turn[:, None]
        Q[i * own + 6 : (i + 1) * own, i * kept + 1 : (i + 1) * kept] = np.eye(kept - 1)
    Q[-6:, -6:] = np.eye(6)
    return scipy.sparse.csr_array(Q)
