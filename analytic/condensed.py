"""Natural frequencies of thousands of poses a call, at a cost that no element count enters."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from analytic import certified, chain_condensed, single
from analytic.dynamic_stiffness import torsion_eigenvalues
from analytic.errors import InputError
from analytic.errors import count as whole
from analytic.kernel import compiled
from analytic.kinematics import limbs_at
from analytic.mechanism import Mechanism
from analytic.modes import check_count
from analytic.pose import Pose, check_poses
from analytic.reduced import Constants, Floats, constants, first_level, geometry, reduced
from analytic.roots import Loop, solve
from analytic.theory import Theory
from analytic.wittrick_williams import Characteristic

CHUNK = 700
"""Poses solved at once: what fits into the processor's cache, twice as many where a compiled loop
has few arrays of all of them."""
WORTHWHILE = 200_000
"""Poses from which on the compiled loop repays the seconds that it takes to load."""
MOST_ELEMENTS = 1_000_000
"""Elements a limb whose dispersion relation is still told from rounding."""
MOST_POLES = 12
"""Bending modes of each kind a limb in a table: for more, bisection is quicker, and more than 30
are beyond the tables' range."""
LEVELS = 6
"""Most limb modes a bending direction before a pose is left to certified bisection."""


def condensed_frequencies(
    mechanism: Mechanism,
    poses: Pose,
    elements: int | None = None,
    *,
    beam: str = "euler-bernoulli",
    shear: str | float = "cowper",
    count: int = 6,
    torsion: bool = True,
    fast: bool | None = None,
) -> NDArray[np.float64]:
    """Return the `count` lowest frequencies [Hz] at every pose, shape (*poses.shape, count).

    Those of `Substructure(elements, beam, shear)`, or of `Continuum(beam, shear)` where `elements`
    is None, to 1e-9. Every pose is checked by the Wittrick-Williams count of the exact limbs; one
    that fails is solved by certified bisection. Memory does not grow with the number of poses.
    Limbs of any chain have tables too (`chain_condensed`), where poses are enough to repay them;
    their other poses are solved one by one, as `Continuum` or `Substructure` do.
    `torsion`: with the modes of torsion of the paper's limbs, which are coupled to nothing.
    `fast`: use the compiled loop (numba, the extra `fast`), which takes seconds to load and then
    half the time a pose; by default where it is installed and the poses are enough to repay that.
    Raises `InputError` for a pose out of reach, more modes than the model has, or `fast` without
    numba.
    """
    theory = Theory(beam, shear)
    check_poses(mechanism, poses)
    available = 10_000
    if elements is not None:
        elements = whole("elements", elements, at_most=MOST_ELEMENTS)
        available = 6 + sum(len(limb.rods) for limb in mechanism.limbs) * (
            (5 + torsion) * elements - 2
        )
    count = check_count(count, available)
    if not mechanism.simple:
        return chain_condensed.condensed(mechanism, poses, theory, elements, count)
    known = constants(mechanism, theory)
    size = math.prod(poses.shape)
    loop = _loop(size, fast)
    if loop is None and not poses.shape:
        limbs = limbs_at(mechanism, poses)
        alone = single.lowest(known, limbs, elements, count, torsion=torsion)
        if alone is not None:
            return np.sqrt(alone) / (2 * np.pi)
    result = _in_chunks(known, mechanism, poses.ravel(), elements, count, loop, torsion)
    result.sort(axis=1)  # of repeated modes, the order is rounding's
    return np.asarray(np.sqrt(np.maximum(result, 0)) / (2 * np.pi)).reshape(*poses.shape, count)


