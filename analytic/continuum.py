"""The model without elements: exact limbs, certified frequencies, mode shapes."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analytic.condensed import condensed_frequencies
from analytic.dynamic_stiffness import bending_waves
from analytic.errors import InputError, number
from analytic.kinematics import Limbs, limbs_at
from analytic.mechanism import Mechanism
from analytic.model import Info
from analytic.modes import STATIONS, Modes, check_count
from analytic.pose import Pose
from analytic.substructure import platform_mass
from analytic.theory import Theory
from analytic.wittrick_williams import WIDTH, Characteristic, characteristic

REPEATED = 1e-9
"""Modes whose omega^2 are closer than this, relative, share one eigenspace."""


@dataclass(frozen=True)
class Continuum:
    """Every limb a continuous beam: the limit s -> infinity of `Substructure`.

    `beam` and `shear` choose the theory (see `Theory`). Raises `InputError` for unknown names.
    """

    beam: str = "euler-bernoulli"
    shear: str | float = "cowper"

    def __post_init__(self) -> None:
        Theory(self.beam, self.shear)

    @property
    def theory(self) -> Theory:
        """The beam theory of the limbs."""
        return Theory(self.beam, self.shear)

    @property
    def elements(self) -> None:
        """None: there are no elements."""
        return

    def info(self) -> Info:
        """Return what the model is."""
        return replace(self.theory.info(), precision=2 * WIDTH)  # two certified brackets

    def limit(self) -> Continuum:
        """Return this model: it is its own limit."""
        return self

    def frequencies(self, mechanism: Mechanism, poses: Pose, count: int = 6) -> NDArray[np.float64]:
        """Return the `count` lowest frequencies [Hz] at every pose, shape (*poses.shape, count).

        By `condensed_frequencies`, to 1e-9.
        """
        return condensed_frequencies(
            mechanism, poses, None, beam=self.beam, shear=self.shear, count=count
        )

    def count_below(self, mechanism: Mechanism, pose: Pose, frequency: float) -> int:
        """Return how many modes lie below `frequency` [Hz], by Wittrick and Williams (1971).

        Exact: repeated modes, torsion of limbs and modes that leave the platform still included.
        Raises `InputError` for a frequency that is not positive, or a pose out of reach.
        """
        hertz = number("frequency", frequency, "a positive number of hertz", positive=True)
        problem = self._problem(mechanism, pose)
        return int(problem.count(np.array([(2 * np.pi * hertz) ** 2]))[0])

    def brackets(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> NDArray[np.float64]:
        """Return lower and upper bounds of the lowest `count` frequencies, (count, 2) [Hz].

        No more than 1e-12 apart, relative: fewer than k modes lie below the k-th lower bound, at
        least k below the upper one. A mode of free motion has (0, upper).
        """
        count = check_count(count, 10_000)
        return np.sqrt(self._problem(mechanism, pose).brackets(count)[0]) / (2 * np.pi)

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        """Return the `count` lowest modes at one pose, each frequency exact to 1e-12.

        Raises `InputError` for a pose out of reach.
        """
        begin = time.perf_counter()
        count = check_count(count, 10_000)
        problem = self._problem(mechanism, pose)
        limbs = limbs_at(mechanism, pose)
        built = time.perf_counter()
        bounds, twisting = problem.brackets(count)
        eigenvalues = np.where(bounds[:, 0] > 0, bounds.mean(axis=1), 0.0)
        platform = np.zeros((count, 6))
        motion = np.zeros((count, len(mechanism.limbs), len(STATIONS), 3))
        root = np.linalg.cholesky(platform_mass(mechanism, pose))
        # A limb that twists moves neither its centre line nor the platform.
        others = np.flatnonzero(twisting < 0)
        near = np.diff(eigenvalues[others]) > REPEATED * eigenvalues[others][1:]
        for group in np.split(others, np.flatnonzero(near) + 1):
            if group.size:
                free = eigenvalues[group[0]] == 0
                U, w, F = eigenspace(problem, bounds[group].mean(), len(group), free)
                platform[group] = np.linalg.solve(root.T, U.T).T
                motion[group] = _centre_lines(problem, limbs, bounds[group].mean(), w, F)
        return Modes(
            frequencies=np.sqrt(eigenvalues) / (2 * np.pi),
            platform=platform,
            limbs=motion,
            theory=self.theory.labels(mechanism),
            model="continuum",
            version="rps-bench, Wittrick-Williams",
            elements=None,
            dofs=6,
            residual=None,
            build_seconds=built - begin,
            solve_seconds=time.perf_counter() - built,
        )

    def _problem(self, mechanism: Mechanism, pose: Pose) -> Characteristic:
        if pose.shape:
            raise InputError("pose", f"{pose.shape} poses", "one pose at a time for this model")
        return characteristic(mechanism, pose, self.theory)


def eigenspace(
    problem: Characteristic, eigenvalue: float, size: int, free: bool
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return platform (size, 6), tip motion and tip forces (size, n, 3) of unit modal mass.

    The modes are B's null vectors (of the static stiffness for `free` motion); their modal mass
    is U^T M_p U - sum d_k'(lambda) w_k^2.
    """
    lam = np.array([eigenvalue])
    B, stiff, d = problem.bordered(lam)
    if free:
        stiff = np.zeros_like(stiff)
        held = problem.scale * [0.0, 1.0, 1.0]  # a pin does not resist
        B = np.zeros_like(B)
        B[0, :6, :6] = np.einsum("ik,ika,ikb->ab", held, problem.vectors, problem.vectors)
        B[0, 6:, 6:] = np.eye(B.shape[1] - 6) * held.max()
    values, vectors = np.linalg.eigh(B[0])
    x = vectors[:, np.argsort(np.abs(values))[:size]].T
    U = x[:, :6] / np.sqrt(eigenvalue)
    w = (U @ problem.vectors.reshape(-1, 6).T).reshape(size, -1, 3)
    # The unknown of a stiff direction is its force, of which 1 / d_k makes a motion near zero.
    forces = x[:, 6:].reshape(w.shape) * np.sqrt(problem.scale)
    forces = np.where(stiff[0], forces, d[0] * w)
    w = np.where(stiff[0], forces / d[0], w)
    slope = problem.slope(lam)
    # Of a stiff direction by its force: -d' w^2 = -(d' / d^2) F^2.
    mass = np.where(stiff, -slope / d**2, -slope)[0]
    share = np.where(stiff[0], forces, w)
    gram = U @ U.T + np.einsum("aik,ik,bik->ab", share, mass, share)
    root = np.linalg.cholesky(gram)
    U, w, forces = (
        np.linalg.solve(root, y.reshape(size, -1)).reshape(y.shape) for y in (U, w, forces)
    )
    return U, w, forces


