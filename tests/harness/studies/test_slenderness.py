"""Stout rods are where beam theory fails, and by the law that it should."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from analytic import Mechanism, Platform, limbs_at
from harness.bench import Bench
from harness.case_file import load_cases
from harness.cases import PRESETS
from harness.studies.slenderness import RATIOS, slenderness, with_rods
from reference_models import Named

EULER, TIMOSHENKO = Named("euler-bernoulli", None), Named("timoshenko", None)


@pytest.mark.parametrize("name", ["case1", "case2"])
@pytest.mark.parametrize("ratio", RATIOS)
def test_rods_have_the_ratio_asked_for(name: str, ratio: float) -> None:
    case = with_rods(PRESETS[name], ratio)
    length = limbs_at(case.mechanism, case.pose).lengths.mean()
    diameters = [limb.rod.diameter for limb in case.mechanism.limbs]
    np.testing.assert_allclose(diameters, ratio * length)
    assert case.mechanism.platform == PRESETS[name].mechanism.platform
    assert case.name == f"{name} d/L={ratio}"


def test_rods_of_any_chain_keep_their_bores_in_proportion() -> None:
    """Both rods of a limb, tubes too; joints, drives and lengths stay."""
    file = Path(__file__).parents[3] / "results/published/mechanisms.toml"
    before = load_cases(file)["rps-real"]
    case = with_rods(before, 0.1)
    length = limbs_at(case.mechanism, case.pose).lengths.mean()
    for old, new in zip(before.mechanism.limbs, case.mechanism.limbs, strict=True):
        for first, second in zip(old.rods, new.rods, strict=True):
            assert second.section.diameter == pytest.approx(0.1 * length)
            ratios = [one.section.bore / (one.section.diameter or 1) for one in (first, second)]
            assert ratios[0] == pytest.approx(ratios[1]) and first.length == second.length
        assert old.chain[0] == new.chain[0] and old.chain[2] == new.chain[2]


def test_the_error_of_euler_bernoulli_grows_as_the_square() -> None:
    """Shear enters as (d / L)^2 once the platform outweighs the rods; Timoshenko has it."""
    case = PRESETS["case1"]
    heavy = Platform.disc(0.2, 0.02, 7.82e6)
    case = replace(case, mechanism=Mechanism(case.mechanism.limbs, heavy))
    reference = Named("exudyn-beam", (12, 24))
    with Bench() as bench:
        result = slenderness(
            [case], (0.025, 0.05, 0.1), (EULER, TIMOSHENKO), reference, (1, 2, 3), bench
        )
    assert not result.failures()
    error = result.errors[case, EULER]
    np.testing.assert_allclose(error[1:] / error[:-1], 4, rtol=0.005)
    assert np.abs(result.errors[case, TIMOSHENKO]).max() < 1e-4
    own = result.study.answers[with_rods(case, 0.1), reference].first(3)
    assert own.uncertainty is not None
    of_reference = 100 * own.uncertainty / own.frequencies
    np.testing.assert_allclose(result.uncertainty[case][-1], of_reference, rtol=1e-6)
    # The largest error is said with the reference's own uncertainty of that very frequency.
    place = int(error[-1].argmax())
    largest = f"{error[-1, place]:.2g} +-{result.uncertainty[case][-1, place]:.1g} %"
    said = f"At d/L = 0.1 exact euler-bernoulli lies within {largest} of {reference.label}."
    assert result.sentences()[-1] == said
