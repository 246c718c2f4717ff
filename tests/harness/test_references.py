"""Which simulators stand beside Table I where none are named, and what is said of those missing."""

import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from harness import text
from harness.bench import Bench
from harness.presets import QUICKEST, TABLE_ONE
from harness.reproduce import chosen, jobs, reproduce
from harness.studies import table
from harness.text import plan, request
from reference_models import Named, UnavailableError, catalogue

KINDS = ("exudyn-beam", "exudyn-cable", "exudyn-ffrf", "mujoco-composite", "mujoco-cable",
         "calculix-solid", "ngsolve-solid")  # fmt: skip
WHY = "CalculiX's program ccx is not on the path"


@pytest.fixture
def no_ccx(monkeypatch: pytest.MonkeyPatch) -> None:
    which = shutil.which
    monkeypatch.setattr(
        shutil, "which", lambda name, *a, **k: None if name == "ccx" else which(name)
    )


def test_one_of_each_kind_that_users_named(no_ccx: None) -> None:
    """What is missing is no reference, and said; the main job asks for the same and more."""
    asked, job = request(table, {}), plan({})
    assert set(KINDS) == set(TABLE_ONE) and set(QUICKEST) < set(KINDS)
    for one in (asked, job):
        found = {model.name for model in one.references}
        assert found | set(one.absent) >= set(KINDS)
        assert "calculix-solid" not in found and one.absent["calculix-solid"].startswith(WHY)
    named = request(table, {"references": "exudyn-cable"})
    assert named.references == (Named("exudyn-cable", (8, 16)),) and not named.absent


def test_what_is_missing_is_a_sentence_and_the_others_stand(no_ccx: None) -> None:
    asked = request(table, {"references": "usual", "cases": "case1", "modes": "1"})
    cable = tuple(model for model in asked.references if model.name == "exudyn-cable")
    with Bench() as bench:
        found = table.run(asked.with_(references=cable), bench)
    notes = [note for note in found.tables()[""].notes if "cannot run here" in note]
    assert [note for note in notes if note.startswith(f"calculix-solid cannot run here: {WHY}")]
    assert len(notes) == len(asked.absent) and not found.failures()
    assert "calculix-solid" in [row[0] for row in found.tables()["-seen"].rows]


@pytest.mark.slow
def test_a_plain_table_has_a_row_of_each(rps_bench: Callable[..., Any], tmp_path: Path) -> None:
    answer = rps_bench("table", "--cases", "case1", "--output", str(tmp_path))
    assert answer.status == 0, answer.err
    rows = (tmp_path / "table1.csv").read_text()
    seen = (tmp_path / "table1-seen.csv").read_text()
    missing = request(table, {}).absent
    for name in KINDS:
        assert (f"FEA ({name}@" in rows) == (name not in missing)
        assert f"\n{name}" in seen


@pytest.fixture
def no_simulator(monkeypatch: pytest.MonkeyPatch) -> None:
    missing = [(name, replace(info, missing="gone")) for name, info in catalogue()]
    monkeypatch.setattr(text, "catalogue", lambda: missing)


@pytest.mark.parametrize("group", ["usual", "quick", "all"])
def test_where_none_can_run_it_says_what_needs_none(no_simulator: None, group: str) -> None:
    with pytest.raises(UnavailableError, match=r"references = '(.*)' needs none") as said:
        text.models(group, "references")
    (model,) = text.models(str(said.value).split("'")[1], "references")
    assert not model.info().isolated


def test_the_main_job_needs_none_if_none_is_asked(no_simulator: None) -> None:
    asked = plan({"references": "timoshenko@exact", "cases": "case1"})
    with Bench() as bench:
        (part,) = reproduce(chosen(["table"]), asked, bench)
    assert not part.why and [model.label for model in asked.references] == ["timoshenko@exact"]
    assert part.results["table1"].tables()[""].rows
    for entry in chosen(None):
        jobs(entry, entry.load(), asked)  # what it makes of the plan names no simulator either
