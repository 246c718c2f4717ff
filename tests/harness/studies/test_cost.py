"""What a frequency costs: parts add up, growth is read right, a failure costs itself alone."""

import re
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from analytic import Substructure
from harness.bench import Bench
from harness.case_file import load_cases
from harness.cases import PRESETS
from harness.studies.cost import FLOOR, YARDSTICK, Cost, measure
from harness.studies.cost.measured import plain_pair, quartiles, simulators_table
from harness.studies.cost.work import counted, exponent, grown
from harness.tables import Table
from harness.timing import Timed, Way, time_ways
from harness.unbeaten import unbeaten
from reference_models import Named

CASE = PRESETS["case2"]
EULER = Named("euler-bernoulli", 3)
MECHANISMS = Path(__file__).parents[3] / "results/published/mechanisms.toml"


@pytest.fixture(scope="module")
def cost() -> Cost:
    references = [Named("exudyn-cable", (4, 8)), Named("mujoco-cable", (4, 8))]
    with Bench() as bench:
        return measure(CASE, EULER, references, (1, 2, 4), (1, 100), 2, bench, 200)


def test_modes_say_what_they_took_to_build_and_to_solve(cost: Cost) -> None:
    for t in cost.elements:
        assert t.median("build") > 0 < t.median("solve"), t.way.method
        # What is left of a call is of that call: parts of other calls could be longer than it.
        assert ((t.each("rest") > 0) & (t.each("rest") < t.each("seconds"))).all(), t.way.method
    for t in cost.batches:  # frequencies say nothing of it
        assert np.isnan([t.median(name) for name in ("build", "solve", "rest")]).all()


def test_coordinates_are_counted(cost: Cost) -> None:
    for s in (1, 2, 3, 4):
        own = cost.at("euler-bernoulli", s)
        assert own is not None and own.dofs == 6 + 3 * (6 * s - 2)


def test_ratios_are_to_the_same_round(cost: Cost) -> None:
    own = cost.at("euler-bernoulli")
    assert own is not None
    yard = cost.timings.yardsticks[YARDSTICK]
    np.testing.assert_allclose(cost.ratios(own, YARDSTICK) * yard, own.each("seconds"))
    assert (cost.timings.yardsticks[FLOOR] < yard).all()


def test_meshes_that_a_simulator_cannot_have_are_left_out(cost: Cost) -> None:
    assert cost.failures() == {}
    why = cost.timings.left_out["mujoco-cable"]  # which needs three segments
    assert why.startswith("not with s = 2 (elements = 2: expected")
    assert cost.at("mujoco-cable", 4) is not None
    assert cost.at("exudyn-cable", 1) is not None


def test_growth_is_read_from_made_up_times(cost: Cost) -> None:
    own = next(t for t in cost.elements if t.way.method == "euler-bernoulli")
    made = tuple(
        Timed(
            way, own.first, (replace(own.first, seconds=2e-5 * (way.model.elements or 0) ** 1.5),)
        )
        for way in (Way(replace(EULER, elements=s)) for s in (1, 2, 4, 8, 16))
    )
    found = grown(made, (1, 2, 4, 8, 16), CASE)
    sizes, slope, _ = exponent(found["euler-bernoulli", "time"])
    assert slope == pytest.approx(1.5, abs=1e-9) and sizes == "1-16"
    assert exponent(found["euler-bernoulli", "time"], 8)[0] == "-"  # two sizes give no line
    assert {what for _, what in found} == {
        "time", "solve time", "operations, dense", "operations, sparse",
    }  # fmt: skip


def test_counted_work_knows_no_machine(cost: Cost) -> None:
    """Cubic where it is dense, linear in s where it is sparse; multipliers take more."""
    work = [counted("paper", s, CASE) for s in (2, 4, 8)]
    assert [one.dofs for one in work] == [36, 72, 144]
    for few, many in pairwise(work):
        assert 2.8 < np.log2(many.flops / few.flops) < 3.01
    long = [counted("paper", s, CASE).flops for s in (32, 64, 128)]
    for few, many in pairwise(long):
        assert 0.9 < np.log2(many / few) < 1.1
    for formulation in ("null-space", "saddle-point"):
        assert cost.operations(formulation) > 1


def test_what_users_meet(cost: Cost) -> None:
    frame = cost.to_frame()
    assert {"method", "elements", "seconds_a_pose", "build_s", "solve_s", "dofs"} <= set(frame)
    endings = ["-elements", "-growth", "-work", "-batches", "-ratios", "-simulators", "-cores",
               "-peers", "-claims"]  # fmt: skip
    assert list(cost.tables()) == endings
    assert all(table.rows for table in cost.tables().values())
    assert cost.plot() is not None
    said = " ".join(cost.sentences())
    assert "6x6 numpy.linalg.eigh" in said and "multipliers (saddle-point)" in said
    assert all(row["solve_s"] > 0 for row in cost.rows())


def test_what_nothing_beats() -> None:
    points = [(1, 5.0), (2, 4.0), (2, 4.5), (4, 4.0), (8, 9.0)]
    assert unbeaten(points, lambda p: (p[1], -p[0])) == [(4, 4.0), (8, 9.0)]
    assert unbeaten(points, lambda p: p) == [(1, 5.0), (2, 4.0)]


