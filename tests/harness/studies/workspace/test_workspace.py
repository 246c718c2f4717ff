"""Maps of the workspace: the grid, the paper's two statements, tables, pictures and rows."""

import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from analytic import Continuum, InputError, Limits, Mechanism, Modes, Pose, Substructure, reachable
from analytic.regular_workspace import RegularWorkspace
from analytic.workspace import inscribed
from harness.bench import Bench
from harness.cases import PRESETS
from harness.figures import picture
from harness.request import Plan, Request
from harness.rows import MAP, mechanism_hash
from harness.studies import workspace
from harness.studies.workspace import Workspace, figures
from harness.studies.workspace.checks import (
    height_table,
    largest_ripple,
    mirrored,
    region_table,
    ripple,
    rises,
    symmetry_table,
    turned,
    verdicts,
)
from harness.studies.workspace.map import Answers, Grid, Map, Region, limits_met, solve
from harness.text import request
from reference_models import ModelError, Named

CONTINUUM = Named("timoshenko", None)
MECHANISMS = Path(__file__).parents[4] / "results/published/mechanisms.toml"


@pytest.fixture(scope="module")
def bench() -> Iterator[Bench]:
    with Bench() as own:
        yield own


@pytest.fixture(scope="module")
def region(robot: Mechanism) -> Region:
    z = np.array([0.3, 0.5, 0.7, 0.9])
    circles = RegularWorkspace(z, inscribed(robot, z, Limits(), azimuths=24)[0])
    return Region(robot, Limits(), circles, circles.cone())


@pytest.fixture(scope="module")
def grid(region: Region) -> Grid:
    return Grid.of(region, np.array([0.32, 0.5, 0.8]), 24, 5)


@pytest.fixture(scope="module")
def solved(region: Region, grid: Grid, bench: Bench) -> Map[Grid]:
    return Map.of(grid, CONTINUUM, 6, bench)


@pytest.fixture
def few_layers(monkeypatch: pytest.MonkeyPatch) -> None:
    """A coarse profile, to be quick."""
    monkeypatch.setattr("harness.studies.workspace.map.PROFILE", 9)


@dataclass(frozen=True)
class Planted:
    """A model of which a test says what it does at many poses, and at one."""

    elements: int | None = 2
    isolated: bool = True
    fails_between: tuple[float, float] = (2, 3)
    broken: str = ""

    def info(self) -> Any:
        return replace(Substructure(2).info(), isolated=self.isolated)

    def limit(self) -> None:
        return None

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        low, high = self.fails_between
        if low < pose.azimuth < high:
            raise ModelError("no convergence")
        return Substructure(2).modes(mechanism, pose, count)

    def frequencies(self, mechanism: Mechanism, poses: Pose, count: int = 6) -> Any:
        found = Substructure(2).frequencies(mechanism, poses, count)
        if self.broken == "nan":
            found[-1, 0] = np.nan
        return (
            found[:, ::-1]
            if self.broken == "order"
            else found[:1]
            if self.broken == "shape"
            else found
        )


def made(grid: Grid, frequencies: Any) -> Map[Grid]:
    """A map of frequencies that no model gave."""
    found = frequencies[grid.wanted]
    answers = Answers(CONTINUUM, grid.mechanism, grid.held(grid.wanted), found,
                      [None] * len(found), {})  # fmt: skip
    return Map(grid, answers)


def invented(grid: Grid, waves: Any) -> Map[Grid]:
    """Frequencies of 100 / z [Hz], each with its own wave of azimuth that grows outwards."""
    shape = np.broadcast_shapes((3, 1, 1), (24, 1), (3, 1, 5))
    azimuth, size = grid.azimuth[:, None], (grid.tilt / grid.radii[:, None])[:, None, :] ** 2
    f = [np.broadcast_to(100 / grid.z[:, None, None] * (1 + size * w(azimuth)), shape)
         for w in waves]  # fmt: skip
    return made(grid, np.stack(f, axis=-1))


@pytest.fixture
def waves(grid: Grid) -> Map[Grid]:
    """f1 round, f2 with three waves of 1 %, f3 with one."""
    return invented(grid, (
        lambda a: 0 * a, lambda a: 0.01 * np.cos(3 * a), lambda a: 0.01 * np.cos(a + 0.2)
    ))  # fmt: skip


