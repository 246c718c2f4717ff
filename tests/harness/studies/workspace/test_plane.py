"""Maps over a plane: how far the limits let the platform go, and what symmetry makes equal."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analytic import (
    InputError,
    Joint,
    Limb,
    Limits,
    Material,
    Mechanism,
    Platform,
    Pose,
    Rod,
    Substructure,
)
from analytic.workspace import in_plane, rim
from harness.bench import Bench
from harness.case import Case
from harness.case_file import load_cases
from harness.figures import picture
from harness.request import Plan
from harness.rows import PLANE
from harness.studies import stiffness, workspace
from harness.studies.workspace import PlaneMap
from harness.studies.workspace.map import Map, Plane
from harness.text import request
from reference_models import Named

FILE = Path(__file__).parents[4] / "results/published/mechanisms.toml"
CASES = load_cases(FILE)
HOME = CASES["hexapod-home"]
ONE = Named("euler-bernoulli", 1)


@pytest.fixture(scope="module")
def bench() -> Iterator[Bench]:
    with Bench() as own:
        yield own


@pytest.fixture(scope="module")
def hexapod(bench: Bench) -> PlaneMap:
    plane = Plane.of(HOME, ("x", "y"), Limits(), 12, 3)
    return PlaneMap(Map.of(plane, ONE, 3, bench), (1, 2, 3))


def asked(study: Any, **texts: str) -> Any:
    return request(study, {"case_file": str(FILE), "cases": "hexapod-home"} | texts)


def turned(values: Any, by: int) -> Any:
    """What every direction has, `by` directions further."""
    return np.roll(values, by, axis=0)


def mirrored(values: Any) -> Any:
    """What every direction has, mirrored about the first coordinate's axis."""
    return values[-np.arange(len(values))]


def planar(angle: float) -> Case:
    """A 3-RPR robot in its plane, turned by an angle: equal limbs 120 degrees apart."""
    rod, about = Rod.round(Material(200e9, 77e9, 7820), 0.03), Joint.revolute((0, 0, 1))
    chain = (about, replace(rod, length=0.1), Joint.prismatic(None, 2e7), rod, about)
    limb = Limb((0.5, 0, 0), (0.15, 0, 0), chain, stroke=(0.1, 0.4), reference=(0, 0, 1))
    limbs = tuple(limb.turned(2 * np.pi * k / 3) for k in range(3))
    robot = Mechanism(limbs, Platform.disc(0.15, 0.02, 7820))
    return Case(f"planar at {angle}", robot, Pose.planar(0.0, 0.0, angle), "")


@pytest.mark.parametrize("names", [("x", "y"), ("x", "z"), ("y", "z")])
def test_the_platform_goes_until_a_stroke_ends(names: tuple[str, str]) -> None:
    """|B A + r u| is the longest limb or the shortest: the first root of six limbs' quadratics."""
    case = CASES["hexapod"]
    direction = 2 * np.pi * np.arange(16) / 16
    found = rim(case.mechanism, case.pose, names, direction, Limits())
    u = np.zeros((16, 3))
    for name, along in zip(names, (np.cos(direction), np.sin(direction)), strict=True):
        u[:, "xyz".index(name)] = along
    o = np.array([case.pose.x, case.pose.y, case.pose.z])
    arms = case.mechanism.platform_points @ case.pose.rotation.T
    span = o + arms - case.mechanism.bases
    low, high = (0.42 + stroke for stroke in (0.15, 0.6))
    ends = []
    for length in (low, high):
        b, c = u @ span.T, (span**2).sum(axis=1) - length**2
        root = np.sqrt(np.maximum(b**2 - c, 0))
        both = np.stack([-b - root, -b + root])
        ends.append(np.where((b**2 > c) & (both > 0), both, np.inf).min(axis=(0, 2)))
    np.testing.assert_allclose(found, np.minimum(*ends), rtol=0, atol=1e-9)
    assert np.unique(np.round(found, 6)).size > 8


def test_a_hexapod_at_home_has_the_symmetry_of_its_limbs(hexapod: PlaneMap) -> None:
    """Turned by 120 degrees and mirrored the map is the same; turned by 60 degrees it is not."""
    for values in (hexapod.map.grid.far, hexapod.map.frequencies):
        np.testing.assert_allclose(turned(values, 4), values, rtol=1e-9)
        np.testing.assert_allclose(mirrored(values), values, rtol=1e-9)
        assert np.abs(turned(values, 2) - values).max() > 0.01 * values.max()


def test_a_planar_robot_has_the_symmetry_of_its_limbs(bench: Bench) -> None:
    """Turned by 120 degrees; its mirror image is the robot turned the other way."""
    own, other = (
        Map.of(Plane.of(planar(angle), ("x", "y"), Limits(), 12, 3), ONE, 3, bench)
        for angle in (0.3, -0.3)
    )
    assert np.isfinite(own.frequencies).all()
    for one, image in ((own.grid.far, other.grid.far), (own.frequencies, other.frequencies)):
        np.testing.assert_allclose(turned(one, 4), one, rtol=1e-9)
        np.testing.assert_allclose(mirrored(image), one, rtol=1e-9)
    assert np.abs(mirrored(own.frequencies) / own.frequencies - 1).max() > 1e-3


