"""Counting the modes below a frequency, and frequencies certified by such counts.

With D(lambda) = sum_k d_k a_k a_k^T - lambda M_p over the limbs' three directions each, the modes
below omega are J = J_0 + (negative eigenvalues of D), Wittrick and Williams (1971).

D has poles, and modes sit next to them. Where d_k is large its force is kept as an unknown: in
    B = [[sum_soft d_k a_k a_k^T - lambda M_p, a_stiff], [a_stiff^T, -1 / d_stiff]]
nothing is large, and J = J_0 - (stiff d_k > 0) + (negative eigenvalues of B): the jump of J_0 at a
pole and the change of sign of 1 / d_k cancel.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analytic.dynamic_stiffness import (
    Sections,
    fixed_tip_counts,
    limb_stiffness,
    sections,
    torsion_eigenvalues,
)
from analytic.kinematics import limbs_at
from analytic.mechanism import Mechanism
from analytic.pose import Pose
from analytic.substructure import platform_mass, rigid_arm
from analytic.theory import Theory

WIDTH = 1e-12
"""Largest relative width of a certified bracket of a frequency."""
STILL = 1e-6
"""Frequencies below this part of the softest limb's first are given as zero: free motion."""


@dataclass(frozen=True)
class Characteristic:
    """The frequency-dependent problem of one mechanism at one pose.

    Attributes: limb `lengths` (n,) [m], their `rods`, `vectors` a_k over coordinates in which the
    platform's mass is the identity, shape (n, 3, 6), `elements` a limb or None (continuum). For
    counting alone, `lengths` (q, n) and `vectors` (q, n, 3, 6) give every omega^2 its own pose.
    """

    rods: Sections
    lengths: NDArray[np.float64]
    vectors: NDArray[np.float64]
    elements: int | None

    def stiffness(self, eigenvalue: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return d_k at each of `eigenvalue` (q,), shape (q, n, 3) [N/m]."""
        values = limb_stiffness(self.rods, self.lengths, eigenvalue[:, None], self.elements)
        return np.asarray(values.real)

    def slope(self, eigenvalue: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return d_k'(lambda) at each of `eigenvalue` (q,), exact by complex step, (q, n, 3)."""
        step = eigenvalue[:, None] * 1e-30
        moved = eigenvalue[:, None] + 1j * step
        values = limb_stiffness(self.rods, self.lengths, moved, self.elements)
        return np.asarray(values.imag / step[..., None])

    @property
    def scale(self) -> NDArray[np.float64]:
        """Static stiffness 3 EI / L^3 (twice) and EA / L, shape (n, 3) [N/m]."""
        bending = 3 * self.rods.EI / self.lengths**3
        return np.stack([bending, bending, self.rods.EA / self.lengths], axis=-1)

    @property
    def first(self) -> float:
        """omega^2 of the softest limb's first bending mode between pins, without shear."""
        return float(((np.pi / self.lengths) ** 4 * self.rods.EI / self.rods.line_mass).min())

    def bordered(
        self, eigenvalue: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.bool_], NDArray[np.float64]]:
        """Return B (q, m, m), which d_k are stiff (q, n, 3), and d_k, for `eigenvalue` (q,).

        m = 6 + 3 n. B is free of units: displacements are divided by omega, forces by the root of
        `scale`; the row of a soft d_k is that of the identity.
        """
        d = self.stiffness(eigenvalue)
        ratio = (d / self.scale).reshape(len(d), -1)
        stiff = np.abs(ratio) > 1
        directions = ratio.shape[1]
        scale = np.sqrt(self.scale.reshape(-1, directions) / eigenvalue[:, None])
        a = scale[..., None] * self.vectors.reshape(-1, directions, 6)
        soft = np.where(stiff, 0.0, ratio)
        border = np.where(stiff[..., None], a, 0.0)
        B = np.zeros((len(d), 6 + directions, 6 + directions))
        B[:, :6, :6] = np.einsum("qk,qki,qkj->qij", soft, a, a) - np.eye(6)
        B[:, :6, 6:] = border.swapaxes(1, 2)
        B[:, 6:, :6] = border
        k = np.arange(directions)
        B[:, 6 + k, 6 + k] = np.where(stiff, -1 / np.where(stiff, ratio, 1.0), 1.0)
        return B, stiff.reshape(d.shape), d

    def spectra(
        self, eigenvalue: NDArray[np.float64]
    ) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return for `eigenvalue` (q,) the count outside B, without torsion, and B's eigenvalues.

        The first has shape (q,), the second (q, 6 + 3 n).
        """
        B, stiff, d = self.bordered(eigenvalue)
        held = fixed_tip_counts(self.rods, self.lengths, eigenvalue[:, None], self.elements)
        outside = held[..., :3].sum(axis=(1, 2)) - (stiff & (d > 0)).sum(axis=(1, 2))
        return np.asarray(outside), np.asarray(np.linalg.eigvalsh(B))

    def count(self, eigenvalue: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the number of modes below each omega^2 of `eigenvalue` (q,), torsion included."""
        outside, values = self.spectra(eigenvalue)
        held = fixed_tip_counts(self.rods, self.lengths, eigenvalue[:, None], self.elements)
        return np.asarray(outside + held[..., 3].sum(axis=1) + (values < 0).sum(axis=1))

    def coupled(self, count: int) -> NDArray[np.float64]:
        """Return brackets of the lowest `count` omega^2 that are not torsion, shape (count, 2).

        ITP (Oliveira and Takahashi 2021) on the eigenvalue of B that crosses zero at the mode
        sought, for all modes at once; every step's count decides which side it is on.
        """
        found = np.stack(self._isolated(count), axis=1)
        rank = np.flatnonzero(found[:, 0] > 0)
        if not rank.size:
            return found
        x = np.log(found[rank])
        y = np.stack([self._crossing(np.exp(x[:, side]), rank) for side in (0, 1)], axis=1)
        tolerance = WIDTH / 4
        width = (x[:, 1] - x[:, 0]).max()
        for left in range(int(np.ceil(np.log2(width / (2 * tolerance)))) + 1, -1, -1):
            middle, half = x.mean(axis=1), (x[:, 1] - x[:, 0]) / 2
            if (half <= tolerance).all():
                break
            tame = np.isfinite(y).all(axis=1)
            fraction = np.full(len(y), 0.5)
            fraction[tame] = y[tame, 0] / (y[tame, 0] - y[tame, 1])
            secant = x[:, 0] + fraction * 2 * half
            toward = np.sign(middle - secant)
            shift = np.minimum(0.2 / width * (2 * half) ** 2, np.abs(middle - secant))
            # The shift past the secant shrinks the far side too; never below what a count can tell.
            trial = secant + toward * np.maximum(shift, np.minimum(tolerance, half))
            radius = np.maximum(tolerance * 2.0**left - half, 0.0)
            trial = np.clip(trial, middle - radius, middle + radius)
            value = self._crossing(np.exp(trial), rank)
            below = value > 0
            x[below, 0], y[below, 0] = trial[below], value[below]
            x[~below, 1], y[~below, 1] = trial[~below], value[~below]
        # Ends that fell on the mode itself move off it by more than rounding.
        found[rank] = np.exp(x + np.array([-tolerance, tolerance]))
        return found

    def _crossing(
        self, eigenvalue: NDArray[np.float64], rank: NDArray[np.int64]
    ) -> NDArray[np.float64]:
        """Return B's eigenvalue that is negative where more than `rank` modes lie below."""
        outside, values = self.spectra(eigenvalue)
        index = rank - outside
        inside = np.clip(index, 0, values.shape[1] - 1)
        value = np.take_along_axis(values, inside[:, None], axis=1)[:, 0]
        value = np.where(index < 0, -np.inf, np.where(index >= values.shape[1], np.inf, value))
        return np.asarray(value)

    def _isolated(self, count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return brackets (count,) from a coarse grid that grows until it holds all modes."""
        grid = self.first * np.r_[STILL**2, np.geomspace(1e-6, 1e2, 65)]
        below = self.coupled_count(grid)
        while below[-1] < count:
            more = grid[-1] * np.geomspace(1.2, 100, 25)
            grid, below = np.r_[grid, more], np.r_[below, self.coupled_count(more)]
        upper = (below[None, :] > np.arange(count)[:, None]).argmax(axis=1)
        return np.where(upper > 0, grid[upper - 1], 0.0), grid[upper]

    def coupled_count(self, eigenvalue: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the number of modes below each omega^2 of `eigenvalue` (q,), without torsion."""
        outside, values = self.spectra(eigenvalue)
        return np.asarray(outside + (values < 0).sum(axis=1))

    def brackets(self, count: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Return brackets of the lowest `count` omega^2, and the limb that twists in each.

        Shapes (count, 2) and (count,); -1 where the mode is not torsion of a limb.
        """
        coupled = self.coupled(count)
        torsion = torsion_eigenvalues(self.rods, self.lengths, count, self.elements)
        twisting = np.repeat(np.arange(len(self.lengths)), torsion.shape[1])
        both = np.concatenate([coupled, torsion.reshape(-1, 1) * [1 - WIDTH / 2, 1 + WIDTH / 2]])
        limb = np.r_[np.full(count, -1), twisting]
        order = np.argsort(both.mean(axis=1), kind="stable")[:count]
        return both[order], limb[order]


def characteristic(
    mechanism: Mechanism, pose: Pose, theory: Theory, elements: int | None = None
) -> Characteristic:
    """Return the problem at one pose. Raises `InputError` for a pose out of reach."""
    limbs = limbs_at(mechanism, pose)
    root = np.linalg.cholesky(platform_mass(mechanism, pose))
    arms = np.array([rigid_arm(arm) for arm in limbs.arms])
    vectors = np.einsum("ijk,ijm->ikm", limbs.frames, arms)
    vectors = np.linalg.solve(root, vectors.reshape(-1, 6).T).T.reshape(vectors.shape)
    return Characteristic(sections(mechanism, theory), limbs.lengths, vectors, elements)