def test_the_grid_fills_the_circles(region: Region, grid: Grid) -> None:
    assert np.isfinite(grid.tilt).sum(axis=1).tolist() == [4, 5, 5]
    np.testing.assert_array_equal(grid.tilt[grid.rim[:, 0]], grid.radii)
    where = np.nonzero(grid.wanted)
    assert reachable(region.mechanism, grid.poses[where], region.limits).all()
    assert len(where[0]) == 3 + 24 * (3 + 4 + 4)  # a level platform once a layer
    common = grid.tilt[:, :3]
    np.testing.assert_array_equal(common, np.broadcast_to(common[0], common.shape))


def test_the_map_is_the_model(solved: Map[Grid], robot: Mechanism) -> None:
    for i, k, j in ((0, 5, 0), (1, 7, 4), (2, 23, 2)):
        wanted = Continuum("timoshenko").modes(robot, solved.grid.poses[i, k, j]).frequencies
        np.testing.assert_allclose(solved.frequencies[i, k, j], wanted, rtol=1e-8)
    assert np.isnan(solved.frequencies[0, :, 4]).all()


def test_a_map_is_a_frame_and_pictures(solved: Map[Grid]) -> None:
    """One row a mode and pose of every azimuth, level poses too; contours first."""
    result = Workspace(solved, solved, (1, 2, 3, 4, 5, 6))
    frame = result.to_frame()
    assert {"model", "z_m", "azimuth_rad", "tilt_rad", "rim", "mode", "frequency_hz"} <= set(frame)
    assert len(frame) == np.isfinite(solved.frequencies).sum()
    level = frame[(frame["tilt_rad"] == 0) & (frame["mode"] == 1) & (frame["z_m"] == 0.5)]
    assert set(level["frequency_hz"]) == {solved.frequencies[1, 0, 0, 0]} and len(level) == 24
    figure = result.plot()
    assert figure is not None and "every panel has its own scale" in figure.get_suptitle()
    assert "circle [deg]" in result._repr_html_()


def test_any_elements_and_theory(robot: Mechanism, bench: Bench) -> None:
    poses = Pose(np.array([0.4, 0.6]), 0.3, 0.2)
    found = solve(Named("rayleigh", 2), robot, poses, 4, bench).frequencies
    for row, pose in zip(found, poses, strict=True):
        wanted = Substructure(2, "rayleigh").modes(robot, pose, 4).frequencies
        np.testing.assert_allclose(row, wanted, rtol=1e-8)


def test_what_the_paper_says_of_fig_6(solved: Map[Grid], bench: Bench) -> None:
    """Not circularly symmetrical: 120-degree periodic and mirrored. Falling with height."""
    assert max(turned(solved, 3), mirrored(solved)) < 1e-9
    largest = np.nanmax(ripple(solved), axis=(0, 1))
    np.testing.assert_array_equal(largest, largest_ripple(solved))
    assert (largest[:3] > 0.03).all() and (largest[:3] < 0.12).all()
    assert turned(solved, 2) > 0.03  # no 180-degree turn
    change, checked = rises(solved)
    assert checked.sum() == 6 * (1 + 24 * 3)
    assert np.nanmax(change) < -0.3
    symmetry, height = verdicts(solved, range(1, 7))[1:]
    assert symmetry.startswith('"Circularly symmetrical": only 120-degree periodic. That turn ')
    assert height.endswith(": yes, in all 732 steps of 438 columns of poses.")


def test_ripple_and_turns_of_known_waves(waves: Map[Grid]) -> None:
    wave = ripple(waves)
    assert np.nanmax(wave[..., 0]) < 1e-12
    rim = wave[waves.grid.rim[:, 0]]
    np.testing.assert_allclose(rim[:, 1], 0.02, rtol=1e-9)
    two = made(waves.grid, waves.frequencies[..., :2])
    assert turned(two, 3) < 1e-12 and mirrored(two) < 1e-12
    assert turned(waves, 3) == pytest.approx(0.01 * np.sqrt(3), rel=0.02)
    assert mirrored(waves) == pytest.approx(0.02 * np.sin(0.2), rel=0.02)
    assert str(symmetry_table(waves, [1, 2, 3]).rows[1][1]) == "2.000"
    assert ": yes, to " in verdicts(waves, [1])[1]
    assert ": no. A turn of 120 deg changes" in verdicts(waves, [1, 3])[1]


