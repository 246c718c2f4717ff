"""Extrapolation follows the shape of a mode, not its place in the list."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from analytic import InputError, Mechanism, Modes, Pose, Substructure
from reference_models import Richardson


@dataclass(frozen=True)
class Planted:
    """Known shapes with f = limit (1 + error / elements^2); modes may cross between meshes."""

    elements: int
    limits: tuple[float, ...]
    errors: tuple[float, ...]

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        shapes = Substructure(4).modes(mechanism, pose, len(self.limits))
        f = np.array(self.limits) * (1 + np.array(self.errors) / self.elements**2)
        order = np.argsort(f)
        return replace(
            shapes,
            frequencies=f[order],
            platform=shapes.platform[order],
            limbs=shapes.limbs[order],
            residual=1e-12 * self.elements,
            elements=self.elements,
        ).first(count)


LIMITS = (100.0, 110.0, 200.0, 300.0, 310.0, 400.0, 405.0, 500.0, 510.0, 520.0)


@pytest.mark.parametrize(
    "errors", [(0.1,) * 10, (0, 0, 0, -5.0, 1.0, 0, 0, 0, 0, 0), (0, 0, 0, 0, 0, 8.0, 0, 0, 0, 0)]
)
def test_planted_limits_come_back(robot: Mechanism, case2: Pose, errors: tuple[float, ...]) -> None:
    """The second set crosses modes 4 and 5 between the meshes, the third takes one off the list."""
    coarse, fine = (Planted(n, LIMITS, errors) for n in (8, 16))
    modes = Richardson(coarse, fine, order=2).modes(robot, case2, 6)
    np.testing.assert_allclose(modes.frequencies, LIMITS[:6], rtol=1e-12)
    assert modes.elements == (8, 16)
    assert modes.residual == 16e-12
    assert modes.uncertainty is not None
    expected = np.abs(np.array(errors) / 16**2 * LIMITS)[:6]
    np.testing.assert_allclose(modes.uncertainty, expected, atol=1e-9)


def test_close_modes_that_cross_are_followed(robot: Mechanism, case2: Pose) -> None:
    """In the limit 0.05 % apart, which looks repeated, and in the other order on a coarse mesh."""
    limits = (*LIMITS[:4], 300.15, *LIMITS[5:])
    errors = (0.0, 0.0, 0.0, 0.3, -0.3, 0.0, 0.0, 0.0, 0.0, 0.0)
    coarse, fine = (Planted(n, limits, errors) for n in (8, 32))
    modes = Richardson(coarse, fine, order=2).modes(robot, case2, 6)
    np.testing.assert_allclose(modes.frequencies, limits[:6], rtol=1e-12)


def test_the_coarser_comes_first() -> None:
    with pytest.raises(InputError, match=r"elements = \(16, 8\): expected two numbers"):
        Richardson(Planted(16, LIMITS, LIMITS), Planted(8, LIMITS, LIMITS), 2)
