"""Eq. (25): limits, the polar boundary, inscribed circles and the truncated cone."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from analytic import (
    InputError,
    Joint,
    Limb,
    Limits,
    Link,
    Mechanism,
    Pose,
    RegularWorkspace,
    Rod,
    Section,
    limbs_at,
    reachable,
    regular_workspace,
)
from analytic.workspace import SMALLEST, boundary, heights, inscribed, margins

PAPER = Mechanism.paper()
LIMITS = Limits()
THIRD = 2 * np.pi / 3

zs = st.floats(0.2, 0.98)
azimuths = st.floats(-np.pi, np.pi)
tilts = st.floats(0.0, 1.2)


@given(zs, azimuths, tilts)
def test_reachable_is_eq_25(z: float, azimuth: float, tilt: float) -> None:
    """Lengths and angles straight from Eq. (3), by arccos instead of the model's arctan2."""
    pose = Pose(z, azimuth, tilt)
    limbs = limbs_at(PAPER, pose)
    along = limbs.frames[:, :, 2]
    alpha = np.arccos(along @ pose.rotation[:, 2])
    beta = np.arccos(along[:, 2])
    wanted = (
        (limbs.lengths >= 0.2).all()
        and (limbs.lengths <= 1.0).all()
        and (alpha <= np.pi / 4).all()
        and (beta <= np.pi / 4).all()
    )
    assert reachable(PAPER, pose, LIMITS) == wanted


def test_each_limit_is_felt() -> None:
    pose = Pose(0.49, 0.3, 0.2)
    limbs = limbs_at(PAPER, pose)
    assert reachable(PAPER, pose, LIMITS)
    for tight in (
        {"length_min": limbs.lengths.min() + 1e-9},
        {"length_max": limbs.lengths.max() - 1e-9},
        {"spherical_max": limbs.spherical.max() - 1e-9},
        {"revolute_max": np.abs(limbs.revolute).max() - 1e-9},
    ):
        assert not reachable(PAPER, pose, replace(LIMITS, **tight))


def test_many_poses_are_each_of_them() -> None:
    poses = Pose(np.array([[0.3], [0.6]]), 0.4, np.linspace(0, 1, 5))
    found = reachable(PAPER, poses, LIMITS)
    assert found.shape == (2, 5)
    assert found.any() and not found.all()
    for index in np.ndindex(2, 5):
        assert found[index] == reachable(PAPER, poses[index], LIMITS)


@given(azimuths, zs)
@settings(max_examples=10)
def test_a_limit_is_active_on_the_boundary(azimuth: float, z: float) -> None:
    tilt = float(boundary(PAPER, z, azimuth, LIMITS))
    at = margins(PAPER, Pose(z, azimuth, tilt), LIMITS)
    assert 0 <= at.min() < 2 * SMALLEST
    assert not reachable(PAPER, Pose(z, azimuth, tilt + 2 * SMALLEST), LIMITS)
    assert reachable(PAPER, Pose(z, azimuth, np.linspace(0, tilt, 500)), LIMITS).all()


def test_the_boundary_is_the_first_one() -> None:
    """Limb 1 shortens as it leans, then lengthens again: what lies beyond the gap is cut off."""
    lengths = limbs_at(PAPER, Pose(0.25, 0.0, np.linspace(0, np.pi / 2, 100_001))).lengths[:, 0]
    least = int(lengths.argmin())
    assert 0 < least < 100_000
    limits = Limits(lengths[least] + 1e-3, 2.0, math.pi, math.pi)
    inside = lengths >= limits.length_min
    first = np.linspace(0, np.pi / 2, 100_001)[inside.argmin()]
    assert inside[-1]
    assert boundary(PAPER, 0.25, 0.0, limits) == pytest.approx(first, abs=2e-5)
    assert reachable(PAPER, Pose(0.25, 0.0, np.pi / 2), limits)


@given(azimuths, azimuths, st.floats(0.25, 0.9))
@settings(max_examples=8)
def test_the_boundary_turns_with_the_frame(azimuth: float, heading: float, z: float) -> None:
    """Three limbs repeat after 120 degrees and mirror; a turned mechanism turns its boundary."""
    around = np.array([azimuth, azimuth + THIRD, azimuth - THIRD, -azimuth])
    tilt = boundary(PAPER, z, around, LIMITS)
    np.testing.assert_allclose(tilt, tilt[0], atol=2 * SMALLEST)
    turned = boundary(Mechanism.paper(heading=heading), z, azimuth + heading, LIMITS)
    np.testing.assert_allclose(turned, tilt[0], atol=2 * SMALLEST)
    # Leaning by -tilt is leaning the other way.
    opposite = Pose(z, azimuth + np.pi, -tilt[0])
    np.testing.assert_allclose(
        margins(PAPER, opposite, LIMITS), margins(PAPER, Pose(z, azimuth, tilt[0]), LIMITS),
        atol=1e-13,
    )  # fmt: skip


