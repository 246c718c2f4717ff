"""Whether a simulator has as many modes below a frequency as its theory has.

The theory's number is Wittrick and Williams' count, halfway between neighbouring frequencies of
the theory: a mode that a simulator misses, has twice or makes up shifts its own number there.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from analytic import Mechanism, Pose, condensed_frequencies
from analytic.mode_counts import mode_counts
from analytic.model import Model
from analytic.theory import Theory

CLEAR = 4
"""Neighbours further apart than this many deviations are told apart."""
REPEATED = 1e-6
"""Relative distance below which neighbours are one repeated mode."""
SPARE = 4
"""Further modes of the theory, for what a simulator has in the place of those it misses."""

Floats = NDArray[np.float64]
Beams = Mapping[str, Any]
"""Limbs whose modes can be counted, as functions of `analytic` take them: `elements` each, None for
exact ones, `beam` and `shear`."""


class ModeCheck(NamedTuple):
    """At N poses, above each of `count` modes: was it counted there, and wrongly; (N, count)."""

    counted: NDArray[np.bool_]
    wrong: NDArray[np.bool_]


def beams_of(model: Model) -> Beams | None:
    """Return what a model assumes of its limbs where it is one of beams, or None."""
    if model.info().isolated:
        return None
    built: Any = model.build() if hasattr(model, "build") else model
    theory = getattr(built, "theory", None)
    if not isinstance(theory, Theory):
        return None
    return {"elements": built.elements, "beam": theory.beam, "shear": theory.shear}


def frequencies(
    mechanism: Mechanism, poses: Pose, count: int, theory: Beams, torsion: bool
) -> Floats:
    """Return the frequencies (N, count) [Hz] of a theory whose limbs twist or do not."""
    return condensed_frequencies(
        mechanism, poses, count=count, torsion=torsion, fast=False, **theory
    )


def check_modes(
    found: Floats, mechanism: Mechanism, poses: Pose, theory: Beams, torsion: bool = True
) -> ModeCheck:
    """Count a simulator's frequencies `found` (N, count) [Hz] against those of `theory`.

    A gap between two modes of the theory is left out where it is not `CLEAR` of how far the
    frequencies next to its ends are from these, or of what is usual at the pose: a mode without a
    partner does not excuse itself. Without `torsion` the theory's limbs do not twist either.
    """
    count = found.shape[1]
    exact = frequencies(mechanism, poses, count + 1 + SPARE, theory, torsion)
    away = np.abs(found[:, :, None] - exact[:, None, :])
    partner = away.argmin(axis=2)
    nearest = partner[..., None] == np.arange(exact.shape[1])
    deviation = np.where(nearest, away, 0.0).max(axis=1)[:, : count + 1]
    usual = np.median(away.min(axis=2) / np.take_along_axis(exact, partner, axis=1), axis=1)
    exact = exact[:, : count + 1]
    deviation = np.maximum(deviation, usual[:, None] * exact)
    gap = np.diff(exact)
    counted = gap > CLEAR * np.maximum(deviation[:, 1:], deviation[:, :-1])
    counted &= gap > REPEATED * exact[:, 1:]
    middle = (exact[:, 1:] + exact[:, :-1]) / 2
    right = mode_counts(mechanism, poses, middle, torsion=torsion, **theory)
    below = (found[:, None, :] < middle[:, :, None]).sum(axis=2)
    return ModeCheck(counted, counted & (below != right))
