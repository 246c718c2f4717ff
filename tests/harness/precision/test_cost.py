"""The timing study: its structure, its fits and its claims; never how fast this machine is."""

import csv
import io
import json
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analytic import Continuum, Substructure
from analytic.kernel import compiled
from harness import published, sections
from harness.cases import PRESETS
from harness.gate.study import YARDSTICK
from harness.history.store import COLUMNS, open_history
from harness.models import Spec
from harness.precision import cost as study
from harness.precision.cost import Cost, Timing, growth, measure
from harness.precision.cost_report import cost_figure, cost_tables
from harness.reproduce import Plan
from harness.run import rows, run
from reference_models import ModelError, reference
from reference_models.exudyn_cable import ExudynCable

LOOPS = ["condensed"] + (["condensed, compiled"] if compiled() else [])
OURS = [
    "substructure, dense",
    "substructure, sparse",
    "multipliers, null-space",
    "multipliers, saddle-point",
    *LOOPS,
]


@pytest.fixture(scope="module")
def cost() -> Cost:
    return measure([1, 2, 4], ["exudyn-beam", "mujoco-cable"], [1, 20], 2)


def planted(model: str, sizes: list[int], seconds: Callable[[float], float]) -> list[Timing]:
    noise = np.array([0.9, 1.0, 1.1])
    return [Timing(model, s, None, None, seconds(s) * noise, seconds(s) * noise) for s in sizes]


def test_a_planted_growth_is_found() -> None:
    sizes = [1, 2, 4, 8, 16, 32, 64]
    timings = planted("cubic", sizes, lambda s: 1e-4 * s**2.5)
    timings += planted("constant", sizes, lambda s: 3e-3)
    timings += planted("overhead", sizes, lambda s: 5e-3 + 1e-5 * s**2)
    timings += planted("too few", [1, 2], lambda s: s)
    cubic, constant, overhead = growth(timings)
    assert cubic.exponent == pytest.approx(2.5, abs=1e-12)
    assert cubic.error == pytest.approx(0, abs=1e-7)
    assert constant.exponent == pytest.approx(0, abs=1e-12)
    assert overhead.error > 0.05
    late = growth(timings, 8)[2]
    assert late.sizes == (8, 16, 32, 64)
    assert overhead.exponent < late.exponent < 2


def test_standard_error_by_hand() -> None:
    seconds = {1: 1.0, 2: 3.0, 4: 4.0, 8: 9.0}
    (fit,) = growth(planted("odd", list(seconds), lambda s: seconds[int(s)]))
    x, y = np.log(list(seconds)), np.log(list(seconds.values()))
    slope = ((x - x.mean()) * y).sum() / ((x - x.mean()) ** 2).sum()
    rest = y - y.mean() - slope * (x - x.mean())
    assert fit.exponent == pytest.approx(slope)
    error = np.sqrt((rest**2).sum() / 2 / ((x - x.mean()) ** 2).sum())
    assert fit.error == pytest.approx(error)


@pytest.mark.slow
def test_everything_is_timed_in_every_round(cost: Cost) -> None:
    found = {(timing.model, timing.size) for timing in cost.elements}
    # The paper's three elements are always there; the MuJoCo cable starts at three.
    wanted = {(name, s) for name in [*OURS, "exudyn-beam"] for s in (1, 2, 3, 4)}
    wanted |= {("mujoco-cable", 3), ("mujoco-cable", 4), ("continuum", None)}
    wanted |= {(loop, None) for loop in LOOPS}
    assert found == wanted
    assert "not at s=2" in cost.left_out["mujoco-cable"]
    assert {(t.model, t.size) for t in cost.batches} == {
        (f"{loop}, {s}", size)
        for loop in LOOPS
        for s in ("s=1", "s=4", "exact")
        for size in (1, 20)
    }
    for timing in (*cost.elements, *cost.batches):
        assert timing.seconds.shape == timing.ratios.shape == (2,)
        assert (timing.seconds > 0).all() and np.isfinite(timing.ratios).all()
    assert (cost.yardstick.ratios == 1).all() and not cost.failures


@pytest.mark.slow
def test_dofs_are_the_models(cost: Cost) -> None:
    dofs = {(t.model, t.size): t.dofs for t in cost.elements}
    for s in (1, 2, 4):
        assert dofs["substructure, dense", s] == dofs["multipliers, null-space", s] == 18 * s
        assert dofs["multipliers, saddle-point", s] == 18 * s + 48
    assert dofs["condensed", 1] is None and dofs["continuum", None] == 6


@pytest.mark.slow
def test_ratios_are_to_the_same_round(cost: Cost) -> None:
    for timing in cost.elements:
        np.testing.assert_allclose(timing.ratios * cost.yardstick.seconds, timing.seconds)
    for timing in cost.batches:
        np.testing.assert_allclose(timing.ratios * cost.floor.seconds, timing.seconds)


