"""Two refinements of one model, extrapolated to none."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from analytic.errors import InputError
from analytic.mechanism import Mechanism
from analytic.modes import Modes
from analytic.pairing import pair
from analytic.pose import Pose

SPARE = 2
"""Modes that may lie beyond those asked for and still belong among them in the limit."""


@dataclass(frozen=True)
class Richardson:
    """f = f_fine + (f_fine - f_coarse) / (r^p - 1), with r the ratio of elements and p `order`.

    Modes are paired by shape first; shapes are the finer model's. The extrapolation's own step is
    given as the uncertainty.
    """

    coarse: Any
    fine: Any
    order: float

    def __post_init__(self) -> None:
        if not self.coarse.elements < self.fine.elements:
            pair_of = (self.coarse.elements, self.fine.elements)
            raise InputError("elements", pair_of, "two numbers, the smaller first")

    @property
    def elements(self) -> tuple[int, int]:
        """The two numbers of elements."""
        return self.coarse.elements, self.fine.elements

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        """Return the extrapolated modes; raises whatever the model itself raises."""
        # More modes than asked for: one that crosses the end of a mesh's list must be found.
        coarse: Modes = self.coarse.modes(mechanism, pose, count + 2 * SPARE)
        fine: Modes = self.fine.modes(mechanism, pose, count + SPARE)
        return extrapolated(coarse, fine, self.elements, self.order, mechanism, pose, count)


def extrapolated(
    coarse: Modes,
    fine: Modes,
    elements: tuple[int, int],
    order: float,
    mechanism: Mechanism,
    pose: Pose,
    count: int,
) -> Modes:
    """Return the `count` lowest modes in the limit of two meshes of so many `elements`.

    `coarse` holds at least as many modes as `fine`. A limit below zero is zero: by the uncertainty
    it may be.
    """
    ratio = elements[1] / elements[0]
    partner = pair(fine, coarse, mechanism, pose).partner
    step = (fine.frequencies - coarse.frequencies[partner]) / (ratio**order - 1)
    limit = np.maximum(fine.frequencies + step, 0.0)
    lowest = np.argsort(limit)[:count]
    return replace(
        fine,
        frequencies=limit[lowest],
        platform=fine.platform[lowest],
        limbs=fine.limbs[lowest],
        elements=elements,
        residual=max(coarse.residual or 0.0, fine.residual or 0.0),
        build_seconds=coarse.build_seconds + fine.build_seconds,
        solve_seconds=coarse.solve_seconds + fine.solve_seconds,
        uncertainty=np.abs(step)[lowest],
    )
