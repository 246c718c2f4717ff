"""A page of real results and a made history, and a real browser to open it in."""

import csv
import json
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser, Page, sync_playwright

from analytic import Mechanism, Pose, condensed_frequencies
from harness.cases import PRESETS
from harness.history import store
from harness.models import Spec
from harness.report.page import page
from harness.report.sources import Sources, read_sources
from harness.run import mechanism_hash, rows, run

RESULTS = Path(__file__).parents[3] / "results"
FLAGS = [
    "--no-sandbox", "--disable-background-networking", "--disable-component-update",
    "--disable-sync", "--no-first-run", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
]  # fmt: skip
HOSTILE = "</script><script>document.title = 'taken'</script> & \u2028 {{ 7 * 7 }}"
CLAIMS = [
    ("mass-matrix", "Eq. 8", "m r2^2 about all axes", "12 % on f3", "holds"),
    ("fem-close", "Section 3.3", HOSTILE, "1.5 to 6 %", "fails: the references differ"),
    ("symmetric", "Fig. 6", "circularly symmetric", "120 degrees", "holds only if read loosely"),
    ("table", "Table I", "115.02 Hz", "137.8 Hz", "cannot be reproduced as printed"),
]
CHANGED = 3, 1e-5
"""The pose whose f2 the newest run gives otherwise, and by how much, relative."""
CHANGED_ON_MAP = 13, 2
"""The pose and mode that the newest map has otherwise, by as much."""
WAYS = ("substructure, dense", "multipliers, null-space")


@dataclass(frozen=True)
class Made:
    """Where the sources of the page were made, the sources, and the page."""

    results: Path
    history: Path
    sources: Sources
    file: Path


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


def map_rows(file: Path, model: str, change: float = 0.0) -> list[dict[str, Any]]:
    """The poses of an accepted map as `rps-bench workspace` records them."""
    about = {"case": "map", "mechanism": mechanism_hash(PRESETS["case1"].mechanism), "model": model,
             "theory": "any", "settings": '{"count": 3}', "version": "rps-bench 0.2"}  # fmt: skip
    result = []
    with file.open(newline="") as lines:
        for k, row in enumerate(csv.DictReader(lines)):
            if float(row["tilt_rad"]) == 0 and float(row["azimuth_rad"]) != 0:
                continue  # a level platform once
            pose = {name: float(row[name]) for name in ("z_m", "azimuth_rad", "tilt_rad")}
            for mode in (1, 2, 3):
                f = float(row[f"f{mode}_hz"]) * (1 + change * ((k, mode) == CHANGED_ON_MAP))
                result.append({**about, **pose, "mode": mode, "frequency_hz": f})
    return result


def append_others(history: Path, accepted: Path, named: list[dict[str, Any]]) -> None:
    """What commands other than the gate record: ways to solve, maps, a row of heights, a sweep."""
    hours = (datetime(2026, 3, 3, hour, tzinfo=UTC) for hour in range(13, 24))
    slow = [row for row in named if (row["case"], row["model"]) == ("case2", "euler-bernoulli@3")]
    ways = [row | {"settings": json.dumps({"count": 6, "way": way, "timed": "cost"}),
                   "solve_s": 0.001 * (k + 1)}
            for k, way in enumerate(WAYS) for row in slow]  # fmt: skip
    store.append(history, ways, "rps-bench cost", next(hours))
    model = "timoshenko@exact"
    same = map_rows(accepted, model)
    for rows_of_map in (
        same,
        map_rows(accepted, "euler-bernoulli@3"),
        map_rows(accepted, model, CHANGED[1]),
        same[:90],
    ):
        store.append(history, rows_of_map, "rps-bench workspace", next(hours))
    heights = [row | {"tilt_rad": 0.0, "z_m": 0.3 + 0.001 * k} for k, row in enumerate(same)]
    store.append(history, heights, "rps-bench claims", next(hours))
    pose = {"azimuth_rad": 0.1, "tilt_rad": 0.2, "case": "sweep", "mechanism": "abc"}
    sweep = [{**pose, "z_m": 0.3 + k / 1000, "model": name, "mode": mode, "frequency_hz": 100.0}
             for name in (model, "rayleigh@3") for k in range(7) for mode in (1, 2)]  # fmt: skip
    store.append(history, sweep, "rps-bench sweep --poses random:7", next(hours))