@pytest.mark.slow
def test_claims_stand_beside_what_was_measured(cost: Cost) -> None:
    table = cost_tables(cost)["cost-claims"]
    rows = {row[0]: row for row in csv.reader(io.StringIO(table.csv()))}
    assert [float(rows[name][2]) for name in ("theoretical model", "finite-element model")] == [
        0.82,
        6.16,
    ]
    saved = rows["cost saved against exudyn-beam@12+24"]
    assert float(saved[2]) == 86.69
    assert np.isfinite(float(saved[3]))
    for name in OURS[2:4]:
        assert float(rows[name][3]) > 0 and np.isfinite(
            float(rows[f"cost saved against {name}"][3])
        )
    # The paper: 0.18 to 0.13 % and 0.36 to 0.29 % from one element to three.
    for case, points in (("case1", 0.05), ("case2", 0.07)):
        row = rows[f"f1 of {case}, s=1 to s=3"]
        assert float(row[2]) == pytest.approx(points)
        assert 0 < float(row[3]) < 0.1
        f1, f6 = (float(rows[f"f{i} of {case}, s=1 to s=4"][3]) for i in (1, 6))
        assert f1 < 0.1 and f6 > 10


def keys(found: list[dict[str, Any]]) -> list[tuple[Any, ...]]:
    """What tells rows apart, by settings but for the modes solved for, which tell no way apart."""
    return [
        (row["case"], row["mechanism"], row["model"], row["mode"],
         *sorted((k, v) for k, v in json.loads(row["settings"]).items() if k != "count"))
        for row in found
    ]  # fmt: skip


@pytest.mark.slow
def test_every_way_has_rows_of_its_own(cost: Cost) -> None:
    case, found = PRESETS["case2"], cost.rows
    assert all(set(row) <= set(COLUMNS) for row in found)
    timings = [cost.yardstick, *cost.elements, cost.stand_in, *cost.batches]
    assert len(set(keys(found))) == len(found) == 6 * len(timings)
    # A model that was solved once, for a table, is another way to time it, too.
    specs = [Spec("euler-bernoulli", 3), Spec("exudyn-beam", 4), Spec("exudyn-beam", (12, 24))]
    assert not set(keys(found)) & set(keys(rows(run([case], specs, 6))))
    # The gate's series is its own: nothing here passes for its yardstick.
    assert YARDSTICK not in {row[name] for row in found for name in ("case", "model")}
    again = measure([1], ["exudyn-beam"], [1], 1).rows
    assert set(keys(again)) < set(keys(found)) and len(again) > 60


@pytest.mark.slow
def test_rows_hold_what_was_timed(cost: Cost) -> None:
    case = PRESETS["case2"]
    found = dict(zip(keys(cost.rows), cost.rows, strict=True))

    def hertz(model: str, where: str = "case2", **how: Any) -> list[float]:
        tail = tuple(sorted({"timed": "cost", **how}.items()))
        (mechanism,) = {row["mechanism"] for row in cost.rows}
        chosen = [found[(where, mechanism, model, mode, *tail)] for mode in range(1, 7)]
        seconds = {(row["build_s"], row["solve_s"]) for row in chosen}
        assert len(seconds) == 1 and seconds < every
        return [row["frequency_hz"] for row in chosen]

    timings = (cost.yardstick, cost.stand_in, *cost.elements, *cost.batches)
    every = {(0.0, float(np.median(timing.seconds))) for timing in timings if timing}
    close = pytest.approx
    for s in (1, 3):
        expected = Substructure(s).modes(case.mechanism, case.pose, 6).frequencies
        for way in OURS:
            assert hertz(f"euler-bernoulli@{s}", way=way) == close(expected, rel=1e-8)
    assert hertz("euler-bernoulli@3", way=study.YARDSTICK) == close(expected, rel=1e-8)
    beam = reference("exudyn-beam", (12, 24)).modes(case.mechanism, case.pose, 6).frequencies
    how = {"way": "exudyn-beam", "shear": "cowper"}
    assert hertz("exudyn-beam@12+24", **how) == close(beam, rel=1e-9)
    for size in (1, 20):
        pose = study.random_poses(size)[0]
        exact = Continuum().modes(case.mechanism, pose, 6).frequencies
        for loop in LOOPS:
            many = hertz("euler-bernoulli@exact", "random", way=loop, poses=size)
            assert many == close(exact, rel=1e-8)


