"""Poses as people state them: names, files, columns; all of them through a sweep."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from analytic import InputError, Mechanism, Pose, Substructure
from harness.case_file import load_cases
from harness.history.store import open_history
from harness.poses import COLUMNS, columns, named, stated, turned, used
from harness.sweep.pose_sets import pose_set, written
from harness.sweep.sweep import solve

MECHANISMS = Path(__file__).parents[2] / "results/published/mechanisms.toml"


def robot_of(name: str) -> Mechanism:
    return load_cases(MECHANISMS)[name].mechanism


def test_yaw_pitch_and_roll_are_turns_about_z_then_y_then_x() -> None:
    angles = np.radians([20.0, -7.0, 11.0])
    pose = stated(
        {"x": 0.1, "y": 0.2, "z": 0.3, **dict(zip(("yaw", "pitch", "roll"), angles, strict=True))}
    )
    np.testing.assert_allclose(
        pose.rotation, Rotation.from_euler("ZYX", angles).as_matrix(), atol=1e-15
    )
    assert (pose.x, pose.y, pose.z) == (0.1, 0.2, 0.3)
    assert stated({"z": 0.3, "roll": 0.1}).x is None
    assert stated({"x": 0.1, "y": 0.2, "torsion": 0.3}) == Pose.planar(0.1, 0.2, 0.3)


@pytest.mark.parametrize(
    ("values", "said"),
    [({"x": 1.0, "z": 1.0}, "both x and y"), ({"tilt": 1.0}, "z, or x and y"),
     ({"z": 1.0, "yaw": 1.0, "tilt": 1.0}, "angles of one kind")],
)  # fmt: skip
def test_half_a_pose_is_refused(values: dict[str, float], said: str) -> None:
    with pytest.raises(InputError, match=said):
        stated(values)


def test_a_pose_turned_with_its_mechanism_is_the_same_problem() -> None:
    robot = robot_of("hexapod")
    pose = stated({"x": 0.05, "y": -0.03, "z": 0.75, "yaw": 0.1, "pitch": 0.05, "roll": -0.08})
    other = Mechanism(tuple(limb.turned(0.7) for limb in robot.limbs), robot.platform)
    again = turned(pose, 0.7)
    f = [Substructure(1).frequencies(*of, 4) for of in ((robot, pose), (other, again))]
    np.testing.assert_allclose(f[1], f[0], rtol=1e-10)


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("pose:x=60,y=110,z=640", ("x", "y", "z")),
        ("grid:x=-60..60x3,y=0..20x2,z=640", ("x", "y", "z")),
        ("random:4:2:x=-60..60,y=-60..60,z=600..700", ("x", "y", "z")),
    ],
)
def test_sets_of_poses_with_x_and_y(text: str, names: tuple[str, ...]) -> None:
    poses = pose_set(text, robot_of("three-upu"))
    assert all(getattr(poses, name) is not None for name in names)
    assert not np.any(poses.tilt) and not np.any(poses.torsion)
    for pose in poses:
        assert pose_set(written(pose), robot_of("three-upu"))[0] == pose


def test_what_hinges_do_not_say_is_asked_for() -> None:
    with pytest.raises(InputError, match="x and y too: no hinges at the base set them"):
        pose_set("grid:z=600..700x2", robot_of("three-upu"))
    with pytest.raises(InputError, match="universal joints in line, not those of limb 2"):
        pose_set("pose:x=60,y=110,z=640,tilt=3", robot_of("three-upu"))


def test_a_file_of_positions_and_turns(tmp_path: Path) -> None:
    path = tmp_path / "poses.csv"
    path.write_text("x_mm,y_mm,z_mm,yaw_deg,pitch_deg,roll_deg\n60,-20,780,3,-2,1\n0,0,760,0,0,0\n")
    poses = pose_set(str(path), robot_of("hexapod"))
    turns = Rotation.from_euler("ZYX", [3, -2, 1], degrees=True).as_matrix()
    np.testing.assert_allclose(poses[0].rotation, turns, atol=1e-15)
    np.testing.assert_allclose(poses.x, [0.06, 0.0])
    assert used([poses]) == tuple(COLUMNS)
    assert named(poses[1]) == "x = 0 mm, y = 0 mm, z = 760 mm, azimuth 0 deg, tilt 0 deg"


def test_a_sweep_tells_poses_apart_by_x_y_and_torsion(tmp_path: Path) -> None:
    """Its folder solves nothing twice, and nothing else; rows say where each pose is."""
    robot, models = robot_of("three-upu"), "euler-bernoulli@1"
    first = solve(robot, "grid:x=-60..60x3,y=0,z=640", models, tmp_path, 2, cores=1)
    again = solve(robot, "grid:x=-60..60x3,y=0,z=640", models, tmp_path, 2, cores=1)
    moved = solve(robot, "grid:x=-60..60x3,y=5,z=640", models, tmp_path, 2, cores=1)
    assert (first.solved, again.solved, moved.solved) == (1, 0, 1)
    frame = moved.to_frame()
    assert list(frame.x_m) == [-0.06, -0.06, 0.0, 0.0, 0.06, 0.06]
    assert (frame.y_m == 0.005).all() and "torsion_rad" not in frame
    f = [Substructure(1).frequencies(robot, pose, 2) for pose in Pose.planar(
        np.array([-0.06, 0.0, 0.06]), 0.005, 0.0, 0.64)]  # fmt: skip
    np.testing.assert_allclose(frame.frequency_hz, np.ravel(f), rtol=1e-12)


def test_the_history_holds_all_of_a_pose(rps_bench: Callable[..., Any], tmp_path: Path) -> None:
    rps_bench(
        "table", "--case-file", str(MECHANISMS), "--cases", "three-upu", "--modes", "1",
        "--references", "timoshenko@1", "--history", str(tmp_path),
    )  # fmt: skip
    rows = open_history(tmp_path).query("SELECT DISTINCT x_m, y_m, z_m, torsion_rad FROM rows")
    assert rows.rows() == [{"x_m": 0.06, "y_m": 0.11, "z_m": 0.64, "torsion_rad": 0.0}]
    assert columns(Pose(0.5))["x_m"] is None
