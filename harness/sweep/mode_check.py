"""Whether a simulator has as many modes below a frequency as its theory has.

The theory's number is Wittrick and Williams' count, halfway between neighbouring frequencies of
the theory: a mode that a simulator misses, has twice or makes up shifts its own number there.
"""

from dataclasses import dataclass
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


class ModeCheck(NamedTuple):
    """At N poses, above each of `count` modes: was it counted there, and wrongly; (N, count)."""

    counted: NDArray[np.bool_]
    wrong: NDArray[np.bool_]


@dataclass(frozen=True)
class Beams:
    """Limbs whose modes can be counted: `elements` each, None for exact ones; their theory."""

    elements: int | None
    theory: Theory

    @property
    def said(self) -> dict[str, Any]:
        """The limbs as functions of `analytic` take them."""
        theory = self.theory
        return {"elements": self.elements, "beam": theory.beam, "shear": theory.shear}

    def frequencies(self, mechanism: Mechanism, poses: Pose, count: int, torsion: bool) -> Floats:
        """Return frequencies (N, count) [Hz], of limbs that twist or do not."""
        return condensed_frequencies(
            mechanism, poses, count=count, torsion=torsion, fast=False, **self.said
        )


def beams_of(model: Model) -> Beams | None:
    """Return the beams of a model whose limbs are some, or None."""
    if model.info().isolated:
        return None
    built: Any = model.build() if hasattr(model, "build") else model
    theory = getattr(built, "theory", None)
    return Beams(built.elements, theory) if isinstance(theory, Theory) else None


def check_modes(
    found: Floats, mechanism: Mechanism, poses: Pose, theory: Beams, torsion: bool = True
) -> ModeCheck:
    """Count a simulator's frequencies `found` (N, count) [Hz] against those of `theory`.

    A gap between two modes of the theory is left out where it is not `CLEAR` of how far the
    frequencies next to its ends are from these, or of what is usual at the pose: a mode without a
    partner does not excuse itself. Without `torsion` the theory's limbs do not twist either.
    """
    count = found.shape[1]
    exact = theory.frequencies(mechanism, poses, count + 1 + SPARE, torsion)
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
    right = mode_counts(mechanism, poses, middle, torsion=torsion, **theory.said)
    below = (found[:, None, :] < middle[:, :, None]).sum(axis=2)
    return ModeCheck(counted, counted & (below != right))
