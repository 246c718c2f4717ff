"""A mechanism that a model cannot take is no failure of a run that did not ask for that model."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from harness.bench import run
from harness.case_file import load_cases
from harness.cases import PRESETS
from harness.studies.table import TableOne
from reference_models import Named

CHAINS = Path(__file__).parents[2] / "results" / "published" / "mechanisms.toml"
TAKES, CANNOT = Named("exudyn-beam", 2), Named("mujoco-cable", (4, 8))


def test_a_refusal_is_told_from_a_failure() -> None:
    case = load_cases(CHAINS)["prs"]
    theory = Named("euler-bernoulli", 2)
    study = run(case, [theory, TAKES, CANNOT])
    assert (case, TAKES) in study.answers
    assert study.refused == {(case, CANNOT)}
    result = TableOne(study, (theory,), (TAKES, CANNOT), (1, 2, 3), ())
    assert not result.failures()
    ((what, why),) = result.refusals().items()
    assert what == "mujoco-cable at prs"
    assert why.startswith("mechanism = 'limb 1, P-body-R-rod-S'")
    # What takes no case has no column; beside a case that it takes, its cell says so.
    assert result.tables()["-references"].columns[3:] == ("exudyn-beam@2",)
    both = run([PRESETS["case1"], case], [theory, TAKES, CANNOT])
    table = TableOne(both, (theory,), (TAKES, CANNOT), (1,), ()).tables()["-references"]
    assert [row[-1] for row in table.rows][1:] == ["cannot take it"]


@pytest.mark.parametrize(
    ("references", "status"), [("quick", 0), ("exudyn-beam@2,mujoco-cable@4", 1)]
)
def test_only_a_model_that_was_named_must_answer(
    rps_bench: Callable[..., Any], references: str, status: int
) -> None:
    answer = rps_bench("table", "--case-file", str(CHAINS), "--cases", "prs",
                       "--references", references)  # fmt: skip
    assert answer.status == status, answer.err
    assert "mujoco-cable at prs" in answer.err
    assert "left out: mechanism = 'limb 1" in answer.err
    assert "exudyn-beam@" in answer.out
    assert (
        "mujoco-cable" not in answer.out.split("Every reference")[0] or "cannot take" in answer.out
    )


def test_models_that_cannot_for_one_reason_are_one_sentence(
    rps_bench: Callable[..., Any],
) -> None:
    table = ("table", "--case-file", "mechanisms", "--cases", "prs", "--references")
    answer = rps_bench(*table, "mujoco-cable@4,exudyn-ffrf@2")
    assert answer.err.count("mechanism = ") == 1
    assert answer.err.startswith(
        "rps-bench: mujoco-cable at prs, exudyn-ffrf at prs are left out: mechanism = 'limb 1"
    )
    assert answer.out.count("mujoco-cable@4, exudyn-ffrf@2 cannot take prs: mechanism = ") == 1


def test_what_chains_have_no_frames_or_statements_for(
    rps_bench: Callable[..., Any], tmp_path: Path
) -> None:
    """Where mirrored limbs lean is known of R-P-S limbs alone; statements are a paper's."""
    table = tmp_path / "table.csv"
    table.write_text("case,f1,f2,f3\nprs,27,30,51\n")
    for command, given, says in (
        (
            "identify",
            ("--table", str(table), "--parameters", "z_mm", "--frames", "mirrored"),
            "frames = 'mirrored': expected three equal R-P-S limbs",
        ),
        ("claims", (), "expected the folder of a paper with claims.toml"),
    ):
        answer = rps_bench(command, "--case-file", str(CHAINS), *given)
        assert answer.status == 2 and says in answer.err
        assert len(answer.err.strip().splitlines()) == 1, answer.err
