"""The page as people meet it: by keyboard, on paper, on a phone, in the dark, without WebGL."""

import io
from typing import Any

import numpy as np
import pytest
from axe_playwright_python.sync_playwright import Axe
from PIL import Image

pytestmark = pytest.mark.slow

CHARTS = ["fig3-chart", "budget-chart", "work-chart", "ws-map", "ws-surface", "shape-chart",
          "history-chart"]  # fmt: skip

SMALL = {"width": 800, "height": 600}


def picture(locator: Any) -> np.ndarray:
    return np.asarray(Image.open(io.BytesIO(locator.screenshot())).convert("RGB"), dtype=int)


def wide(page: Any) -> int:
    found: int = page.evaluate("document.documentElement.scrollWidth - innerWidth")
    return found


def scrolling(page: Any) -> list[str]:
    """Boxes inside the page that hold more than they show, but for drop-down lists."""
    found: list[str] = page.evaluate("""[...document.querySelectorAll("body *")]
        .filter((one) => ["auto", "scroll"].includes(getComputedStyle(one).overflowX)
          || ["auto", "scroll"].includes(getComputedStyle(one).overflowY))
        .filter((one) => one.scrollWidth > one.clientWidth + 1
          || one.scrollHeight > one.clientHeight + 1)
        .filter((one) => !one.closest("select, dialog"))
        .map((one) => one.outerHTML.slice(0, 80))""")
    return found


def broken(page: Any, cells: str = "th") -> list[str]:
    """Words in tables' heads, or in other `cells`, that stand on two lines."""
    script = r"""(cells) => [...document.querySelectorAll(cells)].flatMap((cell) =>
        [...cell.childNodes].filter((one) => one.nodeType === 3).flatMap((node) =>
          [...node.data.matchAll(/\w+/g)].filter((word) => {
            const range = document.createRange();
            range.setStart(node, word.index);
            range.setEnd(node, word.index + word[0].length);
            return new Set([...range.getClientRects()].map((box) => Math.round(box.top))).size > 1;
          }).map((word) => word[0])))"""
    found: list[str] = page.evaluate(script, cells)
    return found


def open_all(page: Any) -> None:
    page.evaluate("document.querySelectorAll('details').forEach((one) => { one.open = true })")


@pytest.fixture(scope="module")
def tab(made: Any, opened: Any) -> Any:
    with opened(made.file, viewport=SMALL) as tab:
        yield tab


def test_pictures(tab: Any) -> None:
    """Every chart draws something, and in the dark something else."""
    for chart in CHARTS:
        tab.draw(chart)
        solid = chart in ("ws-surface", "shape-chart")
        tab.page.wait_for_timeout(600 if solid else 50)
        light = picture(tab.page.locator(f"#{chart}"))
        assert len(np.unique(light.reshape(-1, 3), axis=0)) > 20, chart
        if chart not in ("fig3-chart", "ws-map", "shape-chart"):
            continue
        tab.page.click("#theme")
        tab.page.wait_for_timeout(600 if solid else 50)
        dark = picture(tab.page.locator(f"#{chart}")).mean()
        assert dark < (0.75 if chart == "ws-map" else 0.5) * light.mean(), chart
        tab.page.click("#theme")


def test_shapes_turn_and_move(tab: Any) -> None:
    page = tab.page
    traces = tab.draw("shape-chart")
    assert [trace["type"] for trace in traces] == ["mesh3d"] * 8 + ["scatter3d"]
    page.wait_for_timeout(800)
    still = [picture(page.locator("#shape-chart")) for _ in range(2)]
    assert (still[0] == still[1]).all(), "nothing moves unasked"
    tab.choose("shape-mode", "3")
    third = tab.traces("shape-chart")
    assert third[4]["x"] != traces[4]["x"]
    assert third[0]["x"] == traces[0]["x"], "the undeformed mechanism stays"
    tab.choose("shape-case", "case2")
    assert tab.traces("shape-chart")[0]["x"] != traces[0]["x"]
    tab.choose("shape-model", "timoshenko@exact")
    assert "236.52" in tab.caption("shape-chart")
    eye = "document.getElementById('shape-chart')._fullLayout.scene.camera.eye"
    before = page.evaluate(eye)
    for name in ("Turn left", "Look from higher", "Nearer"):
        page.get_by_role("button", name=name).click()
        after = page.evaluate(eye)
        assert after != before, name
        before = after
    page.get_by_role("button", name="Play").click()
    places = []
    for _ in range(3):
        page.wait_for_timeout(300)
        places.append(tab.traces("shape-chart")[7]["z"])
    assert places[0] != places[1] != places[2]
    page.get_by_role("button", name="Pause").dispatch_event("click")
    page.wait_for_timeout(500)
    assert tab.traces("shape-chart")[7]["z"] == tab.traces("shape-chart")[7]["z"]


