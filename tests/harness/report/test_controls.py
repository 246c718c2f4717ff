"""Every control of the page, in a real browser, changes what it should."""

import re
from typing import Any

import numpy as np
import pytest

SECTIONS = ["result", "claims", "table1", "fig3", "budget", "work-precision", "workspace", "shapes",
            "refine", "slenderness", "history", "provenance"]  # fmt: skip


def values(trace: dict[str, Any], key: str = "y") -> Any:
    return np.array(trace[key], dtype=float)


def named(traces: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [trace for trace in traces if trace["name"]]


def test_every_section_is_there(tab: Any) -> None:
    here = "[...document.querySelectorAll('main > section')].map(({id}) => id)"
    assert tab.page.evaluate(here) == SECTIONS
    assert tab.page.locator(".missing").inner_text().endswith("no solid can run.")
    assert [a.get_attribute("href") for a in tab.page.locator("nav li a").all()] == [
        f"#{key}" for key in SECTIONS
    ]


def test_the_first_screen(tab: Any) -> None:
    """Without scrolling, at 1280 by 900: the paper, the finding, the figure, the verdicts."""
    tab.page.evaluate("scrollTo(0, 0)")
    for place in (".paper", "h1", ".finding >> nth=1", ".counts", ".panels svg >> nth=1",
                  ".robot img", ".gate"):  # fmt: skip
        box = tab.page.locator(f"#result {place}").bounding_box()
        assert box["y"] + box["height"] <= 900, place
    assert tab.page.evaluate("document.querySelector('.robot img').naturalWidth") > 300
    tab.page.locator(".counts a").first.click()
    assert tab.page.evaluate("location.hash") == "#claims"


def test_fig3_shows_the_errors_of_the_run(tab: Any, made: Any) -> None:
    tab.choose("fig3-case", "case2")
    tab.choose("fig3-reference", "timoshenko@exact")
    study = made.result("fig3")
    errors = next(e for case, e in study.errors.items() if case.name == "case2")
    traces = named(tab.draw("fig3-chart"))
    for i, trace in enumerate(traces):
        np.testing.assert_allclose(values(trace), errors[:, i], rtol=1e-6)


def test_fig3_switches(tab: Any) -> None:
    tab.choose("fig3-case", "case1")
    everything = tab.draw("fig3-chart")
    assert "e1 and e2; e5 and e6 lie on each other" in tab.caption("fig3-chart")
    tab.choose("fig3-mode", "4")
    one = tab.traces("fig3-chart")
    assert len(one) < len(everything)
    assert one[0]["name"] == "e<sub>4</sub>"
    floor = one[-1]
    assert values(floor)[0] == pytest.approx(values(one[0])[-1], rel=1e-3), "eight are enough"
    tab.choose("fig3-reference", "euler-bernoulli@exact")
    tab.choose("fig3-scale", "log")
    limit = values(tab.traces("fig3-chart")[0])
    ratio = np.log(limit[3] / limit[7]) / np.log(2)
    assert ratio == pytest.approx(4, abs=0.2), "fourth order, from 4 to 8 elements"
    tab.choose("fig3-mode", "all")
    tab.choose("fig3-scale", "linear")
    tab.choose("fig3-reference", "timoshenko@exact")
    drawn = tab.page.locator("#fig3-chart .scatterlayer .trace").count()
    assert drawn == len(tab.traces("fig3-chart"))
    assert tab.page.locator("#fig3-chart .scatterlayer .trace").first.locator(".point").count() == 8


def test_a_name_in_the_legend_hides_its_curve(tab: Any) -> None:
    tab.draw("fig3-chart")
    seen = "document.querySelectorAll('#fig3-chart .scatterlayer .trace').length"
    before = tab.page.evaluate(seen)
    name = tab.page.locator("#fig3-chart-legend button").first
    name.click()
    assert tab.page.evaluate(seen) == before - 1
    assert name.get_attribute("aria-pressed") == "false"
    name.click()
    assert tab.page.evaluate(seen) == before


def test_budget_adds_up(tab: Any) -> None:
    tab.draw("budget-chart")
    for case in ("case1", "case2"):
        for s in ("1", "3"):
            tab.choose("budget-case", case)
            tab.choose("budget-elements", s)
            *parts, total = named(tab.traces("budget-chart"))
            assert [part["type"] for part in parts] == ["bar"] * len(parts)
            added = sum(values(part) for part in parts)
            np.testing.assert_allclose(added, values(total), rtol=1e-6)
            assert f"with {s} element" in tab.caption("budget-chart")
            assert case in tab.caption("budget-chart")
    written = tab.page.locator("#budget-chart .annotation-text").all_text_contents()
    assert written == [f"{value:+.2f}" for value in values(total)]


def test_work_and_precision(tab: Any, made: Any) -> None:
    points = [p for p in made.result("work-precision").points if p.method == "euler-bernoulli"]
    tab.draw("work-chart")
    tab.choose("work-theory", "Euler-Bernoulli")
    (line,) = named(tab.traces("work-chart"))
    known = [p for p in points if p.worst("own theory", 3) > 0]
    shown = [y for y in line["y"] if y is not None]
    np.testing.assert_allclose(shown, [p.worst("own theory", 3) for p in known], rtol=1e-4)
    tab.choose("work-modes", "1")
    shown = [y for y in named(tab.traces("work-chart"))[0]["y"] if y is not None]
    np.testing.assert_allclose(shown, [p.worst("own theory", 6) for p in known], rtol=1e-4)
    tab.choose("work-theory", "")
    assert {one["name"] for one in named(tab.traces("work-chart"))} >= {
        "euler-bernoulli", "timoshenko"}  # fmt: skip


def test_the_map_is_contours(tab: Any) -> None:
    """Between its rings and rays it is linear; outside of its rim there is nothing."""
    tab.choose("ws-set", "109 poses, 318 mm")
    tab.choose("ws-show", "frequency")
    contours, poses = tab.draw("ws-map")
    assert (contours["type"], poses["type"]) == ("contour", "scatter")
    x, y = (np.array(contours[axis]) for axis in "xy")
    z = np.array(contours["z"], dtype=float)
    given = np.array([poses[axis] for axis in "xy"], dtype=float)
    colours = np.array(poses["colours"])
    seen = [z[np.abs(y - b).argmin(), np.abs(x - a).argmin()] for a, b in given.T]
    inside = np.hypot(*given) < 17
    np.testing.assert_allclose(np.array(seen)[inside], colours[inside], rtol=5e-3)
    assert np.isnan(z[0, 0])


@pytest.mark.slow
def test_workspace_choices(tab: Any) -> None:
    tab.choose("ws-set", "109 poses, 318 mm")
    tab.choose("ws-show", "frequency")
    tab.choose("ws-run", "0")
    poses = tab.draw("ws-map")[-1]
    assert len(poses["x"]) == 12 * 9 + 1
    first = poses["colours"]
    tab.choose("ws-mode", "2")
    assert tab.traces("ws-map")[-1]["colours"] != first
    assert "f3 of timoshenko@exact" in tab.caption("ws-map")
    tab.choose("ws-set", "the gate's poses")
    assert len(tab.traces("ws-map")[-1]["x"]) == 36
    tab.choose("ws-layer", "600")
    assert "z = 600 mm" in tab.caption("ws-map")
    tab.choose("ws-model", "timoshenko@exact")
    tab.choose("ws-mode", "0")
    tab.choose("ws-show", "against")
    error = values(tab.traces("ws-map")[-1], "colours")
    assert -5 < error.min() < error.max() < 0, "shear softens"
    tab.choose("ws-model", "euler-bernoulli@exact")
    assert values(tab.traces("ws-map")[-1], "colours").min() > 0


@pytest.mark.slow
def test_workspace_names_the_pose_that_changed(tab: Any) -> None:
    tab.draw("ws-map")
    tab.choose("ws-set", "the gate's poses")
    tab.choose("ws-run", "0")
    tab.choose("ws-model", "timoshenko@exact")
    tab.choose("ws-layer", "400")
    tab.choose("ws-show", "since")
    for since in ("1", "2"):
        tab.choose("ws-since", since)
        tab.choose("ws-mode", "1")
        change = values(tab.traces("ws-map")[-1], "colours")
        assert (change != 0).sum() == 1
        assert change.max() == pytest.approx(10, rel=1e-4), "ppm"
        assert "1 of 36 poses differ" in tab.caption("ws-map")
        tab.choose("ws-mode", "0")
        assert "No pose differs" in tab.caption("ws-map")
    tab.choose("ws-model", "euler-bernoulli@exact")
    tab.choose("ws-mode", "1")
    assert "No pose differs" in tab.caption("ws-map")
    tab.choose("ws-run", "2")
    assert tab.page.locator("#ws-show option[value=since]").is_disabled(), "nothing earlier"
    assert tab.page.input_value("#ws-show") == "frequency"


@pytest.mark.slow
def test_detailed_maps_of_runs(tab: Any) -> None:
    """Any run can be chosen and held against any earlier one, and against this run's map."""
    tab.draw("ws-map")
    tab.choose("ws-set", "109 poses, 318 mm")
    tab.choose("ws-run", "1")
    tab.choose("ws-show", "since")
    since = tab.page.locator("#ws-since option")
    own, run = since.all_inner_texts()
    assert own == "this run"
    assert re.fullmatch(r"2026-03-03 14:00:00, \S+, timoshenko@exact", run)
    for earlier in ("0", "3"):
        tab.choose("ws-since", earlier)
        tab.choose("ws-mode", "1")
        assert "1 of 109 poses differ" in tab.caption("ws-map")
        assert values(tab.traces("ws-map")[-1], "colours").max() == pytest.approx(10, rel=1e-3)
        tab.choose("ws-mode", "0")
        assert "No pose differs" in tab.caption("ws-map")
    tab.page.locator("#ws-map-numbers summary").click()
    tab.page.locator("#ws-map-numbers button.n").first.click()
    text = tab.page.locator("#record").inner_text()
    for run in ("2026-03-03 14:00 UTC", "2026-03-03 16:00 UTC"):
        assert run in text
    assert text.count("rps-bench workspace") == 2
    tab.page.keyboard.press("Escape")
    tab.page.locator("#ws-map-numbers summary").click()
    tab.choose("ws-show", "against")
    assert tab.page.locator("#ws-other option").all_inner_texts() == ["euler-bernoulli@3"]
    assert not values(tab.traces("ws-map")[-1], "colours").any(), "made the same in this test"
    tab.choose("ws-run", "0")
    tab.choose("ws-show", "since")
    assert since.count() == 2, "this run's map is held against runs with its model"
    tab.choose("ws-set", "30 poses, 318 mm")
    assert tab.page.locator("#ws-show option[value=since]").is_disabled()
    assert len(tab.traces("ws-map")[-1]["x"]) == 30


def test_a_series_that_moved_is_a_click_away(tab: Any) -> None:
    cards = tab.page.locator("#history-cards button")
    assert cards.count() == 4
    card = cards.filter(has_text="timoshenko@exact").filter(has_text="case2")
    assert "+1 ppm" in card.inner_text()
    card.click()
    assert tab.page.input_value("#history-case") == "case2"
    assert tab.page.input_value("#history-model") == "timoshenko@exact"
    for trace in tab.draw("history-chart"):
        np.testing.assert_allclose(values(trace), [-1, 0, 0], rtol=1e-5, atol=1e-9)  # ppm


@pytest.mark.slow
def test_history_marks_the_release(tab: Any) -> None:
    tab.choose("history-case", "case1")
    tab.choose("history-model", "euler-bernoulli@3")
    traces = tab.draw("history-chart")
    assert len(traces) == 6
    for trace in traces:
        np.testing.assert_allclose(values(trace), [-1, 0, 0], rtol=1e-5, atol=1e-9)  # ppm
    marks = "document.getElementById('history-chart').layout.annotations.map(({text}) => text)"
    assert "rps-bench 0.2.0" in tab.page.evaluate(marks)[0]
    tab.choose("history-what", "frequency")
    tab.choose("history-mode", "3")
    (one,) = tab.traces("history-chart")
    assert values(one)[-1] == pytest.approx(236.5285, rel=1e-6)
    tab.choose("history-case", "case2")
    tab.choose("history-model", "timoshenko@exact")
    assert tab.page.locator("#history-variant").is_disabled(), "nothing but the usual"
    assert values(tab.traces("history-chart")[0])[-1] == pytest.approx(236.52, rel=1e-4)
    tab.choose("history-along", "run")
    assert tab.traces("history-chart")[0]["x"] == [1, 2, 3]
    tab.choose("history-what", "solve")
    assert (values(tab.traces("history-chart")[0]) > 0).all()
    assert tab.page.locator("#history-mode").is_disabled()


@pytest.mark.slow
def test_history_says_how_it_was_solved(tab: Any) -> None:
    tab.draw("history-chart")
    tab.choose("history-what", "solve")
    tab.choose("history-case", "case2")
    tab.choose("history-model", "euler-bernoulli@3")
    offered = tab.page.locator("#history-variant option").all_inner_texts()
    ways = ["multipliers, null-space, timed by cost", "substructure, dense, timed by cost"]
    assert offered == ["as usual", *ways, "all 3, to compare"]
    assert len(tab.traces("history-chart")[0]["y"]) == 3
    tab.choose("history-variant", ways[0])
    (one,) = tab.traces("history-chart")
    assert list(values(one)) == [2]
    assert ways[0] in tab.caption("history-chart")
    tab.choose("history-variant", "all")
    assert [trace["name"] for trace in tab.traces("history-chart")] == ["as usual", *ways]
    tab.choose("history-what", "frequency")
    assert tab.page.locator("#history-mode option").all_inner_texts()[0] == "f1"
    tab.choose("history-mode", "1")
    assert [trace["name"] for trace in tab.traces("history-chart")] == ["as usual", *ways]
    assert "Frequency of f1: euler-bernoulli@3, case2, all 3" in tab.caption("history-chart")
    tab.choose("history-what", "change")
    tab.choose("history-variant", "")
    tab.choose("history-case", "case1")
    tab.choose("history-mode", "all")
    assert len(tab.traces("history-chart")) == 6


def test_sweeps_are_listed(tab: Any) -> None:
    table = tab.page.locator("#history details", has_text="Newest sweeps")
    assert "rps-bench history --run RUN --export FILE" in table.text_content()
    cells = [cell.strip() for cell in table.locator("tbody td").all_text_contents()]
    assert cells[0].startswith("20260303-")
    assert cells[1:] == [
        "rps-bench sweep --poses random:7",
        "rayleigh@3, timoshenko@exact",
        "7",
        "28",
    ]


def test_claims_by_verdict_and_words(tab: Any) -> None:
    page = tab.page
    folded = page.locator(".claims:not([open])")
    assert "fails" not in folded.all_inner_texts()
    assert folded.count() == 3, "what fails comes first, all else is folded away"
    page.fill("#claims-search", " ")
    shown = page.locator(".claims li:visible")
    page.select_option("#claims-verdict", "fails")
    assert shown.count() == 1
    assert "</script>" in shown.inner_text(), "shown, not run"
    assert page.title() != "taken"
    page.select_option("#claims-verdict", "")
    page.fill("#claims-search", "circularly 120")
    assert shown.count() == 1
    assert page.inner_text("#claims-count") == "1 of 4 claims"
    page.fill("#claims-search", "by hand")
    page.fill("#claims-search", "m r2^2")
    assert shown.count() == 1, "a folded group opens where it has a hit"
    page.fill("#claims-search", "")
    assert shown.count() >= 2, "what has been opened stays open"
    assert page.inner_text("#claims-count") == "4 of 4 claims"


def test_a_number_says_where_it_comes_from(tab: Any) -> None:
    page = tab.page
    row = page.locator("#table1 tr", has_text="timoshenko@exact").first
    row.locator(".under button").first.click()
    dialog = page.locator("#record")
    text = dialog.inner_text()
    for part in (
        "f1: error of euler-bernoulli@3 against timoshenko@exact, case1",
        "\n1.47553",
        "euler-bernoulli@3 at case1",
        "z = 490 mm, azimuth 0°, tilt 0°",
        "none can open",
        "rps-bench table --cases case1 --references 'euler-bernoulli@3'",
        "This run",
        "numpy",
    ):
        assert part in text
    page.keyboard.press("Escape")
    assert not dialog.is_visible()


def test_a_point_says_where_it_comes_from(tab: Any) -> None:
    tab.choose("fig3-mode", "all")
    tab.draw("fig3-chart")
    tab.page.locator("#fig3-chart").scroll_into_view_if_needed()
    point = tab.page.locator("#fig3-chart .point").first.bounding_box()
    tab.page.mouse.move(point["x"] + point["width"] / 2, point["y"] + point["height"] / 2)
    tab.page.wait_for_timeout(200)
    tab.page.mouse.click(point["x"] + point["width"] / 2, point["y"] + point["height"] / 2)
    dialog = tab.page.locator("#record")
    dialog.wait_for()
    assert "rps-bench reproduce --only convergence,table" in dialog.inner_text()
    dialog.get_by_role("button", name="Close").click()
    assert not dialog.is_visible()


def test_numbers_under_a_chart(tab: Any) -> None:
    tab.choose("fig3-mode", "all")
    tab.page.locator("#fig3-chart-numbers summary").click()
    table = tab.page.locator("#fig3-chart-numbers table")
    table.wait_for()
    assert table.locator("tbody tr").count() == 9, "eight numbers of elements, and the floor"
    assert table.locator("button").count() == 48


def test_a_link_opens_what_is_folded_away(made: Any, opened: Any) -> None:
    with opened(made.file) as tab:
        tab.page.evaluate("location.hash = '#claim-mass-matrix'")
        tab.page.locator("#claim-mass-matrix").wait_for(state="visible")


def test_what_cannot_be_read_is_named(tab: Any) -> None:
    assert "foreign.parquet" in tab.page.inner_text("#skipped")
    assert "Gate: failed." in tab.page.inner_text("#result")
