"""Linear modes against motion in time, which no linearisation and no eigenvalue enters."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import find_peaks, get_window

from analytic import Mechanism, Pose
from reference_models import placement
from reference_models.exudyn import system as exudyn_system
from reference_models.exudyn.cable import ExudynCable

exudyn = pytest.importorskip("exudyn", reason="exudyn is not installed: pip install exudyn")

Array = NDArray[np.float64]
ELEMENTS, STEP, STEPS = 3, 5e-5, 10_000
HIGHEST = 1000.0


@pytest.mark.slow
def test_a_random_push_rings_at_the_linear_modes(robot: Mechanism, case2: Pose) -> None:
    """Peaks of the spectrum of half a second are the modes: all six below 1 kHz, and no other."""
    linear = ExudynCable(ELEMENTS).modes(robot, case2, 8).frequencies
    linear = linear[linear < HIGHEST]
    ringing = peaks(pushed(robot, case2))
    assert len(linear) == 6
    np.testing.assert_allclose(ringing, linear, rtol=1e-5)


def pushed(mechanism: Mechanism, pose: Pose) -> Array:
    """Return velocities (STEPS + 1, 3) of the platform after a random push.

    Nonlinear equations of motion by the trapezoidal rule, which loses no energy.
    """
    placed = placement.place(mechanism, pose)
    with exudyn_system.system(exudyn, "test") as mbs:
        node, body = exudyn_system.add_platform(
            exudyn, mbs, mechanism.platform, placed.centre, placed.rotation
        )
        for axis, limb in zip(
            exudyn_system.rod_axes(mechanism, placed), mechanism.limbs, strict=True
        ):
            line = ExudynCable(ELEMENTS)._add_rod(exudyn, mbs, axis)
            exudyn_system.add_spherical(exudyn, mbs, body, limb.platform_point, line.tip)
        sensor = mbs.AddSensor(
            exudyn.itemInterface.SensorNode(
                nodeNumber=node,
                storeInternal=True,
                outputVariableType=exudyn.OutputVariableType.Velocity,
            )
        )
        mbs.Assemble()
        push(mbs)
        settings = exudyn.SimulationSettings()
        integration = settings.timeIntegration
        integration.numberOfSteps, integration.endTime = STEPS, STEPS * STEP
        integration.generalizedAlpha.spectralRadius = 1.0
        integration.newton.relativeTolerance = 1e-6  # rounding of forces that cancel
        settings.solutionSettings.sensorsWritePeriod = STEP
        settings.solutionSettings.writeSolutionToFile = False
        assert mbs.SolveDynamic(settings)
        return np.array(mbs.GetSensorStoredData(sensor))[:, 1:]


def push(mbs: Any) -> None:
    """Set small random velocities that the joints allow."""
    *_, J = mbs.ComputeLinearizedSystem(returnConstraintJacobian=True)
    random = np.random.default_rng(5).normal(size=len(J))
    allowed = random - J @ np.linalg.lstsq(J, random, rcond=None)[0]
    velocities = 1e-4 * allowed
    mbs.systemData.SetODE2Coordinates_t(velocities, configuration=exudyn.ConfigurationType.Initial)


def peaks(signals: Array) -> Array:
    """Return the frequencies [Hz] below HIGHEST at which any of `signals` rings."""
    window = get_window("blackmanharris", len(signals))[:, None]
    padded = 8 * len(signals)
    power = (np.abs(np.fft.rfft(signals * window, padded, axis=0)) ** 2).sum(axis=1)
    level = np.log(power)
    at, _ = find_peaks(level, height=level.max() - np.log(1e6), prominence=2.0)
    before, here, after = (level[at + i] for i in (-1, 0, 1))
    found = (at + (before - after) / (2 * (before - 2 * here + after))) / (padded * STEP)
    # The rule turns omega into 2 / h atan(omega h / 2).
    found = np.tan(np.pi * found * STEP) / (np.pi * STEP)
    return np.asarray(found[found < HIGHEST])
