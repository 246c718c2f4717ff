"""Limbs of any chain in Exudyn: another program's beams, joints and assembly."""

from pathlib import Path

import numpy as np
import pytest

from analytic import (
    Continuum,
    InputError,
    Joint,
    Limb,
    Link,
    Material,
    Mechanism,
    Platform,
    Pose,
    Rod,
)
from harness.case_file import load_cases
from reference_models.exudyn.beam import ExudynBeam
from reference_models.exudyn.chain import chain_modes
from reference_models.richardson import Richardson

CASES = load_cases(Path(__file__).parents[2] / "results" / "published" / "mechanisms.toml")
CHAINS = sorted(name for name, case in CASES.items() if not case.mechanism.simple)


@pytest.mark.slow
@pytest.mark.parametrize("name", CHAINS)
def test_extrapolated_beams_are_the_continuum(name: str) -> None:
    """Timoshenko without elements against geometrically exact beams: 3e-4 on f1-f8."""
    mechanism, pose = CASES[name].mechanism, CASES[name].pose
    limit = Richardson(ExudynBeam(8), ExudynBeam(16), 2).modes(mechanism, pose, 8)
    exact = Continuum("timoshenko").modes(mechanism, pose, 8)
    assert limit.frequencies == pytest.approx(exact.frequencies, rel=3e-4)
    assert limit.residual is not None
    assert limit.residual < 1e-12


def test_the_papers_limbs_as_chains_are_those_of_the_model_for_them() -> None:
    robot, pose = Mechanism.paper(), Pose(0.49, 0.2, -0.2)
    model = ExudynBeam(6)
    found = chain_modes("exudyn-beam", "", 6, model._kappas, robot, pose, 8)
    known = model.modes(robot, pose, 8)
    assert found.frequencies == pytest.approx(known.frequencies, rel=1e-8)
    assert np.abs(found.limbs - known.limbs).max() < 1e-5 * np.abs(known.limbs).max()


def test_what_exudyn_cannot_take_is_said() -> None:
    rod = Rod.round(Material(200e9, 77e9, 7820), 0.05)
    plate = Platform.disc(0.2, 0.02, 7820)
    chain = (Joint.revolute((0, 1, 0)), Link(0.1), rod, Joint.spherical())
    limb = Limb((0.3, 0, 0), (0.2, 0, 0), chain)
    robot = Mechanism(tuple(limb.turned(2 * np.pi * k / 3) for k in range(3)), plate)
    with pytest.raises(InputError, match="rigid links"):
        ExudynBeam(4).modes(robot, Pose(0.5))
    assert Continuum().modes(robot, Pose(0.5)).frequencies[0] > 0