@pytest.mark.slow
def test_the_main_job_keeps_the_rows(cost: Cost, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(study, "measure", lambda *_: cost)
    plan = Plan((PRESETS["case1"],), Spec("euler-bernoulli", 3), (), (1,), (1,))
    assert sections.cost(plan, print).rows == cost.rows


def test_the_published_percentage_follows_from_the_published_seconds() -> None:
    said = published.cost()
    saved = 100 * (1 - said["theoretical model"] / said["finite-element model"])
    assert saved == pytest.approx(said["cost saved"], abs=0.005)


@pytest.mark.slow
def test_tables_have_every_form_and_say_the_circumstances(cost: Cost) -> None:
    tables = cost_tables(cost)
    assert list(tables) == ["cost-elements", "cost-growth", "cost-batches", "cost-claims"]
    for table in tables.values():
        assert table.rows and table.latex().count("\\\\") == len(table.rows) + 1
    notes = " ".join(tables["cost-elements"].notes)
    assert "condensed: plain numpy" in notes
    assert "one BLAS thread" in notes and "2 rounds" in notes and "not at s=2" in notes
    exponents = [row[2].value for row in tables["cost-growth"].rows]  # type: ignore[union-attr]
    assert np.isfinite(exponents).all() and len(exponents) == len(OURS) + 1
    assert "calculix" not in tables["cost-growth"].markdown()


@pytest.mark.slow
def test_figure_has_a_line_for_every_model(cost: Cost) -> None:
    left, right = cost_figure(cost).axes
    shown = [text.get_text() for text in left.get_legend().get_texts()]  # type: ignore[union-attr]
    exact = [f"{name}, exact" for name in (*LOOPS, "continuum")]
    both = [*OURS, "exudyn-beam", "mujoco-cable", *exact]
    assert shown == both
    for axes in (left, right):
        assert axes.get_xscale() == axes.get_yscale() == "log"
    assert len(right.lines) == 3 * len(LOOPS)


@pytest.mark.slow
def test_long_runs_end_a_series(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(study, "LONG", 0.0)
    monkeypatch.setattr(study, "SLOW", 0.0)
    cost = measure([1, 2], [], [1], 5)
    sizes = [t.size for t in cost.elements if t.model == "substructure, dense"]
    assert sizes == [1] and "not beyond s=1" in cost.left_out["substructure, dense"]
    assert all(len(t.seconds) == study.FEW for t in cost.elements)


def test_what_is_loaded_once_ends_no_series(monkeypatch: pytest.MonkeyPatch) -> None:
    """A compiler that only the second size needs is not that size's cost."""
    monkeypatch.setattr(study, "LONG", 0.05)
    naps = {4: [0.0, 0.0], 8: [0.1, 0.0], 16: [0.1, 0.1], 32: [0.0, 0.0]}
    jobs = [
        study.Job("compiled", s, lambda s=s: time.sleep(naps[s].pop(0)), growing=True) for s in naps
    ]
    left_out: dict[str, str] = {}
    warm = study.warm_up(jobs, left_out, {})
    assert [w.job.size for w in warm] == [4, 8, 16]
    assert "not beyond s=16" in left_out["compiled"]


@pytest.mark.slow
def test_a_failing_simulator_costs_only_itself(
    rps_bench: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def broken(*_: object) -> None:
        raise ModelError("exudyn-cable: no solution")

    monkeypatch.setattr(ExudynCable, "modes", broken)
    answer = rps_bench(
        "cost", "--elements", "1", "--references", "exudyn-cable", "--repeats", "1",
        "--batches", "1", "--output", str(tmp_path), "--history", str(tmp_path / "history"),
    )  # fmt: skip
    assert answer.status == 1
    past = open_history(tmp_path / "history").query("SELECT DISTINCT command, model FROM rows")
    assert set(past["model"]) == {f"euler-bernoulli@{s}" for s in (1, 3, "exact")}
    assert past["command"][0].startswith("rps-bench cost --elements 1 --references exudyn-cable")
    assert "exudyn-cable@3 failed at case2: exudyn-cable: no solution" in answer.err
    assert "0.82" in answer.out and "6.16" not in answer.out
    names = {path.name for path in tmp_path.iterdir()}
    assert {"cost.svg", "cost.png", "cost-elements.csv", "cost-claims.tex"} <= names
    missing = replace(ExudynCable.info(), missing="no Exudyn; pip install exudyn")
    monkeypatch.setattr(ExudynCable, "info", staticmethod(lambda: missing))
    answer = rps_bench("cost", "--references", "exudyn-cable")
    assert answer.status == 2 and "cannot run here: no Exudyn" in answer.err


@pytest.mark.slow
def test_one_thread_is_what_is_timed(monkeypatch: pytest.MonkeyPatch) -> None:
    from threadpoolctl import threadpool_info, threadpool_limits

    seen: set[int] = set()
    honest = Substructure.modes

    def watched(self: Substructure, *arguments: Any) -> Any:
        seen.update(pool["num_threads"] for pool in threadpool_info())
        return honest(self, *arguments)

    monkeypatch.setattr(Substructure, "modes", watched)
    with threadpool_limits(2):
        measure([1], [], [1], 1)
    assert seen == {1}
