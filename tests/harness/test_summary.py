"""What the main job says first: a verdict, at most five findings, and where to look."""

import re

import pytest

from harness.bench import Bench
from harness.reproduce import Part, chosen, reproduce, summaries
from harness.request import Plan
from harness.text import plan


@pytest.fixture(scope="module")
def made() -> tuple[Plan, list[Part]]:
    """Return a plan, and what the quick studies make of it."""
    asked = plan({"references": "timoshenko@exact"})
    with Bench() as bench:
        return asked, list(reproduce(chosen(["table", "convergence"]), asked, bench))


def test_a_summary_is_a_verdict_five_findings_and_where_to_look(
    made: tuple[Plan, list[Part]],
) -> None:
    lines = summaries(*made)["summary.md"].decode().splitlines()
    assert len(lines) <= 25
    verdict, *found = [line for line in lines[1:] if line and not line.startswith("Where")]
    assert verdict.startswith("3 elements a limb are enough: they cost at most 0.098 %")
    assert 3 <= len(found) <= 5
    assert all(line.startswith(f"{k}. ") and len(line) < 200 for k, line in enumerate(found, 1))
    assert re.search(r"up to 1\.9 % on f1-f3 and up to 5\.9 % on f4-f6", found[0])
    assert found[1].endswith("none agrees with euler-bernoulli@3 to 0.1 %.")


def test_one_element_is_said_to_be_too_few() -> None:
    asked = plan({"references": "timoshenko@exact", "model": "euler-bernoulli@1"})
    with Bench() as bench:
        parts = list(reproduce(chosen(["table"]), asked, bench))
    text = summaries(asked, parts)["summary.md"].decode()
    assert "1 element a limb is too few: it costs at most 13 %, more than beam theory" in text


def test_studies_without_a_lead_say_their_first_sentence(made: tuple[Plan, list[Part]]) -> None:
    asked = made[0]
    with Bench() as bench:
        parts = list(reproduce(chosen(["refine"]), asked, bench))
    assert parts[0].sentences()[0] in summaries(asked, parts)["summary.md"].decode()
