"""Pages of quick runs and a made history, and a real browser to open them in."""

import json
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from playwright.sync_api import Browser, Page, sync_playwright

from analytic import Mechanism, Pose, condensed_frequencies
from harness.bench import Bench, run
from harness.cases import PRESETS
from harness.history import store
from harness.report.page import page_files, render
from harness.reproduce import Part, chosen, reproduce
from harness.request import Plan
from harness.result import Result
from harness.rows import mechanism_hash
from harness.studies import find
from harness.studies.precision import work_precision
from harness.timing import Way
from reference_models import Named

FLAGS = [
    "--no-sandbox", "--disable-background-networking", "--disable-component-update",
    "--disable-sync", "--no-first-run", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
]  # fmt: skip
HOSTILE = "</script><script>document.title = 'taken'</script> & \u2028 {{ 7 * 7 }}"
CLAIMS = [
    ("mass-matrix", "Eq. 8", "m r2^2 about all axes", "12 % on f3", "holds", "holds"),
    ("fem-close", "Section 3.3", HOSTILE, "1.5 to 6 %", "fails: the references differ", "fails"),
    ("symmetric", "Fig. 6", "circularly symmetric", "120 degrees",
     "holds only if read loosely", "holds only if"),
    ("table", "Table I", "115.02 Hz", "137.8 Hz", "cannot be reproduced as printed",
     "cannot be reproduced"),
]  # fmt: skip
CHANGED = 3, 1e-5
"""The pose whose f2 the newest run gives otherwise, and by how much, relative."""
CHANGED_ON_MAP = 13, 2
"""The pose and mode that the newest map has otherwise, by as much."""
WAYS = ("substructure, dense", "multipliers, null-space")
THEORY, FIRST, SECOND = Named("euler-bernoulli", 3), Named("timoshenko", None), Named("rayleigh", 3)
PLAN = Plan((PRESETS["case1"], PRESETS["case2"]), THEORY, (FIRST, SECOND))
CHECK = {
    "status": "failed",
    "summary": "failed: 1 frequency moved",
    "time": "2026-03-03T12:00:00",
    "findings": [{"kind": "frequency", "model": "exudyn-beam@12+24", "case": "case1", "mode": 1,
                  "before": 135.824, "after": 135.826, "verdict": "moved"}],
}  # fmt: skip


class Claims(Result):
    """Claims as the study judges them."""

    def to_frame(self) -> pd.DataFrame:
        names = ("id", "section", "quoted", "measured", "verdict", "kind")
        more = {"how": "by hand", "uncertainty": "0.1 %", "command": "rps-bench claims"}
        return pd.DataFrame([dict(zip(names, one, strict=True)) | more for one in CLAIMS])


@dataclass(frozen=True)
class Mapped(Result):
    """A map as the study of the workspace gives it."""

    given: tuple[dict[str, Any], ...]

    def rows(self) -> list[dict[str, Any]]:
        return list(self.given)

    def sentences(self) -> list[str]:
        return ["f1 falls with the height."]


@dataclass(frozen=True)
class Made:
    """Where the page was made, the history it was made with, and its parts."""

    results: Path
    history: Path
    file: Path
    parts: tuple[Part, ...]

    def result(self, stem: str) -> Any:
        return next(part.results[stem] for part in self.parts if stem in part.results)


def workspace_rows(robot: Mechanism, change: float) -> list[dict[str, Any]]:
    """Poses as the gate solves them: 3 layers, 12 azimuths, 3 tilts, two models."""
    grid = np.meshgrid(
        [0.4, 0.5, 0.6], np.radians(30 * np.arange(12)), np.radians([5, 10, 15]), indexing="ij"
    )
    z, azimuth, tilt = (axis.ravel() for axis in grid)
    result = []
    for beam in ("euler-bernoulli", "timoshenko"):
        found = condensed_frequencies(robot, Pose(z, azimuth, tilt), elements=None, beam=beam)
        if beam == "timoshenko":
            found[CHANGED[0], 1] *= 1 + change
        for k, frequencies in enumerate(found):
            pose = {"z_m": z[k], "azimuth_rad": azimuth[k], "tilt_rad": tilt[k]}
            about = {"case": "workspace", "mechanism": "abc", "model": f"{beam}@exact",
                     "theory": beam, "settings": "{}", "version": "rps-bench 0.2"}  # fmt: skip
            result += [
                {**pose, **about, "mode": i, "frequency_hz": f}
                for i, f in enumerate(frequencies, 1)
            ]
    return result


