"""Planted limits and orders come back; what cannot be read is said."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from analytic import Continuum
from harness.cases import PRESETS
from harness.models import Spec
from harness.refinement import refine, verify


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


@pytest.mark.parametrize(
    ("name", "elements"), [("euler-bernoulli", (2, 4, 8)), ("timoshenko", (8, 16, 32)),
                           ("exudyn-beam", (6, 12, 24)), ("exudyn-cable", (2, 4, 8))]
)  # fmt: skip
def test_the_band_holds_the_exact_limit(name: str, elements: tuple[int, ...]) -> None:
    """Every model's limit and band, against the exact answer of its own theory."""
    case = PRESETS["case2"]
    theory = "timoshenko" if name in ("timoshenko", "exudyn-beam") else "euler-bernoulli"
    exact = Continuum(theory).modes(case.mechanism, case.pose).frequencies
    result = refine([case], [[Spec(name, n) for n in elements]], 6)
    for i in range(6):
        values, seen = result.found["case2", name, i]
        assert seen.asymptotic, seen
        assert abs(values[-1] - exact[i]) <= seen.gci
        assert abs(seen.limit - exact[i]) <= 0.2 * seen.gci
    assert np.isfinite([seen.order for _, seen in result.found.values()]).all()


def test_command(rps_bench: Callable[..., Any]) -> None:
    answer = rps_bench(
        "refine", "--cases", "case1", "--references", "exudyn-cable", "--elements", "2,4,8"
    )
    assert answer.status == 0
    assert "GCI" in answer.out and "euler-bernoulli" in answer.out
    assert rps_bench("refine", "--elements", "2,4").status == 2