def test_the_picture_names_what_nothing_beats_and_no_more(cost: Cost) -> None:
    for axes in cost.plot().axes:
        names = [text.get_text() for text in axes.texts]
        assert 0 < len(names) < 5 and len(set(names)) == len(names)
        assert len({line.get_color() for line in axes.lines}) == 2  # the front and the rest


def test_somebody_elses_case_has_no_claims(cost: Cost) -> None:
    own = replace(cost, case=replace(CASE, name="mine", paper=None, published=""))
    assert "-claims" not in own.tables()


def test_the_plain_assembly_is_the_same_pair() -> None:
    for s in (1, 2, 3, 8):
        own = Substructure(s).matrices(CASE.mechanism, CASE.pose)
        for plain, ours in zip(plain_pair(CASE.mechanism, CASE.pose, s), own, strict=True):
            scale = np.abs(plain).max()
            np.testing.assert_allclose(ours.toarray(), plain, atol=1e-13 * scale)


def test_ratios_are_of_what_they_say(cost: Cost) -> None:
    for one in cost.plain:
        assert (one.own > 0).all() and (one.yard > 0).all()
        middle, low, high = quartiles(one.own / one.yard)
        assert low <= middle <= high
    whats = [one.what for one in cost.plain]
    assert len(set(whats)) == len(whats)
    assert {"modes of s=3", "exact modes, certified", "condensed, s=64, 100 poses"} <= set(whats)


def test_simulators_say_where_their_time_goes(cost: Cost) -> None:
    simulated = [t for t in cost.elements if t.way.model.info().isolated]
    assert {t.way.method for t in simulated} == {"exudyn-cable", "mujoco-cable"}
    for t in simulated:
        assert t.phases["simulator"] > 0 and t.phases["projection"] > 0
    for t in cost.elements:
        assert t in simulated or sum(v for k, v in t.phases.items() if k) == 0


def test_no_part_of_a_simulators_time_is_a_difference_of_medians(cost: Cost) -> None:
    one = next(t for t in cost.elements if t.way.method == "exudyn-cable")
    # Two phases are slow in turns: their medians are more than the median of the whole.
    rounds = tuple(
        replace(one.first, seconds=total, phases=dict.fromkeys(one.first.phases, 0.0) | parts)
        for total, parts in (
            (10.5, {"simulator": 9.0, "eigen-solution": 1.0, "": 0.5}),
            (10.5, {"simulator": 1.0, "eigen-solution": 9.0, "": 0.5}),
            (18.5, {"simulator": 9.0, "eigen-solution": 9.0, "": 0.5}),
        )
    )
    frame = simulators_table([replace(one, rounds=rounds)]).to_frame()
    assert frame["rest [ms]"].tolist() == [500.0]


def test_every_core_has_its_poses(cost: Cost) -> None:
    assert cost.many[0].cores == 1
    for one in cost.many:
        assert one.poses == 200 * one.cores
        assert one.rate == pytest.approx(6 * one.poses / one.seconds)
        assert not one.megabytes <= 10  # NaN where the system does not say


def test_no_digit_of_its_tables_is_cut(cost: Cost, whole: Callable[[Table], None]) -> None:
    assert len(cost.tables()) > 1
    for table in cost.tables().values():
        whole(table)


def test_what_nobody_reads_is_written_all_the_same(
    cost: Cost, writes_first: Callable[[str, object], None]
) -> None:
    writes_first("cost", cost)


@pytest.mark.slow
def test_limbs_of_any_chain_have_a_cost_too() -> None:
    """3-PRS: counted work of its own matrices, and all that is measured of R-P-S limbs."""
    case = load_cases(MECHANISMS)["prs"]
    with Bench() as bench:
        found = measure(case, EULER, (), (1, 2), (1,), 1, bench, 1)
    assert found.failures() == {}
    assert [name for name, table in found.tables().items() if not table.rows] == ["-simulators"]
    for t in found.elements:
        if t.way.method == "euler-bernoulli" and (s := t.way.model.elements):
            assert t.dofs == counted("paper", s, case).dofs == 9 + 18 * s
    assert {"null-space", "saddle-point"} <= {
        dict(t.way.model.settings).get("solver") for t in found.elements
    }
    assert found.operations("null-space") > 1 and found.operations("saddle-point") > 1
    assert "limb 1, P-body-R-rod-S" in found.peers.reason or "OpenSees needs" in found.peers.reason


def test_no_more_poses_are_asked_of_what_is_slow(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("harness.timing.LONG_BATCH", 0.0)
    loop = Named("condensed", None, (("fast", False),))
    ways = [Way(loop, 10), Way(loop, 100), Way(replace(loop, elements=2), 100)]
    with Bench() as bench:
        timings = time_ways(bench, ways, [CASE], 1, 6)
    assert [t.way for t in timings.timed] == [ways[0], ways[2]]
    assert re.search(r"not beyond 10: .* s a call", " ".join(timings.left_out.values()))


def test_what_a_model_cannot_take_is_left_out_and_no_failure() -> None:
    prs = load_cases(MECHANISMS)["prs"]
    ways = [Way(Named("euler-bernoulli", 2)), *(Way(Named("mujoco-cable", s)) for s in (4, 8))]
    with Bench() as bench:
        timings = time_ways(bench, ways, [prs], 1, 6)
    assert [t.way for t in timings.timed] == ways[:1]
    assert timings.failures == {}
    assert "limb 1, P-body-R-rod-S" in timings.left_out["mujoco-cable"]
