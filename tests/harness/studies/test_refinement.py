"""Planted limits and orders come back; what cannot be read is said."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from analytic import Continuum, InputError
from harness.api import study
from harness.cases import PRESETS
from harness.studies.refinement import Family, Refinement, ladder, verify
from reference_models import Named


@given(
    limit=st.floats(1, 1e4),
    error=st.floats(-0.5, 0.5),
    order=st.floats(1.6, 4.9),
    start=st.integers(2, 12),
    ratios=st.tuples(st.integers(2, 3), st.integers(2, 3)),
)
def test_planted_order_and_limit(
    limit: float, error: float, order: float, start: int, ratios: tuple[int, int]
) -> None:
    assume(abs(error) > 1e-3)
    elements = [start, start * ratios[0], start * ratios[0] * ratios[1]]
    frequencies = [limit * (1 + error * n**-order) for n in elements]
    formal = 2 if order < 2.5 else 4
    seen = verify(elements, frequencies, formal)
    if seen.converged:
        return
    assert seen.monotone
    assert seen.order == pytest.approx(order, abs=0.01)
    assert abs(limit - frequencies[-1]) <= seen.gci * 1.001
    if seen.asymptotic:
        assert seen.limit == pytest.approx(limit, rel=1e-6)
        assert seen.gci == pytest.approx(1.25 * abs(limit - frequencies[-1]), rel=0.02)


def test_what_cannot_be_read_is_said() -> None:
    wave = verify([2, 4, 8], [100.0, 101.0, 100.5], 2)
    assert not wave.monotone and math.isnan(wave.order) and wave.limit == 100.5
    assert "not monotone" in wave.remark and wave.gci > 0
    slow = verify([2, 4, 8], [100.0, 101.0, 101.9], 2)
    assert not slow.asymptotic and slow.remark == "not in the asymptotic range"
    done = verify([2, 4, 8], [100.0, 100.0, 100.0], 2)
    assert done.converged and done.gci == 0


def test_no_limit_is_below_zero() -> None:
    assert verify([2, 4, 8], [9.0, 5.0, 1.0], 2).limit == 0.0
    free = verify([2, 4, 8], [0.0, 0.0, 0.0], 2)
    assert free.converged and free.limit == free.gci == 0.0


@pytest.mark.parametrize(
    ("name", "elements"),
    [("euler-bernoulli", (2, 4, 8)), ("timoshenko", (8, 16, 32)), ("exudyn-beam", (6, 12, 24)),
     ("exudyn-cable", (2, 4, 8)), ("mujoco-chain", (6, 12, 24)), ("mujoco-cable", (4, 8, 16))],
)  # fmt: skip
def test_the_band_holds_the_exact_limit(name: str, elements: tuple[int, ...]) -> None:
    """Every model's limit and band, against the exact answer of its own theory."""
    case = PRESETS["case2"]
    theory = "timoshenko" if name in ("timoshenko", "exudyn-beam") else "euler-bernoulli"
    exact = Continuum(theory).modes(case.mechanism, case.pose).frequencies
    steps = ladder(Named(name, None), elements)
    result = study("refine", cases=case, model=steps[0], references=[steps[0]], elements=elements)
    assert isinstance(result, Refinement) and not result.failures()
    (family,) = result.families
    assert family.steps == steps and not family.misses()
    for i in range(1, 7):
        seen = family.seen[case, i]
        assert family.exact[case, i] == pytest.approx(exact[i - 1], rel=1e-9)
        assert abs(seen.frequencies[-1] - exact[i - 1]) <= seen.gci
        if seen.asymptotic:
            assert abs(seen.limit - exact[i - 1]) <= 0.5 * seen.gci
            assert seen.order == pytest.approx(steps[0].info().order, rel=0.25)


def test_ladders() -> None:
    """A model's own meshes; two asked for stand on half the coarser; three are needed."""
    assert [m.elements for m in ladder(Named("timoshenko", 3))] == [3, 4, 8, 16]
    assert [m.elements for m in ladder(Named("exudyn-beam", (12, 24)))] == [6, 12, 24]
    assert [m.elements for m in ladder(Named("exudyn-beam", (8, 16)))] == [4, 8, 16]
    assert [m.elements for m in ladder(Named("exudyn-ffrf", (2, 4)))] == [1, 2, 4]
    with pytest.raises(InputError, match="elements = '2,4': expected three numbers at least"):
        ladder(Named("exudyn-cable", 2), (2, 4))


def test_models_of_one_name_stay_apart() -> None:
    result = study("refine", model="timoshenko@3", cases="case1", modes="1", elements="4,8,16",
                   references=[Named("timoshenko", 3, (("shear", 0.3),))])  # fmt: skip
    frame = result.to_frame()
    assert frame["model"].nunique() == 2 and np.ptp(frame["limit_hz"]) > 1
    assert len(result.tables()) == 3
    steps = ladder(Named("timoshenko", 3, (("shear", 0.3),)))
    assert "shear=0.3" in Family(steps, {}, {}).name