@given(
    st.floats(0.0, 0.05), st.floats(0.0, 0.1), st.floats(0.0, 0.3), st.floats(0.0, 0.3), azimuths
)
@settings(max_examples=10)
def test_tighter_limits_never_widen(
    shorter: float, longer: float, alpha: float, beta: float, azimuth: float
) -> None:
    tight = Limits(0.2 + shorter, 1.0 - longer, np.pi / 4 - alpha, np.pi / 4 - beta)
    z = np.array([0.26, 0.5, 0.85])
    wide, narrow = (boundary(PAPER, z, azimuth, limits) for limits in (LIMITS, tight))
    reached = ~np.isnan(narrow)
    assert (narrow[reached] <= wide[reached] + SMALLEST).all()


def test_heights_by_hand() -> None:
    """Level limbs are hypot(z, r1 - r2) long."""
    low, high = heights(PAPER, LIMITS)
    assert low == pytest.approx(math.sqrt(0.2**2 - 0.1**2), abs=2e-12)
    assert high == pytest.approx(math.sqrt(1.0**2 - 0.1**2), abs=2e-12)
    narrow = replace(LIMITS, spherical_max=0.2)  # limbs lean by atan(0.1 / z)
    assert heights(PAPER, narrow)[0] == pytest.approx(0.1 / math.tan(0.2), abs=2e-12)


def test_the_circle_by_hand() -> None:
    """At azimuth 0 limb 1 stays in its plane: its spherical angle is tilt + beta."""
    radius, touch = inscribed(PAPER, 0.49, LIMITS, azimuths=25)
    assert math.remainder(touch[0], THIRD) == pytest.approx(0, abs=1e-3)
    leaning = Pose(0.49, 0.0, radius[0])
    o = 0.1 * (math.cos(radius[0]) - 1)  # x of Eq. (2) at phi = 0
    beta = math.atan2(o + 0.2 * math.cos(radius[0]) - 0.3, 0.49 - 0.2 * math.sin(radius[0]))
    assert radius[0] - beta == pytest.approx(math.pi / 4, abs=1e-8)
    assert reachable(PAPER, leaning, LIMITS)


@pytest.mark.parametrize("heading", [0.0, 0.0327])
def test_the_circle_does_not_depend_on_the_samples(heading: float) -> None:
    """Where it touches is found between samples, too; no azimuth is outside."""
    robot, z = Mechanism.paper(heading=heading), np.array([0.18, 0.2, 0.49, 0.88, 0.97])
    radii, _ = inscribed(robot, z, LIMITS, azimuths=24)
    finer = boundary(robot, z[:, None], heading + np.linspace(0, THIRD, 361), LIMITS).min(axis=1)
    np.testing.assert_allclose(radii, finer, atol=1e-7)


def test_an_uneven_mechanism_has_its_own_circle() -> None:
    """Limbs of different reach: the least of several basins is found."""
    even = PAPER.limbs
    near = replace(even[1], base=(-0.13, 0.13 * math.sqrt(3), 0.0))
    robot = Mechanism((even[0], near, even[2]), PAPER.platform)
    radius, touch = inscribed(robot, 0.5, LIMITS, azimuths=24)
    finer = boundary(robot, 0.5, np.radians(np.arange(0, 360, 0.5)), LIMITS)
    assert radius[0] == pytest.approx(finer.min(), abs=2e-5)
    assert radius[0] <= finer.min() + SMALLEST
    assert boundary(robot, 0.5, touch[0], LIMITS) == pytest.approx(radius[0], abs=SMALLEST)


def test_any_number_of_limbs() -> None:
    """Four limbs cannot lean between their planes; one limb leans in its own only."""
    square = Mechanism.regular(0.3, 0.2, PAPER.limbs[0].rod, PAPER.platform, limbs=4)
    assert boundary(square, 0.49, 0.0, LIMITS) > 0.3
    assert boundary(square, 0.49, 0.4, LIMITS) < 1e-3
    assert np.isnan(margins(square, Pose(0.49, 0.4, 0.2), LIMITS)).all()
    assert inscribed(square, 0.49, LIMITS, azimuths=24)[0] < 1e-3
    alone = Mechanism(PAPER.limbs[:1], PAPER.platform)
    assert boundary(alone, 0.49, 0.0, LIMITS) > 0.3


