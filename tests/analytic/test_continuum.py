"""The model without elements: known values, counts against assembled matrices, mode shapes."""

import numpy as np
import pytest

from analytic import (
    Continuum,
    InputError,
    Limb,
    Material,
    Mechanism,
    Platform,
    Pose,
    Rod,
    Substructure,
    Theory,
)
from analytic import wittrick_williams as ww
from analytic.eigen import lowest_modes
from analytic.pairing import assurance, mass_vectors

EXACT = {
    ("euler-bernoulli", "cowper"): (
        [137.826371, 137.826371, 236.516862, 793.124051, 880.839551, 880.839551],
        [124.665975, 149.507123, 241.043346, 720.339940, 894.736495, 947.888615],
    ),
    ("rayleigh", "cowper"): (
        [137.454547, 137.454547, 235.538174, 783.568098, 867.878418, 867.878418],
        [124.331897, 149.100684, 240.035562, 711.940140, 881.782704, 933.922035],
    ),
    ("timoshenko", 0.9): (
        [135.848648, 135.848648, 232.253211, 758.307568, 837.621129, 837.621129],
        [123.026950, 147.212920, 236.573004, 691.481346, 850.484305, 895.873556],
    ),
    ("timoshenko", 0.8863): (
        [135.824252, 135.824252, 232.203410, 757.935496, 837.174006, 837.174006],
        [123.007089, 147.184283, 236.520556, 691.178100, 850.023192, 895.310986],
    ),
}
"""Computed independently of this code, printed to 1e-6 Hz."""


@pytest.mark.parametrize(("beam", "shear"), EXACT)
def test_known_values(robot, case1, case2, beam, shear):
    for pose, expected in zip((case1, case2), EXACT[beam, shear], strict=True):
        found = Continuum(beam, shear).modes(robot, pose).frequencies
        np.testing.assert_allclose(found, expected, rtol=1e-8)


def eigenvalues(mechanism, pose, s, theory):
    pair = Substructure(s, theory.beam, theory.shear).matrices(mechanism, pose)
    K, M = (matrix.toarray() for matrix in pair)
    return np.sqrt(lowest_modes(K, M, len(K))[0]) / (2 * np.pi)


def mixed_robot() -> Mechanism:
    """Four different rods, none of the paper's symmetry in stiffness or mass."""
    paper = Mechanism.regular(0.3, 0.2, Rod(Material(70e9, 26e9, 2700), 0.04), PLATE, limbs=4)
    rods = [Rod(Material(200e9, 77e9, 7820), d) for d in (0.03, 0.05, 0.02)]
    limbs = [
        Limb.rps(limb.base, limb.axis, limb.platform_point, rod)
        for limb, rod in zip(paper.limbs, [*rods, paper.limbs[3].rod], strict=True)
    ]
    return Mechanism(tuple(limbs), Platform.diagonal(12.0, (0.1, 0.2, 0.3)))


PLATE = Platform.disc(0.2, 0.02, 7820)
THEORIES = [Theory("euler-bernoulli"), Theory("rayleigh"), Theory("timoshenko", 0.9)]


def miscounts(mechanism, poses, theory, s, seed):
    """Count where Wittrick-Williams and the eigenvalues of the assembled pair disagree."""
    random, wrong = np.random.default_rng(seed), 0
    for pose in poses:
        known = eigenvalues(mechanism, pose, s, theory)
        frequency = random.uniform(0.2, 1.0, 200) * known[-1] * random.uniform(0.01, 1.0, 200)
        problem = ww.characteristic(mechanism, pose, theory, s)
        counted = problem.count((2 * np.pi * frequency) ** 2)
        wrong += (counted != np.searchsorted(known, frequency)).sum()
    return wrong


@pytest.mark.slow
def test_counts_equal_assembled_ones_at_200_poses(robot, workspace_poses):
    """200 frequencies at each of 200 poses, over the whole spectrum of the same elements."""
    poses = workspace_poses(200, 31)
    for theory, part in zip(THEORIES, (slice(0, 70), slice(70, 135), slice(135, 200)), strict=True):
        assert miscounts(robot, poses[part], theory, 3, 5) == 0


def test_counts_of_different_rods():
    mixed = mixed_robot()
    poses = Pose(np.linspace(0.3, 0.7, 6))
    for theory in THEORIES:
        assert miscounts(mixed, poses, theory, 2, 7) == 0


def test_dropped_torsion_is_noticed(robot, workspace_poses, monkeypatch):
    monkeypatch.setattr(ww, "torsion_counts", lambda *a: np.zeros((1, 1), dtype=int))
    assert miscounts(robot, workspace_poses(3, 31), THEORIES[0], 3, 5) > 100


@pytest.mark.slow
def test_continuum_counts_between_those_of_many_elements(robot, workspace_poses):
    """Conforming elements are never soft: #(f_s < f) <= J(f) <= #(f_s < f (1 + error))."""
    random, poses = np.random.default_rng(3), workspace_poses(200, 32)
    told = 0
    for i, pose in enumerate(poses):
        theory = THEORIES[i % 2]
        known = eigenvalues(robot, pose, 12, theory)
        frequency = random.uniform(50.0, 2500.0, 200)
        problem = ww.characteristic(robot, pose, theory)
        counted = problem.count((2 * np.pi * frequency) ** 2)
        low, high = np.searchsorted(known, frequency), np.searchsorted(known, frequency * 1.001)
        assert ((low <= counted) & (counted <= high)).all()
        told += (low == high).sum()
    assert told > 0.98 * 200 * 200


