"""What a model owes the theory that it declares: the exact limit's modes, none missing or made up.

The number of modes below a frequency is Wittrick and Williams' count of the exact limit. A mode
that a model misses, has twice or makes up shifts its own number there; so does a wrong unit.
"""

import numpy as np
from numpy.typing import NDArray

from analytic import Mechanism, Modes, Pose, limbs_at
from analytic.model import Info
from reference_models import ModelError

Array = NDArray[np.float64]
SPARE = 4
"""Further modes of the theory, for what a model has in the place of those it misses."""
CLEAR = 4
"""Neighbours further apart than this many deviations are told apart."""
REPEATED = 1e-6
"""Relative distance below which neighbours are one repeated mode."""
SAME = 1e-6
"""Largest relative difference of a model without elements from the exact limit."""
COARSE = 2.0
"""Largest factor by which the coarsest mesh misses the lowest frequency."""
TRUSTED = 20.0
"""An extrapolated frequency is at most so many times the largest uncertainty from its limit."""


def torsion(mechanism: Mechanism, pose: Pose) -> Array:
    """Return the lowest frequency of each limb that twists alone, shape (n,) [Hz].

    f = sqrt(G / rho) / 4 L of a rod fixed at B_i and free at A_i; the next are 3, 5 ... times it.
    """
    lengths = limbs_at(mechanism, pose).lengths
    materials = [limb.rod.material for limb in mechanism.limbs]
    speed = np.array([np.sqrt(m.shear / m.density) for m in materials])
    return np.asarray(speed / (4 * lengths))


def asked(mechanism: Mechanism, info: Info, count: int) -> int:
    """Return how many modes of the limit it takes to compare `count` of a model."""
    return count + 1 + SPARE + (0 if info.torsion else len(mechanism.limbs))


def keeps(
    modes: Modes,
    info: Info,
    elements: int | tuple[int, int] | None,
    exact: Array,
    mechanism: Mechanism,
    pose: Pose,
) -> None:
    """Raise `ModelError` where `modes` cannot be of the theory whose `exact` frequencies [Hz] are.

    `exact` ascend and are `asked` of many, shape (k,). Without elements the two are equal; with two
    numbers of elements they differ by the uncertainty; one mesh may miss them by a lot, but its
    lowest frequency not by a factor of two, and no mode may be missing or made up where the
    distance of its neighbours tells.
    """
    if not info.torsion:
        first = torsion(mechanism, pose)
        odd = np.arange(1, 2 + exact[-1] / first.min(), 2)
        twists = np.sort(np.outer(first, odd).ravel())
        exact = _without(exact, twists[twists <= exact[-1] * (1 + REPEATED)])
    found = modes.frequencies
    number = min(len(found), len(exact))
    smallest = exact[exact > 0].min(initial=np.inf)
    off = np.abs(found[:number] - exact[:number]) / np.maximum(exact[:number], smallest)
    moving = np.flatnonzero(exact[:number] > 0)
    if moving.size and not 1 / COARSE <= found[moving[0]] / exact[moving[0]] <= COARSE:
        raise _miss(moving[0], found, exact)
    if elements is None and (off > SAME).any():
        raise _miss(int(off.argmax()), found, exact)
    wrong = _miscounted(found, exact)
    if wrong is not None:
        raise ModelError(wrong)
    if isinstance(elements, tuple) and modes.uncertainty is not None:
        known = modes.uncertainty[:number] / np.maximum(exact[:number], smallest)
        if (off > TRUSTED * known.max() + SAME).any():
            raise _miss(int(off.argmax()), found, exact)


def _miss(i: int, found: Array, exact: Array) -> ModelError:
    return ModelError(
        f"its f{i + 1} is {found[i]:.6g} Hz, which is not of the theory that it declares: exact is "
        f"{exact[i]:.6g} Hz"
    )


def _without(frequencies: Array, left_out: Array) -> Array:
    """Return `frequencies` without the one nearest to each of `left_out`."""
    kept = frequencies
    for f in left_out:
        kept = np.delete(kept, np.abs(kept - f).argmin())
    return kept


def _miscounted(found: Array, exact: Array) -> str | None:
    """Say where `found` has more or fewer modes below a gap of `exact`, or None.

    A gap is left out where it is not `CLEAR` of how far the frequencies next to its ends are from
    these, or of what is usual: a mode without a partner does not excuse itself.
    """
    away = np.abs(found[:, None] - exact)
    partner = away.argmin(axis=1)
    scale = np.maximum(exact, exact[exact > 0].min(initial=np.inf))
    nearest = partner[:, None] == np.arange(len(exact))
    number = min(len(found) + 1, len(exact))
    usual = float(np.median(away.min(axis=1) / scale[partner]))
    deviation = np.maximum(np.where(nearest, away, 0.0).max(axis=0), usual * scale)[:number]
    gap = np.diff(exact[:number])
    clear = gap > CLEAR * np.maximum(deviation[1:], deviation[:-1])
    clear &= gap > REPEATED * exact[1:number]
    middle = (exact[1:number] + exact[: number - 1]) / 2
    below = (found[:, None] < middle).sum(axis=0)
    wrong = np.flatnonzero(clear & (below != np.arange(1, number)))
    if not wrong.size:
        return None
    i = int(wrong[0])
    return (
        f"it has {below[i]} modes below {middle[i]:.6g} Hz, where its theory has {i + 1}: a mode "
        f"is {'missing' if below[i] <= i else 'made up'}"
    )
