"""What every model answers: natural frequencies, mode shapes and what they cost."""

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from analytic.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

STATIONS = np.linspace(0.0, 1.0, 11)
"""Where limb motion is reported: fractions of the length, from B_i (0) to A_i (1)."""


@dataclass(frozen=True)
class Modes:
    """The lowest modes of a mechanism at one pose, ascending; m modes, n limbs.

    Shapes are scaled to unit modal mass (by the model's own mass matrix) and turned so that their
    largest component is positive: any two models' modes can be compared.

    Attributes:
        frequencies: f_i = omega_i / 2 pi, Eq. (24), shape (m,) [Hz].
        platform: displacement and rotation at o, global axes, shape (m, 6) [m, rad, per sqrt(kg)].
        limbs: centre-line displacement at `STATIONS`, global axes, shape (m, n, 11, 3).
        theory: what the model assumes of a rod, in words.
        model, version: the model's name, and its simulator's name and version.
        elements: elements a limb; two numbers where extrapolated; None without elements.
        dofs: independent coordinates solved for.
        residual: largest gap of a joint, as the simulator sees it [m]; None where none can open.
        build_seconds, solve_seconds: time spent on the matrices and on their eigenvalues.
        uncertainty: estimated numerical error of each frequency, shape (m,) [Hz], or None.
    """

    frequencies: NDArray[np.float64]
    platform: NDArray[np.float64] = field(repr=False)
    limbs: NDArray[np.float64] = field(repr=False)
    theory: str
    model: str
    version: str
    elements: int | tuple[int, int] | None
    dofs: int
    residual: float | None
    build_seconds: float
    solve_seconds: float
    uncertainty: NDArray[np.float64] | None = field(default=None)

    def __post_init__(self) -> None:
        flat = np.concatenate(
            [self.platform, self.limbs.reshape(len(self.frequencies), -1)], axis=1
        )
        largest = flat[np.arange(len(flat)), np.abs(flat).argmax(axis=1)]
        sign = np.where(largest < 0, -1.0, 1.0)[:, None]
        object.__setattr__(self, "platform", self.platform * sign)
        object.__setattr__(self, "limbs", self.limbs * sign[:, :, None, None])

    def first(self, count: int) -> "Modes":
        """Return the `count` lowest of these modes."""
        uncertainty = None if self.uncertainty is None else self.uncertainty[:count]
        return replace(
            self,
            frequencies=self.frequencies[:count],
            platform=self.platform[:count],
            limbs=self.limbs[:count],
            uncertainty=uncertainty,
        )

    def to_frame(self) -> "pd.DataFrame":
        """Return one row a mode as a pandas frame: frequency and uncertainty [Hz], model, theory.

        pandas is looked for when this is called; nothing else in this package needs it.
        """
        import pandas as pd

        return pd.DataFrame({
            "mode": range(1, len(self.frequencies) + 1),
            "frequency_hz": self.frequencies,
            "uncertainty_hz": np.nan if self.uncertainty is None else self.uncertainty,
            "model": self.model,
            "elements": str(self.elements),
            "theory": self.theory,
            "version": self.version,
        })  # fmt: skip

    @property
    def seconds(self) -> float:
        """Build and solve together."""
        return self.build_seconds + self.solve_seconds


def check_count(count: int, available: int) -> int:
    """Return `count` if a model with `available` coordinates has so many modes, or refuse."""
    if isinstance(count, bool) or not isinstance(count, (int, np.integer)) or count < 1:
        raise InputError("count", count, "a whole number of modes, at least 1")
    if count > available:
        raise InputError("count", count, f"at most {available}, the coordinates of this model")
    return int(count)
