"""The same mechanism the traditional way: free bodies, joints as constraints, multipliers."""

from __future__ import annotations  # scipy loads its parts when they are first used

import time
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from analytic.continuum import Continuum
from analytic.eigen import hertz, lowest_modes
from analytic.errors import InputError
from analytic.errors import count as whole
from analytic.kinematics import Limbs
from analytic.lanczos import factor, lowest
from analytic.mechanism import Mechanism
from analytic.model import Info
from analytic.modes import Modes, check_count
from analytic.pose import Pose
from analytic.substructure import (
    limb_matrices,
    limb_motion,
    limbs_at_one,
    platform_mass,
    rigid_arm,
)
from analytic.theory import Theory

SOLVERS = ("null-space", "saddle-point")
BASES = ("revolute", "free")


@dataclass(frozen=True)
class Multipliers:
    """M u'' + K u + C^T mu = 0, C u = 0: what Section 3.2 sets its method against (refs. 14, 17).

    u holds all nodes of all limbs, 6 (s+1) a limb of `elements` s, and the platform's six. C has
    three rows a spherical joint and five a revolute one. `solver`:

    - "null-space": u = N x with C N = 0, then the dense pair (N^T K N, N^T M N); mu drops out.
    - "saddle-point": ([[K, C^T], [C, 0]] - omega^2 [[M, 0], [0, 0]]) [u; mu] = 0, sparse.

    `base="free"` leaves out the revolute joints. The paper says of its ref. 15 that it "only
    considers the deformation coordination between the moving platform and limbs, and the boundary
    conditions between limbs and the base are ignored". Taken at its word that is this: limbs free
    at B_i, tied to the platform at A_i, hence 6 + 3 n motions without stiffness (the whole, and
    each of n limbs about its A_i) and no frequency of the mechanism. What ref. 15 itself computes
    is not in the paper's text, and is not claimed here.

    `beam` and `shear` as in `Substructure`. Raises `InputError` for unknown names or fewer than
    one element.
    """

    elements: int = 3
    beam: str = "euler-bernoulli"
    shear: str | float = "cowper"
    solver: str = "null-space"
    base: str = "revolute"

    def __post_init__(self) -> None:
        whole("elements", self.elements)
        Theory(self.beam, self.shear)
        if self.solver not in SOLVERS:
            raise InputError("solver", self.solver, f"one of {', '.join(SOLVERS)}")
        if self.base not in BASES:
            raise InputError("base", self.base, f"one of {', '.join(BASES)}")

    @property
    def theory(self) -> Theory:
        """The beam theory of the elements."""
        return Theory(self.beam, self.shear)

    def info(self) -> Info:
        """Return what the model is."""
        return self.theory.info()

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

    def matrices(
        self, mechanism: Mechanism, pose: Pose
    ) -> tuple[scipy.sparse.csr_array, scipy.sparse.csr_array, scipy.sparse.csr_array]:
        """Return K, M, both (N, N), and C, (c, N): N = 6 n (s+1) + 6, c = 8 n (3 n, base free)."""
        return self._matrices(mechanism, pose, limbs_at_one(mechanism, pose))

    def _matrices(
        self, mechanism: Mechanism, pose: Pose, limbs: Limbs
    ) -> tuple[scipy.sparse.csr_array, scipy.sparse.csr_array, scipy.sparse.csr_array]:
        s, n = self.elements, len(mechanism.limbs)
        K, M = zip(
            *(limb_matrices(mechanism, limbs, i, s, self.theory) for i in range(n)), strict=True
        )
        K_all = scipy.sparse.csr_array(scipy.sparse.block_diag([*K, np.zeros((6, 6))]))
        M_all = scipy.sparse.csr_array(
            scipy.sparse.block_diag([*M, platform_mass(mechanism, pose)])
        )
        axes = mechanism.axes if self.base == "revolute" else None
        return K_all, M_all, joints(limbs.arms, axes, s)

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        """Return the `count` lowest modes at one pose; `dofs` counts what is solved for.

        That is the coordinates N - c for "null-space", and N + c, multipliers included, for
        "saddle-point". Raises `InputError` for a pose out of reach, or more modes than N - c.
        """
        begin = time.perf_counter()
        limbs = limbs_at_one(mechanism, pose)
        K, M, C = self._matrices(mechanism, pose, limbs)
        dofs = K.shape[0] - C.shape[0]
        check_count(count, dofs)
        built = time.perf_counter()
        if self.solver == "null-space":
            N = null_space(C)
            frequencies, x = lowest_modes(N.T @ K @ N, N.T @ M @ N, count, "dense")
            u = N @ x
        else:
            dofs = K.shape[0] + C.shape[0]
            frequencies, u = _saddle_point(K, M, C, count, _limb_scale(mechanism, limbs))
        solved = time.perf_counter()
        nodes = np.split(u[:-6], len(mechanism.limbs))
        return Modes(
            frequencies=frequencies,
            platform=u[-6:].T,
            limbs=limb_motion(mechanism, limbs, nodes, self.theory),
            theory=self.theory.labels(mechanism),
            model="multipliers",
            version=f"rps-bench, {self.solver}",
            elements=self.elements,
            dofs=dofs,
            residual=None,
            build_seconds=built - begin,
            solve_seconds=solved - built,
        )


