"""`rps-bench workspace`: maps, the paper's two statements, pictures and data."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from analytic import Continuum, Limits, Mechanism, Pose, RegularWorkspace, Substructure, reachable
from analytic.workspace import inscribed
from harness.figures import picture
from harness.history.store import COLUMNS, open_history
from harness.models import Spec
from harness.run import MANY_POSES, mechanism_hash
from harness.workspace.checks import (
    height_table,
    mirrored,
    opposite,
    region_table,
    ripple,
    rises,
    symmetry_table,
    turned,
    verdicts,
)
from harness.workspace.figures import contour_figure, region_figure, ripple_figure, surface_figure
from harness.workspace.map import Answers, Grid, Region, WorkspaceMap, solve, workspace_map
from harness.workspace.rows import history_rows
from reference_models import ModelError
from reference_models.exudyn_cable import ExudynCable

CONTINUUM = Spec("timoshenko", None)
Bench = Callable[..., Any]


@pytest.fixture(scope="module")
def region(robot: Mechanism) -> Region:
    z = np.array([0.3, 0.5, 0.7, 0.9])
    circles = RegularWorkspace(z, inscribed(robot, z, Limits(), azimuths=24)[0])
    return Region(robot, Limits(), circles, circles.cone())


@pytest.fixture(scope="module")
def grid(region: Region) -> Grid:
    return Grid.of(region, np.array([0.32, 0.5, 0.8]), 24, 5)


@pytest.fixture(scope="module")
def solved(region: Region, grid: Grid) -> WorkspaceMap:
    return workspace_map(region, grid, CONTINUUM, 6)


@pytest.fixture
def few_layers(monkeypatch: pytest.MonkeyPatch) -> None:
    """A coarse profile, to be quick."""
    monkeypatch.setattr("harness.workspace.map.PROFILE", 9)


@pytest.fixture
def fragile(monkeypatch: pytest.MonkeyPatch) -> None:
    """A simulator that fails at azimuths of 2 to 3 rad."""
    real = ExudynCable.modes

    def fragile(self: Any, mechanism: Mechanism, pose: Pose, count: int = 6) -> Any:
        if 2 < pose.azimuth < 3:
            raise ModelError("no convergence")
        return real(self, mechanism, pose, count)

    monkeypatch.setattr(ExudynCable, "modes", fragile)


@pytest.fixture
def invented(region: Region, grid: Grid) -> WorkspaceMap:
    """f1 round, f2 with three waves of 1 %, f3 with one; all fall with z as 1 / z."""
    shape = np.broadcast_shapes((3, 1, 1), (24, 1), (3, 1, 5))
    azimuth, size = grid.azimuth[:, None], (grid.tilt / grid.radii[:, None])[:, None, :] ** 2
    waves = (0 * azimuth, 0.01 * np.cos(3 * azimuth), 0.01 * np.cos(azimuth + 0.2))
    f = [np.broadcast_to(100 / grid.z[:, None, None] * (1 + size * w), shape) for w in waves]
    every = np.stack(f, axis=-1)
    return WorkspaceMap(region, grid, CONTINUUM, every, Answers(every[grid.wanted], {}, {}, 0.0))


def test_the_grid_fills_the_circles(region: Region, grid: Grid) -> None:
    assert np.isfinite(grid.tilt).sum(axis=1).tolist() == [4, 5, 5]
    rims = grid.tilt[np.arange(3), grid.rim]
    np.testing.assert_array_equal(rims, grid.radii)
    where = np.nonzero(grid.wanted)
    assert reachable(region.mechanism, grid.pose(*where), region.limits).all()
    assert len(where[0]) == 3 + 24 * (3 + 4 + 4)  # a level platform once a layer
    common = grid.tilt[:, :3]
    np.testing.assert_array_equal(common, np.broadcast_to(common[0], common.shape))


def test_the_map_is_the_model(solved: WorkspaceMap, robot: Mechanism) -> None:
    for i, k, j in ((0, 5, 0), (1, 7, 4), (2, 23, 2)):
        wanted = Continuum("timoshenko").modes(robot, solved.grid.pose(i, k, j)).frequencies
        np.testing.assert_allclose(solved.frequencies[i, k, j], wanted, rtol=1e-8)
    assert np.isnan(solved.frequencies[0, :, 4]).all()


def test_any_elements_and_theory(robot: Mechanism) -> None:
    poses = Pose(np.array([0.4, 0.6]), 0.3, 0.2)
    found = solve(Spec("rayleigh", 2), robot, poses, 4).frequencies
    for row, pose in zip(found, poses, strict=True):
        wanted = Substructure(2, "rayleigh").modes(robot, pose, 4).frequencies
        np.testing.assert_allclose(row, wanted, rtol=1e-8)


def test_what_the_paper_says_of_fig_6(solved: WorkspaceMap) -> None:
    """Not circularly symmetrical: 120-degree periodic and mirrored. Falling with height."""
    assert max(turned(solved, 3), mirrored(solved), opposite(solved)) < 1e-9
    largest = np.nanmax(ripple(solved), axis=(0, 1))
    assert (largest[:3] > 0.03).all() and (largest[:3] < 0.12).all()
    assert turned(solved, 2) > 0.03  # no 180-degree turn
    change, checked = rises(solved)
    assert checked.sum() == 6 * (1 + 24 * 3)
    assert np.nanmax(change) < -0.3
    symmetry, height = verdicts(solved.region, solved, range(1, 7))[1:]
    assert '"Circularly symmetrical": only 120-degree periodic. That turn changes no' in symmetry
    assert height.endswith("yes, in all 732 steps of 438 columns of poses.")


def test_ripple_and_turns_of_known_waves(invented: WorkspaceMap) -> None:
    wave = ripple(invented)
    assert np.nanmax(wave[..., 0]) < 1e-12
    rim = wave[np.arange(3), invented.grid.rim]
    np.testing.assert_allclose(rim[:, 1], 0.02, rtol=1e-9)
    assert turned(replace(invented, frequencies=invented.frequencies[..., :2]), 3) < 1e-12
    assert turned(invented, 3) == pytest.approx(0.01 * np.sqrt(3), rel=0.02)
    assert mirrored(replace(invented, frequencies=invented.frequencies[..., :2])) < 1e-12
    assert mirrored(invented) == pytest.approx(0.02 * np.sin(0.2), rel=0.02)
    row = symmetry_table(invented, [1, 2, 3]).rows[1]
    assert str(row[1]) == "2.000"
    assert '"Circularly symmetrical": yes' in verdicts(invented.region, invented, [1])[1]
    assert ": no. A turn of 120 deg changes" in verdicts(invented.region, invented, [1, 3])[1]


def test_a_rise_is_named(invented: WorkspaceMap) -> None:
    f = invented.frequencies.copy()
    f[2, 6, 1, 1] = 1.01 * f[1, 6, 1, 1]
    rising = replace(invented, frequencies=f)
    said = verdicts(rising.region, rising, [1, 2])[2]
    assert "not in 1 of " in said
    assert "first f2 at z = 500.0 mm, azimuth 90.00 deg, tilt " in said
    first, second = height_table(rising, [1, 2]).rows
    assert first[1] == first[2] == 73
    assert second[2] == 72 and second[3] == "+0.033"


def test_the_table_of_layers(solved: WorkspaceMap, region: Region) -> None:
    rows = region_table(region, solved, [1]).rows
    assert [row[3] for row in rows] == ["spherical joint"] * 3
    level = solved.frequencies[1, 0, 0, 0]
    assert rows[1][5].value == pytest.approx(level)  # type: ignore[union-attr]
    top = Grid.of(region, np.array([0.95]), 12, 2)
    assert region.bound(0.95, top.touch[0], top.radii[0]) == "longest limb"


@pytest.mark.usefixtures("fragile")
def test_a_simulator_goes_pose_by_pose(region: Region, robot: Mechanism) -> None:
    """One failing pose costs itself; level poses are solved once."""
    heard: list[str] = []
    grid = Grid.of(region, np.array([0.5]), 3, 2)
    spec = Spec("exudyn-cable", 2)
    data = workspace_map(region, grid, spec, 3, heard.append)
    assert len(heard) == 1 + 3
    wanted = ExudynCable(2).modes(robot, grid.pose(0, 2, 1), 3).frequencies
    np.testing.assert_array_equal(data.frequencies[0, 2, 1], wanted)
    assert np.isnan(data.frequencies[0, 1, 1]).all()
    assert list(data.answers.failures.values()) == ["no convergence"]
    (pose, label), *_ = data.answers.failures
    assert pose.startswith("z = 500.0 mm, azimuth 120.00 deg") and label == "exudyn-cable@2"
    for figure in (contour_figure(data, [1]), surface_figure(data, [1]), ripple_figure(data, [1])):
        assert picture(figure, "png").startswith(b"\x89PNG")
    symmetry, height = verdicts(region, data, [1])[1:]
    assert symmetry.endswith("not checked, for no circle of one tilt is complete.")
    assert height.endswith("not checked, for no two layers share a pose.")
    assert symmetry_table(data, [1]).rows[0][1:] == ("",) * 4


def test_every_pose_solved_is_a_row_of_the_history(solved: WorkspaceMap, robot: Mechanism) -> None:
    """Frequencies of the model itself, asked pose by pose; a level platform once a layer."""
    rows = history_rows(solved)
    poses = {(row["z_m"], row["azimuth_rad"], row["tilt_rad"]) for row in rows}
    assert len(rows) == 6 * len(poses) == 6 * solved.grid.wanted.sum()
    assert sum(tilt == 0 for _, _, tilt in poses) == 3
    for first in (0, 6 * 40, len(rows) - 6):
        some = rows[first : first + 6]
        pose = Pose(some[0]["z_m"], some[0]["azimuth_rad"], some[0]["tilt_rad"])
        wanted = Continuum("timoshenko").modes(robot, pose)
        np.testing.assert_allclose(
            [row["frequency_hz"] for row in some], wanted.frequencies, rtol=1e-8
        )
        assert [row["mode"] for row in some] == [1, 2, 3, 4, 5, 6]
        for row in some:
            assert row["case"] in MANY_POSES and row["mechanism"] == mechanism_hash(robot)
            assert row["model"] == "timoshenko@exact" and row["theory"] == wanted.theory
            assert json.loads(row["settings"]) == {"count": 6, "shear": "cowper"}
            assert row["version"] == "rps-bench, condensed" and row["dofs"] == wanted.dofs
            assert 0 < row["solve_s"] == solved.answers.seconds
            assert set(row) <= set(COLUMNS)


@pytest.mark.usefixtures("fragile")
def test_rows_of_a_simulator_are_its_own(region: Region, robot: Mechanism) -> None:
    """With closure and uncertainty; a pose that failed has none."""
    grid = Grid.of(region, np.array([0.5]), 3, 2)
    spec = Spec("exudyn-cable", (2, 4))
    rows = history_rows(workspace_map(region, grid, spec, 3))
    assert len(rows) == 3 * 3  # of one level and three tilted poses, one failed
    wanted = spec.build().modes(robot, grid.pose(0, 2, 1), 3)
    assert wanted.uncertainty is not None
    for i, row in enumerate(rows[-3:]):
        assert row["azimuth_rad"] == grid.azimuth[2] and row["tilt_rad"] == grid.tilt[0, 1]
        assert row["frequency_hz"] == wanted.frequencies[i]
        assert row["uncertainty_hz"] == wanted.uncertainty[i]
        assert row["closure_m"] == wanted.residual and row["version"] == wanted.version
        assert row["build_s"] > 0 and row["solve_s"] > 0


@pytest.mark.slow
def test_the_solid_limb_says_its_uncertainty_at_every_pose(
    region: Region, robot: Mechanism
) -> None:
    pytest.importorskip("ngsolve")
    grid, spec = Grid.of(region, np.array([0.5]), 3, 2), Spec("solid-limb", 1)
    rows = history_rows(workspace_map(region, grid, spec, 2))
    assert len(rows) == 2 * 4
    for first in (0, 4):
        row = rows[first]
        pose = Pose(row["z_m"], row["azimuth_rad"], row["tilt_rad"])
        wanted = spec.build().modes(robot, pose, 2)
        assert wanted.uncertainty is not None
        assert row["uncertainty_hz"] == pytest.approx(wanted.uncertainty[0], rel=1e-6)
        assert row["version"] == wanted.version and row["theory"] == wanted.theory


@pytest.mark.slow
def test_pictures_show_degrees_and_hertz(solved: WorkspaceMap, region: Region) -> None:
    contours = contour_figure(solved, [1, 2])
    panels = [axes for axes in contours.axes if axes.get_aspect() == 1]
    assert len(panels) == 6
    for k, axes in enumerate(panels[:3]):
        rim = np.hypot(*axes.lines[0].get_data())
        np.testing.assert_allclose(rim, np.degrees(solved.grid.radii[k]))
    side, above = region_figure(region, solved.grid).axes[:2]
    for k in range(3):
        edge, circle = (line.get_ydata() for line in above.lines[2 * k : 2 * k + 2])
        assert circle[0] == pytest.approx(np.degrees(solved.grid.radii[k]))
        assert edge.min() == pytest.approx(np.degrees(solved.grid.radii[k]), abs=1e-3)
    assert side.get_ylabel() == "height $z$ [mm]"
    assert picture(surface_figure(solved, [3]), "svg") == picture(
        surface_figure(solved, [3]), "svg"
    )


@pytest.mark.slow
@pytest.mark.usefixtures("few_layers")
def test_the_command(rps_bench: Bench, tmp_path: Path, robot: Mechanism) -> None:
    answer = rps_bench(
        "workspace", "--model", "euler-bernoulli@3", "--modes", "1,4", "--layers", "600,320",
        "--grid", "12x3", "--spherical-max-deg", "40", "--output", str(tmp_path),
        "--history", str(tmp_path / "history"),
    )  # fmt: skip
    assert answer.status == 0, answer.err
    assert "spherical joints 40 deg" in answer.out
    assert '- "Circularly symmetrical": only 120-degree periodic.' in answer.out
    assert '- "The increased platform height decreases the natural frequency": yes' in answer.out
    names = {path.name for path in tmp_path.iterdir()}
    pictures = {f"{stem}.{form}" for stem in ("workspace", "contours", "surfaces", "ripple")
                for form in ("svg", "png")}  # fmt: skip
    assert pictures | {"map.csv", "layers.md", "symmetry.tex", "height.csv"} <= names
    frame = pl.read_csv(tmp_path / "map.csv")
    assert frame["z_m"].unique().sort().to_list() == [0.32, 0.6]
    assert frame.columns[-1] == "f4_hz"
    row = frame.row(20, named=True)
    pose = Pose(row["z_m"], row["azimuth_rad"], row["tilt_rad"])
    wanted = Substructure(3).modes(robot, pose, 4).frequencies
    np.testing.assert_allclose([row[f"f{i}_hz"] for i in range(1, 5)], wanted, rtol=1e-8)
    kept = open_history(tmp_path / "history").query(
        'SELECT command, mode, z_m, azimuth_rad, tilt_rad, frequency_hz FROM rows WHERE "case" = ?',
        ["map"],
    )
    assert kept["command"].unique().to_list() == [
        "rps-bench workspace --model euler-bernoulli@3 --modes 1,4 --layers 600,320 --grid 12x3 "
        "--spherical-max-deg 40"
    ]
    place = ["z_m", "azimuth_rad", "tilt_rad"]
    first = kept.filter(mode=4).join(frame, on=place)
    assert 2 < len(first) == len(kept) / 4
    assert first["frequency_hz"].to_list() == first["f4_hz"].to_list()


@pytest.mark.slow
@pytest.mark.usefixtures("few_layers")
def test_the_command_with_a_simulator(rps_bench: Bench, tmp_path: Path) -> None:
    answer = rps_bench(
        "workspace", "--model", "exudyn-cable@2", "--layers", "400,600", "--grid", "12x2",
        "--output", str(tmp_path),
    )  # fmt: skip
    assert answer.status == 0, answer.err
    assert "exudyn-cable@2: 26 poses one by one at " in answer.err
    assert pl.read_csv(tmp_path / "map.csv").height == 2 * 12 * 2