@pytest.mark.parametrize("beam", ["euler-bernoulli", "timoshenko"])
def test_brackets_are_certified(robot, case1, case2, beam):
    model = Continuum(beam)
    for pose in (case1, case2, Pose(0.7)):
        bounds = model.brackets(robot, pose, 14)
        assert (bounds[:, 1] / bounds[:, 0] - 1 <= 1e-12).all()
        for k, (low, high) in enumerate(bounds):
            below, above = (model.count_below(robot, pose, f) for f in (low, high))
            assert below <= k < above
        found = model.modes(robot, pose, 14).frequencies
        assert ((bounds[:, 0] <= found) & (found <= bounds[:, 1])).all()


@pytest.mark.parametrize("beam", ["euler-bernoulli", "rayleigh", "timoshenko"])
def test_shapes_are_those_of_many_elements(robot, case2, beam):
    """Scaled the same way: the largest difference is small against the largest motion."""
    exact = Continuum(beam).modes(robot, case2, 15)
    fine = Substructure(32, beam).modes(robot, case2, 15)
    assert (np.linalg.norm(exact.platform, axis=1) == 0).sum() == 3  # torsion of three limbs
    for i, frequency in enumerate(fine.frequencies):
        j = np.abs(exact.frequencies - frequency).argmin()
        size = max(np.abs(fine.limbs[i]).max(), 0.01)
        direct = np.abs(exact.limbs[j] - fine.limbs[i]).max()
        assert min(direct, np.abs(exact.limbs[j] + fine.limbs[i]).max()) < 3e-3 * size


def test_repeated_modes_span_the_same_space(robot, case1):
    exact, fine = (model.modes(robot, case1) for model in (Continuum(), Substructure(16)))
    a, b = (mass_vectors(modes, robot, case1) for modes in (exact, fine))
    assert assurance(a, b, fine.frequencies).max(axis=1) == pytest.approx(1, abs=1e-8)
    gram = a @ a.T / np.sqrt(np.outer((a**2).sum(1), (a**2).sum(1)))
    np.testing.assert_allclose(gram, np.eye(6), atol=1e-3)


def test_modes_that_leave_the_platform_still():
    """Eight limbs have more modes between pins than the platform can feel: roots at a pole."""
    rod = Rod(Material(200e9, 77e9, 7820), 0.05)
    robot, pose = Mechanism.regular(0.3, 0.2, rod, PLATE, limbs=8), Pose(0.4)
    modes = Continuum().modes(robot, pose, 9)
    length = np.hypot(0.4, 0.1)
    held = np.pi / 2 / length**2 * np.sqrt(200e9 / 7820) * 0.05 / 4
    assert modes.frequencies[4:9] == pytest.approx(held, rel=1e-11)
    np.testing.assert_allclose(modes.platform[4:9], 0, atol=1e-9)
    still = mass_vectors(modes, robot, pose)[4:9]
    np.testing.assert_allclose(still @ still.T, np.eye(5), atol=1e-3)  # Simpson's rule
    fine = Substructure(16).modes(robot, pose, 9).frequencies
    np.testing.assert_allclose(modes.frequencies, fine, rtol=1e-5)


def test_free_motion_is_given_as_zero():
    """One limb holds nothing but itself: its platform swings and spins about A."""
    rod = Rod(Material(200e9, 77e9, 7820), 0.05)
    robot = Mechanism.regular(0.3, 0.2, rod, PLATE, limbs=1)
    modes = Continuum().modes(robot, Pose(0.4), 7)
    assert (modes.frequencies[:4] == 0).all()
    assert (modes.frequencies[4:] > 1).all()
    fine = Substructure(16).modes(robot, Pose(0.4), 7).frequencies
    np.testing.assert_allclose(modes.frequencies[4:], fine[4:], rtol=1e-5)
    # A hangs still, the limb swings stiffly: straight centre lines, but no sideways motion of A.
    straight = modes.limbs[:4] - np.linspace(0, 1, 11)[:, None] * modes.limbs[:4, :, -1:, :]
    np.testing.assert_allclose(straight, 0, atol=1e-6)
    np.testing.assert_allclose(modes.limbs[:4, 0, :, 1], 0, atol=1e-6)


def test_heavy_platform_puts_modes_next_to_poles(robot, case2):
    heavy = Mechanism(robot.limbs, Platform.diagonal(1e7, (1e6, 1e6, 1e6)))
    bounds = Continuum().brackets(heavy, case2, 12)
    assert (bounds[:, 1] / bounds[:, 0] - 1 <= 1e-12).all()
    fine = Substructure(24).modes(heavy, case2, 12).frequencies
    np.testing.assert_allclose(bounds.mean(axis=1), fine, rtol=2e-5)


def test_refuses_bad_input(robot, case1):
    with pytest.raises(InputError, match="frequency"):
        Continuum().count_below(robot, case1, -1.0)
    with pytest.raises(InputError, match="beam"):
        Continuum("plate")
    with pytest.raises(InputError, match="count"):
        Continuum().modes(robot, case1, 0)
    with pytest.raises(InputError, match="one pose"):
        Continuum().modes(robot, Pose([0.4, 0.5]))
