"""Time against error: errors are the models' own, the front is what nothing beats."""

from collections.abc import Callable

import numpy as np
import pytest

from analytic import InputError
from harness.bench import Bench
from harness.cases import PRESETS
from harness.studies.precision import (
    OPTIONS,
    OWN,
    SOLID,
    STEPS,
    WorkPrecision,
    every_way,
    work_precision,
)
from harness.tables import Table
from harness.timing import Way
from reference_models import Named

CASES = [PRESETS["case1"], PRESETS["case2"]]
EULER = Named("euler-bernoulli", 3)
TRUTH = Named("timoshenko", None)
"""Stands for solids here: an answer that is known without a mesh."""


@pytest.fixture(scope="module")
def result() -> WorkPrecision:
    ways = [w for w in every_way(EULER, [], (1, 2, 4)) if w.poses <= 1]
    ways += [Way(Named("exudyn-cable", n)) for n in (1, 2, 4)]
    ways += [Way(Named("condensed", None), 100)]
    with Bench() as bench:
        return work_precision(CASES, ways, TRUTH, 2, bench)


def test_models_without_elements_have_no_error_of_their_own(result: WorkPrecision) -> None:
    exact = [p for p in result.points if p.size == "exact"]
    assert len(exact) == 7
    assert max(p.worst(OWN, 6) for p in exact) < 1e-7


def test_errors_fall_with_the_order_of_the_elements(result: WorkPrecision) -> None:
    for method, order in (("euler-bernoulli", 4), ("timoshenko", 2), ("exudyn-cable", 4)):
        coarse, fine = (
            next(p for p in result.points if (p.method, p.size) == (method, size))
            for size in ("2", "4")
        )
        ratio = coarse.worst(OWN, 3) / fine.worst(OWN, 3)
        assert 2 ** (order - 1) < ratio < 2 ** (order + 2), method


def test_formulations_of_one_model_have_one_error(result: WorkPrecision) -> None:
    for size in ("1", "2", "4"):
        errors = [
            p.worst(kind, 6)
            for p in result.points
            for kind in (OWN,)
            if p.size == size
            and p.method.startswith(("euler-bernoulli", "multipliers", "condensed[beam=euler"))
        ]
        assert len(errors) == 4
        np.testing.assert_allclose(errors, errors[0], rtol=1e-6)


def test_nothing_beats_the_front(result: WorkPrecision) -> None:
    for kind in (OWN, SOLID):
        front = result.front(kind, 6)
        assert front
        for point in front:
            assert not any(
                other.seconds < point.seconds and other.worst(kind, 6) < point.worst(kind, 6)
                for other in result.points
            )


def test_the_cheapest_way_is_within_its_target(result: WorkPrecision) -> None:
    for target in (1.0, 0.1, 0.01):
        best = result.cheapest(OWN, 6, target, many=False)
        assert best is not None and best.worst(OWN, 6) <= target
        faster = [p for p in result.points if p.seconds < best.seconds and p.poses <= 1]
        assert all(p.worst(OWN, 6) > target for p in faster)


def test_extrapolation_adds_times(result: WorkPrecision) -> None:
    at = {p.size: p for p in result.points if p.method == "exudyn-cable"}
    both = at["2"].seconds + at["4"].seconds
    assert at["2+4"].seconds == pytest.approx(both, rel=0.5)  # medians of sums of two rounds
    assert at["2+4"].worst(OWN, 3) < at["4"].worst(OWN, 3)


def test_euler_bernoulli_is_never_within_one_percent_of_solids(result: WorkPrecision) -> None:
    names = {p.method for p in result.points if p.worst(SOLID, 6) < 1}
    assert "timoshenko" in names
    assert not any(name.startswith("euler-bernoulli") for name in names)


def test_what_users_meet(result: WorkPrecision) -> None:
    frame = result.to_frame()
    assert {"method", "elements", "seconds_a_pose", "f1-f6_own_theory_percent"} <= set(frame)
    assert len(frame) == len(result.points)
    assert len(result.table().rows) == 12
    assert any("cheapest way to 0.1 %" in line for line in result.sentences())
    (figure,) = result.figures().values()
    assert len(figure.axes) == 4
    timed = [row for row in result.rows() if "work-precision" in row["settings"]]
    assert {row["model"] for row in timed} >= {"euler-bernoulli@2", "exudyn-cable@4"}


def test_every_way_has_every_theory_and_rival() -> None:
    methods = {way.method for way in every_way(EULER, [Named("exudyn-beam", (12, 24))], STEPS)}
    assert {"euler-bernoulli", "rayleigh", "timoshenko", "exudyn-beam"} <= methods
    assert {"multipliers[solver=null-space]", "multipliers[solver=saddle-point]"} <= methods


@pytest.mark.parametrize("text", ["0", "-1", "1001", "three", "", "1e2", "9" * 40])
def test_bad_numbers_of_rounds(text: str) -> None:
    with pytest.raises(InputError, match=r"^rounds = .*: expected a whole number from 1 to 1000$"):
        OPTIONS[0].parse(text)


def test_no_digit_of_its_tables_is_cut(
    result: WorkPrecision, whole: Callable[[Table], None]
) -> None:
    assert len(result.tables()) > 1
    for table in result.tables().values():
        whole(table)


def test_what_nobody_reads_is_written_all_the_same(
    result: WorkPrecision, writes_first: Callable[[str, object], None]
) -> None:
    writes_first("work-precision", result)