def test_out_of_reach_is_nan_and_refused() -> None:
    assert np.isnan(boundary(PAPER, 1.2, 0.0, LIMITS))
    assert np.isnan(inscribed(PAPER, 1.2, LIMITS, azimuths=24)[0]).all()
    with pytest.raises(InputError, match=r"layers = 1\.2: expected heights in metres"):
        regular_workspace(PAPER, [0.5, 1.2], LIMITS)
    with pytest.raises(InputError, match="at least two different heights"):
        regular_workspace(PAPER, [0.5], LIMITS)
    with pytest.raises(InputError, match="limits that a level platform"):
        heights(PAPER, Limits(length_min=0.01, length_max=0.05))


def test_layers_are_sorted_circles() -> None:
    found = regular_workspace(PAPER, [0.6, 0.3, 0.45], LIMITS, azimuths=24)
    np.testing.assert_array_equal(found.z, [0.3, 0.45, 0.6])
    np.testing.assert_allclose(found.radii, inscribed(PAPER, found.z, LIMITS)[0], atol=1e-8)
    assert reachable(PAPER, found.random(2000, 1), LIMITS).all()
    assert reachable(PAPER, found.grid(24, 4), LIMITS).all()
    assert found.grid(24, 4).shape == (3, 24, 4)


@given(st.lists(st.floats(0.01, 1.0), min_size=2, max_size=9))
def test_the_cone_is_the_largest_chord(radii: list[float]) -> None:
    """Against every pair of layers, each checked against every layer between."""
    body = RegularWorkspace(np.linspace(0.2, 1.0, len(radii)), np.array(radii))
    best = {0.0: 0.0, 2e-12: 0.0}  # what rounding leaves open is either
    for i in range(len(radii)):
        for j in range(i + 1, len(radii)):
            chord = np.interp(body.z[i : j + 1], body.z[[i, j]], body.radii[[i, j]])
            volume = RegularWorkspace(body.z[[i, j]], body.radii[[i, j]]).volume
            for room in best:
                if (chord <= body.radii[i : j + 1] + room).all():
                    best[room] = max(best[room], volume)
    cone = body.cone()
    assert best[0.0] * (1 - 1e-9) <= cone.volume <= best[2e-12] * (1 + 1e-9)
    assert (cone.radius(body.z) <= body.radii + 2e-12).all()


def test_rounding_cuts_no_cylinder_in_two() -> None:
    radii = np.array([1.0, 1.0 - 2e-16, 1.0])
    body = RegularWorkspace(np.array([0.2, 0.6, 1.0]), radii)
    assert body.cone().volume == pytest.approx(body.volume)


def test_volume_and_random_poses() -> None:
    """A cylinder below a cone: volumes by hand, and random poses in their proportion."""
    body = RegularWorkspace(np.array([0.2, 0.4, 1.0]), np.array([0.3, 0.3, 0.0]))
    cylinder, cone = np.pi * 0.09 * 0.2, np.pi * 0.09 * 0.6 / 3
    assert body.volume == pytest.approx(cylinder + cone)
    poses = body.random(40_000, 7)
    assert body.contains(poses).all()
    share = np.mean(poses.z < 0.4)
    assert share == pytest.approx(cylinder / (cylinder + cone), abs=0.01)
    above = poses.z[poses.z > 0.4]  # the volume above z goes with the cube
    assert np.mean((1.0 - above) / 0.6 < 0.5) == pytest.approx(1 / 8, abs=0.01)
    inner = poses.tilt < 0.5 * body.radius(poses.z)
    assert np.mean(inner) == pytest.approx(1 / 4, abs=0.01)
    assert np.mean(poses.azimuth < THIRD) == pytest.approx(1 / 3, abs=0.01)
    np.testing.assert_array_equal(body.random(5, 7).z, body.random(5, 7).z)
    assert not body.contains(
        Pose(np.array([0.1, 0.3, 0.9]), 0.0, np.array([0.0, -0.31, 0.1]))
    ).any()


@pytest.mark.parametrize(
    ("given", "named"),
    [
        ({"length_min": -0.1}, "Limits.length_min = -0.1"),
        ({"length_max": 0.2}, "Limits.length_max = 0.2: expected more than length_min"),
        ({"length_max": math.nan}, "Limits.length_max = nan"),
        ({"spherical_max": 0.0}, "Limits.spherical_max = 0.0"),
        ({"revolute_max": 4.0}, "Limits.revolute_max = 4.0: expected an angle above 0"),
        ({"revolute_max": "wide"}, "Limits.revolute_max = 'wide'"),
    ],
)
def test_bad_limits(given: dict[str, float], named: str) -> None:
    with pytest.raises(InputError, match=named):
        Limits(**given)