def test_a_rise_is_named(waves: Map[Grid]) -> None:
    f = waves.frequencies.copy()
    f[2, 6, 1, 1] = 1.01 * f[1, 6, 1, 1]
    rising = made(waves.grid, f)
    said = verdicts(rising, [1, 2])[2]
    assert "not in 1 of " in said
    assert "first f2 at z = 500 mm, azimuth 90 deg, tilt " in said
    first, second = height_table(rising, [1, 2]).rows
    assert first[1] == first[2] == 73
    assert second[2] == 72 and second[3] == "+0.033"


def test_the_table_of_layers(solved: Map[Grid], region: Region) -> None:
    rows = region_table(solved, [1]).rows
    assert [row[3] for row in rows] == ["spherical joint"] * 3
    level = solved.frequencies[1, 0, 0, 0]
    assert rows[1][5].value == pytest.approx(level)  # type: ignore[union-attr]
    top = Grid.of(region, np.array([0.95]), 12, 2)
    edge = Pose(0.95, top.touch[0], top.radii[0])
    assert limits_met(region.mechanism, region.limits, edge) == "longest limb"


def test_a_simulator_goes_pose_by_pose(region: Region, robot: Mechanism) -> None:
    """One failing pose costs itself; level poses are solved once."""
    grid = Grid.of(region, np.array([0.5]), 3, 2)
    model = Planted()
    heard: list[str] = []
    listener = SimpleNamespace(expect=lambda number: None, done=heard.append)
    with Bench(listener=listener) as bench:
        # A class of a test file is no module of a worker: here it is solved in this process.
        bench.call = lambda task, isolated: Bench.call(bench, task, False)  # type: ignore[method-assign]
        data = Map.of(grid, model, 3, bench)
    assert len(heard) == 1 + 3
    wanted = Substructure(2).modes(robot, grid.poses[0, 2, 1], 3)
    np.testing.assert_array_equal(data.frequencies[0, 2, 1], wanted.frequencies)
    assert np.isnan(data.frequencies[0, 1, 1]).all()
    ((pose, why),) = data.answers.failures.items()
    assert " at z = 500 mm, azimuth 120 deg" in pose and why == "no convergence"
    for draw in (figures.contour_figure, figures.surface_figure, figures.ripple_figure):
        assert picture(draw(data, [1]), "png").startswith(b"\x89PNG")
    symmetry, height = verdicts(data, [1])[1:]
    assert symmetry.endswith("not checked, for no circle of one tilt is complete.")
    assert height.endswith("not checked, for no two layers share a pose.")
    assert symmetry_table(data, [1]).rows[0][1:] == ("",) * 4
    rows = data.answers.rows()
    assert len(rows) == 3 * 3  # of one level and three tilted poses, one failed
    assert [row["frequency_hz"] for row in rows[-3:]] == wanted.frequencies.tolist()
    assert all(row["build_s"] > 0 and row["solve_s"] > 0 for row in rows)


@pytest.mark.parametrize(("broken", "why"), [
    ("nan", "hold nan"), ("order", "do not ascend"), ("shape", "have shape"),
])  # fmt: skip
def test_frequencies_that_are_none_are_a_failure(
    region: Region, bench: Bench, broken: str, why: str
) -> None:
    grid = Grid.of(region, np.array([0.4, 0.5]), 3, 2)
    data = Map.of(grid, Planted(isolated=False, broken=broken), 3, bench)
    assert np.isnan(data.frequencies).all() and why in next(iter(data.answers.failures.values()))
    result = Workspace(data, data, (1,))
    assert len(result.to_frame()) == 0 and result.figures() == {}
    assert result.tables() and "is complete. (" in result.sentences()[1]
    assert result.rows() == [] and len(result.failures()) == 1


