"""The paper's model: substructure synthesis over independent displacement coordinates."""

from __future__ import annotations  # scipy loads its parts when they are first used

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy
from numpy.typing import NDArray

from analytic.beam import centre_line, element_matrices
from analytic.eigen import lowest_modes
from analytic.errors import InputError
from analytic.errors import count as whole
from analytic.kinematics import Limbs, limbs_at
from analytic.mechanism import Mechanism
from analytic.model import Info
from analytic.modes import STATIONS, Modes, check_count
from analytic.pose import Pose
from analytic.theory import Theory

if TYPE_CHECKING:
    from analytic.continuum import Continuum

SOLVERS = ("dense", "sparse")


@dataclass(frozen=True)
class Substructure:
    """Eqs. (4)-(24) with `elements` s a limb.

    `beam` and `shear` choose the theory (see `Theory`; the paper: Euler-Bernoulli). `solver` is
    "dense" or "sparse". Raises `InputError` for unknown names or fewer than one element.
    """

    elements: int = 3
    beam: str = "euler-bernoulli"
    shear: str | float = "cowper"
    solver: str = "dense"

    def __post_init__(self) -> None:
        whole("elements", self.elements)
        Theory(self.beam, self.shear)
        if self.solver not in SOLVERS:
            raise InputError("solver", self.solver, f"one of {', '.join(SOLVERS)}")

    @property
    def theory(self) -> Theory:
        """The beam theory of the elements."""
        return Theory(self.beam, self.shear)

    def info(self) -> Info:
        """Return what the model is."""
        return self.theory.info()

    def limit(self) -> Continuum:
        """Return the exact model of the same theory."""
        from analytic.continuum import Continuum  # which needs the platform's mass from here

        return Continuum(self.beam, self.shear)

    def frequencies(self, mechanism: Mechanism, poses: Pose, count: int = 6) -> NDArray[np.float64]:
        """Return the `count` lowest frequencies [Hz] at every pose, shape (*poses.shape, count).

        Of many poses by `condensed_frequencies`, which gives the same to 1e-9.
        """
        from analytic.condensed import condensed_frequencies

        return condensed_frequencies(
            mechanism, poses, self.elements, beam=self.beam, shear=self.shear, count=count
        )

    def matrices(
        self, mechanism: Mechanism, pose: Pose
    ) -> tuple[scipy.sparse.csr_array, scipy.sparse.csr_array]:
        """Return K = Q^T K_r Q and M = Q^T M_r Q of Eq. (22), both (n (6 s) + 6 - ..., same).

        The order is U of Eq. (19): for every limb its independent angle at B_i, its inner nodes
        and Phi_Ai; last Delta_p and Phi_p.
        """
        return self._matrices(mechanism, pose, limbs_at_one(mechanism, pose))

    def _matrices(
        self, mechanism: Mechanism, pose: Pose, limbs: Limbs
    ) -> tuple[scipy.sparse.csr_array, scipy.sparse.csr_array]:
        s, n = self.elements, len(mechanism.limbs)
        H_p = platform_selection(n, s)
        K_bar = scipy.sparse.csr_array((H_p.shape[1], H_p.shape[1]))
        M_bar = H_p.T @ scipy.sparse.csr_array(platform_mass(mechanism, pose)) @ H_p
        for i in range(n):
            K_i, M_i = limb_matrices(mechanism, limbs, i, s, self.theory)
            H_i = limb_selection(i, n, s, limbs.arms[i])
            K_bar = K_bar + H_i.T @ K_i @ H_i
            M_bar = M_bar + H_i.T @ M_i @ H_i
        # Eq. (14) strikes out Delta_Bi; Eqs. (17)-(21) then leave one angle a revolute joint.
        Q = independent_coordinates(mechanism.axes, s)
        return scipy.sparse.csr_array(Q.T @ K_bar @ Q), scipy.sparse.csr_array(Q.T @ M_bar @ Q)

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        """Return the `count` lowest modes at one pose, Eqs. (23)-(24).

        Raises `InputError` for a pose out of reach, or more modes than coordinates.
        """
        begin = time.perf_counter()
        limbs = limbs_at_one(mechanism, pose)
        K, M = self._matrices(mechanism, pose, limbs)
        built = time.perf_counter()
        check_count(count, K.shape[0])
        frequencies, U = lowest_modes(K, M, count, self.solver)
        solved = time.perf_counter()
        expanded = independent_coordinates(mechanism.axes, self.elements) @ U
        n = len(mechanism.limbs)
        nodes = [
            limb_selection(i, n, self.elements, arm) @ expanded for i, arm in enumerate(limbs.arms)
        ]
        return Modes(
            frequencies=frequencies,
            platform=expanded[-6:].T,
            limbs=limb_motion(mechanism, limbs, nodes, self.theory),
            theory=self.theory.labels(mechanism),
            model="substructure",
            version=f"rps-bench, {self.solver}",
            elements=self.elements,
            dofs=K.shape[0],
            residual=None,
            build_seconds=built - begin,
            solve_seconds=solved - built,
        )


