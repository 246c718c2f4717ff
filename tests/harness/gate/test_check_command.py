"""The command: a baseline is made, kept, compared with, and changed only for a reason."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

from harness.gate.study import LADDERS, YARDSTICK, standard, yardstick
from harness.history.store import open_history
from harness.run import GATE

OPTIONS = ("--models", "rayleigh,condensed", "--baseline", "base", "--history", "past")


@pytest.mark.slow
def test_from_the_first_baseline_to_a_reason(
    rps_bench: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    first = rps_bench("check", *OPTIONS)
    assert first.status == 2
    assert "expected a folder of accepted figures (rps-bench check --accept makes one)" in first.err
    assert rps_bench("check", *OPTIONS, "--accept").status == 0
    assert not Path("base/frequencies.csv").read_text().startswith("\n")

    clean = rps_bench("check", *OPTIONS, "--output", "out", "--junit", "one.xml")
    assert clean.status == 0 and "nothing moved" in clean.out
    said = json.loads(Path("out/check.json").read_text())
    assert said["status"] == "passed" and said["findings"] == []
    assert said["checked"]["frequency"] == 5 * 2 * 6
    assert said["command"] == "rps-bench check --baseline base --models rayleigh,condensed"
    assert Path("one.xml").read_bytes() == Path("out/check.xml").read_bytes()
    found = open_history(Path("past")).query(
        'SELECT model, "case", count(*) AS n FROM rows GROUP BY ALL'
    )
    counted = {(m, c): n for m, c, n in found.iter_rows()}
    assert counted["condensed@exact", GATE] == 2 * 108 * 6
    assert counted[YARDSTICK, YARDSTICK] == 2

    file = Path("base/frequencies.csv")
    lines = file.read_text().splitlines()
    (at,) = [i for i, x in enumerate(lines) if x.startswith("case2,rayleigh@8,4,")]
    cells = lines[at].split(",")
    cells[3] = repr(float(cells[3]) * (1 + 1e-9))
    file.write_text("\n".join([*lines[:at], ",".join(cells), *lines[at + 1 :], ""]))
    planted = file.read_text()

    moved = rps_bench("check", *OPTIONS, "--output", "out")
    assert moved.status == 1
    assert "rps-bench check failed: 1 x frequency; rayleigh@8" in moved.out
    (one,) = json.loads(Path("out/check.json").read_text())["findings"]
    assert (one["kind"], one["model"], one["case"], one["mode"]) == (
        "frequency", "rayleigh@8", "case2", 4)  # fmt: skip
    assert one["before"] == float(cells[3]) and one["verdict"] == "better"
    assert one["after"] / one["before"] - 1 == pytest.approx(-1e-9, rel=1e-3)
    suites = {s.get("name"): s for s in ElementTree.parse("out/check.xml").getroot()}
    assert suites["frequency"].get("failures") == "1"
    failure = suites["frequency"].find("testcase/failure")
    assert failure is not None and "mode 4" in failure.get("message", "")
    text = Path("out/check.md").read_text()
    assert text.startswith("# :x: rps-bench check failed") and "| rayleigh@8 " in text

    # Downwards is towards the exact limit; the other way takes a reason.
    lower = repr(float(cells[3]) * (1 - 2e-9))
    file.write_text(planted.replace(cells[3], lower))
    refused = rps_bench("check", *OPTIONS, "--accept")
    assert refused.status == 1 and "1 findings lower the bar" in refused.err
    accepted = rps_bench("check", *OPTIONS, "--accept", "--reason", "a test, of course")
    assert accepted.status == 0
    assert '"a test, of course"' in Path("base/reasons.csv").read_text()
    assert rps_bench("check", *OPTIONS).status == 0


@pytest.mark.parametrize(
    ("arguments", "argument", "expected"),
    [
        (
            ["--baseline", "none", "--models", "exudyn"],
            "--models = 'exudyn'",
            "expected some of euler-bernoulli, ",
        ),
        (["--baseline", ""], "--baseline = ''", "the name of a folder, or none"),
        (["--baseline", "nowhere"], "--baseline = 'nowhere'", "a folder of accepted figures"),
        (["--baseline", "none", "--accept"], "--baseline = 'none'", "a folder to accept figures"),
        (["--reason", "because"], "--reason = 'because'", "words, beside --accept"),
        (["--reason", " ", "--accept"], "--reason = ' '", "words, beside --accept"),
        (["--baseline", "none", "--json", ""], "--json = ''", "the name of a file"),
        (["--baseline", "none", "--output", ""], "--output = ''", "the name of a folder"),
    ],
)
def test_bad_input(
    rps_bench: Callable[..., Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: list[str],
    argument: str,
    expected: str,
) -> None:
    """In one sentence, before anything is solved or written."""
    monkeypatch.chdir(tmp_path)
    answer = rps_bench("check", "--history", "none", *arguments)
    assert answer.status == 2 and answer.out == ""
    assert answer.err.count("\n") == 1
    assert argument in answer.err and expected in answer.err
    assert not list(tmp_path.iterdir())


def test_the_yardstick_is_a_known_chain() -> None:
    """150 unit masses between walls: omega_1 = 2 sin(pi / 302)."""
    frequency, seconds = yardstick()
    assert frequency == pytest.approx(2 * np.sin(np.pi / 302) / (2 * np.pi), rel=1e-10)
    assert seconds > 0


def test_what_a_check_runs() -> None:
    full, quick = standard(), standard(quick=True)
    assert len(full.poses) == 3 * 12 * 3
    names = {spec.name for spec in full.everywhere}
    assert names | set(full.missing) >= {*LADDERS, "euler-bernoulli", "multipliers"}
    assert {spec.name for spec in full.everywhere} - {spec.name for spec in quick.everywhere} <= {
        "calculix-solid", "ngsolve-solid", "ngsolve-averaged", "exudyn-ffrf"}  # fmt: skip
    assert [s.label for s in standard(["timoshenko"]).mapped] == ["timoshenko@exact"]