def map_rows(robot: Mechanism, model: str, change: float = 0.0) -> list[dict[str, Any]]:
    """One layer as `rps-bench workspace` records it: 12 azimuths, 9 tilts and a level platform."""
    azimuth, tilt = np.meshgrid(np.radians(30 * np.arange(12)), np.radians(2.0 * np.arange(1, 10)))
    azimuth, tilt = np.append(0.0, azimuth.ravel()), np.append(0.0, tilt.ravel())
    z = np.full(len(tilt), 0.318)
    found = condensed_frequencies(robot, Pose(z, azimuth, tilt), elements=None, beam="timoshenko")
    about = {"case": "map", "mechanism": mechanism_hash(robot), "model": model, "theory": "any",
             "settings": '{"count": 3}', "version": "rps-bench 0.2"}  # fmt: skip
    return [
        {**about, "z_m": z[k], "azimuth_rad": azimuth[k], "tilt_rad": tilt[k], "mode": mode,
         "frequency_hz": found[k, mode - 1] * (1 + change * ((k, mode) == CHANGED_ON_MAP))}
        for k in range(len(tilt)) for mode in (1, 2, 3)
    ]  # fmt: skip


def append_others(history: Path, robot: Mechanism, named: list[dict[str, Any]]) -> None:
    """What commands other than the gate record: ways to solve, maps, a row of heights, a sweep."""
    hours = (datetime(2026, 3, 3, hour, tzinfo=UTC) for hour in range(13, 24))
    slow = [row for row in named if (row["case"], row["model"]) == ("case2", THEORY.label)]
    ways = [row | {"settings": json.dumps({"count": 6, "way": way, "timed": "cost"}),
                   "solve_s": 0.001 * (k + 1)}
            for k, way in enumerate(WAYS) for row in slow]  # fmt: skip
    store.append(history, ways, "rps-bench cost", next(hours))
    model = "timoshenko@exact"
    same = map_rows(robot, model)
    for rows_of_map in (
        same,
        map_rows(robot, "euler-bernoulli@3"),
        map_rows(robot, model, CHANGED[1]),
        same[:90],
    ):
        store.append(history, rows_of_map, "rps-bench workspace", next(hours))
    heights = [row | {"tilt_rad": 0.0, "z_m": 0.3 + 0.001 * k} for k, row in enumerate(same)]
    store.append(history, heights, "rps-bench claims", next(hours))
    pose = {"azimuth_rad": 0.1, "tilt_rad": 0.2, "case": "sweep", "mechanism": "abc"}
    sweep = [{**pose, "z_m": 0.3 + k / 1000, "model": name, "mode": mode, "frequency_hz": 100.0}
             for name in (model, "rayleigh@3") for k in range(7) for mode in (1, 2)]  # fmt: skip
    store.append(history, sweep, "rps-bench sweep --poses random:7", next(hours))


def made_history(history: Path, robot: Mechanism) -> None:
    """Three runs of the gate, the first of an older release, whose frequencies are 1e-6 lower;
    after them one of each other kind."""
    now = run(PLAN.cases, [THEORY, FIRST], 6).rows()
    old = [row | {"frequency_hz": row["frequency_hz"] * (1 - 1e-6), "version": "rps-bench 0.1"}
           for row in now]  # fmt: skip
    for day, ours, release in ((1, old, "0.1.0"), (2, now, "0.2.0"), (3, now, "0.2.0")):
        change = CHANGED[1] if day == 3 else 0.0
        named = [row | {"release": release} for row in ours + workspace_rows(robot, change)]
        store.append(history, named, "rps-bench check", datetime(2026, 3, day, 12, tzinfo=UTC))
    append_others(history, robot, now)
    (history / "foreign.parquet").write_bytes(b"not a table")


