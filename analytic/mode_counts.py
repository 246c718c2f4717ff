"""How many modes lie below a frequency, at thousands of poses a call."""

import numpy as np
from numpy.typing import NDArray

from analytic.mechanism import Mechanism
from analytic.pose import Pose, check_poses
from analytic.reduced import constants, geometry
from analytic.theory import Theory
from analytic.wittrick_williams import Characteristic

CHUNK = 1000
"""Counts made at once: what fits into the processor's cache."""


def mode_counts(
    mechanism: Mechanism,
    poses: Pose,
    frequencies: NDArray[np.float64],
    elements: int | None = None,
    *,
    beam: str = "euler-bernoulli",
    shear: str | float = "cowper",
    torsion: bool = True,
) -> NDArray[np.int64]:
    """Return how many modes lie below `frequencies` (N, q) [Hz] at N `poses`, shape (N, q).

    By Wittrick and Williams (1971), as `Continuum.count_below`: the exact stiffness of the limbs,
    no frequency computed. `torsion`: with the limbs' own, which is coupled to nothing; `elements`,
    `beam` and `shear` as for `condensed_frequencies`. Raises `InputError` for a pose out of reach.
    """
    check_poses(mechanism, poses)
    known = constants(mechanism, Theory(beam, shear))
    lengths, vectors = geometry(known, mechanism, poses)
    n = lengths.shape[1]
    pose_of = np.repeat(np.arange(len(lengths)), frequencies.shape[1])
    squares = (2 * np.pi * frequencies.ravel()) ** 2
    found = np.empty(len(squares), dtype=np.int64)
    for first in range(0, len(squares), CHUNK):
        some = slice(first, first + CHUNK)
        of = pose_of[some]
        problem = Characteristic(
            known.rods, lengths[of], vectors[of].reshape(-1, n, 3, 6), elements
        )
        found[some] = (problem.count if torsion else problem.coupled_count)(squares[some])
    return found.reshape(frequencies.shape)
