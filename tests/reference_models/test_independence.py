"""A slip in the analytic model is seen: planted one at a time, some simulator keeps its numbers."""

import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from analytic import Mechanism, Pose, Rod, Substructure, pose
from analytic.theory import Theory
from reference_models import UnavailableError, reference

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Slip:
    """What is wrong in `analytic`: `owner`.`name` becomes `wrong`; `seen_by` a simulator."""

    owner: Any
    name: str
    wrong: Callable[[Any], Any]
    seen_by: str
    theory: str = "euler-bernoulli"


def _eq_1(right: Any) -> Any:
    return lambda azimuth, tilt: right(azimuth, -tilt)


def _eq_2(right: Any) -> Any:
    def wrong(axes: Any, bases: Any, points: Any, z: Any, *rest: Any) -> Any:
        # The other sign of z in the joints' conditions, or of x and y, opens them; a lifted
        # platform does not.
        return right(axes, bases, points, 1.001 * np.asarray(z), *rest)

    return wrong


def _doubled(right: property) -> property:
    return property(lambda rod: 2 * right.fget(rod))  # type: ignore[misc]


SLIPS = {
    "Eq. 1": Slip(pose, "leaned", _eq_1, "exudyn-cable"),
    "Eq. 2": Slip(pose, "closure", _eq_2, "exudyn-cable"),
    "A": Slip(Rod, "area", _doubled, "ngsolve-averaged"),
    "I": Slip(Rod, "second_moment", _doubled, "ngsolve-averaged"),
    "kappa": Slip(
        Theory, "shear_coefficient", lambda right: lambda *given: 2 * right(*given), "exudyn-beam",
        "timoshenko",
    ),
}  # fmt: skip
"""Of Section 2 and Eqs. (1), (2), (10)-(13)."""


def forget() -> None:
    """Have the analytic model compute all anew."""
    for name, module in list(sys.modules.items()):
        if name.startswith("analytic"):
            for thing in vars(module).values():
                getattr(thing, "cache_clear", lambda: None)()


@pytest.fixture
def unknown() -> Iterator[None]:
    forget()
    yield
    forget()


@pytest.mark.usefixtures("unknown")
@pytest.mark.parametrize("slip", SLIPS.values(), ids=SLIPS)
def test_a_slip_in_the_analytic_model_is_seen(
    robot: Mechanism, slip: Slip, monkeypatch: pytest.MonkeyPatch
) -> None:
    try:
        simulator = reference(slip.seen_by, 1 if "ngsolve" in slip.seen_by else 4)
    except UnavailableError as reason:
        pytest.skip(str(reason))
    # A tilt whose sign is seen: limbs at 0, 120 and 240 degrees, a pose with no mirror.
    at = Pose(0.49, np.radians(10), np.radians(-12))
    right = Substructure(3, beam=slip.theory).modes(robot, at).frequencies
    before = simulator.modes(robot, at).frequencies
    monkeypatch.setattr(slip.owner, slip.name, slip.wrong(getattr(slip.owner, slip.name)))
    forget()
    wrong = Substructure(3, beam=slip.theory).modes(robot, at).frequencies
    assert np.abs(wrong / right - 1).max() > 1e-3
    np.testing.assert_array_equal(simulator.modes(robot, at).frequencies, before)
