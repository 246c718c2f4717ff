"""What moves a point of limbs: a matrix over coordinates."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

PLATFORM = tuple(range(-6, 0))


@dataclass(frozen=True)
class Map:
    """What moves a point of n limbs: `matrix` (n, 6, c) over the coordinates `columns` (c,) of
    each; those of the platform are -6 ... -1.
    """

    columns: tuple[int, ...]
    matrix: Floats

    def carried(self, arm: Floats) -> "Map":
        """Return the motion of the point that is `arm` (n, 3) away on the same rigid body."""
        moved = self.matrix.copy()
        moved[:, :3] += np.cross(self.matrix[:, 3:], arm[:, :, None], axis=1)
        return Map(self.columns, moved)

    @property
    def size(self) -> int:
        """How many coordinates move the point."""
        return len(self.columns)