def _centre_lines(
    problem: Characteristic,
    limbs: Limbs,
    eigenvalue: float,
    w: NDArray[np.float64],
    forces: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Return global displacement at `STATIONS`, shape (m, n, 11, 3), from tips' w and forces.

    A limb's motion between is known up to a factor, taken from w and F together: at a fixed-tip
    mode w is zero, at a free-tip mode F is.
    """
    rods, lengths = problem.rods, problem.lengths
    waves = bending_waves(rods, lengths, np.full(len(lengths), eigenvalue), None)
    local = np.zeros((*w.shape[:2], len(STATIONS), 3))
    for i, length in enumerate(lengths):
        k = np.sqrt(waves.K[:, i] + 0j)
        x = STATIONS[:, None] * length
        # Of each wave one part decays from the base and one from the tip: nothing overflows.
        line = np.concatenate([np.exp(-k * x), np.exp(-k * (length - x))], axis=1)
        sign = np.r_[-1.0, -1.0, 1.0, 1.0]
        theta = sign * np.tile(waves.n[:, i] * k, 2)
        force = sign * np.tile(waves.f[:, i] * k, 2)
        moment = np.tile(waves.h[:, i], 2)
        for direction, base in ((0, line[0] * moment), (1, line[0] * theta)):
            conditions = np.stack([line[0], base, line[-1] * moment])
            conditions /= np.linalg.norm(conditions, axis=1, keepdims=True)
            amplitude = np.linalg.svd(conditions)[2][-1].conj()
            tip = np.array([line[-1] @ amplitude, line[-1] * force @ amplitude])
            factor = _factor(tip, w[:, i, direction], forces[:, i, direction], problem.scale[i, 0])
            local[:, i, :, direction] = np.outer(factor, line @ amplitude).real
        k_z = np.sqrt(eigenvalue / rods.axial_speed2[i])
        tip = np.array([np.sin(k_z * length), rods.EA[i] * k_z * np.cos(k_z * length)])
        factor = _factor(tip, w[:, i, 2], forces[:, i, 2], problem.scale[i, 2])
        local[:, i, :, 2] = np.outer(factor, np.sin(k_z * STATIONS * length)).real
    return np.asarray(np.einsum("ixk,misk->misx", limbs.frames, local))


def _factor(
    tip: NDArray[np.complex128],
    w: NDArray[np.float64],
    force: NDArray[np.float64],
    scale: float,
) -> NDArray[np.complex128]:
    """Return the least-squares factor of a solution whose tip has (w, F) = `tip`, shape (m,)."""
    weighted = tip * [scale, 1.0]
    target = np.stack([w * scale, force], axis=-1)
    return np.asarray(target @ weighted.conj() / (np.abs(weighted) ** 2).sum())
