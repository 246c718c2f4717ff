"""Time against error: errors are what independent calls give, verdicts what planted ones imply."""

import csv
import io
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analytic import Continuum, Modes, Substructure
from analytic.theory import BEAMS
from harness.cases import PRESETS
from harness.history.store import open_history
from harness.models import Spec
from harness.precision.report import cheapest, meets, precision_tables, verdict
from harness.precision.work_precision import (
    OWN,
    SOLID,
    Point,
    Truth,
    WorkPrecision,
    truths,
    work_precision,
)
from harness.run import Study
from harness.run import rows as study_rows
from reference_models import ModelError, reference
from reference_models.exudyn_cable import ExudynCable

CASES = [PRESETS["case1"], PRESETS["case2"]]
REFERENCES = ["exudyn-cable", "mujoco-chain"]
RIGID = "3-D elasticity, rigid end faces"


def planted(elements: Any, own: float, solid: float, ms: float, spread: float = 0.0) -> Point:
    seconds = 1e-3 * ms * np.array([1 - spread, 1, 1 + spread])
    errors = [np.full((1, 6), error) for error in (own, solid)]
    spec = Spec("timoshenko", elements)
    return Point("substructure, timoshenko", spec, "single", seconds, 6, *errors)


def known(points: list[Point], floor: float, unsure: float) -> WorkPrecision:
    """Return points of exact floor and truth uncertainty [%]."""
    exact = Continuum().modes(CASES[1].mechanism, CASES[1].pose)
    solid = replace(exact, uncertainty=exact.frequencies * unsure / 100)
    limits = {
        "timoshenko": Truth(Spec("timoshenko", None), {"case2": exact}),
        RIGID: Truth(Spec("calculix-solid", (8, 12)), {"case2": solid}),
    }
    floors = {"timoshenko": np.full((1, 6), floor), RIGID: np.zeros((1, 6))}
    study = Study((CASES[1],), (), 6, {}, {})
    return WorkPrecision(
        (CASES[1],), tuple(points), limits, floors, limits[RIGID], 3, {}, {}, study, []
    )


def test_errors_that_cancel_a_floor_are_not_precision() -> None:
    """A coarse mesh is high by what its theory is low: right, for the wrong reason."""
    lucky = planted(2, own=0.7, solid=0.001, ms=1)
    result = known([lucky, planted(8, 0.02, -0.68, 2)], floor=-0.7, unsure=0.01)
    points = list(result.points)
    assert not meets(result, lucky, SOLID, 6, 0.1)
    assert verdict(result, points, SOLID, 6, 0.1) == "not reachable: floor 0.7 %"
    assert verdict(result, points, SOLID, 6, 1.0) == "2: 1 ms"
    assert verdict(result, points, OWN, 6, 0.1) == "8: 2 ms"
    assert verdict(result, points, OWN, 6, 0.01) == "no: 8 is off by 0.02 %"


def test_a_truth_decides_no_more_than_it_knows() -> None:
    result = known([planted(4, 0.0, 0.02, 1)], floor=0.02, unsure=0.09)
    points = list(result.points)
    assert verdict(result, points, SOLID, 6, 0.1) == "undecided: 4 is off by 0.02 +- 0.09 %"
    assert verdict(result, points, SOLID, 6, 0.01) == "undecided: 4 is off by 0.02 +- 0.09 %"
    assert verdict(result, points, SOLID, 6, 1.0) == "4: 1 ms"


def test_of_equal_times_the_fewest_elements_are_cheapest() -> None:
    noisy = [planted(32, 0, 0, 0.98, 0.1), planted(3, 0, 0, 1.0, 0.1), planted(64, 0, 0, 2.0)]
    chosen = cheapest(noisy)
    assert chosen is not None and chosen.elements == "3"
    without = cheapest([*noisy, planted(None, 0, 0, 1.0, 0.1)])
    assert without is not None and without.elements == "exact"
    assert cheapest([]) is None


def test_every_theory_has_its_own_truth() -> None:
    found = truths(["exudyn-beam", "ngsolve-averaged", "ngsolve-solid"], Spec("calculix-solid", 8))
    assert set(found) == {
        "euler-bernoulli", "rayleigh", "timoshenko", RIGID, "3-D elasticity, averaged end faces",
    }  # fmt: skip
    assert found["timoshenko"] == Spec("timoshenko", None)
    assert found[RIGID] == Spec("calculix-solid", 8)


@pytest.fixture(scope="module")
def measured() -> WorkPrecision:
    return work_precision(CASES, [2, 3], REFERENCES, Spec("calculix-solid", 4), 2)


def modes_of(model: Any) -> list[Modes]:
    return [model.modes(case.mechanism, case.pose, 6) for case in CASES]


