"""Rods so thin that bending is rounding beside stretching: every solver ends, with digits."""

import numpy as np

from analytic import (
    Continuum,
    Material,
    Mechanism,
    Multipliers,
    Pose,
    Rod,
    Substructure,
)


def test_rods_of_forty_thousand_diameters() -> None:
    """Bending is 1e-10 of stretching: solvers end, and agree to what rounding of that leaves."""
    rod = Rod(Material(200e9, 77e9, 7820.0), 0.5 / 40_000)
    robot = Mechanism.regular(0.3, 0.2, rod, Mechanism.paper().platform)
    pose = Pose(0.49, np.radians(10), np.radians(-12))
    exact = Continuum().modes(robot, pose, 9).frequencies
    np.testing.assert_allclose(Substructure(64).modes(robot, pose, 9).frequencies, exact, rtol=2e-6)
    dense = Substructure(3, solver="dense").modes(robot, pose).frequencies
    for model in (
        Substructure(3, solver="sparse"),
        Multipliers(3),
        Multipliers(3, solver="saddle-point"),
    ):
        np.testing.assert_allclose(model.modes(robot, pose).frequencies, dense, rtol=1e-5)
