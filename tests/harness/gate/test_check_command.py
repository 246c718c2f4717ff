"""The commands: a baseline is made, kept, compared with, and changed only for a reason."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from analytic import Mechanism, Platform, Pose
from harness.accepted import SHOWN
from harness.case import Case
from harness.cases import PRESETS
from harness.gate.plan import YARDSTICK, standard
from harness.history.store import open_history
from harness.report.page import FILE, FORMAT, VERSION, page_files
from harness.request import Plan
from harness.studies import STUDIES
from reference_models import Named

OPTIONS = ("--models", "rayleigh,multipliers", "--baseline", "base", "--history", "past")


@pytest.mark.slow
def test_from_the_first_baseline_to_a_reason(
    rps_bench: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    first = rps_bench("check", *OPTIONS)
    assert first.status == 2
    assert "expected a folder of accepted figures (rps-bench accept makes one)" in first.err
    assert rps_bench("accept", *OPTIONS, "--latest", "none").status == 0

    Path("out").mkdir()
    plan = Plan((PRESETS["case1"],), Named("rayleigh", 3), ())
    Path("out/page.json").write_bytes(page_files(plan, (), None)["page.json"])
    clean = rps_bench("check", *OPTIONS, "--output", "out", "--junit", "one.xml")
    assert clean.status == 0 and "nothing moved" in clean.out
    assert "Gate: passed." in Path("out/index.html").read_text(), "on the page that is there"
    said = json.loads(Path("out/check.json").read_text())
    assert said["status"] == "passed" and said["findings"] == []
    assert said["checked"]["frequency"] == 2 * (4 + 1 + 4) * 6
    assert said["command"] == "rps-bench check --baseline base --models rayleigh,multipliers"
    assert Path("one.xml").read_bytes() == Path("out/check.xml").read_bytes()
    found = open_history(Path("past")).query(
        'SELECT model, "case", count(*) AS n FROM rows GROUP BY ALL'
    )
    counted = {(row["model"], row["case"]): row["n"] for row in found.rows()}
    assert counted["rayleigh@exact", "case1"] == 2 * 6
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
    refused = rps_bench("accept", *OPTIONS, "--latest", "none")
    assert refused.status == 1
    assert "--reason = None: expected why 1 findings that lower the bar are right" in refused.err
    accepted = rps_bench("accept", *OPTIONS, "--latest", "none", "--reason", "a test, of course")
    assert accepted.status == 0
    assert '"a test, of course"' in Path("base/reasons.csv").read_text()
    assert rps_bench("check", *OPTIONS).status == 0


@pytest.mark.slow
def test_a_baseline_of_ones_own_mechanism(
    rps_bench: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A tenth of the size: made, kept, and not mixed up with another mechanism."""
    monkeypatch.chdir(tmp_path)
    text = (
        "[mechanisms.mine]\nheading_deg = 10\nbase_radius_mm = 30\nplatform_radius_mm = 20\n"
        "platform_thickness_mm = 2\nrod_diameter_mm = 10\nyoung_GPa = 200\nshear_GPa = 77\n"
        'density_kg_m3 = 7820\n[cases.low]\nmechanism = "mine"\nz_mm = 49\ntilt_deg = -12\n'
    )
    Path("mine.toml").write_text(text)
    asked = ("--case-file", "mine.toml", "--models", "exudyn-cable", "--history", "none")
    missing = rps_bench("check", *asked)
    assert missing.status == 2 and "a folder for the figures of your own cases" in missing.err
    assert rps_bench("accept", *asked, "--baseline", "own").status == 0
    clean = rps_bench("check", *asked, "--baseline", "own", "--output", "out")
    assert clean.status == 0, clean.out
    said = json.loads(Path("out/check.json").read_text())
    assert {one["name"] for one in said["properties"]} >= {
        "120 deg symmetry",
        "s -> infinity is exact",
    }
    lines = Path("own/frequencies.csv").read_text().splitlines()[1:]
    assert {line.split(",")[0].split()[0] for line in lines} == {"low", '"workspace'}
    Path("mine.toml").write_text(text.replace("diameter_mm = 10", "diameter_mm = 11"))
    other = rps_bench("check", *asked, "--baseline", "own")
    assert other.status == 1
    assert "another mechanism, not another answer" in other.out