def limbs_at_one(mechanism: Mechanism, pose: Pose) -> Limbs:
    """Return the limbs at a single pose; raises `InputError` for an array of poses."""
    if pose.shape:
        raise InputError("pose", f"{pose.shape} poses", "one pose at a time for this model")
    return limbs_at(mechanism, pose)


def limb_matrices(
    mechanism: Mechanism, limbs: Limbs, i: int, s: int, theory: Theory
) -> tuple[scipy.sparse.csr_array, scipy.sparse.csr_array]:
    """Return K_i, M_i of one free rod in global axes, Eqs. (4)-(6), each (6 (s+1), 6 (s+1)).

    Every element has the same frame, so T_i is applied to one of them before they are joined.
    """
    T = np.kron(np.eye(4), limbs.frames[i])
    element = element_matrices(mechanism.limbs[i].rod, limbs.lengths[i] / s, theory)
    K, M = (_joined(T @ matrix @ T.T, s) for matrix in element)
    return K, M


def limb_motion(
    mechanism: Mechanism, limbs: Limbs, nodes: Sequence[NDArray[np.float64]], theory: Theory
) -> NDArray[np.float64]:
    """Return global displacement at `STATIONS`, (m, n, 11, 3), from m motions of limbs' nodes.

    `nodes` holds for every limb its coordinates in global axes, shape (6 (s+1), m).
    """
    count, s = nodes[0].shape[1], len(nodes[0]) // 6 - 1
    motion = np.empty((count, len(nodes), len(STATIONS), 3))
    for i, (limb, node) in enumerate(zip(mechanism.limbs, nodes, strict=True)):
        R = limbs.frames[i]
        local = (node.reshape(-1, 3, count).transpose(0, 2, 1) @ R).transpose(0, 2, 1)
        shape = centre_line(limb.rod, limbs.lengths[i], s, theory, STATIONS)
        motion[:, i] = np.einsum("kdj,jm->mkd", shape, local.reshape(-1, count)) @ R.T
    return motion


def _joined(element: NDArray[np.float64], s: int) -> scipy.sparse.csr_array:
    """Return s equal elements joined end to end, node by node."""
    rows, columns = np.divmod(np.arange(144), 12)
    start = 6 * np.arange(s)[:, None]
    size = 6 * (s + 1)
    entries = np.tile(element.ravel(), s)
    where = ((start + rows).ravel(), (start + columns).ravel())
    return scipy.sparse.csr_array(scipy.sparse.coo_array((entries, where), shape=(size, size)))


def platform_mass(mechanism: Mechanism, pose: Pose) -> NDArray[np.float64]:
    """Return M_p = T_p ^oM_p T_p^T about o in global axes, Eqs. (7)-(9), shape (6, 6)."""
    R = pose.rotation
    M = np.zeros((6, 6))
    M[:3, :3] = mechanism.platform.mass * np.eye(3)
    M[3:, 3:] = R @ np.array(mechanism.platform.inertia) @ R.T
    return M


def rigid_arm(arm: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return J_i = [E_3, [A_i o x]] of Eq. (10), shape (3, 6); `arm` is o to A_i [m]."""
    x, y, z = arm
    return np.array([[1.0, 0, 0, 0, z, -y], [0, 1.0, 0, -z, 0, x], [0, 0, 1.0, y, -x, 0]])


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


def independent_coordinates(axes: NDArray[np.float64], s: int) -> scipy.sparse.csr_array:
    """Return the map from U, Eq. (19), to U-bar, Eq. (11): Q of Eq. (21) with the zero rows kept.

    Shape (n (6 s + 3) + 6, n (6 s - 2) + 6). At B_i, Delta = 0 and Phi = (e / e_k) phi_k, where
    e is the revolute axis. Eq. (17) fixes k = y, Eq. (18) k = x; either divides by zero for some
    base orientation. Pivoting on the largest |e_k| never does, and gives Eq. (17) where e is along
    y.
    """
    n, own, kept = len(axes), 6 * s + 3, 6 * s - 2
    rows, columns, entries = [], [], []
    for i, axis in enumerate(axes):
        pivot = np.abs(axis).argmax()
        rows += [i * own + np.arange(3, own)]
        columns += [i * kept + np.r_[0, 0, 0, 1:kept]]
        entries += [np.r_[axis / axis[pivot], np.ones(kept - 1)]]
    rows += [n * own + np.arange(6)]
    columns += [n * kept + np.arange(6)]
    entries += [np.ones(6)]
    where = (np.concatenate(rows), np.concatenate(columns))
    shape = (n * own + 6, n * kept + 6)
    return scipy.sparse.csr_array(
        scipy.sparse.coo_array((np.concatenate(entries), where), shape=shape)
    )
