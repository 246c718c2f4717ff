"""Stout rods are where beam theory fails, and by the law that it should."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analytic import Mechanism, Platform, limbs_at
from harness.cases import PRESETS
from harness.models import Spec
from harness.slenderness import RATIOS, slenderness, with_rods


@pytest.mark.parametrize("name", ["case1", "case2"])
@pytest.mark.parametrize("ratio", RATIOS)
def test_rods_have_the_ratio_asked_for(name: str, ratio: float) -> None:
    case = with_rods(PRESETS[name], ratio)
    length = limbs_at(case.mechanism, case.pose).lengths.mean()
    diameters = [limb.rod.diameter for limb in case.mechanism.limbs]
    np.testing.assert_allclose(diameters, ratio * length)
    assert case.mechanism.platform == PRESETS[name].mechanism.platform
    assert case.name == f"{name} d/L={ratio}"


def test_the_error_of_euler_bernoulli_grows_as_the_square() -> None:
    """Shear enters as (d / L)^2 once the platform outweighs the rods; Timoshenko has it."""
    case = PRESETS["case1"]
    heavy = Platform.disc(0.2, 0.02, 7.82e6)
    case = replace(case, mechanism=Mechanism(case.mechanism.limbs, heavy))
    result = slenderness([case], (0.025, 0.05, 0.1), Spec("exudyn-beam", (12, 24)), 3)
    error = result.errors["case1", "euler-bernoulli"]
    np.testing.assert_allclose(error[1:] / error[:-1], 4, rtol=0.005)
    assert np.abs(result.errors["case1", "timoshenko"]).max() < 1e-4
    assert np.isfinite(result.uncertainty["case1"]).all()


@pytest.mark.slow
def test_command_on_solids(rps_bench: Callable[..., Any], tmp_path: Path) -> None:
    answer = rps_bench(
        "slenderness", "--references", "calculix-solid@4", "--cases", "case2",
        "--output", str(tmp_path),
    )  # fmt: skip
    assert answer.status == 0
    assert "not known" in answer.out  # one mesh gives no uncertainty
    assert len(list(tmp_path.iterdir())) == 5
