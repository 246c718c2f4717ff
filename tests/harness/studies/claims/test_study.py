"""The study of claims: what it quotes, measures and says; what it cannot check is no verdict."""

from dataclasses import replace
from typing import Any

import click
import numpy as np
import pytest

from analytic import InputError
from harness.bench import Bench
from harness.cases import PRESETS
from harness.paper import Claim
from harness.request import Plan
from harness.studies import claims as study
from harness.studies.claims import Claims, facts, judge, select
from harness.studies.claims.facts import (
    CASES,
    COST_STEPS,
    PAPER,
    Facts,
    UnmeasuredError,
    checked,
)
from harness.studies.cost.work import counted
from harness.text import request
from reference_models import Named

PRINTED = checked()


@pytest.mark.parametrize("claim", PRINTED.claims, ids=lambda claim: claim.id)
def test_what_is_quoted_is_what_is_printed(claim: Claim) -> None:
    number = {"name-3-prs": "3-PRS"}.get(claim.id, "")
    if isinstance(claim.args.get("printed"), float):
        number = f"{claim.args['printed']:g}"
    elif claim.args.get("quantity"):
        number = f"{PRINTED.cost[claim.args['quantity']]:.2f}"
    elif claim.args.get("method"):
        row = PRINTED.row(claim.args["case"], claim.args["method"])
        number = f"{row[claim.args['mode'] - 1]:.2f}"
    assert number in claim.quoted
    # A bar would end a cell of a Markdown table.
    assert "|" not in claim.quoted + claim.how + claim.command
    assert claim.section and claim.how and "{" not in claim.id + claim.quoted + claim.command
    assert claim.erratum in {"", *(erratum.id for erratum in PRINTED.errata)}


def test_its_command_can_be_run() -> None:
    """Every command is one of the program's, with arguments that the study can read."""
    from harness.cli.study import study_command
    from harness.studies import find

    for claim in PRINTED.claims:
        program, name, *arguments = claim.command.split()
        assert program == "rps-bench"
        command = study_command(name)
        context = command.make_context(name, arguments)
        texts: dict[str, Any] = {
            key: value for key, value in context.params.items() if isinstance(value, str)
        }
        asked = request(find(name).load(), texts)
        if name == "claims":
            assert asked.options["only"] == [claim.id]
    assert isinstance(command, click.Command)


def run(only: str, bench: Bench) -> Claims:
    return study.run(request(study, {"only": only}), bench)


def test_a_frame_is_what_the_page_reads(bench: Bench) -> None:
    result = run("eq2-plane,table1-case1-error-f2", bench)
    frame = result.to_frame()
    assert frame["id"].tolist() == ["eq2-plane", "table1-case1-error-f2"]
    wanted = {"id", "section", "quoted", "measured", "uncertainty", "verdict", "command", "kind"}
    assert wanted <= set(frame.columns)
    assert frame["verdict"][1].startswith("holds only if the frequencies had more digits")
    assert result.failures() == {} and result.figures() == {}


def test_table_and_sentences(bench: Bench) -> None:
    result = run("table1-case2-error-f6,time-saved-follows,eq21-blocks", bench)
    table = result.table()
    assert [row[-2] for row in table.rows] == result.to_frame()["verdict"].tolist()
    assert table.notes[0] == "1 holds; 1 holds only if; 0 cannot be reproduced as printed; 1 fails"
    first, fails = result.sentences()
    assert first.startswith("Of 3 statements of the paper: 1 holds, ")
    assert fails.startswith("table1-case2-error-f6: fails: the printed rows give 4.06 %")
    assert list(result.tables()) == [""]
    many = replace(result, found=result.found * 5)
    assert [len(t.columns) for t in many.tables().values()] == [7, 4]


def test_what_a_claim_does_not_need_is_not_measured(bench: Bench) -> None:
    for name, measured in (("time-saved-follows", {"printed"}), ("eq2-plane", {"equations"})):
        own = Facts(bench)
        before = set(vars(own))
        judge(select([name], PRINTED.claims), own)
        assert vars(own).keys() - before == measured and own.solved == []


def test_an_unknown_claim_is_named() -> None:
    with pytest.raises(InputError, match=r"^only = 'eq99': expected one of the 98 ids"):
        run("eq99", Bench())


def test_claims_are_about_the_paper_alone() -> None:
    plan = Plan((PRESETS["case1"],), PAPER, ())
    assert list(study.jobs(plan)) == ["claims"]
    assert study.jobs(replace(plan, case_file=True)) == {}
    mine = replace(PRESETS["case1"], name="mine", published="")
    with pytest.raises(InputError, match=r"case_file = 'mine': expected the folder of a paper"):
        study.run(replace(request(study, {}), cases=(mine,)), Bench())


def test_what_is_solved_is_rows_of_the_history(bench: Bench) -> None:
    rows = run("slender-members", bench).rows()
    # Six slendernesses, the last of which is the paper's own in one of the cases.
    assert {row["model"] for row in rows} == {"euler-bernoulli@exact", "timoshenko@exact"}
    assert len({row["mechanism"] for row in rows}) == 12 and len(rows) == 2 * 6 * 2 * 6


def test_rows_are_what_verdicts_rest_on(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(facts, "ROUNDS", 1)
    own = Facts(bench)
    hertz, scanned, times, rows = own.hertz, own.scan, own.times, own.solved
    for case in PRESETS.keys() - set(CASES):
        theory = PRESETS[case].theory
        one = {
            r["mode"]: r["frequency_hz"]
            for r in rows
            if r["case"] == case and r["model"] == theory.label and '"count": 8}' in r["settings"]
        }
        np.testing.assert_array_equal([one[i + 1] for i in range(6)], hertz[case, theory])
    scan = [r["frequency_hz"] for r in rows if r["case"] == "map" and r["tilt_rad"] == 0]
    np.testing.assert_array_equal(np.reshape(scan, (-1, 6)), scanned["case1"])
    timed = [r for r in rows if '"timed": "claims"' in r["settings"]]
    rivals = ("multipliers@{}[solver=null-space]", "multipliers@{}[solver=saddle-point]")
    assert {r["model"] for r in timed} == {
        name.format(s) for s in COST_STEPS for name in ("euler-bernoulli@{}", *rivals)
    }
    assert all(r["solve_s"] > 0 for r in timed)
    for name in ("paper", "null-space", "saddle-point"):
        assert list(times[name]) == list(COST_STEPS)
        for s, one in times[name].items():
            assert (one.seconds > 0).all() and (one.solves > 0).all()
            assert one.work == counted(name, s, PRESETS["case2"]).flops


def test_what_was_not_measured_leaves_its_claims_unchecked(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(facts, "solid_truth", lambda names: None)
    asked = select(["time-saved-follows", "table1-case1-fea-f1"], PRINTED.claims)
    result = judge(asked, Facts(bench, fea=None))
    assert [one.claim.id for one in result.found] == ["time-saved-follows"]
    ((name, why),) = result.failures().items()
    assert name == "table1-case1-fea-f1" and why.startswith("ngsolve-solid: ")


def test_a_simulator_that_fails_is_no_fact(bench: Bench) -> None:
    with pytest.raises(UnmeasuredError, match="exudyn-cable@0"):
        Facts(bench, [PRESETS["case1"]]).reference(Named("exudyn-cable", 0))
