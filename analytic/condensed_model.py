"""What `condensed_frequencies` condenses, as one more model."""

import time
from dataclasses import dataclass, replace

import numpy as np

from analytic.condensed import MOST_ELEMENTS, condensed_frequencies
from analytic.continuum import Continuum, HasLimit
from analytic.errors import count as whole
from analytic.mechanism import Mechanism
from analytic.modes import Modes
from analytic.pose import Pose
from analytic.reduced import Floats
from analytic.substructure import Substructure

AGREED = 1e-9
"""How far, relative, frequencies may be from those of the model they are condensed from."""


@dataclass(frozen=True)
class Condensed(HasLimit):
    """The models that `condensed_frequencies` condenses, as one more model.

    `elements` a limb, or None for exact limbs; `beam` and `shear` choose the theory (see `Theory`);
    `fast`: the compiled loop, as in `condensed_frequencies`.
    Raises `InputError` for unknown names or fewer than one element.
    """

    elements: int | None = None
    beam: str = "euler-bernoulli"
    shear: str | float = "cowper"
    fast: bool | None = None

    def __post_init__(self) -> None:
        if self.elements is not None:
            whole("elements", self.elements, at_most=MOST_ELEMENTS)
        super().__post_init__()

    def frequencies(self, mechanism: Mechanism, poses: Pose, count: int = 6) -> Floats:
        """Return the `count` lowest frequencies [Hz] at every pose, shape (*poses.shape, count)."""
        return condensed_frequencies(
            mechanism,
            poses,
            self.elements,
            beam=self.beam,
            shear=self.shear,
            count=count,
            fast=self.fast,
        )

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        """Return the `count` lowest modes at one pose, with the shapes of the model condensed.

        Raises `InputError` for a pose out of reach, and `ArithmeticError` where that model's own
        frequencies differ by more than 1e-9.
        """
        begin = time.perf_counter()
        found = self.frequencies(mechanism, pose, count)
        solved = time.perf_counter()
        full = (
            Continuum(self.beam, self.shear)
            if self.elements is None
            else Substructure(self.elements, self.beam, self.shear)
        ).modes(mechanism, pose, count)
        apart = np.abs(found - full.frequencies)
        if (apart > AGREED * full.frequencies).any():
            raise ArithmeticError(
                f"condensed frequencies differ from the full model's by {apart.max():.1e} Hz"
            )
        return replace(
            full,
            frequencies=found,
            model="condensed",
            version="rps-bench, condensed",
            build_seconds=time.perf_counter() - solved,
            solve_seconds=solved - begin,
        )
