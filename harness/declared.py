"""What a model owes the theory that it declares: the exact limit's modes, none missing or made up.

The exact limit says how many modes lie below a frequency: Wittrick and Williams' count. A mode that
a model misses, has twice or makes up shifts its own number there; so does a wrong unit.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from analytic import Mechanism, Modes, Pose, limbs_at
from analytic.chain_models import held_modes
from analytic.model import Info
from analytic.pairing import mass_vectors, pair
from analytic.theory import Theory
from harness.signatures import Array
from reference_models import ModelError

SPARE = 2
"""Further modes of the theory, for what a model has in the place of those it misses."""
STILL = 1e-3
"""Below this root of a modal mass a mode moves neither line nor platform: a limb moves alone."""
CLEAR = 4
"""Neighbours further apart than this many deviations are told apart."""
REPEATED = 1e-6
"""Relative distance below which neighbours are one repeated mode."""
EXCHANGED = 1e-2
"""Relative distance of neighbours whose shapes a coarse mesh may mix."""
SAME = 1e-6
"""Largest relative difference of a model without elements from the exact limit."""
COARSE = 2.0
"""Largest factor by which the coarsest mesh misses the lowest frequency."""
PARTS = 4
"""Elements a rod by which limbs' own motions are found: torsion by half a per cent."""
TRUSTED = 20.0
"""An extrapolated frequency is at most so many times the largest uncertainty from its limit."""


def alone(mechanism: Mechanism, pose: Pose, below: float) -> float:
    """Return the lowest frequency at which a limb moves and neither its line nor the platform [Hz].

    Of the paper's limbs a rod that twists, fixed at B_i and free at A_i, f = sqrt(G / rho) / 4 L.
    Elsewhere bodies turn on springs too: the lowest such mode of limbs whose platform is held.
    Infinity where there is none `below` a frequency [Hz].
    """
    if mechanism.simple:
        lengths = limbs_at(mechanism, pose).lengths
        of = [limb.rod.material for limb in mechanism.limbs]
        speeds = np.array([np.sqrt(material.shear / material.density) for material in of])
        return float((speeds / (4 * lengths)).min())
    held = held_modes(mechanism, pose, Theory("timoshenko", "cowper"), PARTS, below)
    if held is None:
        return np.inf
    size = np.linalg.norm(mass_vectors(held, mechanism, pose), axis=1)
    return float(held.frequencies[size < 10 * STILL].min(initial=np.inf))


def asked(mechanism: Mechanism, count: int) -> int:
    """Return how many modes of the limit it takes to compare `count` of a model.

    A model whose rods do not twist has others in the place of one a limb.
    """
    return available(mechanism, count + SPARE + len(mechanism.limbs))


def available(mechanism: Mechanism, count: int) -> int:
    """Return `count`, or the 6 modes that there are where no limb has a rod."""
    return count if any(limb.rods for limb in mechanism.limbs) else min(count, 6)


def keeps(
    modes: Modes,
    info: Info,
    elements: int | tuple[int, int] | None,
    exact: Modes,
    mechanism: Mechanism,
    pose: Pose,
) -> None:
    """Raise `ModelError` where `modes` cannot be of the theory whose `exact` modes these are.

    Of the latter there are as many as `asked`. Without elements the two are equal; with two numbers
    of elements they differ by the uncertainty; one mesh may miss them by a lot, but its lowest
    frequency not by a factor of two, and no mode may be missing or made up where the distance of
    its neighbours tells.
    """
    if not info.torsion:
        moves = moving(exact, mechanism, pose)
        kept = {name: getattr(exact, name)[moves] for name in ("frequencies", "platform", "limbs")}
        exact = replace(exact, uncertainty=None, **kept)
    found, truth = modes.frequencies, exact.frequencies
    if len(truth) <= len(found):
        return

    def refuse(i: int) -> None:
        raise ModelError(
            f"its f{i + 1} is {found[i]:.6g} Hz, which is not of the theory that it declares: "
            f"exact is {truth[i]:.6g} Hz"
        )

    scale = np.maximum(truth, truth[truth > 0].min(initial=np.inf))
    off = np.abs(found - truth[: len(found)]) / scale[: len(found)]
    first = int((truth == 0).sum())
    if first < len(found) and not 1 / COARSE <= found[first] / truth[first] <= COARSE:
        refuse(first)
    if elements is None and (off > SAME).any():
        refuse(int(off.argmax()))
    _count(modes, exact, scale, off.max(), mechanism, pose)
    if isinstance(elements, tuple) and modes.uncertainty is not None:
        known = modes.uncertainty / scale[: len(found)]
        if (off > TRUSTED * known.max() + SAME).any():
            refuse(int(off.argmax()))


def moving(modes: Modes, mechanism: Mechanism, pose: Pose) -> NDArray[np.bool_]:
    """Return which of `modes` are not of limbs that twist alone."""
    return np.asarray(np.linalg.norm(mass_vectors(modes, mechanism, pose), axis=1) >= STILL)


def _count(
    modes: Modes, exact: Modes, scale: Array, by_order: float, mechanism: Mechanism, pose: Pose
) -> None:
    """Refuse `modes` with more or fewer of them below a gap of the `exact` ones.

    Modes are paired by shape; frequencies that fit by order, at most `by_order` off, but not by the
    shapes that they came with are refused as well: of modes that a mesh has in another order it is
    the other way round. A gap is left out where it is not `CLEAR` of how far the partners of its
    ends are from these, or of what is usual: a mode without a partner does not excuse itself.
    """
    found, truth = modes.frequencies, exact.frequencies
    pairing = pair(modes, exact, mechanism, pose)
    partner, sure = pairing.partner, ~pairing.doubtful
    away = np.abs(found - truth[partner])
    by_shape = np.where(sure, away / scale[partner], 0.0)
    worst = by_shape.max(initial=0.0)
    if worst > CLEAR * by_order + EXCHANGED:
        i = int(by_shape.argmax())
        raise ModelError(
            f"the shape of its f{i + 1}, {found[i]:.6g} Hz, is that of {truth[partner[i]]:.6g} Hz "
            "of the theory that it declares: shapes are exchanged"
        )
    deviation = float(np.median(away / scale[partner])) * scale
    deviation[partner] = np.maximum(deviation[partner], away)
    number = len(found) + 1
    lower, upper = truth[: number - 1], truth[1:number]
    gap = upper - lower
    clear = gap > CLEAR * np.maximum(deviation[1:number], deviation[: number - 1])
    # What a coarse mesh has higher up is not missing.
    clear &= (gap > REPEATED * upper) & (lower * (1 + CLEAR * worst) <= found[-1])
    middle = (upper + lower) / 2
    below, partners = found[:, None] < middle, truth[partner][:, None] < middle
    # A mode that a coarse mesh has on the other side is neither missing nor made up.
    crossed = (below.astype(int) - partners)[sure].sum(axis=0)
    has, right = below.sum(axis=0), np.arange(1, number) + crossed
    for i in np.flatnonzero(clear & (has != right))[:1]:
        raise ModelError(
            f"it has {has[i]} modes below {middle[i]:.6g} Hz, where its theory has {right[i]}: "
            f"a mode is {'missing' if has[i] < right[i] else 'made up'}"
        )
