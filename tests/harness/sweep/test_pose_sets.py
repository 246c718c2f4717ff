"""Pose sets: what people write, and the poses it means."""

import os
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from analytic import InputError, Mechanism, Pose
from analytic.workspace import Limits, reachable
from harness.history.duck import connect
from harness.sweep.pose_sets import pose_set, written


def test_random_poses_are_the_same_again_within_their_ranges(robot: Mechanism) -> None:
    poses = pose_set("random:2000:7", robot)
    shorter = pose_set("random:500:7", robot)
    np.testing.assert_array_equal(poses[:500].tilt, shorter.tilt)
    assert not np.isin(pose_set("random:2000:8", robot).z, poses.z).any()
    for values, high in ((1000 * poses.z, 700), (poses.azimuth, 2 * np.pi), (poses.tilt, 0.349066)):
        low = 350 if high == 700 else 0
        span = high - low
        assert low <= values.min() < low + 0.01 * span
        assert high - 0.01 * span < values.max() <= high
    narrow = pose_set("random:50:7:z=400..410,tilt=5", robot)
    assert narrow.z.min() >= 0.4 and narrow.z.max() <= 0.41
    np.testing.assert_allclose(narrow.tilt, np.radians(5))


def test_a_grid_has_every_combination_and_a_full_turn_no_pose_twice(robot: Mechanism) -> None:
    poses = pose_set("grid:z=350..700x8,azimuth=0..360x12,tilt=0..20x5", robot)
    assert len(poses) == 8 * 12 * 5
    np.testing.assert_allclose(np.unique(poses.z), np.linspace(0.35, 0.7, 8))
    np.testing.assert_allclose(np.unique(poses.azimuth), np.radians(30 * np.arange(12)))
    np.testing.assert_allclose(np.unique(poses.tilt), np.radians([0, 5, 10, 15, 20]))
    half = pose_set("grid:z=490,azimuth=0..180x3", robot)
    np.testing.assert_allclose(half.azimuth, np.radians([0, 90, 180]))


@pytest.mark.slow
def test_workspace_poses_can_be_reached(robot: Mechanism) -> None:
    poses = pose_set("workspace:300:1", robot)
    assert len(poses) == 300
    assert reachable(robot, poses, Limits()).all()
    assert np.ptp(poses.z) > 0.3 and poses.tilt.max() > 0.3


def test_one_pose_reads_back_to_the_last_bit(robot: Mechanism) -> None:
    random = np.random.default_rng(0)
    for z, azimuth, tilt in random.uniform([0.3, -3, -0.3], [0.7, 3, 0.3], (200, 3)):
        pose = Pose(z, azimuth, tilt)
        assert pose_set(written(pose), robot)[0] == pose
    by_hand = pose_set("pose:490,10,-12", robot)[0]
    assert by_hand == Pose(0.49, np.radians(10), np.radians(-12))


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_files_in_either_units(suffix: str, robot: Mechanism, tmp_path: Path) -> None:
    edge = pd.DataFrame({"tilt_deg": [0, -12], "z_mm": [490, 500], "azimuth_deg": [0.0, 10.0]})
    inside = pd.DataFrame(
        {"z_m": [0.49, 0.5], "azimuth_rad": np.radians([0, 10]), "tilt_rad": np.radians([0, -12])}
    )
    found = []
    for name, frame in (("edge", edge), ("inside", inside)):
        path = tmp_path / f"{name}.{suffix}"
        if suffix == "csv":
            frame.to_csv(path, index=False)
        else:
            with connect() as base:
                base.register("frame", frame)
                base.execute(f"COPY (FROM frame) TO '{path}' (FORMAT parquet)")
        found.append(pose_set(str(path), robot))
    for name in ("z", "azimuth", "tilt"):
        np.testing.assert_allclose(getattr(found[0], name), getattr(found[1], name), rtol=1e-15)
    assert len(found[0]) == 2


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("z_mm,azimuth_deg\n490,0\n", "tilt_deg"),
        ("z_mm,azimuth_deg,tilt_deg,load\n490,0,0,1\n", "load"),
        ("z_mm,azimuth_rad,tilt_deg\n490,0,0\n", "z_m, azimuth_rad, tilt_rad"),
        ("z_mm,azimuth_deg,tilt_deg\n490,0,0\n490,NaN,0\n", "azimuth_deg, row 2 = 'NaN'"),
        ("z_mm,azimuth_deg,tilt_deg\n490,0,0\n490,0,\n", "tilt_deg, row 2 = None"),
        ("z_mm,azimuth_deg,tilt_deg\n490,0,0\nhigh,0,0\n", "z_mm, row 2 = 'high'"),
        ("z_mm,azimuth_deg,tilt_deg\n", "at least one pose"),
        ("", "readable file of poses"),
        ("z_m,azimuth_rad,tilt_rad\n0.49,0,0\n490,0,0\n0.0,0,1.5707963267948966\n", "pose"),
    ],
)
def test_files_that_are_refused(text: str, said: str, robot: Mechanism, tmp_path: Path) -> None:
    path = tmp_path / "poses.csv"
    path.write_text(text)
    if said == "pose":  # its first limb has no length
        robot = Mechanism.regular(0.2, 0.2, robot.limbs[0].rod, robot.platform)
        path.write_text("z_mm,azimuth_deg,tilt_deg\n490,0,0\n0,0,0\n")
    with pytest.raises(InputError) as refused:
        pose_set(str(path), robot)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


HEAD = "z_mm,azimuth_deg,tilt_deg\n"


@pytest.mark.parametrize(
    ("name", "text", "count"),
    [
        ("whole-numbers-first.csv", HEAD + 100 * "490,0,0\n" + "490.5,0,0\n", 101),
        ("blank-line.csv", HEAD + "490,0,0\n\n", 1),
        ("POSES.CSV", HEAD + "490,0,0\n", 1),
        ("runs[1]/it's.csv", HEAD + "490,0,0\n", 1),
        ("windows.csv", "\ufeff" + (HEAD + "490,0,0\n").replace("\n", "\r\n"), 1),
    ],
)
def test_files_as_people_have_them(
    name: str, text: str, count: int, robot: Mechanism, tmp_path: Path
) -> None:
    path = tmp_path / name
    path.parent.mkdir(exist_ok=True)
    path.write_text(text, newline="")
    poses = pose_set(str(path), robot)
    assert len(poses) == count
    assert poses.z[-1] == (0.4905 if count == 101 else 0.49)


@pytest.mark.parametrize("kind", ["list", "pipe", "endless", "folder"])
def test_what_is_no_file_of_poses_is_one_sentence(
    kind: str, robot: Mechanism, tmp_path: Path
) -> None:
    path = tmp_path / "poses.parquet"
    if kind == "list":
        with connect() as base:
            sql = "SELECT [490] AS z_mm, 0 AS azimuth_deg, 0 AS tilt_deg"
            base.execute(f"COPY ({sql}) TO '{path}' (FORMAT parquet)")
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind == "endless":
        path.symlink_to("/dev/zero")
    else:
        path.mkdir()
    with pytest.raises(InputError) as refused:
        pose_set(str(path), robot)
    assert len(str(refused.value).splitlines()) == 1