@pytest.fixture(scope="session")
def made(tmp_path_factory: pytest.TempPathFactory, robot: Mechanism) -> Made:
    """Three runs of the gate, the first of an older release, whose frequencies are 1e-6 lower;
    after them one of each other kind.
    """
    folder = tmp_path_factory.mktemp("dashboard")
    results, history = folder / "results", folder / "history"
    (results / "workspace").mkdir(parents=True)
    for stem in ("table1", "fig3", "references", "budget"):
        for end in ("csv", "md"):
            shutil.copy(RESULTS / f"{stem}.{end}", results)
    shutil.copy(RESULTS / "frequencies.csv", results)
    with (RESULTS / "workspace" / "map.csv").open() as file:
        lines = file.readlines()[:721]  # the lowest layer: 72 azimuths of 10 tilts
    kept = [line for k, line in enumerate(lines[1:]) if k // 10 % 6 == 0]
    (results / "workspace" / "map.csv").write_text("".join([lines[0], *kept]))
    names = ("id", "section", "quoted", "measured", "verdict")
    claims = [dict(zip(names, claim, strict=True)) for claim in CLAIMS]
    for claim in claims:
        claim |= {"uncertainty": "0.1 %", "command": f"rps-bench claims --only {claim['id']}"}
    (results / "claims.json").write_text(json.dumps(claims))
    finding = {"kind": "frequency", "model": "exudyn-beam@12+24", "case": "case1", "mode": 1,
               "before": 135.824, "after": 135.826, "verdict": "moved"}  # fmt: skip
    check = {"status": "failed", "findings": [finding]}
    (results / "check.json").write_text(json.dumps(check))
    with (results / "work-precision.csv").open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["Case", "Model", "Theory", "Elements", "Modes", "Error own theory [%]",
                        "Error 3-D [%]", "ms a pose"])  # fmt: skip
        for s in (1, 2, 4):
            for modes, error in (("f1-f3", 0.2), ("f1-f6", 12.0)):
                row = ["dense", "Euler", s, modes, error / s**4, 5 + error / s**4, 4 + s]
                table.writerow(["both cases", *row])
        for theory in ("Euler", "Timoshenko"):
            row = [f"exact, {theory}", theory, "-", "f1-f3", "is the truth", 1.2, 0.02]
            table.writerow(["both cases", *row])
    specs = [Spec("euler-bernoulli", 3), Spec("timoshenko", None)]
    now = rows(run([PRESETS["case1"], PRESETS["case2"]], specs, 6))
    old = [row | {"frequency_hz": row["frequency_hz"] * (1 - 1e-6), "version": "rps-bench 0.1"}
           for row in now]  # fmt: skip
    for day, ours, release in ((1, old, "0.1.0"), (2, now, "0.2.0"), (3, now, "0.2.0")):
        change = CHANGED[1] if day == 3 else 0.0
        named = [row | {"release": release} for row in ours + workspace_rows(robot, change)]
        store.append(history, named, "rps-bench check", datetime(2026, 3, day, 12, tzinfo=UTC))
    append_others(history, results / "workspace" / "map.csv", now)
    (history / "foreign.parquet").write_bytes(b"not a table")
    sources = read_sources(results, history)
    file = folder / "dashboard.html"
    file.write_bytes(page(sources))
    return Made(results, history, sources, file)


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
            """id => document.getElementById(id).data.map(({name, type, x, y, z, r, theta, marker,
                intensity}) => ({name, type, x, y, z, r, theta, intensity,
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
