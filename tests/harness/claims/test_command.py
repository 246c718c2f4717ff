"""`rps-bench claims`: what it quotes, prints and writes, and what it says if it cannot check."""

import csv
import io
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import click
import numpy as np
import polars as pl
import pytest

from harness import published
from harness.cases import PRESETS
from harness.claims import measure
from harness.claims.claims import needed
from harness.claims.data import Claim, claims, select
from harness.claims.facts import GROUPS
from harness.claims.measure import gather
from harness.cli import cli
from harness.history.store import open_history
from harness.options import Request
from harness.terminal import KEY
from reference_models.exudyn_beam import ExudynBeam


@pytest.mark.parametrize("claim", claims(), ids=lambda claim: claim.id)
def test_what_is_quoted_is_what_is_printed(claim: Claim) -> None:
    number = {"name-3-prs": "3-PRS"}.get(claim.id, "")
    if isinstance(claim.args.get("printed"), float):
        number = f"{claim.args['printed']:g}"
    elif claim.args.get("quantity"):
        number = f"{published.cost()[claim.args['quantity']]:.2f}"
    elif claim.args.get("method"):
        row = published.table1()[claim.args["case"], claim.args["method"]]
        number = f"{row[claim.args['mode'] - 1]:.2f}"
    assert number in claim.quoted
    # A bar would end a cell of a Markdown table.
    assert "|" not in claim.quoted + claim.how + claim.command
    assert claim.section and claim.how and "{" not in claim.id + claim.quoted + claim.command
    assert claim.erratum in {"", *(erratum.id for erratum in published.errata())}


@pytest.mark.parametrize("claim", claims(), ids=lambda claim: claim.id)
def test_its_command_can_be_run(claim: Claim) -> None:
    program, command, *arguments = claim.command.split()
    assert program == "rps-bench"
    found = cli.get_command(click.Context(cli), command)
    assert found is not None
    context = found.make_context(command, arguments)
    if command == "claims":
        assert [one.id for one in select([context.params["only"]])] == [claim.id]
    elif set(context.params) == set(Request.__dataclass_fields__):
        request = Request(**context.params)
        assert request.chosen and request.shown and request.against("exudyn-beam")
        assert request.elements is None or request.steps("")


def test_json_is_what_the_page_reads(rps_bench: Callable[..., Any]) -> None:
    answer = rps_bench("claims", "--only", "eq2-plane,table1-case1-error-f2", "--json")
    assert answer.status == 0 and answer.err == ""
    first, second = json.loads(answer.out)
    assert [first["id"], second["id"]] == ["eq2-plane", "table1-case1-error-f2"]
    wanted = {"id", "section", "quoted", "measured", "uncertainty", "verdict", "command"}
    for row in (first, second):
        assert wanted <= set(row) and all(isinstance(value, str) for value in row.values())
    assert second["verdict"].startswith("holds only if the frequencies had more digits")


def test_terminal_and_files(rps_bench: Callable[..., Any], tmp_path: Path) -> None:
    only = "table1-case2-error-f6,time-saved-follows,eq21-blocks"
    answer = rps_bench("claims", "--only", only, "--output", str(tmp_path))
    assert answer.status == 0
    for text in (
        "Verdict",
        "4.06",
        "rps-bench claims --only",
        "1 holds; 1 holds only if; 0 cannot",
    ):
        assert text in answer.out
    assert {path.name for path in tmp_path.iterdir()} == {
        "claims.csv", "claims.md", "claims.tex", "claims.json",
    }  # fmt: skip
    rows = list(csv.DictReader(io.StringIO((tmp_path / "claims.csv").read_text())))
    again = json.loads((tmp_path / "claims.json").read_text())
    assert [row["Verdict"] for row in rows] == [row["verdict"] for row in again]


def test_what_a_claim_does_not_need_is_not_measured() -> None:
    assert needed(select(["time-saved-follows"])) == []
    assert needed(select(["eq2-plane", "circular-symmetry"])) == ["equations", "maps"]
    assert set(needed(claims())) == set(GROUPS)


def test_what_is_solved_reaches_the_history(rps_bench: Callable[..., Any], tmp_path: Path) -> None:
    runs = []
    for folder in (tmp_path / "a", tmp_path / "b"):
        answer = rps_bench("claims", "--only", "slender-members", "--history", str(folder))
        assert answer.status == 0 and answer.err == ""
        runs.append(open_history(folder).query("SELECT * FROM rows"))
    first, second = (found.select(KEY) for found in runs)
    assert first.equals(second) and first.is_unique().all()
    # Six slendernesses, the last of which is the paper's own in one of the cases.
    assert set(first["model"]) == {"euler-bernoulli@exact", "timoshenko@exact"}
    assert first["mechanism"].n_unique() == 12 and len(first) == 2 * 6 * 2 * 6


@pytest.mark.slow
def test_rows_are_what_verdicts_rest_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(measure, "ROUNDS", 1)
    monkeypatch.setattr(measure, "SHAPE", (12, 3))
    facts, missing, rows = gather(["beams", "times", "maps"])
    assert not missing and facts.beams and facts.maps
    # The paper's model is timed twice, among different others: a run keeps the first.
    found = pl.DataFrame(rows, infer_schema_length=None).unique(KEY, keep="first")
    found = found.sort("z_m", "mode")
    paper = found.filter(pl.col("settings") == '{"count": 8}')
    for case, (_, hertz) in facts.beams.readings.items():
        theory = PRESETS[case].model
        one = paper.filter((pl.col("case") == case) & (pl.col("model") == theory))
        np.testing.assert_allclose(one["frequency_hz"], hertz, rtol=1e-12)
    heights = found.filter(pl.col("settings") == '{"count": 6, "way": "condensed"}')
    scan = heights.filter(pl.col("tilt_rad") == 0)["frequency_hz"].to_numpy().reshape(-1, 6)
    np.testing.assert_array_equal(scan, facts.beams.scan["case1"])
    level = found.filter((pl.col("settings") == '{"count": 3}') & (pl.col("tilt_rad") == 0))
    np.testing.assert_array_equal(level.filter(mode=1)["frequency_hz"], facts.maps.level)
    timed = found.filter(pl.col("settings").str.contains('"timed": "cost"'))
    assert {"case2", "random"} == set(timed["case"]) and timed["solve_s"].null_count() == 0


def test_a_missing_simulator_leaves_its_claims_unchecked(
    rps_bench: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    gone = replace(ExudynBeam.info(), missing="no Exudyn; pip install exudyn")
    monkeypatch.setattr(ExudynBeam, "info", staticmethod(lambda: gone))
    answer = rps_bench("claims", "--only", "time-fea,time-saved-follows", "--json")
    assert answer.status == 1
    assert [row["id"] for row in json.loads(answer.out)] == ["time-saved-follows"]
    assert "time-fea could not be checked: " in answer.err
    assert "no Exudyn; pip install exudyn" in answer.err