def test_what_a_map_gives(hexapod: PlaneMap) -> None:
    """A row a pose, its own pose once, each with the model's answer there."""
    frame = hexapod.to_frame()
    assert len(frame) == 3 * (12 * 2 + 1)
    one = frame[(frame["mode"] == 2) & frame["rim"]].iloc[5]
    pose = replace(HOME.pose, x=one["x_m"], y=one["y_m"])
    f = Substructure(1).frequencies(HOME.mechanism, pose, 2)
    assert one["frequency_hz"] == pytest.approx(f[1], rel=1e-9)
    ray = np.arctan2(one["y_m"], one["x_m"]) % (2 * np.pi)
    assert ray == pytest.approx(hexapod.map.grid.direction[5])
    table = hexapod.table()
    assert [row[:2] for row in table.rows[:2]] == [("f1", "lowest"), ("f1", "highest")]
    assert float(table.rows[0][2].value) == hexapod.map.frequencies[..., 0].min()
    assert "as the mechanism states them" in table.notes[0] and "longest stroke" in table.notes[1]
    ends = 1000 * hexapod.map.grid.far[:, -1]
    assert f"{ends.min():.1f} to {ends.max():.1f} mm" in hexapod.sentences()[0]
    assert {row["case"] for row in hexapod.rows()} == {PLANE} and len(hexapod.rows()) == len(frame)
    (figure,) = hexapod.figures().values()
    assert picture(figure, "svg").startswith(b"<?xml")
    assert [axes.get_xlabel() for axes in figure.axes[:3]] == ["$x$ [mm]"] * 3


def test_the_command_and_the_main_job(bench: Bench) -> None:
    found = workspace.run(asked(workspace, plane="x,z", grid="12x2", model="rayleigh@1"), bench)
    assert isinstance(found, PlaneMap) and found.map.grid.names == ("x", "z")
    assert found.map.frequencies.shape == (12, 2, 3)
    theory = Named("euler-bernoulli", 3)
    assert workspace.jobs(Plan((HOME,), theory, ()))["workspace-plane"].options == {
        "plane": ("x", "y")
    }
    assert list(workspace.jobs(Plan((CASES["rps"],), theory, ()))) == ["workspace"]


def test_stiffness_over_a_plane(monkeypatch: pytest.MonkeyPatch, bench: Bench) -> None:
    """It has the symmetry of the limbs too, and every pose is a row."""
    monkeypatch.setattr(stiffness, "MANY", (12, 3))
    found = stiffness.run(asked(stiffness, plane="x,y"), bench)
    (one,) = found.maps
    assert one.plane is not None
    for values in map(one.plane.spread, (one.force, one.moment)):
        np.testing.assert_allclose(turned(values, 4), values, rtol=1e-9)
        np.testing.assert_allclose(mirrored(values), values, rtol=1e-9)
        assert np.ptp(values) > 0.01 * values.max()
    frame = found.to_frame()
    assert frame["softest_n_m"].dropna().tolist() == one.force.tolist()
    assert {"", "-map"} == set(found.figures())
    with pytest.raises(InputError, match=r"^poses.*beside a plane"):
        stiffness.run(asked(stiffness, plane="x,y", poses="pose:x=0,y=0,z=780"), bench)


@pytest.mark.parametrize(("texts", "said"), [
    ({"plane": "x"}, "^plane = 'x'.*one of x,y x,z y,z"), ({"plane": "y,x"}, "^plane"),
    ({"plane": "x,y", "cases": "rps"}, "^plane.*hinges"),
    ({"plane": "x,y", "layers": "780"}, "^layers"),
    ({"plane": "x,y", "cases": "three-upu", "length_max_mm": "300"}, "^plane.*three-upu is not"),
])  # fmt: skip
def test_what_cannot_be_asked(texts: dict[str, str], said: str, bench: Bench) -> None:
    with pytest.raises(InputError, match=said):
        workspace.run(asked(workspace, **texts), bench)


def test_hinges_keep_a_platform_from_a_plane() -> None:
    level = replace(CASES["rps"], pose=Pose.at([0, 0, 0.49]))
    with pytest.raises(InputError, match=r"^plane.*platform of rps can move"):
        Plane.of(level, ("x", "y"), Limits(), 4, 2)


def test_the_other_coordinates_stay() -> None:
    moved = in_plane(planar(0.3).pose, ("x", "y"), np.array([0.0, 0.1]), np.pi / 2)
    assert moved.x == pytest.approx([0, 0]) and moved.y == pytest.approx([0, 0.1])
    assert moved.torsion == pytest.approx([0.3, 0.3])
