"""What the page is made of, without opening it."""

import csv
import json
import re
import shutil
import time
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analytic.theory import BEAMS
from harness.history import store
from harness.report import fig3, history, workspace
from harness.report.ledger import Ledger
from harness.report.page import page
from harness.report.sources import read_sources

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


def test_equal_maps_are_kept_once(made: Any) -> None:
    _, gate = workspace.section(made.sources, Ledger(made.sources)).data
    kept = [[run["models"][m]["values"] for run in gate["runs"]] for m in gate["runs"][0]["models"]]
    assert sorted(len(set(row)) for row in kept) == [1, 2], "one model changed, once"
    assert len(gate["values"]) == 3
    assert np.shape(gate["values"]) == (3, 6, 108)


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