@pytest.mark.slow
def test_errors_are_those_of_separate_calls(measured: WorkPrecision) -> None:
    points = {(point.method, point.elements): point for point in measured.points}
    exact = np.array([m.frequencies for m in modes_of(Continuum())])
    solid = np.array([m.frequencies for m in modes_of(reference("calculix-solid", 4))])
    models = {
        ("substructure, euler-bernoulli", "2"): Substructure(2),
        ("exudyn-cable", "3"): reference("exudyn-cable", 3),
        ("mujoco-chain", "2+3"): reference("mujoco-chain", (2, 3)),
    }
    for key, model in models.items():
        found = np.array([m.frequencies for m in modes_of(model)])
        np.testing.assert_allclose(points[key].own, 100 * (found / exact - 1), atol=1e-6)
        np.testing.assert_allclose(points[key].solid, 100 * (found / solid - 1), atol=1e-6)
    same = points["condensed, euler-bernoulli", "2"].own
    assert same is not None
    np.testing.assert_allclose(same, points["substructure, euler-bernoulli", "2"].own, atol=1e-7)
    extrapolated = points["mujoco-chain", "2+3"]
    parts = [points["mujoco-chain", n].seconds for n in ("2", "3")]
    np.testing.assert_allclose(extrapolated.seconds, sum(parts))
    floor = measured.floors["euler-bernoulli"]
    np.testing.assert_allclose(floor, 100 * (exact / solid - 1), atol=1e-6)


@pytest.mark.slow
def test_rows_hold_what_was_judged(measured: WorkPrecision) -> None:
    names = ("case", "model", "settings", "mode")
    found = {tuple(row[name] for name in names): row for row in measured.rows}
    assert len(found) == len(measured.rows)
    for case, column in (("case1", 0), ("case2", 1)):
        truth = measured.limits["euler-bernoulli"].modes[case].frequencies
        for point in measured.points:
            rows = [
                row for row in measured.rows
                if row["case"] == case and row["model"] == point.spec.label
                and json.loads(row["settings"])["way"] == point.method
            ]  # fmt: skip
            assert [row["mode"] for row in rows] == list(range(1, len(rows) + 1))
            assert {(row["build_s"], row["solve_s"]) for row in rows} == {
                (0.0, float(np.median(point.seconds)))
            }
            assert {row["dofs"] for row in rows if "dofs" in row} <= {point.dofs}
            if point.spec.name == "euler-bernoulli":
                assert point.own is not None
                judged = truth * (1 + point.own[column] / 100)
                hertz = np.array([row["frequency_hz"] for row in rows])
                assert np.abs(hertz[:, None] / judged - 1).min(axis=0).max() < 1e-12
    # The truths are an ordinary study, whose rows are none of these.
    solid = {row["model"] for row in study_rows(measured.study)}
    assert solid == {*(f"{name}@exact" for name in BEAMS), "calculix-solid@4"}
    assert not set(found) & {tuple(r[name] for name in names) for r in study_rows(measured.study)}


@pytest.mark.slow
def test_tables_say_floors_and_versions(measured: WorkPrecision) -> None:
    tables = precision_tables(measured)
    rows = list(csv.DictReader(io.StringIO(tables["work-precision"].csv())))
    assert {row["Modes"] for row in rows} == {"f1-f3", "f1-f6"}
    for row in rows:
        assert row["Case"] == "case1 and case2" and float(row["ms a pose"]) > 0
        assert float(row["q1 [ms]"]) <= float(row["ms a pose"]) <= float(row["q3 [ms]"])
    text = tables["cheapest-models"].markdown()
    assert "not reachable: floor" in text and "ccx" in text
    assert len(tables["cheapest"].rows) == 4 * 2 * 3  # three beam theories and solids


@pytest.mark.slow
def test_command(
    rps_bench: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A simulator that fails costs its own points, and the exit status."""

    def broken(*_: object) -> None:
        raise ModelError("exudyn-cable: no solution")

    monkeypatch.setattr(ExudynCable, "modes", broken)
    answer = rps_bench(
        "work-precision", "--elements", "1,2", "--references", "exudyn-cable,mujoco-chain",
        "--truth", "calculix-solid@4", "--repeats", "1", "--cases", "case1",
        "--output", str(tmp_path), "--history", str(tmp_path / "history"),
    )  # fmt: skip
    assert answer.status == 1
    assert answer.err.count("exudyn-cable@1 failed") == 1 and "no solution" in answer.err
    past = open_history(tmp_path / "history").query("SELECT * FROM rows WHERE mode = 1")
    assert set(past["command"].str.split(" ").list[1]) == {"work-precision"}
    assert {"calculix-solid@4", "mujoco-chain@2", "rayleigh@exact"} <= set(past["model"])
    assert "exudyn-cable@1" not in set(past["model"])
    stems = {path.name for path in tmp_path.iterdir()}
    assert {"work-precision.svg", "work-precision.csv", "cheapest.csv", "cheapest.tex"} <= stems
    written = (tmp_path / "work-precision.csv").read_text()
    assert "mujoco-chain" in written and "exudyn-cable" not in written
