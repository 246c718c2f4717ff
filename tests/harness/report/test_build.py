"""What the page is made of, without opening it."""

import json
import re
from base64 import b64decode, b64encode
from dataclasses import replace
from datetime import UTC, datetime
from gzip import decompress
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analytic import InputError, Mechanism
from harness.bench import Bench
from harness.case_file import load_cases
from harness.cases import PRESETS
from harness.history import store
from harness.report import history, maps
from harness.report.history import Recorded, read_recorded
from harness.report.page import content, load, load_check, page_files, render, renewed
from harness.report.section import Ledger, variant
from harness.report.sections import VERDICTS
from harness.reproduce import Part
from harness.request import Plan
from harness.rows import MANY_POSES, mechanism_hash
from harness.studies import find
from reference_models import Named

MOST_BYTES = 5_000_000
MECHANISMS = Path(__file__).parents[3] / "results/published/mechanisms.toml"


@pytest.fixture(scope="module")
def kept(made: Any) -> dict[str, Any]:
    return load(made.results)


def test_size_and_what_it_may_do(made: Any) -> None:
    text = made.file.read_text()
    assert len(text.encode()) < MOST_BYTES
    assert not re.search(r'(src|href)="(?!#|data:|https://www.cambridge.org)', text)
    (policy,) = re.findall(r'http-equiv="Content-Security-Policy" content="([^"]*)"', text)
    assert "default-src 'none'" in policy
    (scripts,) = re.findall(r"script-src ([^;]*);", policy)
    assert "unsafe" not in scripts
    for script in re.findall(r"<script>(.*?)</script>", text, re.DOTALL):
        digest = b64encode(sha256(script.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in scripts


def test_fig3_errors_are_those_of_the_study(kept: Any, made: Any) -> None:
    """The page pairs anew, every family with every reference of the run."""
    data = kept["sections"]["fig3"]["data"]
    study = made.result("fig3")
    for case, errors in study.errors.items():
        shown = data["cases"][case.name]["families"]["euler-bernoulli"]
        np.testing.assert_allclose(shown["errors"]["timoshenko@exact"], errors, rtol=1e-6)
        floor = np.array(shown["floors"]["timoshenko@exact"])
        last = np.abs(errors[-1] - floor)
        assert (last < 0.01 * np.abs(floor)).all(), "eight elements are near the floor"
        assert not np.any(shown["floors"]["euler-bernoulli@exact"]), "the limit against itself"


def test_the_first_screen_answers(kept: Any) -> None:
    first = kept["sections"]["result"]["context"]
    assert first["paper"]["source"].startswith("Robotica")
    said = {one["question"]: " ".join(one["said"]) for one in first["answers"]}
    assert "euler-bernoulli@3" in said["What was checked?"]
    assert "timoshenko@exact" in said["Against what?"]
    assert "3 of the 12 errors" in said["Where does the paper contradict itself?"]
    found = {one["question"]: one["said"] for one in first["finding"]}
    assert "0.098 %" in found["Are 3 elements a limb enough?"]
    assert "up to 1.9 % on f1-f3" in found["What does beam theory cost?"]
    assert {one["kind"]: one["count"] for one in first["verdicts"]} == dict.fromkeys(VERDICTS, 1)
    panels = first["fig3"]["panels"]
    assert [panel["title"] for panel in panels] == [
        "Case 1: level platform",
        "Case 2: tilted platform",
    ]
    level, tilted = (panel["picture"] for panel in panels)
    assert level.count("</svg>") == tilted.count("</svg>") == 1 and level != tilted
    ids = re.findall(r'id="([^"]*)"', level + tilted)
    assert len(set(ids)) == len(ids), "two drawings on one page"
    assert {*re.findall(r'[("]#([^")]*)', level + tilted)} <= {*ids}


def test_a_page_about_ones_own_robot(made: Any) -> None:
    """It says nothing of the paper."""
    case = replace(PRESETS["case2"], name="mine", note="", published="", errata=(), title="")
    plan = Plan((case,), Named("timoshenko", 3), (), case_file=True)
    own = content(plan, (), "rps-bench reproduce --case-file mine.toml")
    first = own["sections"]["result"]["context"]
    assert first["paper"] is None
    assert first["heading"].startswith("mine: ")
    text = render(json.loads(json.dumps(own)), None, None).decode()
    for word in ("Robotica", "Gong", "published", "Table I"):
        assert word not in re.sub(r"<(script|style).*?</\1>", "", text, flags=re.DOTALL)


def test_the_first_screen_names_only_what_answered() -> None:
    """mujoco-cable cannot take a carriage; what it would be checked against is not what it was."""
    case = load_cases(MECHANISMS)["prs"]
    references = (Named("timoshenko", 4), Named("mujoco-cable", 4))
    plan = Plan((case,), Named("timoshenko", 3), references, case_file=True)
    with Bench() as bench:
        found = find("table").load().run(plan.request(references=references), bench)
    own = content(plan, (Part(find("table"), {"table1": found}),), "rps-bench reproduce")
    first = own["sections"]["result"]["context"]
    said = {one["question"]: " ".join(one["said"]) for one in first["answers"]}
    assert "timoshenko@4" in said["Against what?"]
    assert "mujoco" not in said["Against what?"]


def test_made_anew_it_is_the_same(made: Any) -> None:
    anew = render(load(made.results), made.history, {"status": "passed"})
    assert b"Gate: passed." in anew
    first = made.file.read_bytes()
    assert len(first) > len(anew), "it shows what failed"
    assert anew == render(load(made.results), made.history, {"status": "passed"})


def test_the_gates_answer_comes_onto_the_page(made: Any, tmp_path: Path) -> None:
    """The page says so where it was not asked; its answer is put there when it is."""
    assert renewed(tmp_path, None) == {}
    (tmp_path / "page.json").write_bytes((made.results / "page.json").read_bytes())
    assert b"Gate: not asked yet." in renewed(tmp_path, None)["index.html"]
    (tmp_path / "check.json").write_text('{"status": "passed", "summary": "nothing moved"}')
    assert b"Gate: passed." in renewed(tmp_path, None)["index.html"]


def test_files_of_others_are_refused(made: Any, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"page\.json: No such file"):
        load(tmp_path)
    for text, why in (
        ("{ not JSON", "it is damaged"),
        ("[]", "version 2, not none"),
        ('{"format": "rps-bench page", "version": 99}', "version 2, not 99"),
    ):
        (tmp_path / "page.json").write_text(text)
        with pytest.raises(InputError, match=why):
            load(tmp_path)
    damaged = load(made.results)
    del damaged["sections"]["result"]["context"]["heading"]
    with pytest.raises(InputError, match="whole"):
        render(damaged, None, None)
    assert load_check(tmp_path) is None
    (tmp_path / "check.json").write_text("7")
    with pytest.raises(InputError, match=r"check\.json"):
        load_check(tmp_path)


def test_a_study_that_failed_says_why(kept: Any) -> None:
    assert kept["sections"]["slenderness"]["missing"] == "not made: no solid can run"


def test_history_is_kept_where_it_changes(made: Any) -> None:
    data = history.section(read_recorded(made.history)).data
    assert history.changes([5, 5, 7, 7, 5]) == [5, 0, 5, 2, 7, 4, 5]
    (one,) = [
        s for s in data["series"]
        if (s["case"], s["model"], s["variant"]) == ("case1", "euler-bernoulli@3", "")
    ]  # fmt: skip
    length, _, first, place, second = one["f"]["1"]
    assert (length, place) == (3, 1)
    assert first == pytest.approx(second * (1 - 1e-6), rel=1e-11)


def test_series_that_moved_come_first(made: Any, tmp_path: Path) -> None:
    context = history.section(read_recorded(made.history)).context
    assert context["moved"] == 4, "two models at two cases"
    assert {card["change"] for card in context["cards"]} == {"+1 ppm"}
    assert {card["when"] for card in context["cards"]} == {"2026-03-02 12:00"}
    row = {"case": "case1", "mode": 1}
    for day, moved, still in ((1, 1.0, 7.0), (2, 1.0, 7.0), (3, 1.02, 7.0 * (1 + 1e-12))):
        rows = [row | {"model": "a@3", "frequency_hz": moved},
                row | {"model": "b@3", "frequency_hz": still}]  # fmt: skip
        store.append(tmp_path, rows, "rps-bench table", datetime(2026, 1, day, tzinfo=UTC))
    (card,) = history.section(read_recorded(tmp_path)).context["cards"]
    assert (card["model"], card["change"], card["place"]) == ("a@3", "+2 %", 2)


def workspace_sets(made: Any, recorded: Recorded) -> dict[str, Any]:
    kept = load(made.results)
    section = maps.section(kept["maps"], recorded, Ledger(kept["ledger"]), "rps-bench")
    return {one["name"]: one for one in section.data}


def test_equal_maps_are_kept_once(made: Any) -> None:
    gate = workspace_sets(made, read_recorded(made.history))["the gate's poses"]
    kept = [[run["models"][m]["values"] for run in gate["runs"]] for m in gate["runs"][0]["models"]]
    assert sorted(len(set(row)) for row in kept) == [1, 2], "one model changed, once"
    assert len(gate["values"]) == 3
    assert np.shape(gate["values"]) == (3, 6, 108)


def test_recorded_maps_stand_beside_the_runs_own(made: Any) -> None:
    """Those of the same poses and mechanism; other poses are a choice of their own."""
    sets = workspace_sets(made, read_recorded(made.history))
    assert list(sets) == ["109 poses, 318 mm", "30 poses, 318 mm", "the gate's poses"]
    detailed = sets["109 poses, 318 mm"]
    assert np.shape(detailed["values"][0]) == (3, 109)
    kept = [(run["name"].split(",")[0], model, about["values"])
            for run in detailed["runs"] for model, about in run["models"].items()]  # fmt: skip
    assert kept == [
        ("this run", "timoshenko@exact", 0),
        ("2026-03-03 16:00:00", "timoshenko@exact", 1),
        ("2026-03-03 15:00:00", "euler-bernoulli@3", 0),
        ("2026-03-03 14:00:00", "timoshenko@exact", 0),
    ]
    first, second = np.array(detailed["values"])
    assert (first != second).sum() == 1
    assert (second / first).max() == pytest.approx(1 + 1e-5, rel=1e-9)


def test_a_pose_stated_otherwise_is_the_same_pose() -> None:
    """A tilt below zero lies on the other side; a level platform has no azimuth."""
    steep, level = np.radians([30, 5]).tolist(), [0.3, 0.0]
    other = np.radians([210, -5]).tolist()
    first = [[0.4, *steep, 1, 100.0], [0.4, *level, 1, 90.0]]
    second = [[0.4, 0.0, 0.0, 1, 91.0], [0.4, *other, 1, 101.0]]
    about = {"mechanism": "m", "record": 0}
    own = [about | {"model": f"m@{k}", "rows": rows} for k, rows in enumerate((first, second))]
    kept = {"maps": own, "left": [], "sentences": [], "tables": []}
    (one,) = maps.section(kept, Recorded(), Ledger(), "").data
    assert one["poses"] == [(400.0, 0.0, 0.0), (400.0, 30.0, 5.0)]
    assert one["values"] == [[[90.0, 100.0]], [[91.0, 101.0]]]


def test_a_row_of_heights_is_no_map(made: Any) -> None:
    recorded = read_recorded(made.history)
    (claims,) = [row["run"] for row in recorded.runs if row["command"] == "rps-bench claims"]
    assert claims not in [row["run"] for row in recorded.maps]


def test_maps_that_find_no_room_are_counted_and_named(made: Any) -> None:
    everything = read_recorded(made.history)
    first = {kind: next(one["numbers"] for one in everything.maps if one["case"] == kind)
             for kind in ("map", "workspace")}  # fmt: skip
    recorded = read_recorded(made.history, sum(first.values()) + len(everything.points))
    sets = workspace_sets(made, recorded)
    assert sets["the gate's poses"]["note"] == (
        "Recorded, but no room on the page: 3 more, of timoshenko@exact."
    )
    assert "of euler-bernoulli@3, timoshenko@exact." in sets["109 poses, 318 mm"]["note"]


def test_a_map_too_large_is_left_out_and_named(made: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(maps, "MOST", 100)
    from harness.report.section import Material

    own = maps.own(Material(Plan((PRESETS["case1"],), Named("rayleigh", 3), ()), made.parts, "me"))
    assert own["maps"] == []
    assert own["left"] == ["timoshenko@exact, 327 frequencies"]


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


def test_another_mechanism_or_pose_is_another_series(robot: Mechanism, tmp_path: Path) -> None:
    own = {"case": "case1", "mechanism": mechanism_hash(robot), "mode": 1, "model": "m@3",
           "frequency_hz": 1.0, "z_m": 0.49, "azimuth_rad": 0.0, "tilt_rad": 0.0,
           "settings": '{"count": 6}'}  # fmt: skip
    rows = [own, own | {"mechanism": "thin"}, own | {"z_m": 0.5}]
    store.append(tmp_path, rows, "rps-bench slenderness")
    series = history.section(read_recorded(tmp_path)).data["series"]
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
    series = history.section(read_recorded(tmp_path)).data["series"]
    assert len(series) == 20
    assert {f"m@{15 + k}" for k in range(15)} < {one["model"] for one in series}
    assert b"The newest 20 of 30 series." in render(load(made.results), tmp_path, None)


def test_of_too_many_runs_the_newest_are_shown(
    made: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(history, "MOST_POINTS", 2)
    row = {"case": "case1", "mode": 1, "model": "m@3"}
    for day in (1, 2, 3):
        time = datetime(2026, 1, day, tzinfo=UTC)
        store.append(tmp_path, [row | {"frequency_hz": float(day)}], "rps-bench table", time)
    found = read_recorded(tmp_path)
    assert [point["frequency_hz"] for point in found.points] == [2.0, 3.0]
    assert b"The newest 2 of 3 runs." in render(load(made.results), tmp_path, None)


def test_the_order_of_rows_says_nothing(tmp_path: Path) -> None:
    """The same runs, their rows the other way round in the file, make the same page."""
    level = [{"case": "map", "mechanism": "m", "model": "m@3", "z_m": 0.4, "tilt_rad": 0.0,
              "mode": 1, "azimuth_rad": 0.1 * k, "frequency_hz": 100.0 + k}
             for k in range(12)]  # fmt: skip
    points = [{"case": "case1", "model": f"m@{k}", "mode": 1 + k % 3, "frequency_hz": 1.0 + k}
              for k in range(9)]  # fmt: skip
    found = []
    for turn in (1, -1):
        folder = tmp_path / str(turn)
        rows = (level + points)[::turn]
        store.append(folder, rows, "one", datetime(2026, 2, 1, tzinfo=UTC))
        recorded = read_recorded(folder)
        sets = maps.section(None, recorded, Ledger(), "").data
        data = history.section(recorded).data
        found.append([data["series"], [one["values"] for one in sets]])
    assert found[0] == found[1]


def test_sweeps_are_counted_not_read(made: Any) -> None:
    recorded = read_recorded(made.history)
    assert not {row["case"] for row in recorded.points} & set(MANY_POSES)
    (sweep,) = recorded.sweeps
    assert (sweep["models"], sweep["poses"], sweep["rows"]) == (
        "rayleigh@3, timoshenko@exact", 7, 28)  # fmt: skip


def test_a_page_of_one_study_alone(made: Any) -> None:
    (table,) = [part for part in made.parts if part.entry.name == "table"]
    files = page_files(Plan((PRESETS["case1"],), Named("euler-bernoulli", 3), ()), [table], None)
    text = files["index.html"].decode()
    assert 'id="table1"' in text
    for key in ("fig3", "claims", "budget", "history", "workspace"):
        assert f'<section id="{key}"' not in text, key
        assert f'href="#{key}"' not in text.replace("<figcaption", ""), key


def test_every_section_says_what_made_it(made: Any) -> None:
    text = made.file.read_text()
    sections = re.findall(r'<section id="([^"]+)"', text)
    for key in sections[1:]:
        assert re.search(rf'href="#{key}" aria-label="Link to this section', text), key
    assert text.count('<p class="made">Made by <code>rps-bench') == len(sections) - 1


@pytest.mark.slow
def test_100_000_rows(made: Any, tmp_path: Path) -> None:
    """500 runs of 14 models and poses whose every number is new: the worst there is to keep."""
    random = np.random.default_rng(1)
    for k in range(500):
        rows = []
        for case in ("case1", "case2"):
            for model in range(16):
                seconds = {"build_s": random.random(), "solve_s": random.random()}
                about = {"case": case, "mechanism": "m", "z_m": 0.49, "azimuth_rad": 0.0,
                         "tilt_rad": 0.0, "model": f"model-{model}@8", "theory": "any",
                         "settings": json.dumps({"k": k % 3}), "version": f"program {k // 50}",
                         "dofs": 9, **seconds}  # fmt: skip
                rows += [about | {"mode": i, "frequency_hz": 100 * i + random.random()}
                         for i in range(1, 7)]  # fmt: skip
        time = datetime(2026, 1, 1 + k // 24, k % 24, tzinfo=UTC)
        store.append(tmp_path, rows, "rps-bench check", time)
    page = render(load(made.results), tmp_path, None)
    assert len(page) < MOST_BYTES
    packed = re.search(rb'id="data">(.*?)</script>', page)[1]
    data = json.loads(decompress(b64decode(packed)))["history"]
    assert len(data["runs"]["run"]) == 500, "all of them"


def test_parts_without_results_make_a_page() -> None:
    plan = Plan((PRESETS["case1"],), Named("euler-bernoulli", 3), ())
    files = page_files(plan, [Part(find("table"), {}, "nothing could run")], None)
    assert b"nothing could run" in files["index.html"]


def test_the_command(made: Any, tmp_path: Path) -> None:
    from click.testing import CliRunner

    from harness.cli.commands import dashboard

    file = tmp_path / "new" / "page.html"
    given = ["--results", str(made.results), "--history", "none"]
    answer = CliRunner().invoke(dashboard, ["--output", str(file), *given])
    assert answer.output.startswith(f"wrote {file} (")
    assert file.read_bytes().startswith(b"<!DOCTYPE html>")
    refused = CliRunner().invoke(dashboard, ["--output", str(tmp_path), *given])
    assert isinstance(refused.exception, InputError)
    assert [path.name for path in tmp_path.iterdir()] == ["new"]