def test_the_drawn_shape_is_the_mode(tab: Any, made: Any) -> None:
    """The platform's centre as drawn moves the way of Modes.platform, to a fifth of a limb."""
    tab.draw("shape-chart")
    tab.choose("shape-case", "case2")
    tab.choose("shape-model", "rayleigh@3")
    tab.choose("shape-mode", "2")
    traces = tab.traces("shape-chart")
    moved = np.array([traces[7][axis][0] - traces[3][axis][0] for axis in "xyz"])
    study = made.result("table1").study
    ((modes),) = [m for (case, model), m in study.answers.items()
                  if (case.name, model.label) == ("case2", "rayleigh@3")]  # fmt: skip
    mode = modes.platform[1, :3]
    assert moved @ mode / np.linalg.norm(moved) / np.linalg.norm(mode) == pytest.approx(1, abs=1e-4)
    largest = np.abs(modes.limbs[1]).max()
    length = np.linalg.norm(moved) / np.linalg.norm(mode) * largest
    assert length == pytest.approx(0.2 * 0.5, rel=0.05), "a fifth of some half a metre"


def test_by_keyboard_alone(made: Any, opened: Any) -> None:
    """Tab reaches every control, and each shows that it has the focus."""
    with opened(made.file, viewport=SMALL) as tab:
        page, focused = tab.page, "document.activeElement"
        page.keyboard.press("Tab")
        assert page.evaluate(f"{focused}.className") == "skip"
        page.keyboard.press("Enter")
        assert page.evaluate(f"{focused}.id") == "main"
        page.reload()
        page.locator("html[data-charts]").wait_for()
        page.evaluate("""document.addEventListener("focusin", ({target}) => {
            const {outlineStyle, outlineWidth} = getComputedStyle(target);
            target.dataset.seen = outlineStyle !== "none" && parseFloat(outlineWidth) >= 1; })""")
        controls = ":is(a, button, select:enabled, input, summary, [tabindex='0']):visible"
        wanted = page.locator(controls).count()
        for _ in range(wanted):
            page.keyboard.press("Tab")
        assert page.locator("[data-seen=true]").count() == wanted
        page.locator("#table1 button.n").first.focus()
        page.keyboard.press("Enter")
        assert page.locator("#record").is_visible()
        page.keyboard.press("Escape")
        assert not page.locator("#record").is_visible()
        assert page.evaluate(f"{focused}.className") == "n", "back where it was"
        page.locator("#fig3-mode").focus()
        page.keyboard.press("ArrowDown")
        assert page.input_value("#fig3-mode") == "1"


def test_on_paper(made: Any, opened: Any) -> None:
    with opened(made.file, color_scheme="dark", viewport=SMALL) as tab:
        page = tab.page
        page.emulate_media(media="print", color_scheme="dark")
        for chart in CHARTS:
            page.locator(f"#{chart}.js-plotly-plot").wait_for()
        assert page.evaluate("document.documentElement.dataset.theme") == "light"
        assert page.locator("nav, .controls, summary, #theme").locator("visible=true").count() == 0
        assert page.locator("details.print:not([open])").count() == 0
        assert page.locator("#budget table tr").count() > 20
        page.set_viewport_size({"width": 688, "height": 1000})  # A4 within its margins
        assert broken(page, "th, td") == []
        assert wide(page) <= 0
        paper = page.pdf(format="A4")
        assert len(paper) > 50_000
        page.emulate_media(media="screen", color_scheme="dark")
        page.locator("html[data-theme=dark]").wait_for()
        assert page.locator("#theme").is_visible()
        assert page.locator("#budget details[open]").count() == 0


def test_the_first_screen_answers_five_questions(made: Any, opened: Any) -> None:
    """On a usual screen, without a step: questions, verdicts, gate, figure and mechanism."""
    with opened(made.file, viewport={"width": 1400, "height": 900}) as tab:
        page = tab.page
        asked = page.locator("#result .asked, #result dt")
        assert asked.all_inner_texts() == [
            "Are 3 elements a limb enough?", "What does beam theory cost?", "What was checked?",
            "Against what?", "Where does the paper contradict itself?",
        ]  # fmt: skip
        for one in [*asked.all(), *page.locator("#result :is(.counts, .gate, svg, dd)").all()]:
            box = one.bounding_box()
            assert 0 < box["y"] < box["y"] + box["height"] <= 900, one.inner_html()[:60]
        assert page.locator("nav").bounding_box()["height"] < 60, "in one line"


@pytest.mark.parametrize("width", [1400, 1024])
def test_nothing_scrolls_inside_the_page(made: Any, opened: Any, width: int) -> None:
    """Every table shows all its columns, and uses the width there is."""
    with opened(made.file, viewport={"width": width, "height": 900}) as tab:
        page = tab.page
        for chart in CHARTS:
            tab.draw(chart)
        open_all(page)
        assert wide(page) == 0
        assert scrolling(page) == []
        assert broken(page) == []
        for one in ("#table1 table >> nth=0", "#fig3-chart", "#history-chart"):
            assert page.locator(one).bounding_box()["width"] > 0.9 * width, one


