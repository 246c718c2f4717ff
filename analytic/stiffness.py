"""The static stiffness at the platform, and which part of the mechanism gives way most.

At rest an element is exact: the stiffness is that of Eq. (22) with one element a rod, condensed to
the platform's six coordinates, whatever the theory of the rods' inertia.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analytic.exact_chain import Exact, exact
from analytic.mechanism import Joint, Mechanism
from analytic.network import Network
from analytic.pose import Pose, one_pose
from analytic.rod_elements import element_matrices
from analytic.theory import Theory

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Stiffness:
    """The platform under a small load at o, in global axes.

    Attributes: `matrix` S (6, 6), force and moment at o of a unit displacement and rotation [N/m,
    N, N m/rad]; `parts`, the elastic parts by (limb, item), both from 1 on, and what each is;
    `compliances` (parts, 6, 6), what each gives way: the sum is the inverse of S.
    """

    matrix: Floats
    parts: tuple[tuple[int, int, str], ...]
    compliances: Floats

    @property
    def compliance(self) -> Floats:
        """The inverse of `matrix`, (6, 6)."""
        return np.asarray(np.linalg.inv(self.matrix))

    @property
    def shares(self) -> Floats:
        """What share of the compliance to each load alone (Fx, Fy, Fz, Mx, My, Mz) is a part's.

        Shape (parts, 6); every column sums to 1.
        """
        each = np.diagonal(self.compliances, axis1=1, axis2=2)
        return np.asarray(each / np.diag(self.compliance))

    def softest(self, *, turns: bool = False) -> tuple[float, Floats, Floats]:
        """Return the least stiffness to a force at o (`turns`: a moment), and what makes it.

        1 / the largest eigenvalue of the compliance to forces [N/m, N m/rad]; its direction (3,);
        the parts' shares of that compliance (parts,).
        """
        block = slice(3, 6) if turns else slice(0, 3)
        values, vectors = np.linalg.eigh(self.compliance[block, block])
        direction = vectors[:, -1] * np.sign(vectors[np.abs(vectors[:, -1]).argmax(), -1])
        each = np.einsum("pij,i,j->p", self.compliances[:, block, block], direction, direction)
        return float(1 / values[-1]), direction, each / values[-1]


def stiffness(
    mechanism: Mechanism, pose: Pose, *, beam: str = "timoshenko", shear: str | float = "cowper"
) -> Stiffness:
    """Return the static stiffness at one pose.

    `beam` and `shear` as of `Theory`: only shear deformation matters at rest. Raises `InputError`
    for a pose out of reach, or a mechanism that can move with its drives locked.
    """
    problem = exact(mechanism, one_pose(mechanism, pose), Theory(beam, shear))
    net = problem.split(1)
    K = problem.pair(net)[0]
    # Spins of limbs move nothing else: the least motion will do.
    follow = -np.linalg.lstsq(K[:-6, :-6], K[:-6, -6:], rcond=None)[0]
    motion = np.concatenate([follow, np.eye(6)])
    matrix = K[-6:, :-6] @ follow + K[-6:, -6:]
    matrix = (matrix + matrix.T) / 2
    loaded = motion @ np.linalg.inv(matrix)
    found = sorted(_energies(problem, net, loaded), key=lambda one: one[:2])
    parts = tuple((limb, item, what) for limb, item, what, _ in found)
    return Stiffness(matrix, parts, np.array([energy for *_, energy in found]))


def _energies(problem: Exact, net: Network, u: Floats) -> list[tuple[int, int, str, Floats]]:
    """Return twice the energy of every elastic part in motions u (size, 6), each (6, 6)."""
    found = []
    matrices = [
        element_matrices(problem.of[p.group, p.item], problem.lengths(p.group, p.item))[:1]
        for p in net.rods
    ]
    blocks = [
        (p.group, p.item, columns, block[0])
        for p, columns, block in zip(
            net.rods, net.rod_columns(), net.rod_blocks(matrices), strict=True
        )
    ]
    blocks += [(g, item, columns, block[0]) for (g, columns, block), item in net.springs()]
    for group, item, columns, block in blocks:
        alike = net.groups[group].alike
        where = np.array(columns)
        for k, start in enumerate(net.starts[group]):
            own = u[np.where(where < 0, len(u) + where, start + where)]
            thing = alike.chains[k][item]
            what = thing.name if isinstance(thing, Joint) else "rod"
            limb = int(alike.limbs[k]) + 1
            found.append((limb, item + 1, what, own.T @ block[k] @ own))
    return found