def joints(
    arms: NDArray[np.float64], axes: NDArray[np.float64] | None, s: int
) -> scipy.sparse.csr_array:
    """Return C of C u = 0 for limbs of s elements, each row a unit coordinate of its limb.

    Spherical at A_i: Delta_A - J_i U_p = 0, Eq. (10). Revolute at B_i about `axes` (n, 3), if any:
    Delta_B = 0 and Phi_B . t = 0 for two directions t across the axis.
    """
    n, own = len(arms), 6 * (s + 1)
    rows = []
    for i, arm in enumerate(arms):
        tip = i * own + 6 * s
        spherical = scipy.sparse.lil_array((3, n * own + 6))
        spherical[:, tip : tip + 3] = np.eye(3)
        spherical[:, -6:] = -rigid_arm(arm)
        rows.append(spherical)
        if axes is not None:
            revolute = scipy.sparse.lil_array((5, n * own + 6))
            revolute[:3, i * own : i * own + 3] = np.eye(3)
            revolute[3:, i * own + 3 : i * own + 6] = scipy.linalg.null_space(axes[i][None]).T
            rows.append(revolute)
    return scipy.sparse.csr_array(scipy.sparse.vstack(rows))


def null_space(C: scipy.sparse.csr_array) -> scipy.sparse.csr_array:
    """Return an orthonormal N with C N = 0, shape (N, N - c): coordinates no joint holds stay."""
    held = np.unique(C.indices)
    others = np.setdiff1d(np.arange(C.shape[1]), held)
    basis = scipy.linalg.qr(C[:, held].toarray().T)[0][:, C.shape[0] :]
    result = scipy.sparse.lil_array((C.shape[1], len(others) + basis.shape[1]))
    result[others, np.arange(len(others))] = 1.0
    result[held, len(others) :] = basis
    return scipy.sparse.csr_array(result)


def _saddle_point(
    K: scipy.sparse.csr_array,
    M: scipy.sparse.csr_array,
    C: scipy.sparse.csr_array,
    count: int,
    shift: float,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Solve the augmented pair by inverting [[K + shift M, C^T], [C, 0]]; modes as `lowest`."""
    size, held = K.shape[0], C.shape[0]
    blocks: list[list[Any]] = [[K + shift * M, C.T], [C, None]]
    inverse = factor(scipy.sparse.csr_array(scipy.sparse.block_array(blocks)))

    def solve(force: NDArray[np.float64]) -> NDArray[np.float64]:
        padded = np.zeros((size + held, force.shape[1]))
        padded[:size] = force
        return np.asarray(inverse.solve(padded)[:size])

    # Only the count is made on the null space: of free limbs, pivots vanish at the modes sought.
    N = null_space(C)
    return hertz(*lowest(K, M, count, solve, (N.T @ K @ N, N.T @ M @ N)))


def _limb_scale(mechanism: Mechanism, limbs: Limbs) -> float:
    """Return omega^2 of the softest limb's first bending mode between pins, (pi / L)^4 EI / rho A.

    Added to K it makes free limbs stiff enough to eliminate, and is small beside no limb's mode.
    """
    rods = [limb.rod for limb in mechanism.limbs]
    ratio = np.array(
        [rod.material.young * rod.second_moment / (rod.material.density * rod.area) for rod in rods]
    )
    return float(((np.pi / limbs.lengths) ** 4 * ratio).min())
