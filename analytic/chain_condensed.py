"""Frequencies of limbs of any chain at many poses a call."""

import numpy as np
from numpy.typing import NDArray

from analytic import chain_models
from analytic.chain_cores import Beside, Joined, cores
from analytic.chain_reduced import ChainReduced, chain_reduced
from analytic.core_tables import Table, table
from analytic.exact_chain import exact
from analytic.limb_core import Core
from analytic.mechanism import Mechanism
from analytic.placed import place
from analytic.pose import Pose
from analytic.roots import solve
from analytic.theory import Theory

Floats = NDArray[np.float64]

FEW, FEWER = 20, 5
"""Poses a core up to which none is worth its table; and where a pose alone costs more."""
LIGHT = 16
"""Elements a rod up to which a pose alone costs a few hundredths of a second at most."""
SAMPLES = 4
"""Poses whose frequencies say how far tables are to reach."""
CHUNK = 250
"""Poses solved at once: what fits into the processor's cache."""
HEADROOM = 1.5
"""Omega^2 up to which tables reach, over that of the samples' last mode."""
GRID = 1.25
"""Tables reach to powers of this, so that neighbouring calls share them."""
BEYOND = 0.02
"""Part of a length by which tables go beyond those of the samples."""
LEVELS = 3
"""How often the reach is doubled before poses are left to the exact problem."""
POLES = 120
"""Poles of all limbs with which bisection pose by pose is no slower."""


def condensed(
    mechanism: Mechanism, poses: Pose, theory: Theory, elements: int | None, count: int
) -> Floats:
    """Return the `count` lowest frequencies [Hz] at every pose, (*poses.shape, count).

    As `condensed.condensed_frequencies`. Few poses, and those that tables cannot answer for
    certain, are solved one by one, by `Continuum`'s bisection or from the elements' matrices.
    """
    flat = poses.ravel()
    few = FEW if elements is not None and elements <= LIGHT else FEWER
    made = _Tables(mechanism, flat, theory, elements, count) if len(flat) > few else None
    if made is None or len(flat) <= few * len(made.reach):
        return chain_models.frequencies(mechanism, poses, theory, elements, count)
    found = np.full((len(flat), count), np.nan)
    for first in range(0, len(flat), CHUNK):
        which = np.arange(first, min(first + CHUNK, len(flat)))
        for level in range(LEVELS):
            omega2, good = made.solved(flat[which], level)
            found[which[good]] = np.sqrt(omega2[good]) / (2 * np.pi)
            which = which[~good]
            if not which.size:
                break
        else:
            found[which] = chain_models.frequencies(mechanism, flat[which], theory, elements, count)
    return found.reshape(*poses.shape, count)


class _Tables:
    """The tables of one call, widened as its poses need."""

    def __init__(
        self,
        mechanism: Mechanism,
        poses: Pose,
        theory: Theory,
        elements: int | None,
        count: int,
    ) -> None:
        self.mechanism, self.theory, self.elements, self.count = mechanism, theory, elements, count
        self.known: dict[tuple[Core, int], Table | None] = {}
        self.spans: dict[Core, tuple[float, float]] = {}
        self.reach: dict[Core, float] = {}
        every = max(1, len(poses) // CHUNK)
        some = poses[::every]
        last = np.array([
            exact(mechanism, pose, theory).upper(count)[-1]
            for pose in some[:: max(1, len(some) // SAMPLES)]
        ])  # fmt: skip
        built = self._cores(some)
        if built is None:
            return
        softest = _softest(built[0])
        share = HEADROOM * float((last / softest[:: max(1, len(some) // SAMPLES)]).max())
        for one in built[0]:
            pinned = one.core.pinned(one.adapting)
            least = share * float((softest[:, None] / pinned).max())
            self.reach[one.core] = GRID ** np.ceil(np.log(least) / np.log(GRID))
            self._widen(one)

    def _cores(self, poses: Pose) -> tuple[list[Joined], Beside] | None:
        turn = np.zeros((len(poses), 6, 6))
        turn[:, :3, :3] = turn[:, 3:, 3:] = poses.rotation
        mass = turn @ self.mechanism.platform.mass_matrix @ turn.swapaxes(1, 2)
        return cores(place(self.mechanism, poses), mass, self.elements, self.theory)

    def _widen(self, one: Joined) -> None:
        low, high = float(one.adapting.min()), float(one.adapting.max())
        if one.core not in self.spans:
            low, high = low * (1 - BEYOND), high * (1 + BEYOND)
        before = self.spans.get(one.core, (low, high))
        if one.core not in self.spans or low < before[0] or high > before[1]:
            self.spans[one.core] = min(low, before[0]), max(high, before[1])
            self.known = {key: value for key, value in self.known.items() if key[0] != one.core}

    def _table(self, one: Joined, level: int) -> Table | None:
        self._widen(one)
        key = one.core, level
        if key not in self.known:
            reach = self.reach.setdefault(one.core, max(self.reach.values()))
            self.known[key] = table(one.core, *self.spans[one.core], reach * 2.0**level)
        return self.known[key]

    def solved(self, poses: Pose, level: int) -> tuple[Floats, NDArray[np.bool_]]:
        """Return omega^2 (N, count) and where they are certain to be the lowest, (N,)."""
        nothing = np.zeros((len(poses), self.count)), np.zeros(len(poses), dtype=bool)
        built = self._cores(poses) if self.reach else None
        if built is None:
            return nothing
        found = [self._table(one, level) for one in built[0]]
        tables = [one for one in found if one is not None]
        if len(tables) < len(found):
            return nothing
        problem, alone = chain_reduced(*built, tables)
        size = problem.mass.shape[1] + problem.poles.shape[1]
        if size < self.count or problem.poles.shape[1] > POLES:
            return nothing
        return _lowest(problem, alone, self.count)


def _lowest(problem: ChainReduced, alone: Floats, count: int) -> tuple[Floats, NDArray[np.bool_]]:
    N = len(alone)
    omega2, good = np.full((N, count), np.inf), np.ones(N, dtype=bool)
    try:
        omega2, good = solve(problem, count, None)
    except np.linalg.LinAlgError:
        # Something without mass, which is loose: not where all moves.
        good = problem.moving()
        if good.any():
            omega2[good], good[good] = solve(problem[good], count, None)
    return np.sort(np.concatenate([omega2, alone], axis=1), axis=1)[:, :count], good


def _softest(joined: list[Joined]) -> Floats:
    """Return the softest limb's omega^2 at every pose, (N,), as of `Core.pinned`."""
    return np.asarray(np.min([one.core.pinned(one.adapting).min(axis=1) for one in joined], axis=0))
