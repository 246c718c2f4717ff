"""The limbs as chains of elements at one pose: what every formulation with elements starts from."""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from analytic import beam
from analytic.kinematics import Limbs
from analytic.mechanism import Mechanism
from analytic.rod_elements import Coefficients, Properties, coefficients, properties
from analytic.theory import Theory
from analytic.waves import paper_rods

Floats = NDArray[np.float64]

SPREAD = 1e4
"""Omega^2 over the lowest from which on strains are needed for the last digits."""
RIGID = 1e-9
"""A motion of the platform that the limbs resist by less than this part of the most is free."""
MOST_ELEMENTS = 1000
"""Elements a limb beyond which rounding of K, which grows with s^4, hides the lowest modes."""
WEAK = 1e-3
"""A motion resisted by less than this part is solved for as carefully as a free one."""


@lru_cache(maxsize=32)
def _fixed(mechanism: Mechanism, theory: Theory) -> tuple[Properties, Coefficients, Floats]:
    """Return what poses share: the limbs' rods, their elements', `turning` of their axes."""
    rods = properties(paper_rods(mechanism), theory).alike()
    return rods, coefficients(rods), turning(mechanism.axes)


@dataclass(frozen=True)
class Chains:
    """n limbs of `elements` s.

    Attributes: `rods` and what their elements have in `common`; limb `lengths` (n,) [m]; `frames`
    (n, 3, 3) from limb to global axes; `arms` o to A_i (n, 3) [m]; `turns` e / e_k of the revolute
    joints (n, 3), see `turning`; `platform_mass` M_p, Eq. (9).
    """

    elements: int
    rods: Properties
    common: Coefficients
    lengths: Floats
    frames: Floats
    arms: Floats
    turns: Floats
    platform_mass: Floats

    @property
    def R(self) -> Floats:
        """R_i^T, from global to limb axes, shape (n, 3, 3)."""
        return self.frames.swapaxes(1, 2)

    @property
    def T(self) -> Floats:
        """T_i^T, an element's global coordinates to those in limb axes, shape (n, 12, 12)."""
        T, R = np.zeros((len(self.arms), 12, 12)), self.R
        for node in range(0, 12, 3):
            T[:, node : node + 3, node : node + 3] = R
        return T

    @property
    def element_lengths(self) -> Floats:
        """h = L_i / s, shape (n,) [m]."""
        return self.lengths / self.elements

    @property
    def platform(self) -> Floats:
        """No stiffness, and M_p: shape (2, 6, 6)."""
        both = np.zeros((2, 6, 6))
        both[1] = self.platform_mass
        return both

    @cached_property
    def J(self) -> Floats:
        """J_i of Eq. (10), the platform's motion to that of A_i, shape (n, 3, 6)."""
        return rigid_arms(self.arms)

    def element_matrices(self) -> Floats:
        """Return K_e and M_e in limb axes, shape (2, n, 12, 12)."""
        return self.common.matrices(self.element_lengths)

    def strains(self, nodes: Floats) -> Floats:
        """Return `beam.strains` of motions of the nodes in global axes, (n, s + 1, 6, m)."""
        return beam.strains(self.rods, self.element_lengths, self._in_limb_axes(nodes))

    def centre_lines(self, nodes: Floats) -> Floats:
        """Return global displacement at `STATIONS`, (m, n, 11, 3), of m motions of the nodes."""
        local = beam.centre_lines(self.rods, self.element_lengths, self._in_limb_axes(nodes))
        return np.asarray((self.frames[:, None] @ local).transpose(3, 0, 1, 2))

    def _in_limb_axes(self, nodes: Floats) -> Floats:
        halves = nodes.reshape(*nodes.shape[:2], 2, 3, -1)
        return np.asarray(self.R[:, None, None] @ halves).reshape(nodes.shape)

    def free_motions(self) -> tuple[int, float]:
        """Return how many motions of the platform no limb resists, and by what to shift K.

        A limb resists its tip along and across, but not about its revolute joint. The shift is
        zero where all motions are held well, or else `limb_scale`: added as that much of M it
        makes K definite.
        """
        held = self.R[:, 1:] @ self.J
        held[..., 3:] /= self.unit
        resisted = np.linalg.svd(held.reshape(-1, 6), compute_uv=False)
        free = 6 - int((resisted > RIGID * resisted[0]).sum())
        if free == 0 and resisted[5] > WEAK * resisted[0]:
            return 0, 0.0
        return free, self.limb_scale

    def well_held(self, eigenvalues: Floats) -> bool:
        """Return whether K alone has told all digits of these omega^2, of all from the lowest up.

        Not those of a motion that is all but free, beside which rounding of the others is large.
        """
        return bool(max(eigenvalues[-1], self.limb_scale) < SPREAD * eigenvalues[0])

    @property
    def unit(self) -> float:
        """A length to multiply rotations by, where they are compared with displacements [m]."""
        return float(self.lengths.mean())

    @property
    def limb_scale(self) -> float:
        """Omega^2 of the softest limb's first bending mode between pins, (pi / L)^4 EI / rho A."""
        return float(((np.pi / self.lengths) ** 4 * self.rods.EI[:, 0] / self.rods.mass).min())


def chains(mechanism: Mechanism, limbs: Limbs, elements: int, theory: Theory) -> Chains:
    """Return the chains of `mechanism` with its `limbs` at one pose."""
    rods, shared, turns = _fixed(mechanism, theory)
    M_p = np.zeros((6, 6))
    M_p[[0, 1, 2], [0, 1, 2]] = mechanism.platform.mass
    M_p[3:, 3:] = limbs.rotation @ mechanism.platform.inertia @ limbs.rotation.T
    return Chains(elements, rods, shared, limbs.lengths, limbs.frames, limbs.arms, turns, M_p)


_STILL = np.hstack([np.eye(3), np.zeros((3, 3))]).ravel()


def _turned() -> Floats:
    """Return what each component of an arm adds to J: spin x arm, shape (3, 18)."""
    turn = np.zeros((3, 3, 6))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        turn[k, i, 3 + j], turn[j, i, 3 + k] = 1.0, -1.0
    return turn.reshape(3, 18)


_TURNED = _turned()


def rigid_arms(arms: Floats) -> Floats:
    """Return J = [E_3, [A o x]] of Eq. (10), shape (..., 3, 6); `arms` (..., 3) o to A [m]."""
    return np.asarray((arms @ _TURNED + _STILL).reshape(*arms.shape, 6))


def turning(axes: Floats) -> Floats:
    """Return e / e_k of each revolute axis e (n, 3), pivoting on its largest component.

    Eq. (17) fixes k = y, Eq. (18) k = x; either divides by zero for some base orientation.
    Pivoting never does, and gives Eq. (17) where e is along y.
    """
    pivot = np.abs(axes).argmax(axis=1)
    return np.asarray(axes / axes[np.arange(len(axes)), pivot][:, None])