def test_every_pose_solved_is_a_row_of_the_history(solved: Map[Grid], robot: Mechanism) -> None:
    """Frequencies of the model itself, asked pose by pose; a level platform once a layer."""
    rows = solved.answers.rows()
    poses = {(row["z_m"], row["azimuth_rad"], row["tilt_rad"]) for row in rows}
    assert len(rows) == 6 * len(poses) == 6 * solved.grid.wanted.sum()
    assert sum(tilt == 0 for _, _, tilt in poses) == 3
    for first in (0, 6 * 40, len(rows) - 6):
        some = rows[first : first + 6]
        pose = Pose(some[0]["z_m"], some[0]["azimuth_rad"], some[0]["tilt_rad"])
        wanted = Continuum("timoshenko").modes(robot, pose)
        found = [row["frequency_hz"] for row in some]
        np.testing.assert_allclose(found, wanted.frequencies, rtol=1e-8)
        assert [row["mode"] for row in some] == [1, 2, 3, 4, 5, 6]
        for row in some:
            assert row["case"] == MAP and row["mechanism"] == mechanism_hash(robot)
            assert row["model"] == "timoshenko@exact" and row["theory"] == wanted.theory
            assert json.loads(row["settings"]) == {"count": 6}
            assert 0 < row["solve_s"] == solved.answers.modes[0].solve_seconds
            assert row["uncertainty_hz"] is None


def test_pictures_show_degrees_and_hertz(solved: Map[Grid]) -> None:
    contours = figures.contour_figure(solved, [1, 2])
    panels = [axes for axes in contours.axes if axes.get_aspect() == 1]
    assert len(panels) == 6
    for k, axes in enumerate(panels[:3]):
        rim = np.hypot(*axes.lines[0].get_data())
        np.testing.assert_allclose(rim, np.degrees(solved.grid.radii[k]))
    side, above = figures.region_figure(solved.grid).axes[:2]
    for k in range(3):
        edge, circle = (np.asarray(line.get_ydata()) for line in above.lines[2 * k : 2 * k + 2])
        assert circle[0] == pytest.approx(np.degrees(solved.grid.radii[k]))
        assert edge.min() == pytest.approx(np.degrees(solved.grid.radii[k]), abs=1e-3)
    assert side.get_ylabel() == "height $z$ [mm]"


def asked(**texts: str) -> Request:
    return request(workspace, dict(texts))


@pytest.mark.usefixtures("few_layers")
def test_the_study(bench: Bench, robot: Mechanism) -> None:
    result = workspace.run(asked(
        model="euler-bernoulli@3", modes="1,4", layers="600,320", grid="12x3",
        spherical_max_deg="40",
    ), bench)  # fmt: skip
    assert "spherical joints 40 deg" in result.table().notes[0]
    region, symmetry, height = result.sentences()
    assert "20000 of 20000 random poses" in region
    assert "only 120-degree periodic" in symmetry and ": yes" in height
    assert all(line.endswith("(euler-bernoulli@3)") for line in (symmetry, height))
    assert list(result.tables()) == ["-layers", "-symmetry", "-height"]
    frame = result.to_frame()
    assert sorted(frame["z_m"].unique()) == [0.32, 0.6]
    assert set(frame["mode"]) == {1, 4} and not result.failures()
    place = ["z_m", "azimuth_rad", "tilt_rad"]
    (where, first), *_ = [*frame.groupby(place)][20:]
    wanted = Substructure(3).modes(robot, Pose(*where), 4).frequencies[[0, 3]]
    np.testing.assert_allclose(first["frequency_hz"], wanted, rtol=1e-8)
    assert result.fine.grid.z.size == 9 and result.map.grid.z.size == 2


