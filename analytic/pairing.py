"""Which mode is which: the modal assurance criterion, with repeated modes as subspaces."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy
from numpy.typing import NDArray

from analytic.mechanism import Mechanism
from analytic.modes import STATIONS, Modes
from analytic.placed import station_masses
from analytic.pose import Pose
from analytic.substructure import platform_mass

REPEATED = 1e-3
"""Modes closer than this, relative, are compared as one subspace: a mesh may turn them within it
(the paper's own finite elements split f1 = f2 of case 1 by 1e-4)."""
EXACTLY = 1e-6
"""Modes closer than this are one mode twice: which shape is which is chance."""
TRUSTED = 0.8
"""Below this assurance a pair is reported as doubtful."""


@dataclass(frozen=True)
class Pairing:
    """For each mode of the first model its partner in the second.

    Attributes:
        partner: index of the partner, shape (m,).
        assurance: the pair's assurance criterion, 0..1, shape (m,).
        matrix: assurance of every mode of the first against every one of the second, (m, k).
        reordered: where pairing by shape disagrees with pairing by order, shape (m,); not within
            a repeated group, where order means nothing.
    """

    partner: NDArray[np.intp]
    assurance: NDArray[np.float64]
    matrix: NDArray[np.float64]
    reordered: NDArray[np.bool_]

    @property
    def doubtful(self) -> NDArray[np.bool_]:
        """Where no mode of the second model looks like this one, shape (m,)."""
        return self.assurance < TRUSTED


def pair(first: Modes, second: Modes, mechanism: Mechanism, pose: Pose) -> Pairing:
    """Pair modes by shape: the assignment of largest total assurance.

    The second model needs at least as many modes as the first; a mode more lets a pair that
    crosses the end of the list be found. Close modes of one subspace go by their own shapes,
    exactly repeated ones by ascending frequency.
    """
    a, b = (mass_vectors(modes, mechanism, pose) for modes in (first, second))
    # Either model may be the one whose modes repeat.
    matrix = np.maximum(assurance(a, b, second.frequencies), assurance(b, a, first.frequencies).T)
    rank = np.arange(matrix.shape[0])[:, None] - np.arange(matrix.shape[1])
    own = np.maximum(
        assurance(a, b, second.frequencies, EXACTLY),
        assurance(b, a, first.frequencies, EXACTLY).T,
    )
    _, partner = scipy.optimize.linear_sum_assignment(
        matrix + 1e-3 * own - 1e-9 * rank**2, maximize=True
    )
    f = second.frequencies
    order = np.arange(len(partner))
    reordered = np.abs(f[partner] - f[order]) > REPEATED * np.abs(f[order])
    return Pairing(partner, matrix[order, partner], matrix, reordered)


def assurance(
    a: NDArray[np.float64],
    b: NDArray[np.float64],
    frequencies: NDArray[np.float64],
    within: float = REPEATED,
) -> NDArray[np.float64]:
    """Return (a_i . b_j)^2 / (a_i . a_i) (b_j . b_j), shape (m, k), for a (m, N) and b (k, N).

    Where `frequencies` (k,) of b repeat, b_j is the whole subspace: |projection of a_i|^2. Modes
    that do not move the centre lines (torsion of a limb) have assurance 1 with each other and 0
    with all else.
    """
    still_a, still_b = (np.linalg.norm(v, axis=1) < 1e-3 for v in (a, b))
    unit = a / np.maximum(np.linalg.norm(a, axis=1, keepdims=True), 1e-300)
    result = np.empty((len(a), len(b)))
    for group in repeated(frequencies, within):
        basis, singular, _ = np.linalg.svd(b[group].T, full_matrices=False)
        basis = basis[:, singular > 1e-6 * max(singular[0], 1e-300)]
        result[:, group] = ((unit @ basis) ** 2).sum(axis=1)[:, None]
    result[still_a] = 0.0
    result[:, still_b] = 0.0
    result[np.ix_(still_a, still_b)] = 1.0
    return result


def repeated(frequencies: NDArray[np.float64], within: float = REPEATED) -> list[slice]:
    """Return slices of ascending `frequencies` that lie `within`, relative, of their neighbour."""
    breaks = np.flatnonzero(np.diff(frequencies) > within * np.abs(frequencies[1:])) + 1
    edges = [0, *breaks.tolist(), len(frequencies)]
    return [slice(start, stop) for start, stop in pairwise(edges)]


def mass_vectors(modes: Modes, mechanism: Mechanism, pose: Pose) -> NDArray[np.float64]:
    """Return shapes (m, N) whose dot product is the centre lines' and platform's mass product.

    Simpson's rule over the stations with the rods' mass, bodies at the nearest, and M_p of Eq. (7)
    for the platform.
    """
    simpson = np.ones(len(STATIONS))
    simpson[1:-1:2], simpson[2:-1:2] = 4, 2
    simpson /= simpson.sum()
    mass = station_masses(mechanism, pose, simpson)
    weighted = modes.limbs * np.sqrt(mass)[..., None]
    platform = modes.platform @ np.linalg.cholesky(platform_mass(mechanism, pose))
    return np.concatenate([platform, weighted.reshape(len(modes.frequencies), -1)], axis=1)