def _in_chunks(
    known: Constants,
    mechanism: Mechanism,
    poses: Pose,
    elements: int | None,
    count: int,
    loop: Loop | None,
    torsion: bool,
) -> Floats:
    """Return the lowest omega^2 (N, count) of poses in a row, chunk by chunk.

    The few that one step of each chunk leaves open are put together and solved at the end: in
    steps of numpy, a few poses of every chunk would cost as much as all of the chunk.
    """
    N, n = len(poses), len(mechanism.limbs)
    size = CHUNK if loop is None else 2 * CHUNK
    coupled = _coupled(count, elements, n)
    result, lengths = np.empty((N, count)), np.empty((N, n))
    left = [np.arange(0)]
    for first in range(0, N, size):
        rows = slice(first, first + size)
        lengths[rows], vectors = geometry(known, mechanism, poses[rows])
        values, unsure = tabulated(
            known, lengths[rows], vectors, elements, coupled, loop, levels=1, quick=True
        )
        left.append(first + unsure)
        values[unsure] = 0.0
        result[rows] = _twisted(known, lengths[rows], values, elements, count, torsion)
    again = np.concatenate(left)
    for first in range(0, len(again), size):
        some = again[first : first + size]
        problem = geometry(known, mechanism, poses[some])
        result[some] = lowest(known, *problem, elements, count, loop, lengths, torsion=torsion)
    return result


def _loop(size: int, fast: bool | None) -> Loop | None:
    """Return the compiled loop where it is asked for, or worth its loading."""
    if fast is False or (fast is None and size < WORTHWHILE):
        return None
    loop = compiled()
    if loop is None and fast:
        raise InputError("fast", fast, "numba to be installed: pip install numba")
    return loop


def lowest(
    known: Constants,
    lengths: Floats,
    vectors: Floats,
    elements: int | None,
    count: int,
    loop: Loop | None = None,
    span: Floats | None = None,
    levels: int = LEVELS,
    torsion: bool = True,
) -> Floats:
    """Return the lowest omega^2 (N, count) of few poses, `torsion` of the limbs among them or not.

    `lengths` (N, n) and `vectors` (N, 3 n, 6) as of `geometry`; tables hold over `span`, by default
    over `lengths`. After so many `levels` of tables certified bisection takes over.
    """
    n = lengths.shape[1]
    coupled = _coupled(count, elements, n)
    values, left = tabulated(known, lengths, vectors, elements, coupled, loop, span, levels)
    for i in left:
        one = Characteristic(known.rods, lengths[i], vectors[i].reshape(n, 3, 6), elements)
        values[i] = certified.middles(certified.coupled(one, coupled))
    return _twisted(known, lengths, values, elements, count, torsion)


def _coupled(count: int, elements: int | None, limbs: int) -> int:
    """Return how many of `count` modes are to be found that are not torsion of limbs."""
    return count if elements is None else min(count, 6 + limbs * (5 * elements - 2))


def _twisted(
    known: Constants,
    lengths: Floats,
    values: Floats,
    elements: int | None,
    count: int,
    torsion: bool,
) -> Floats:
    """Return the lowest of `values` and, with `torsion`, of the limbs' modes of it, (N, count)."""
    if not torsion:
        return values
    twist = torsion_eigenvalues(known.rods, lengths, 1, elements)[..., 0]
    if values.shape[1] == count and twist.min() > values.max():
        return values
    twist = torsion_eigenvalues(known.rods, lengths, count, elements).reshape(len(lengths), -1)
    return np.sort(np.concatenate([values, twist], axis=1), axis=1)[:, :count]


def tabulated(
    known: Constants,
    lengths: Floats,
    vectors: Floats,
    elements: int | None,
    count: int,
    loop: Loop | None = None,
    span: Floats | None = None,
    levels: int = LEVELS,
    quick: bool = False,
) -> tuple[Floats, NDArray[np.intp]]:
    """Return the lowest omega^2 (N, count), torsion apart, and the poses that tables cannot answer.

    Arguments as of `lowest` and `solve`; the values of those poses are infinite.
    """
    values = np.full((len(lengths), count), np.inf)
    left = np.arange(len(lengths))
    level = first_level(count, lengths.shape[1])
    for more in range(min(levels, MOST_POLES - level)):
        own = (lengths[left], vectors[left]) if more else (lengths, vectors)
        problem = reduced(known, *own, elements, level + more, span)
        if problem is None:
            break
        if 6 + problem.poles.shape[1] < count:
            continue
        found, good = solve(problem, count, loop, quick)
        values[left[good]] = found[good]
        left = left[~good]
        if not left.size:
            break
    return values, left
