"""The model without elements: exact limbs, certified frequencies, mode shapes."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analytic.centre_lines import centre_lines
from analytic.certified import WIDTH, brackets, certified, coupled, middles, with_torsion
from analytic.chain_models import exact_modes
from analytic.condensed import condensed_frequencies, tabulated
from analytic.errors import NotCertifiedError, number
from analytic.exact_chain import exact
from analytic.kinematics import limbs_at
from analytic.mechanism import Mechanism
from analytic.model import Info
from analytic.modes import STATIONS, Modes, check_count
from analytic.pose import Pose, one_pose
from analytic.reduced import Constants, constants
from analytic.theory import OfTheory
from analytic.wittrick_williams import Characteristic, Floats, characteristic, of_limbs

MOST = 10_000
"""Most modes that are asked for at once."""
REPEATED = 1e-9
"""Modes whose omega^2 are closer than this, relative, share one eigenspace."""


@dataclass(frozen=True)
class Continuum(OfTheory):
    """Every limb a continuous beam: the limit s -> infinity of `Substructure`.

    `beam` and `shear` choose the theory (see `Theory`). Raises `InputError` for unknown names.
    """

    beam: str = "euler-bernoulli"
    shear: str | float = "cowper"

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
        omega2 = np.array([(2 * np.pi * hertz) ** 2])
        if not one_pose(mechanism, pose).shape and not mechanism.simple:
            return int(exact(mechanism, pose, self.theory).count(omega2)[0])
        problem = self._problem(mechanism, pose)
        return int(problem.count(omega2)[0])

    def brackets(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> NDArray[np.float64]:
        """Return lower and upper bounds of the lowest `count` frequencies, (count, 2) [Hz].

        Fewer than k modes lie below the k-th lower bound, at least k below the upper one: both are
        counted, with a margin for rounding. They are 1e-12 apart, relative, or as far as rounding
        demands, at most 1e-9. A free motion has (0, upper). Raises `NotCertifiedError` for a
        frequency that double precision cannot tell so well.
        """
        count = check_count(count, MOST)
        if not one_pose(mechanism, pose).shape and not mechanism.simple:
            return np.sqrt(exact(mechanism, pose, self.theory).brackets(count)) / (2 * np.pi)
        return np.sqrt(brackets(self._problem(mechanism, pose), count)[0]) / (2 * np.pi)

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        """Return the `count` lowest modes at one pose, each frequency the middle of its bracket.

        A free motion is 0 Hz. Raises `InputError` for a pose out of reach, `NotCertifiedError` as
        `brackets` does.
        """
        begin = time.perf_counter()
        count = check_count(count, MOST)
        if not one_pose(mechanism, pose).shape and not mechanism.simple:
            return exact_modes(mechanism, pose, self.theory, count)
        limbs = limbs_at(mechanism, one_pose(mechanism, pose))
        known = constants(mechanism, self.theory)
        problem = of_limbs(known, limbs)
        built = time.perf_counter()
        bounds, shapes = _solved(problem, known, count)
        bounds, twisting = with_torsion(problem, bounds)
        platform = np.zeros((count, 6))
        motion = np.zeros((count, len(mechanism.limbs), len(STATIONS), 3))
        # A limb that twists moves neither its centre line nor the platform.
        others = np.flatnonzero(twisting < 0)
        if others.size:
            at, U, w, force = (of_all[: len(others)] for of_all in shapes)
            U = U @ known.unit.T
            platform[others] = (U.reshape(-1, 2, 3) @ limbs.rotation.T).reshape(-1, 6)
            motion[others] = centre_lines(problem, at, w, force) @ limbs.frames.swapaxes(-1, -2)
        return Modes(
            frequencies=np.sqrt(middles(bounds)) / (2 * np.pi),
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
        return characteristic(mechanism, one_pose(mechanism, pose), self.theory)


class HasLimit(OfTheory):
    """A model of a beam theory, which the exact one of the same theory tells the truth of."""

    def limit(self) -> Continuum:
        """Return the exact model of the same theory."""
        return Continuum(self.beam, self.shear)


def _solved(
    problem: Characteristic, known: Constants, count: int
) -> tuple[Floats, tuple[Floats, ...]]:
    """Return brackets of the lowest modes that are not torsion (count, 2), and their `_shapes`."""
    flat = problem.lengths[None], problem.vectors.reshape(1, -1, 6)
    near, unknown = tabulated(known, *flat, None, count)
    if not unknown.size:
        # Tables say where the modes are, and the counts whether they are there.
        roots, *shapes = _shapes(problem, np.sort(near[0]))
        try:
            return certified(problem, np.arange(count), roots), tuple(shapes)
        except NotCertifiedError:
            pass  # searched for without them
    bounds = coupled(problem, count)
    return bounds, _shapes(problem, bounds.mean(axis=1))[1:]


def _shapes(problem: Characteristic, omega2: Floats) -> tuple[Floats, ...]:
    """Return the modes next to `omega2` (m,), ascending: roots, where, and as of `eigenspace`."""
    groups = repeated(omega2, np.arange(len(omega2)))
    at, sizes = np.array([omega2[k].mean() for k in groups]), np.array([*map(len, groups)])
    spaces = zip(*problem.eigenspace(at, sizes), strict=True)
    roots, *shapes = (np.concatenate(parts) for parts in spaces)
    return roots, np.repeat(at, sizes), *shapes


def repeated(omega2: NDArray[np.float64], modes: NDArray[np.intp]) -> list[NDArray[np.intp]]:
    """Return `modes` in groups of those whose `omega2`, ascending, repeat."""
    own = omega2[modes]
    return np.split(modes, np.flatnonzero(np.diff(own) > REPEATED * own[1:]) + 1)
