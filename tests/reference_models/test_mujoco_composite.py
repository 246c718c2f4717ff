"""MuJoCo 3's composite cable, in an environment of its own."""

import os
import pickle
import signal
from pathlib import Path

import numpy as np
import pytest

from analytic import Continuum, InputError, Mechanism, Pose
from reference_models import ModelError, UnavailableError, reference
from reference_models.mujoco import environment
from reference_models.mujoco.old_cable import MujocoComposite

needs_environment = pytest.mark.skipif(
    environment.python() is None, reason=MujocoComposite.info().missing
)


@needs_environment
@pytest.mark.slow
def test_it_tends_to_a_rod_that_cannot_stretch(robot: Mechanism, case2: Pose) -> None:
    """First order of the elements, to Rayleigh's rod less what stretch takes off."""
    f16, f32, f64 = (
        reference("mujoco-composite", n).modes(robot, case2).frequencies for n in (16, 32, 64)
    )
    order = np.log2((f16 - f32) / (f32 - f64))
    np.testing.assert_allclose(order[:3], 1, atol=0.15)
    rayleigh = Continuum("rayleigh").modes(robot, case2).frequencies
    np.testing.assert_allclose(2 * f64 - f32, rayleigh, rtol=5e-3)


@needs_environment
def test_what_is_reported_and_refused(robot: Mechanism, case2: Pose) -> None:
    modes = reference("mujoco-composite", 8).modes(robot, case2)
    assert (modes.model, modes.version) == ("mujoco-composite", "mujoco 3.17.0")
    assert modes.residual is not None and modes.residual < 1e-12
    with pytest.raises(InputError, match="count = 4000"):
        reference("mujoco-composite", 8).modes(robot, case2, 4000)
    # The same process goes on.
    again = reference("mujoco-composite", 8).modes(robot, case2).frequencies
    np.testing.assert_array_equal(again, modes.frequencies)


@needs_environment
def test_a_process_that_dies_is_an_error_and_the_next_is_another(
    robot: Mechanism, case2: Pose
) -> None:
    model = MujocoComposite(3)
    before = model.modes(robot, case2).frequencies
    program = environment.python()
    assert program is not None
    os.kill(environment._child(program, os.getpid()).pid, signal.SIGKILL)
    with pytest.raises(ModelError, match=r"ended, exit status -9"):
        model.modes(robot, case2)
    np.testing.assert_array_equal(model.modes(robot, case2).frequencies, before)


def test_without_its_environment_it_says_what_to_do(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(environment, "installed", lambda: "4.0.0")
    assert "python -m reference_models.mujoco.environment" in MujocoComposite.info().missing
    with pytest.raises(UnavailableError, match="needs an environment of its own"):
        reference("mujoco-composite")
    monkeypatch.setattr(environment, "installed", lambda: environment.VERSION)
    assert MujocoComposite.info().missing == ""


def test_errors_cross_processes() -> None:
    error = InputError("count", 3, "less")
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is InputError and str(again) == str(error)