def limited(mechanism: Mechanism, stroke: tuple[float, float], angle: float) -> Mechanism:
    """The mechanism with limits of its own: of every limb's length, and of both its joints."""
    limbs = []
    for limb in mechanism.limbs:
        first, rod, last = limb.chain
        assert isinstance(first, Joint) and isinstance(last, Joint)
        chain = (replace(first, largest=angle), rod, replace(last, largest=angle))
        limbs.append(replace(limb, chain=chain, stroke=stroke))
    return Mechanism(tuple(limbs), mechanism.platform)


def test_limits_that_a_mechanism_states_are_those_of_eq_25_where_these_are_its_own() -> None:
    own = limited(PAPER, (0.2, 1.0), np.pi / 4)
    assert own == PAPER and repr(own) == repr(PAPER) and own.limited and not PAPER.limited
    poses = Pose(np.linspace(0.2, 1.0, 40)[:, None], 0.3, np.radians([0, 5, 15, 30, 50]))
    np.testing.assert_allclose(margins(own, poses, LIMITS), margins(PAPER, poses, LIMITS),
                               atol=1e-12)  # fmt: skip
    assert heights(own, LIMITS) == pytest.approx(heights(PAPER, LIMITS), abs=2e-12)
    tilt = float(boundary(own, 0.49, 0.4, LIMITS))
    assert tilt == pytest.approx(float(boundary(PAPER, 0.49, 0.4, LIMITS)), abs=2 * SMALLEST)


def test_its_own_limits_stand_instead_of_eq_25() -> None:
    tight = limited(PAPER, (0.45, 0.5), np.pi)
    low, high = heights(tight, LIMITS)
    assert (low, high) == pytest.approx([math.sqrt(L**2 - 0.1**2) for L in (0.45, 0.5)], abs=1e-11)
    # The joint alone: the limb of case 1 leans by atan(0.1 / z) from both verticals.
    narrow = limited(PAPER, (0.0, 9.0), 0.2)
    assert heights(narrow, LIMITS)[0] == pytest.approx(0.1 / math.tan(0.2), abs=2e-12)


def test_limbs_without_a_rod_have_the_same_limits() -> None:
    """A rigid link in the place of each rod: the joints lean as they did."""
    rigid = tuple(
        replace(limb, chain=tuple(Link() if isinstance(item, Rod) else item for item in limb.chain))
        for limb in PAPER.limbs
    )
    poses = Pose(np.array([0.4, 0.49, 0.7]), 0.3, np.radians([0, 10, 25]))
    found = margins(Mechanism(rigid, PAPER.platform), poses, LIMITS)
    np.testing.assert_allclose(found, margins(PAPER, poses, LIMITS), atol=1e-12)


def test_a_slider_s_stroke_and_downward_limbs() -> None:
    """A rod of 0.55 m reaches 0.17 m across: the platform hangs sqrt(0.55^2 - 0.17^2) below."""
    steel = PAPER.limbs[0].rod.material
    chain = (
        Joint.prismatic((0, 0, 1), slider="above"),
        replace(Joint.revolute((0, 1, 0)), largest=0.7, rest=(0, 0, -1)),
        Rod(steel, Section.round(0.05), 0.55),
        replace(Joint.spherical(), largest=0.7, rest=(0, 0, -1)),
    )
    limb = Limb((0.35, 0, 0), (0.18, 0, 0), chain, stroke=(-0.7, -0.1))
    turned = tuple(limb.turned(2 * math.pi * k / 3) for k in range(3))
    robot = Mechanism(turned, PAPER.platform)
    drop = math.sqrt(0.55**2 - 0.17**2)
    assert heights(robot, LIMITS) == pytest.approx([-0.7 - drop, -0.1 - drop], abs=1e-11)
    lean = margins(robot, Pose(-0.9), LIMITS)
    assert lean[:, 2:] == pytest.approx(0.7 - math.asin(0.17 / 0.55))
    assert turned[1].stroke == (-0.7, -0.1)


def test_poses_may_share_x_y_and_torsion() -> None:
    limits = replace(LIMITS, x=0.01, y=-0.02, torsion=0.1)
    held = limits.held(Pose(np.array([0.5, 0.6]), 0.3, 0.1))
    np.testing.assert_array_equal(held.x, [0.01, 0.01])
    np.testing.assert_array_equal(held.torsion, [0.1, 0.1])
    placed = Pose(0.5, x=0.0, y=0.0)
    assert limits.held(placed) is placed
