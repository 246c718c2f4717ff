"""Limbs of any chain as free bodies: every node's motion, joints as constraints, multipliers.

Every rod has s + 1 nodes of its own, every body and the platform one. Between two neighbours u and
v of a chain the joints' free twists F let go, and what is square to them does not:
    W^T (v - u) = W^T E r,  W^T F = 0,
with u carried to where v is; r are the stretches of springs and E their twists: coordinates of
their own, without mass. Nothing here is eliminated by hand, as it is in `network`.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from analytic.errors import InputError
from analytic.exact_chain import Exact
from analytic.mechanism import Body
from analytic.placed import Placed
from analytic.platform import body_mass
from analytic.rod_elements import element_matrices
from analytic.strut import DEPENDENT

Floats = NDArray[np.float64]

MOST = 3000
"""Coordinates up to which dense matrices are made."""


@dataclass(frozen=True)
class Free:
    """K and M (N, N) of all bodies, C (c, N) of C u = 0, and where things are.

    Attributes: `nodes`, by (group, item) of a rod, the first coordinate of every limb's (n,);
    `rotations` (N,), which coordinates are angles. The platform's six are last.
    """

    K: Floats
    M: Floats
    C: Floats
    nodes: dict[tuple[int, int], NDArray[np.intp]]
    rotations: NDArray[np.bool_]


def free_bodies(problem: Exact, elements: int) -> Free:
    """Return the mechanism of `problem` with `elements` a rod, free of joints, and its joints.

    Raises `InputError` for more coordinates than `MOST`.
    """
    size = 6
    for group in problem.groups:
        for chain in group.alike.chains:
            size += 6 * sum(isinstance(item, Body) for item in chain)
        size += 6 * (elements + 1) * len(group.alike.rods) * len(group.alike.limbs)
        size += sum(int((of.stiffness > 0).sum()) for of in group.alike.freedoms.values())
    if size > MOST:
        raise InputError("elements", elements, f"fewer: {size} coordinates exceed {MOST}")
    making = _Making(problem, elements, size)
    for g, group in enumerate(problem.groups):
        for i in range(len(group.alike.limbs)):
            making.limb(g, group, i)
    making.M[-6:, -6:] += problem.platform_mass
    rotations = making.rotations
    rotations[-3:] = True
    C = np.array(making.rows) if making.rows else np.zeros((0, size))
    nodes = {key: np.array(value) for key, value in making.nodes.items()}
    return Free(making.K, making.M, C, nodes, rotations)


def lowest(
    free: Free, solver: str, count: int, unit: float, shift: float
) -> tuple[Floats, Floats, int]:
    """Return the `count` lowest omega^2, vectors (N, count) of modal mass 1, and how many unknowns.

    By the null space of C, or by the saddle point of K + `shift` M and C; `unit` a length [m].
    """
    K, M, C = free.K + shift * free.M, free.M, free.C
    scale = np.where(free.rotations, 1 / unit, 1.0)
    rows = C * scale
    rows /= np.linalg.norm(rows, axis=1, keepdims=True)
    if solver == "null-space":
        touched = rows.any(axis=0)
        Q = np.linalg.qr(rows[:, touched].T, mode="complete")[0][:, len(rows) :]
        others = np.flatnonzero(~touched)
        N = np.zeros((len(K), len(others) + Q.shape[1]))
        N[others, np.arange(len(others))] = 1.0
        N[touched, len(others) :] = Q
        N *= scale[:, None]
        k, m = N.T @ K @ N, N.T @ M @ N
        # M of stretches alone is zero: the inverse problem needs none.
        size = len(k)
        mu, x = scipy.linalg.eigh(m, k, subset_by_index=(size - count, size - 1))
        return 1 / mu[::-1] - shift, N @ (x / np.sqrt(mu))[:, ::-1], size
    # All coordinates of one size, and multipliers too, or elimination would take one for zero.
    stiff = scale[:, None] * K * scale
    own = np.diag(stiff).max()
    held = len(rows)
    whole = np.block([[stiff / own, rows.T], [rows, np.zeros((held, held))]])
    d, V = np.linalg.eigh(scale[:, None] * M * scale)
    heavy = d > 1e-14 * d[-1]
    F = V[:, heavy] * np.sqrt(d[heavy])
    size = len(stiff)
    moved = np.linalg.solve(whole, np.vstack([F, np.zeros((held, F.shape[1]))]))[:size] / own
    inner = F.T @ moved
    mu, y = scipy.linalg.eigh(
        (inner + inner.T) / 2, subset_by_index=(F.shape[1] - count, F.shape[1] - 1)
    )
    u = scale[:, None] * (moved @ y / mu)
    return 1 / mu[::-1] - shift, u[:, ::-1], size + held


class _Making:
    """Fills K, M and C, limb after limb."""

    def __init__(self, problem: Exact, elements: int, size: int) -> None:
        self.problem, self.s = problem, elements
        self.K, self.M = np.zeros((2, size, size))
        self.rows: list[Floats] = []
        self.nodes: dict[tuple[int, int], list[int]] = {}
        self.rotations = np.zeros(size, dtype=bool)
        self.used = 0

    def limb(self, g: int, group: Placed, i: int) -> None:
        """Add limb `i` of group `g`."""
        kinds = [kind[0] for kind in group.alike.kind]
        before: int | None = None
        at, pending = 0, []
        for k, kind in enumerate(kinds):
            if kind == "joint":
                pending.append(k)
            elif kind in ("rod", "body"):
                node = self._node(1 if kind == "body" else self.s + 1)
                self._join(group, i, before, at, node, k, pending)
                before, at, pending = node, k, []
                if kind == "body":
                    self._weigh(group, i, k, node)
                else:
                    self._rod(g, group, i, k, node)
                    before, at = node + 6 * self.s, k + 1
        self._join(group, i, before, at, len(self.K) - 6, len(kinds), pending)

    def _node(self, count: int) -> int:
        first = self.used
        self.used += 6 * count
        self.rotations[first : self.used].reshape(-1, 2, 3)[:, 1] = True
        return first

    def _rod(self, g: int, group: Placed, i: int, k: int, node: int) -> None:
        of = self.problem.of[g, k]
        own = type(of)(*(value[i : i + 1] for value in vars(of).values()))
        pair = element_matrices(own, group.lengths[i : i + 1, k] / self.s)[:, 0]
        turn = np.kron(np.eye(4), group.frames[i].T)
        K, M = turn.T @ pair @ turn
        for e in range(self.s):
            part = slice(node + 6 * e, node + 6 * e + 12)
            self.K[part, part] += K
            self.M[part, part] += M
        self.nodes.setdefault((g, k), []).append(node)

    def _weigh(self, group: Placed, i: int, k: int, node: int) -> None:
        body = group.alike.chains[i][k]
        assert isinstance(body, Body)
        axes = group.frames[i] if body.frame == "limb" else np.eye(3)
        inertia = axes @ np.array(body.inertia) @ axes.T
        part = slice(node, node + 6)
        self.M[part, part] += body_mass(body.mass, inertia, axes @ np.array(body.centre))

    def _join(
        self,
        group: Placed,
        i: int,
        before: int | None,
        at: int,
        after: int,
        item: int,
        joints: list[int],
    ) -> None:
        """Add the constraints between node `before`, where item `at` starts, and `after`."""
        starts, unit = group.starts[i], self.problem.unit
        there = starts[item]
        size = np.array([1.0] * 3 + [unit] * 3)
        relative = np.zeros((6, len(self.K)))
        # The platform's six are of o.
        arm = group.arms[i] if item == len(group.alike.kind) else np.zeros(3)
        relative[:, after : after + 6] = _carried(arm)
        if before is not None:
            relative[:, before : before + 6] -= _carried(there - starts[at])
        free = []
        for k in joints:
            E = group.twists(k)[i]
            moved = _carried(there - starts[k]) @ E
            for f, stiffness in enumerate(group.alike.freedoms[k].stiffness[i]):
                if stiffness > 0:
                    r = self.used
                    self.used += 1
                    self.K[r, r] = stiffness
                    self.rotations[r] = bool(E[3:, f].any())
                    relative[:, r] -= moved[:, f]
                else:
                    free.append(moved[:, f])
        W = np.eye(6)
        if free:
            U, sigma, _ = np.linalg.svd(np.array(free).T * size[:, None])
            W = U[:, int((sigma > DEPENDENT * sigma[0]).sum()) :]
        self.rows += list(W.T @ (size[:, None] * relative))


def _carried(arm: Floats) -> Floats:
    """Return (6, 6): a rigid body's motion at the point that is `arm` away."""
    x, y, z = arm
    result = np.eye(6)
    result[:3, 3:] = [[0, z, -y], [-z, 0, x], [y, -x, 0]]
    return result