def test_what_is_shown_comes_from_the_last_run(
    rps_bench: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All of it or none: a run that made a part of it is no run of the main job."""
    monkeypatch.chdir(tmp_path)
    latest = tmp_path / "latest"
    latest.mkdir()
    for name in SHOWN[1:]:
        (latest / name).write_text(name)
    asked = ("accept", "--latest", "latest", "--baseline", "base", "--history", "none")
    refused = rps_bench(*asked, "--models", "multipliers")
    assert refused.status == 2
    assert f"({SHOWN[0]}: No such file or directory)" in refused.err
    (latest / SHOWN[0]).write_text(SHOWN[0])
    studies = [one.name for one in STUDIES if getattr(one.load(), "jobs", STUDIES) is not None]
    page = {
        "format": FORMAT, "version": VERSION,
        "command": "rps-bench reproduce --case-file mine.toml",
        "references": [], "made": studies[1:],
    }  # fmt: skip
    for change, why in (
        ({}, "made by rps-bench reproduce --case-file mine.toml"),
        ({"command": "rps-bench reproduce"}, f"made without the studies {studies[0]}"),
    ):
        page |= change
        (latest / FILE).write_text(json.dumps(page))
        refused = rps_bench(*asked, "--models", "multipliers")
        assert refused.status == 2 and refused.err.count("\n") == 1
        assert "--latest = 'latest': expected what the main job wrote, none, or a --reason" in (
            refused.err
        )
        assert f"({why})" in refused.err
        assert not (tmp_path / "base").exists(), "before anything is solved"
    (latest / FILE).write_text(json.dumps(page | {"made": studies}))
    assert rps_bench(*asked, "--models", "multipliers").status == 0
    written = {path.name: path.read_text() for path in Path("results/accepted").iterdir()}
    assert written == {name: name for name in SHOWN}
    with (tmp_path / "base" / "models.csv").open("a") as file:
        file.write("exudyn-cable@4,Euler-Bernoulli,exudyn 1\n")
    refused = rps_bench(*asked, "--models", "multipliers")
    assert refused.status == 2 and "(made without the models exudyn-cable)" in refused.err


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["check", "--baseline", "none", "--models", "exudyn"], "--models = 'exudyn': expected"),
        (["check", "--baseline", ""], "--baseline = '': expected the name of a folder"),
        (["check", "--baseline", "nowhere"], "--baseline = 'nowhere': expected a folder of"),
        (["check", "--baseline", "none", "--json", ""], "--json = '': expected the name of a file"),
        (["check", "--baseline", "none", "--output", ""], "--output = '': expected the name of a"),
        (["check", "--case-file", "nowhere.toml"], "--case-file = 'nowhere.toml': expected a"),
        (["accept", "--baseline", "none"], "--baseline = 'none': expected a folder to accept"),
        (["accept", "--baseline", "base", "--reason", " "], "--reason = ' ': expected words"),
        (["accept", "--baseline", "base", "--latest", "nowhere"], "--latest = 'nowhere': expected"),
    ],
)  # fmt: skip
def test_bad_input(
    rps_bench: Callable[..., Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: list[str],
    expected: str,
) -> None:
    """In one sentence, before anything is solved or written."""
    monkeypatch.chdir(tmp_path)
    answer = rps_bench(*arguments, "--history", "none")
    assert answer.status == 2 and answer.out == ""
    assert answer.err.count("\n") == 1
    assert answer.err.startswith(f"rps-bench: {expected}")
    assert not list(tmp_path.iterdir())


def test_a_mechanism_that_tilts_in_no_way_has_no_map() -> None:
    """Four joints close at few azimuths: cases are checked, and a sentence says what is not."""
    rod = PRESETS["case1"].mechanism.limbs[0].rod
    four = Mechanism.regular(0.3, 0.2, rod, Platform.disc(0.2, 0.02, 7820.0), limbs=4)
    plan = standard([Case("four", four, Pose(0.49), "a test")], ["euler-bernoulli"])
    assert plan.poses == () and len(plan.everywhere) == 5
    assert plan.notes == (
        "no map of the workspace: mechanism = '4 limbs': expected one that tilts any way",
    )


def test_what_a_check_runs() -> None:
    """Every model of the catalogue on the meshes it is watched on, or a word why not."""
    cases = (PRESETS["case1"], PRESETS["case2"])
    full, quick = standard(cases), standard(cases, quick=True)
    assert len(full.poses) == 3 * 12 * 3
    names = {model.name for model in full.everywhere}
    assert names | set(full.skipped) >= {"euler-bernoulli", "multipliers", "condensed"}
    left_out = {model for model in full.everywhere if model not in quick.everywhere}
    assert all(model.info().slow for model in left_out)
    assert not any(model.info().slow for model in quick.everywhere)
    assert [m.label for m in standard(cases, ["timoshenko"]).mapped] == ["timoshenko@exact"]
    for ladder in full.ladders:
        assert [model.elements for model in ladder] == list(ladder[0].info().ladder)