@pytest.fixture(scope="session")
def parts(robot: Mechanism) -> tuple[Part, ...]:
    """What studies of analytic models give; claims and the map are made up."""
    with Bench() as bench:
        found = list(reproduce(chosen(["table", "convergence", "refine", "budget"]), PLAN, bench))
        ways = [Way(Named(name, s)) for name in ("euler-bernoulli", "timoshenko")
                for s in (1, 2, 4, None)]  # fmt: skip
        timed = work_precision(PLAN.cases[1:], ways, None, 1, bench)
    found.append(Part(find("work-precision"), {"work-precision": timed}))
    found.append(Part(find("claims"), {"claims": Claims()}))
    mapped = Mapped(tuple(map_rows(robot, "timoshenko@exact")))
    found.append(Part(find("workspace"), {"workspace": mapped}))
    found.append(Part(find("slenderness"), {}, "no solid can run"))
    return tuple(found)


@pytest.fixture(scope="session")
def made(
    tmp_path_factory: pytest.TempPathFactory, robot: Mechanism, parts: tuple[Part, ...]
) -> Made:
    folder = tmp_path_factory.mktemp("page")
    results, history = folder / "latest", folder / "history"
    results.mkdir()
    made_history(history, robot)
    for name, content in page_files(PLAN, parts, history).items():
        (results / name).write_bytes(content)
    kept = json.loads((results / "page.json").read_text())
    (results / "index.html").write_bytes(render(kept, history, CHECK))
    return Made(results, history, results / "index.html", parts)


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Debian's chromium, without a screen."""
    program = shutil.which("chromium")
    if program is None:
        pytest.skip("needs a browser: apt-get install chromium")
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=program, args=FLAGS)
        yield started
        started.close()


@dataclass
class Tab:
    """An open page; `said`, errors on its console; `asked`, addresses outside its own file."""

    page: Page
    said: list[str] = field(default_factory=list)
    asked: list[str] = field(default_factory=list)

    def choose(self, control: str, value: str) -> None:
        self.page.select_option(f"#{control}", value)

    def draw(self, chart: str) -> list[dict[str, Any]]:
        """Bring a chart on the screen; return its traces."""
        self.page.locator(f"#{chart}").scroll_into_view_if_needed()
        self.page.locator(f"#{chart}.js-plotly-plot").wait_for()
        return self.traces(chart)

    def traces(self, chart: str) -> list[dict[str, Any]]:
        found: list[dict[str, Any]] = self.page.evaluate(
            """id => document.getElementById(id).data.map(({name, type, x, y, z, marker, quiet,
                intensity}) => ({name, type, x, y, z, intensity, quiet,
                colours: marker?.color, symbol: marker?.symbol}))""",
            chart,
        )
        return found

    def caption(self, chart: str) -> str:
        return self.page.inner_text(f"#{chart}-caption")


Opened = Callable[..., Any]


@pytest.fixture(scope="session")
def opened(browser: Browser) -> Opened:
    """`with opened(file, **context) as tab`: neither errors nor requests may come of it."""

    @contextmanager
    def open_tab(file: Path, script: str = "", **context: Any) -> Iterator[Tab]:
        settings = {"viewport": {"width": 1280, "height": 900}, **context}
        with browser.new_context(**settings) as own:
            tab = Tab(own.new_page())
            if script:
                tab.page.add_init_script(script)
            tab.page.on(
                "console", lambda one: tab.said.append(one.text) if one.type == "error" else None
            )
            tab.page.on("pageerror", lambda error: tab.said.append(str(error)))
            tab.page.on("request", lambda one: tab.asked.append(one.url))
            tab.page.goto(file.as_uri())
            tab.page.locator("html[data-charts]").wait_for()
            yield tab
            assert tab.said == []
            assert {url for url in tab.asked if not url.startswith(("data:", "blob:"))} == {
                file.as_uri()
            }

    return open_tab


@pytest.fixture(scope="module")
def tab(made: Made, opened: Opened) -> Iterator[Tab]:
    """The page, open; tests set what they need and leave the rest as it is."""
    with opened(made.file) as tab:
        yield tab