def test_of_a_users_mechanism(tmp_path: Path, bench: Bench) -> None:
    """A mechanism twice as large has half the frequencies, at twice the height."""
    sizes = {"small": 1, "large": 2}
    text = "".join(
        f"[mechanisms.{name}]\nbase_radius_mm = {300 * k}\nplatform_radius_mm = {200 * k}\n"
        f"platform_thickness_mm = {20 * k}\nrod_diameter_mm = {100 * k}\nyoung_GPa = 200\n"
        f"shear_GPa = 77\ndensity_kg_m3 = 7820\n[cases.{name}]\nmechanism = '{name}'\n"
        f"z_mm = {490 * k}\nazimuth_deg = 0\ntilt_deg = 0\n"
        for name, k in sizes.items()
    )
    path = tmp_path / "cases.toml"
    path.write_text(text)
    maps = {
        name: workspace.run(asked(
            case_file=str(path), cases=name, grid="12x3", layers=f"{400 * k},{600 * k}",
            length_max_mm=f"{1000 * k}", length_min_mm=f"{200 * k}",
        ), bench).map
        for name, k in sizes.items()
    }  # fmt: skip
    np.testing.assert_allclose(2 * maps["large"].frequencies, maps["small"].frequencies, rtol=1e-7)
    with pytest.raises(InputError, match="one case, whose mechanism is mapped"):
        workspace.run(asked(case_file=str(path)), bench)


@pytest.mark.usefixtures("few_layers")
@pytest.mark.parametrize(("texts", "name"), [
    ({"layers": "10"}, "layers"), ({"layers": "a"}, "layers"), ({"grid": "13x4"}, "grid"),
    ({"grid": "12x1"}, "grid"), ({"grid": "12"}, "grid"), ({"grid": "999999x12"}, "grid"),
    ({"length_max_mm": "200"}, "length_max_mm"), ({"length_min_mm": "-1"}, "length_min_mm"),
    ({"spherical_max_deg": "0"}, "spherical_max_deg"), ({"revolute_max_deg": "nan"},
     "revolute_max_deg"), ({"cases": "case1,case1-small-base"}, "cases"),
])  # fmt: skip
def test_what_cannot_be_asked(texts: dict[str, str], name: str, bench: Bench) -> None:
    with pytest.raises(InputError, match=f"^{name}"):
        workspace.run(asked(**texts), bench)


def test_the_main_job_maps_the_richest_theory() -> None:
    cases = tuple(PRESETS[name] for name in ("case1", "case2"))
    ((stem, one),) = workspace.jobs(Plan(cases, Named("euler-bernoulli", 3), ())).items()
    assert (stem, one.cases, one.theory) == ("workspace", cases[:1], CONTINUUM)


def test_limbs_of_any_chain_are_mapped_within_their_own_limits(bench: Bench) -> None:
    """Pose by pose, the same frequencies; the strokes end the map, and no option beside them."""
    texts = {"case_file": str(MECHANISMS), "cases": "rps-real", "model": "euler-bernoulli@1"}
    found = workspace.run(asked(**texts, grid="12x2", layers="450", modes="1"), bench)
    grid = found.map.grid
    region = grid.region
    robot = region.mechanism
    last = int(grid.rim[0, 3].argmax())
    pose = grid.poses[0, 3, last]
    f = Substructure(1).frequencies(robot, pose, 1)
    assert found.map.frequencies[0, 3, last] == pytest.approx(f, rel=1e-12)
    # A cylinder of 250 mm and a leg of 100 to 400 mm between radii of 300 and 200 mm.
    ends = [np.sqrt(length**2 - 0.1**2) for length in (0.35, 0.65)]
    assert region.circles.z[[0, -1]] == pytest.approx(ends, abs=1e-9)
    (notes,) = [t.notes[0] for t in found.tables().values() if t.title.startswith("Regular")]
    assert notes == "limits: strokes and joint angles as the mechanism states them"
    assert "stroke" in limits_met(robot, region.limits, Pose(float(region.circles.z[-1]), 0.0, 0.0))
    for name in ("length_max_mm", "spherical_max_deg"):
        with pytest.raises(InputError, match=f"^{name}.*none beside the limits that the mechanism"):
            workspace.run(asked(**texts, **{name: "50"}), bench)


@pytest.mark.parametrize(
    ("name", "said"),
    [("three-upu", "limbs whose platform tilts any way"), ("tricept", "joints at the platform")],
)
def test_a_platform_that_does_not_tilt_freely_has_no_such_map(
    name: str, said: str, bench: Bench
) -> None:
    with pytest.raises(InputError, match=said):
        workspace.run(asked(case_file=str(MECHANISMS), cases=name), bench)
