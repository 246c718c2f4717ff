"""Wrong units: what cannot be is refused, what is hardly meant is warned of, the rest is let be."""

import re
import warnings
from collections.abc import Callable

import numpy as np
import pytest

from analytic import (
    InputError,
    Material,
    Mechanism,
    Platform,
    Pose,
    Rod,
    UnlikelyWarning,
    unlikely,
)
from harness.case import Case
from harness.cases import PRESETS

STEEL = Material(200e9, 77e9, 7820.0)


def robot(steel: Material = STEEL, diameter: float = 0.1, scale: float = 1.0) -> Mechanism:
    platform = Platform.disc(0.2 * scale, 0.02 * scale, 7820.0)
    return Mechanism.regular(0.3 * scale, 0.2 * scale, Rod(steel, diameter * scale), platform)


def test_degrees_for_radians_are_refused() -> None:
    with pytest.raises(InputError, match=r"Pose.tilt = -12: expected radians, less than a turn"):
        Pose(490, 10, -12)
    with pytest.raises(InputError, match="less than a turn"):
        Pose(0.49, 0.0, np.linspace(0, 30, 4))
    Pose(0.49, 10.0, 2 * np.pi)


@pytest.mark.parametrize(
    ("mechanism", "z", "says"),
    [
        (robot(Material(210, 80, 7850)), 0.49, "sound would go at 0.16 m/s; are they in pascals"),
        (robot(Material(2e17, 8e16, 7850)), 0.49, "sound would go at 5e+06 m/s"),
        (robot(diameter=6e-5), 0.49, "Rod.diameter = 6e-05: less than a thousandth"),
        (robot(), 490.0, "of the mechanism's 4.9e+02 m; is it in metres?"),
    ],
)
def test_what_is_hardly_meant_is_warned_of(mechanism: Mechanism, z: float, says: str) -> None:
    with pytest.warns(UnlikelyWarning, match=re.escape(says)):
        Case("mine", mechanism, Pose(z), "tried")


@pytest.mark.parametrize("scale", [1e-3, 1.0, 100.0])
def test_sizes_from_a_watch_to_a_bridge_are_let_be(scale: float) -> None:
    for steel in (STEEL, Material(3e6, 1.01e6, 1100.0), Material(1.1e12, 4.5e11, 3500.0)):
        assert unlikely(robot(steel, scale=scale), Pose(0.49 * scale)) == []
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for case in PRESETS.values():
            assert Case(case.name, case.mechanism, case.pose, "again")


def test_a_case_is_of_a_mechanism_and_one_pose() -> None:
    wrong: tuple[tuple[Callable[[], object], str], ...] = (
        (lambda: Case("a", Pose(1.0), robot(), ""), "mechanism = Pose"),  # type: ignore[arg-type]
        (lambda: Case("a", robot(), 0.49, ""), "pose = 0.49"),  # type: ignore[arg-type]
        (lambda: Case("a", robot(), Pose(np.ones(2)), ""), "one pose at a time"),
        (lambda: Case("", robot(), Pose(1.0), ""), "Case.name = ''"),
    )
    for make, says in wrong:
        with pytest.raises(InputError, match=says):
            make()
