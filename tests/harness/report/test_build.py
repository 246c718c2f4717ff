"""What the page is made of, without opening it."""

import csv
import json
import re
import shutil
import time
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from analytic.theory import BEAMS
from harness.cases import PRESETS
from harness.history import store
from harness.report import fig3, history, workspace
from harness.report.ledger import Ledger, variant
from harness.report.page import page
from harness.report.recorded import read_recorded
from harness.report.sources import read_sources
from harness.run import MANY_POSES, mechanism_hash

MOST_BYTES = 8_000_000


def test_size_and_what_it_may_do(made: Any) -> None:
    content = made.file.read_text()
    assert len(content.encode()) < MOST_BYTES
    assert "default-src 'none'" in content
    assert not re.search(r'(src|href)="(?!#|data:)', content)


def test_fig3_errors_are_those_of_the_accepted_tables(made: Any) -> None:
    """Against the tables of `rps-bench reproduce`, which paired by the simulators' own shapes."""
    cases = fig3.section(made.sources, Ledger(made.sources)).data["cases"]
    with (made.results / "references.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    compared = 0
    for row in rows:
        for label, text in row.items():
            if label in ("Case", "Mode", "euler-bernoulli@3"):
                continue
            errors = cases[row["Case"]]["theories"]["euler-bernoulli"]["errors"][label]
            shown = float(re.search(r"\(([-+.\d]+) %\)", text)[1])
            assert errors[2][int(row["Mode"][1:]) - 1] == pytest.approx(shown, abs=6e-4)
            compared += 1
    assert compared >= 12 * 2


def test_frequencies_too_far_from_any_theory_are_not_paired(made: Any) -> None:
    study = made.sources.study
    exact = {beam: study.modes["case2", f"{beam}@exact"].frequencies for beam in BEAMS}
    f = exact["timoshenko"][:6].copy()
    assert fig3.nearest(1.005 * f, exact) == "timoshenko"
    assert fig3.nearest(1.1 * f, exact) is None
    f[[0, 1]] = f[[1, 0]]
    assert fig3.nearest(f, exact) is None


def test_history_is_kept_where_it_changes(made: Any) -> None:
    data = history.section(made.sources, Ledger(made.sources)).data
    assert history.changes([5, 5, 7, 7, 5]) == [5, 0, 5, 2, 7, 4, 5]
    (one,) = [
        s for s in data["series"] if (s["case"], s["model"]) == ("case1", "euler-bernoulli@3")
    ]
    length, _, first, place, second = one["f"]["1"]
    assert (length, place) == (3, 1)
    assert first == pytest.approx(second * (1 - 1e-6), rel=1e-11)


def workspace_sets(sources: Any) -> dict[str, Any]:
    return {one["name"]: one for one in workspace.section(sources, Ledger(sources)).data}


def test_equal_maps_are_kept_once(made: Any) -> None:
    gate = workspace_sets(made.sources)["the gate's poses"]
    kept = [[run["models"][m]["values"] for run in gate["runs"]] for m in gate["runs"][0]["models"]]
    assert sorted(len(set(row)) for row in kept) == [1, 2], "one model changed, once"
    assert len(gate["values"]) == 3
    assert np.shape(gate["values"]) == (3, 6, 108)


def test_recorded_maps_stand_beside_the_accepted_one(made: Any) -> None:
    """Those of the same poses and mechanism; other poses are a choice of their own."""
    sets = workspace_sets(made.sources)
    assert list(sets) == ["109 poses, 318 mm", "30 poses, 318 mm", "the gate's poses"]
    detailed = sets["109 poses, 318 mm"]
    assert np.shape(detailed["values"][0]) == (3, 109)
    kept = [(run["name"].split(",")[0], model, about["values"])
            for run in detailed["runs"] for model, about in run["models"].items()]  # fmt: skip
    assert kept == [
        ("accepted", "timoshenko@exact", 0),
        ("2026-03-03 16:00:00", "timoshenko@exact", 1),
        ("2026-03-03 15:00:00", "euler-bernoulli@3", 0),
        ("2026-03-03 14:00:00", "timoshenko@exact", 0),
    ]
    first, second = np.array(detailed["values"])
    assert (first != second).sum() == 1
    assert (second / first).max() == pytest.approx(1 + 1e-5, rel=1e-9)


def test_a_row_of_heights_is_no_map(made: Any) -> None:
    assert "rps-bench claims" in made.sources.recorded.runs["command"].to_list()
    claims = made.sources.recorded.runs.filter(command="rps-bench claims")["run"][0]
    assert claims not in made.sources.recorded.maps["run"].to_list()


def test_maps_that_find_no_room_are_counted_and_named(made: Any) -> None:
    maps = made.sources.recorded.maps
    both = sum(maps.filter(case=case)["numbers"][0] for case in ("map", "workspace"))
    recorded = read_recorded(made.history, both + len(made.sources.recorded.points))
    assert len(recorded.answers) <= both
    sets = workspace_sets(replace(made.sources, recorded=recorded))
    assert sets["the gate's poses"]["note"] == (
        "Recorded, but no room on the page: 3 more, of timoshenko@exact."
    )
    assert "of euler-bernoulli@3, timoshenko@exact." in sets["109 poses, 318 mm"]["note"]
    assert [run["name"] for run in sets["109 poses, 318 mm"]["runs"]] == ["accepted"]


def test_a_map_too_large_is_left_out_and_named(made: Any, tmp_path: Path) -> None:
    shutil.copy(made.results / "table1.csv", tmp_path)
    (tmp_path / "workspace").mkdir()
    header, *lines = (made.results / "workspace" / "map.csv").read_text().splitlines()
    (tmp_path / "workspace" / "map.csv").write_text("\n".join([header, *lines * 300]))
    sources = read_sources(tmp_path, None)
    assert sources.map.is_empty()
    assert sources.skipped == (("map.csv", "of 36,000 poses: too large for the page"),)


def test_what_rows_are_apart_by_in_words() -> None:
    assert variant(None) == variant('{"count": 8, "shear": "cowper"}') == ""
    assert variant('{"count": 8, "shear": 0.9}') == "shear 0.9"
    timed = '{"count": 6, "way": "condensed", "timed": "cost", "poses": 1000}'
    assert variant(timed) == "condensed, timed by cost, batches of 1000 poses"
    assert variant('{"case": "case1", "fitted": {"z_mm": 540.5, "d": 2}}') == (
        "case1, fitted (z_mm 540.5, d 2)"
    )
    assert variant("{") == "settings {"
    assert variant("[1]") == "settings [1]"


def test_another_mechanism_or_pose_is_another_series(made: Any, tmp_path: Path) -> None:
    own = {"case": "case1", "mechanism": mechanism_hash(PRESETS["case1"].mechanism), "mode": 1,
           "model": "m@3", "frequency_hz": 1.0, "z_m": 0.49, "azimuth_rad": 0.0,
           "tilt_rad": 0.0, "settings": '{"count": 6}'}  # fmt: skip
    rows = [own, own | {"mechanism": "thin"}, own | {"z_m": 0.5}]
    store.append(tmp_path, rows, "rps-bench slenderness")
    sources = read_sources(made.results, tmp_path)
    series = history.section(sources, Ledger(sources)).data["series"]
    assert {one["variant"] for one in series} == {
        "", "mechanism thin", "z = 500 mm, azimuth 0°, tilt 0°"}  # fmt: skip


def test_of_too_many_series_the_newest_are_shown(
    made: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(history, "MOST_SERIES", 20)
    row = {"case": "case1", "mode": 1, "frequency_hz": 1.0}
    for day, first in ((1, 0), (2, 15)):
        rows = [row | {"model": f"m@{first + k}"} for k in range(15)]
        store.append(tmp_path, rows, "rps-bench table", datetime(2026, 1, day, tzinfo=UTC))
    sources = read_sources(made.results, tmp_path)
    series = history.section(sources, Ledger(sources)).data["series"]
    assert len(series) == 20
    assert {f"m@{15 + k}" for k in range(15)} < {one["model"] for one in series}
    assert "The newest 20 of 30 series." in page(sources).decode()


def test_the_order_of_rows_says_nothing(made: Any, tmp_path: Path) -> None:
    """The same runs, their rows the other way round in the file, make the same page."""
    about = {
        "case": "map",
        "mechanism": "m",
        "model": "m@3",
        "z_m": 0.4,
        "tilt_rad": 0.0,
        "mode": 1,
    }
    level = [about | {"azimuth_rad": 0.1 * k, "frequency_hz": 100.0 + k} for k in range(12)]
    pages = []
    for turn in (1, -1):
        folder = tmp_path / str(turn)
        store.append(folder, level[::turn], "one pose", datetime(2026, 2, 1, tzinfo=UTC))
        for path in sorted(made.history.glob("2*.parquet")):
            frame = pl.read_parquet(path)
            time = frame["time"][0].replace(tzinfo=UTC)
            store.append(folder, frame.drop("run", "time")[::turn].to_dicts(), "again", time)
        sources = read_sources(made.results, folder)
        data = history.section(sources, Ledger(sources)).data
        sets = workspace_sets(sources)
        pages.append([data["series"], data["yardstick"], [one["values"] for one in sets.values()]])
    assert pages[0] == pages[1]


def test_sweeps_are_counted_not_read(made: Any) -> None:
    recorded = made.sources.recorded
    assert not set(recorded.points["case"]) & set(MANY_POSES)
    (sweep,) = recorded.sweeps.to_dicts()
    assert (sweep["models"], sweep["poses"], sweep["rows"]) == (
        "rayleigh@3, timoshenko@exact",
        7,
        28,
    )


def test_a_history_of_a_sweep_alone(
    made: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is listed, and its rows stay where they are: no question has more than one as answer."""
    sweep = pl.LazyFrame({"z_m": np.linspace(0.3, 0.9, 100_000)}).with_columns(
        pl.lit("sweep").alias("case"), pl.lit("m@3").alias("model"),
        pl.lit(1).alias("mode"), pl.lit(1.0).alias("frequency_hz"),
    )  # fmt: skip
    store.append(tmp_path, sweep, "rps-bench sweep")
    read, query = [], store.History.query

    def counted(*asked: Any) -> pl.DataFrame:
        read.append(query(*asked))
        return read[-1]

    monkeypatch.setattr(store.History, "query", counted)
    sources = read_sources(made.results, tmp_path)
    assert max(map(len, read)) == 1
    assert history.section(sources, Ledger(sources)).data is None
    assert b"The newest of 1 recorded sweeps" in page(sources)


def test_a_page_of_almost_nothing(made: Any, tmp_path: Path) -> None:
    shutil.copy(made.results / "table1.csv", tmp_path)
    (tmp_path / "check.json").write_text("{ not JSON")
    (tmp_path / "budget.csv").write_text("Case,s\n1,2,3\n")
    sources = read_sources(tmp_path, None)
    text = page(sources).decode()
    for command in ("rps-bench budget", "rps-bench work-precision", "rps-bench workspace",
                    "rps-bench table", "rps-bench reproduce"):  # fmt: skip
        assert re.search(f"Nothing here yet: [^.]*<code>{command}", text), command
    assert {name for name, _ in sources.skipped} == {"check.json", "budget.csv"}
    assert text.count("<table>") == 1, "Table I"


def test_the_command(rps_bench: Callable[..., Any], made: Any, tmp_path: Path) -> None:
    file = tmp_path / "new" / "page.html"
    answer = rps_bench("dashboard", "--output", str(file), "--results", str(made.results),
                       "--history", "none")  # fmt: skip
    assert answer.status == 0
    assert answer.out.startswith(f"wrote {file} (")
    assert file.read_bytes().startswith(b"<!DOCTYPE html>")


def test_where_no_file_can_be(rps_bench: Callable[..., Any], made: Any, tmp_path: Path) -> None:
    options = ("--results", str(made.results), "--history", "none")
    answer = rps_bench("dashboard", "--output", str(tmp_path), *options)
    assert answer.status == 2
    assert f"--output = '{tmp_path}': expected the name of a file" in answer.err
    (tmp_path / "file").write_text("mine")
    answer = rps_bench("dashboard", "--output", str(tmp_path / "file" / "page.html"), *options)
    assert answer.status == 2
    assert f"--output = '{tmp_path / 'file'}': cannot write there" in answer.err
    assert [path.read_text() for path in tmp_path.iterdir()] == ["mine"]


@pytest.mark.slow
def test_100_000_rows(made: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """500 runs of 16 models and poses whose every number is new: the worst there is to keep."""
    random = np.random.default_rng(1)
    start, count = datetime(2026, 1, 1, tzinfo=UTC), 0
    for k in range(500):
        rows = []
        for case in ("case1", "case2"):
            for model in range(14):
                seconds = {"build_s": random.random(), "solve_s": random.random()}
                about = {"case": case, "mechanism": "m", "z_m": 0.49, "azimuth_rad": 0.0,
                         "tilt_rad": 0.0, "model": f"model-{model}@8", "theory": "any",
                         "settings": json.dumps({"k": k % 3}), "version": f"program {k // 50}",
                         "dofs": 9, **seconds}  # fmt: skip
                rows += [about | {"mode": i, "frequency_hz": 100 * i + random.random()}
                         for i in range(1, 7)]  # fmt: skip
        for pose in range(5):
            about = {"case": "workspace", "mechanism": "m", "z_m": 0.4, "azimuth_rad": 1.0 * pose,
                     "tilt_rad": 0.1, "model": "model-1@8", "version": "program"}  # fmt: skip
            rows += [about | {"mode": i, "frequency_hz": 100 * i + random.random()}
                     for i in range(1, 7)]  # fmt: skip
        store.append(tmp_path, rows, "rps-bench check", start + timedelta(hours=k))
        count += len(rows)
    assert count >= 99_000
    began = time.perf_counter()
    content = page(read_sources(made.results, tmp_path))
    with capsys.disabled():
        print(f"\n{count} rows: {time.perf_counter() - began:.1f} s, {len(content) / 1e6:.1f} MB")
    assert len(content) < MOST_BYTES
    data = json.loads(re.search(rb'id="data-history">(.*?)</script>', content)[1])
    assert len(data["runs"]["run"]) == 500, "all of them"
