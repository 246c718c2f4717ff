"""Static stiffness: springs in a row, turned axes, and the part that gives way most."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analytic import Joint, Limb, Material, Mechanism, Platform, Pose, Rod, Section, stiffness
from harness import study
from harness.case_file import load_cases
from harness.studies.stiffness import Stiffnesses

MECHANISMS = Path(__file__).parents[3] / "results/published/mechanisms.toml"
STEEL = Material(200e9, 77e9, 7820)
PLATE = Platform.diagonal(5.0, (0.1, 0.1, 0.15))
NAMED = ("rps-real", "prs", "four-rps", "hexapod-home", "flexure-hexapod", "three-upu", "tricept")


@pytest.fixture(scope="module")
def named() -> Any:
    return load_cases(MECHANISMS)


def test_a_drive_and_two_rods_in_a_row_give_way_one_after_the_other() -> None:
    """1 / k = 1 / k_P + L1 / E A1 + L2 / E A2, and each has its share of it."""
    thick, thin = Section.round(0.07, 0.05), Section.round(0.04)
    drive = Joint.prismatic(stiffness=6e7)
    limb = Limb((0, 0, 0), (0, 0, 0), (Rod(STEEL, thick, 0.42), drive, Rod(STEEL, thin)))
    found = stiffness(Mechanism((limb,), PLATE), Pose.at((0, 0, 0.9)))
    each = np.array([0.42 / (200e9 * thick.area), 1 / 6e7, 0.48 / (200e9 * thin.area)])
    assert found.compliance[2, 2] == pytest.approx(each.sum(), rel=1e-10)
    assert found.shares[:, 2] == pytest.approx(each / each.sum(), rel=1e-9)
    assert [what for *_, what in found.parts] == ["rod", "P", "rod"]
    # Without torsion of the drive: GJ / L of both rods about z, the platform turning alone.
    twist = np.array(
        [0.42 / (77e9 * s.torsion_constant) * r for s, r in ((thick, 1), (thin, 8 / 7))]
    )
    assert found.compliance[5, 5] == pytest.approx(twist.sum(), rel=1e-10)


@pytest.mark.parametrize("name", NAMED)
def test_a_named_mechanism_is_held_and_every_part_has_its_share(named: Any, name: str) -> None:
    case = named[name]
    found = stiffness(case.mechanism, case.pose)
    assert np.array_equal(found.matrix, found.matrix.T)
    assert np.linalg.eigvalsh(found.matrix).min() > 0
    scale = np.sqrt(np.outer(np.diag(found.compliance), np.diag(found.compliance)))
    assert np.abs((found.compliances.sum(axis=0) - found.compliance) / scale).max() < 1e-8
    least, direction, shares = found.softest()
    assert shares.sum() == pytest.approx(1.0, rel=1e-8)
    force = np.zeros(6)
    force[:3] = direction
    assert 1 / least == pytest.approx(force @ found.compliance @ force, rel=1e-9)
    assert least <= 1 / np.diag(found.compliance)[:3].max() * (1 + 1e-12)


def test_turned_axes_turn_the_stiffness_with_them(named: Any) -> None:
    robot, pose = named["tricept"].mechanism, named["tricept"].pose
    c, s = np.cos(0.7), np.sin(0.7)
    R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    turned = Mechanism(
        tuple(limb.turned(0.7) for limb in robot.limbs),
        replace(robot.platform, centre=(0, 0, -0.04)),
    )
    there = Pose.at(R @ [pose.x, pose.y, pose.z], R @ pose.rotation @ R.T)
    T = np.kron(np.eye(2), R)
    first, second = stiffness(robot, pose).matrix, stiffness(turned, there).matrix
    size = np.sqrt(np.outer(np.diag(first), np.diag(first)))
    assert np.abs((T.T @ second @ T - first) / size).max() < 1e-8


def result(**texts: str) -> Stiffnesses:
    found = study("stiffness", case_file=str(MECHANISMS), **texts)
    assert isinstance(found, Stiffnesses)
    return found


def test_the_study_names_what_to_stiffen_first() -> None:
    """Drives of 60 N/um are most of a hexapod's compliance, and rods of 40 mm of a 3-PRS's."""
    found = result(cases="hexapod,prs")
    hexapod, prs = found.sentences()
    assert "85 % of that is P joint (item 3): stiffen it first" in hexapod
    assert "79 % of that is rod of 50/36 mm (item 4)" in prs
    frame = found.to_frame()
    sums = frame.groupby(["case", "load"]).share.sum()
    np.testing.assert_allclose(sums, 1.0, rtol=1e-8)
    assert list(found.figures()) == [""] and "-map" not in found.tables()


def test_a_map_over_poses_holds_each_pose_s_own_stiffness(named: Any) -> None:
    found = result(cases="three-upu", poses="grid:x=-60..60x3,y=0,z=600..700x2")
    (one,) = found.maps
    robot = named["three-upu"].mechanism
    own = [stiffness(robot, pose).softest()[0] for pose in one.poses]
    np.testing.assert_allclose(one.force, own, rtol=1e-12)
    assert f"{1e-6 * min(own):.4g} to {1e-6 * max(own):.4g} N/um" in found.sentences()[1]
    assert list(found.figures()) == ["", "-map"]


def test_what_cannot_move_so_is_one_sentence(rps_bench: Callable[..., Any]) -> None:
    file = ("--case-file", str(MECHANISMS), "--cases", "three-upu")
    answer = rps_bench("stiffness", *file, "--poses", "pose:x=60,y=110,z=640,tilt=3")
    assert answer.status == 2 and "universal joints in line" in answer.err
    assert len(answer.err.splitlines()) == 1


def test_rounding_is_not_shown_as_stiffness() -> None:
    """A level platform's forces along x and z are coupled by nothing."""
    found = study("stiffness", cases="case1")
    level = {row[1]: row[2:] for row in found.tables()["-matrix"].rows}
    assert level["Fx"][1:4] == ("0", "0", "0") and float(str(level["Fx"][0])) > 1e8
    assert float(str(level["Fx"][4])) == float(str(level["My"][0])) > 1e8
    assert "case1 is softest along any direction across (0.00, 0.00, 1.00)" in found.sentences()[0]
    assert "case2 is softest along (0.08, 1.00, 0.00)" in study("stiffness").sentences()[1]
