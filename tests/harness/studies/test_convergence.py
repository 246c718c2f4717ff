"""Fig. 3 and the discretisation error: the observed order is the formal one."""

import numpy as np
import pytest

from analytic import Continuum, Substructure
from harness.api import study
from harness.cases import PRESETS
from harness.studies.convergence import Convergence


@pytest.mark.parametrize(("theory", "order"), [("euler-bernoulli", 4), ("timoshenko", 2)])
def test_the_discretisation_error_falls_with_the_formal_order(theory: str, order: int) -> None:
    result = study("convergence", model=theory, references=f"{theory}@exact",
                   elements="4,8,16,32", cases="case2")  # fmt: skip
    assert isinstance(result, Convergence) and result.same_theory
    (case,) = result.errors
    np.testing.assert_allclose(result.order(case)[-1], order, atol=0.15)
    exact = Continuum(theory).modes(case.mechanism, case.pose).frequencies
    ours = Substructure(4, theory).modes(case.mechanism, case.pose).frequencies
    np.testing.assert_allclose(result.errors[case][0], 100 * (ours / exact - 1), atol=1e-6)
    assert list(result.tables()) == ["", "-order", "-verification"]


def test_the_floor_is_what_no_number_of_elements_removes() -> None:
    result = study("convergence", references="timoshenko@exact", elements="1,32", cases="case2")
    assert isinstance(result, Convergence)
    (case,) = result.errors
    euler, timoshenko = (
        Continuum(beam).modes(case.mechanism, case.pose).frequencies[:6]
        for beam in ("euler-bernoulli", "timoshenko")
    )
    np.testing.assert_allclose(result.floor(case), 100 * (euler / timoshenko - 1), atol=1e-8)
    np.testing.assert_allclose(result.errors[case][1], result.floor(case), rtol=1e-4)
    (axes,) = result.figures()[""].axes
    lines = [line for line in axes.lines if line.get_linestyle() == ":"]
    np.testing.assert_allclose([line.get_ydata()[0] for line in lines], result.floor(case))
    ends = {f"$e_{{{i}}}$ {value:#.3g}" for i, value in enumerate(result.errors[case][1], 1)}
    assert {text.get_text() for text in axes.texts} == ends, "what the curves end at"


def test_the_printed_errors_stand_beside_ours() -> None:
    result = study("convergence", references="timoshenko@exact", elements="1,2", cases="case1")
    frame = result.to_frame()
    quoted = {
        (row.elements, row.mode): row.printed_percent
        for row in frame.itertuples()
        if np.isfinite(row.printed_percent)
    }
    assert PRESETS["case1"].paper is not None
    printed = PRESETS["case1"].paper.errors
    assert quoted == {
        (s, i): value for (case, s, i), value in printed.items() if case == "case1" and s < 3
    }
    assert "printed" in result.table().markdown()