def test_on_a_phone(made: Any, opened: Any) -> None:
    size = {"width": 390, "height": 844}
    with opened(made.file, viewport=size, has_touch=True, is_mobile=True) as tab:
        page = tab.page
        assert wide(page) == 0
        for chart in CHARTS:
            tab.draw(chart)
            box = page.locator(f"#{chart}").bounding_box()
            assert box["x"] >= 0
            assert box["x"] + box["width"] <= 390
            key = page.locator(f"#{chart}-legend")
            if key.is_visible():
                assert key.bounding_box()["height"] < box["height"], chart
        open_all(page)
        page.wait_for_timeout(200)
        assert wide(page) == 0
        assert scrolling(page) == []
        outside = page.evaluate("""[...document.querySelectorAll("main td, main th, main button")]
            .filter((one) => one.getBoundingClientRect().right > innerWidth + 1).length""")
        assert outside == 0
        page.locator("#table1 button.n").first.click()
        box = page.locator("#record").bounding_box()
        assert 0 <= box["x"] < box["x"] + box["width"] <= 390


def test_on_a_phone_the_navigation_follows(made: Any, opened: Any) -> None:
    size = {"width": 390, "height": 844}
    with opened(made.file, viewport=size, has_touch=True, is_mobile=True) as tab:
        page = tab.page
        assert not page.locator("#sections").is_visible()
        page.locator("#history").scroll_into_view_if_needed()
        page.evaluate("document.getElementById('history').scrollIntoView()")
        page.locator("#menu", has_text="History").wait_for()
        assert page.locator("#menu").bounding_box()["y"] < 60, "it is where the reader is"
        page.click("#menu")
        page.click("#sections a[href='#fig3']")
        assert not page.locator("#sections").is_visible()
        page.locator("#menu", has_text="Fig. 3").wait_for()


def test_accessible(made: Any, opened: Any) -> None:
    """No violation of any rule of axe, in light and dark, all tables and a dialog open."""
    with opened(made.file, viewport=SMALL) as tab:
        page = tab.page
        tab.choose("ws-set", "the gate's poses")
        for chart in CHARTS:
            tab.draw(chart)
        open_all(page)
        for theme in ("light", "dark"):
            assert page.evaluate("document.documentElement.dataset.theme") == theme
            found = Axe().run(page)
            assert found.violations_count == 0, found.generate_report()
            page.click("#theme")
        page.locator("#table1 button.n").first.click()
        found = Axe().run(page, context="#record")
        assert found.violations_count == 0, found.generate_report()


def test_accessible_on_a_phone(made: Any, opened: Any) -> None:
    size = {"width": 390, "height": 844}
    with opened(made.file, viewport=size, has_touch=True, is_mobile=True) as tab:
        open_all(tab.page)
        found = Axe().run(tab.page)
        assert found.violations_count == 0, found.generate_report()


def test_without_webgl(made: Any, opened: Any) -> None:
    none = """const own = HTMLCanvasElement.prototype.getContext;
        HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
            return kind.startsWith("webgl") ? null : own.call(this, kind, ...rest) };"""
    with opened(made.file, none, viewport=SMALL) as tab:
        for chart in ("ws-surface", "shape-chart"):
            place = tab.page.locator(f"#{chart}")
            place.scroll_into_view_if_needed()
            tab.page.locator(f"#{chart}.empty").wait_for()
            assert "no WebGL" in place.inner_text()
        tab.page.get_by_role("button", name="Play").click()
        tab.page.get_by_role("button", name="Turn left").click()
        assert len(tab.draw("ws-map")[-1]["x"]) > 0


def test_the_theme_is_chosen(made: Any, opened: Any) -> None:
    with opened(made.file, color_scheme="dark", viewport=SMALL) as tab:
        page = tab.page
        tab.draw("fig3-chart")
        ground = "getComputedStyle(document.body).backgroundColor"
        ink = "document.getElementById('fig3-chart')._fullLayout.font.color"
        dark = page.evaluate(ground), page.evaluate(ink)
        drawn = [
            f"getComputedStyle(document.querySelector('.panels {one}')).{what}"
            for one, what in (("#panel0-patch_2 path", "fill"), ("#panel0-text_1", "fill"))
        ]
        body = "getComputedStyle(document.body).color"
        seen = [page.evaluate(one) for one in drawn]
        assert seen == [dark[0], page.evaluate(body)], "drawings stand on the page, in its ink"
        page.click("#theme")
        assert [page.evaluate(one) for one in drawn] == ["rgb(255, 255, 255)", page.evaluate(body)]
        light = page.evaluate(ground), page.evaluate(ink)
        assert light == ("rgb(255, 255, 255)", "#1c2127")
        assert dark != light
        page.reload()
        assert page.evaluate(ground) == light[0], "remembered"
        tab.asked.clear()
        tab.asked.append(page.url)
