"""Many poses at once: equal to the models it condenses, whatever the batch holds."""

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
    certified,
    condensed,
    condensed_frequencies,
    roots,
)
from analytic.kernel import compiled
from analytic.theory import Theory
from analytic.wittrick_williams import characteristic

THEORIES = [("euler-bernoulli", "cowper"), ("rayleigh", "cowper"), ("timoshenko", 0.9)]
PLATE = Platform.disc(0.2, 0.02, 7820)
STEEL = Material(200e9, 77e9, 7820)


@pytest.fixture(params=["numpy", pytest.param("compiled", marks=pytest.mark.slow)], autouse=True)
def route(request, monkeypatch):
    """Everything holds for plain numpy and, where numba is installed, for the compiled loop."""
    if request.param == "compiled":
        if compiled() is None:
            pytest.skip("numba is not installed: pip install numba")
        monkeypatch.setattr(condensed, "WORTHWHILE", 0)
    return request.param


def one_by_one(mechanism, poses, elements, beam, shear, count=6):
    model = Continuum(beam, shear) if elements is None else Substructure(elements, beam, shear)
    return np.array([model.modes(mechanism, pose, count).frequencies for pose in poses])


def check(mechanism, poses, elements, beam="euler-bernoulli", shear="cowper", count=6, rtol=1e-9):
    found = condensed_frequencies(mechanism, poses, elements, beam=beam, shear=shear, count=count)
    expected = one_by_one(mechanism, poses, elements, beam, shear, count)
    np.testing.assert_allclose(found, expected, rtol=rtol)


@pytest.mark.parametrize(("beam", "shear"), THEORIES)
@pytest.mark.parametrize("elements", [1, 2, 3, 8, None])
def test_equals_the_full_model(robot, workspace_poses, beam, shear, elements):
    check(robot, workspace_poses(8, 21), elements, beam, shear)


@pytest.mark.slow
@pytest.mark.parametrize("elements", [1, 3, None])
@pytest.mark.parametrize("beam", ["euler-bernoulli", "timoshenko"])
def test_more_modes_torsion_among_them(robot, workspace_poses, elements, beam):
    check(robot, workspace_poses(3, 22), elements, beam, count=18)


@pytest.mark.parametrize("elements", [2, None])
def test_without_torsion_all_other_modes_are_left(robot, elements):
    """Those of the one-pose models whose centre lines move; some of six twist at 200 mm."""
    poses = Pose(np.array([0.2, 0.21, 0.5]), 0.3, 0.1)
    found = condensed_frequencies(robot, poses, elements, torsion=False)
    for i, pose in enumerate(poses):
        modes = (Continuum() if elements is None else Substructure(2)).modes(robot, pose, 10)
        moves = np.abs(modes.limbs).max(axis=(1, 2, 3))
        expected = modes.frequencies[moves > 1e-6 * moves.max()][:6]
        assert (len(np.intersect1d(expected, modes.frequencies[:6])) < 6) == (pose.z < 0.3)
        np.testing.assert_allclose(found[i], expected, rtol=1e-9)


def test_all_modes_of_one_element(robot, workspace_poses):
    check(robot, workspace_poses(3, 23), 1, count=18)
    with pytest.raises(InputError, match="count"):
        condensed_frequencies(robot, Pose(0.5), 1, count=19)
    every = condensed_frequencies(robot, Pose(0.5), 1, count=18)
    without = condensed_frequencies(robot, Pose(0.5), 1, count=15, torsion=False)
    left = np.abs(every[:, None] / without - 1).min(axis=1) > 1e-9
    assert left.sum() == 3 and np.ptp(every[left]) < 1e-6  # equal limbs twist alike
    with pytest.raises(InputError, match="count"):
        condensed_frequencies(robot, Pose(0.5), 1, count=16, torsion=False)


@pytest.mark.slow
@pytest.mark.parametrize("elements", [3, None])
def test_symmetric_poses_in_a_batch(robot, elements):
    """Repeated pairs, exactly and nearly, at zero and tiny tilt, among ordinary poses."""
    tilt = [0.0, 1e-12, 1e-9, 1e-7, 1e-5, 1e-4, 1e-3, 1e-2, -0.2, 0.0]
    poses = Pose(np.r_[np.full(9, 0.49), 0.61], 0.3, np.array(tilt))
    for beam, shear in THEORIES[::2]:
        # The last one wanted may be half of a pair.
        for count in (5, 6):
            check(robot, poses, elements, beam, shear, count)


def test_all_but_symmetric_poses(robot):
    """Modes that all but repeat mix at will; what else they mix with must not be lost by it."""
    z, tilt = np.linspace(0.35, 0.7, 60), 10.0 ** np.linspace(-15, -11, 60)
    poses = Pose(z, np.linspace(-3, 3, 60), tilt)
    expected = [Continuum().brackets(robot, Pose(height)).mean(axis=1) for height in z]
    single = [condensed_frequencies(robot, pose) for pose in poses]
    for found in (np.array(single), condensed_frequencies(robot, poses)):
        np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_level_poses_are_the_same_alone_and_in_company(robot):
    """Modes that repeat are coupled by rounding alone, which must not say how many steps follow."""
    random = np.random.default_rng(1)
    poses = Pose(random.uniform(0.35, 0.7, 300), random.uniform(-3, 3, 300), 0.0)
    found = condensed_frequencies(robot, poses, 1, beam="timoshenko")
    single = [condensed_frequencies(robot, pose, 1, beam="timoshenko") for pose in poses]
    np.testing.assert_allclose(single, found, rtol=1e-12)


def test_modes_that_mix_settle_only_when_they_are_right(robot):
    """Nine modes, some all but repeated: of later steps too the mixing bounds what is left.

    By a power of it they settle while 4e-9 is still wrong.
    """
    poses = Pose([0.32867906121896295], -0.09594707588967832, 1.559843599946202e-05)
    problem = characteristic(robot, poses[0], Theory("euler-bernoulli", "cowper"))
    expected = np.sqrt(certified.middles(certified.coupled(problem, 9))) / (2 * np.pi)
    found = condensed_frequencies(robot, poses, count=9, torsion=False)
    np.testing.assert_allclose(found[0], expected, rtol=1e-9)


def test_modes_next_to_poles(robot, workspace_poses):
    """A heavy platform leaves the limbs' modes at their fixed-tip frequencies."""
    for mass in (1e3, 1e5, 1e7):
        heavy = Mechanism(robot.limbs, Platform.diagonal(mass, (0.1 * mass,) * 3))
        check(heavy, workspace_poses(3, 24), None, count=9, rtol=1e-9)


def test_platforms_that_stand_still():
    """Eight limbs: roots exactly at a pole, five times."""
    eight = Mechanism.regular(0.3, 0.2, Rod(STEEL, 0.05), PLATE, limbs=8)
    check(eight, Pose([0.4, 0.5]), None, count=10)
    check(eight, Pose([0.4, 0.5]), 4, count=10)


@pytest.mark.slow
@pytest.mark.parametrize("elements", [2, None])
def test_different_rods(elements):
    regular = Mechanism.regular(0.3, 0.2, Rod(STEEL, 0.05), PLATE, limbs=4)
    rods = [Rod(STEEL, 0.05), Rod(Material(70e9, 26e9, 2700), 0.03), Rod(STEEL, 0.02)]
    limbs = [
        Limb.rps(limb.base, limb.axis, limb.platform_point, rod)
        for limb, rod in zip(regular.limbs, [*rods, rods[0]], strict=True)
    ]
    inertia = ((0.2, 0.03, 0.01), (0.03, 0.3, 0.02), (0.01, 0.02, 0.4))
    mixed = Mechanism(tuple(limbs), Platform(12.0, inertia))
    for beam, shear in THEORIES:
        check(mixed, Pose(np.linspace(0.3, 0.7, 4)), elements, beam, shear, count=10)


def test_what_fails_the_count_is_solved_by_bisection(robot, workspace_poses, monkeypatch):
    poses = workspace_poses(4, 25)
    expected = condensed_frequencies(robot, poses)
    monkeypatch.setattr(
        roots, "_certain", lambda problem, *rest: np.zeros(len(problem.lengths), dtype=bool)
    )
    np.testing.assert_allclose(condensed_frequencies(robot, poses), expected, rtol=1e-9)


@pytest.mark.parametrize("fault", ["missed", "doubled"])
def test_the_count_notices_a_wrong_mode(robot, workspace_poses, monkeypatch, fault):
    """Let the first attempt miss its third mode, or find it twice: the answer is still right."""
    poses, solve = workspace_poses(4, 26), roots._certain
    expected = condensed_frequencies(robot, poses, count=5)
    sixth = (2 * np.pi * condensed_frequencies(robot, poses, count=6)[:, -1]) ** 2
    attempts = []

    def lossy(problem, found, below):
        if not attempts:
            if fault == "missed":
                found[:, 2:] = np.column_stack([found[:, 3:], sixth])
            else:
                found[:, 3:] = found[:, 2:-1]
        attempts.append(solve(problem, found, None))
        return attempts[-1]

    monkeypatch.setattr(roots, "_certain", lossy)
    np.testing.assert_allclose(condensed_frequencies(robot, poses, count=5), expected, rtol=1e-9)
    assert not attempts[0].any()


def test_shapes_of_the_answer(robot, case2):
    single = condensed_frequencies(robot, case2, 3)
    assert single.shape == (6,)
    grid = Pose(np.full((2, 3), case2.z), case2.azimuth, case2.tilt)
    np.testing.assert_allclose(
        condensed_frequencies(robot, grid, 3, count=2), single[:2] * np.ones((2, 3, 1))
    )
    assert condensed_frequencies(robot, Pose(np.zeros(0) + 0.5)).shape == (0, 6)


def test_refuses_bad_input(robot, case1):
    for bad in ({"elements": 0}, {"beam": "plate"}, {"count": 0}, {"count": 2.5}):
        with pytest.raises(InputError):
            condensed_frequencies(robot, case1, **bad)


def test_no_count_of_elements_enters_the_work(robot, workspace_poses, monkeypatch):
    """Matrices of the same size, as many of them; the few poses left over in one batch more."""
    poses, solve, sizes = workspace_poses(4 * condensed.CHUNK, 28), condensed.solve, []

    def counted(problem, *rest):
        sizes[-1].append((len(problem.lengths), problem.poles.shape[1]))
        return solve(problem, *rest)

    monkeypatch.setattr(condensed, "solve", counted)
    for elements in (1, 64, None):
        sizes.append([])
        condensed_frequencies(robot, poses, elements)
    for own in sizes:
        whole = [one for one in own if one[0] >= condensed.CHUNK]
        assert whole == [one for one in sizes[0] if one[0] >= condensed.CHUNK]
        assert sum(count for count, _ in whole) == len(poses)
        left = own[len(whole) :]
        assert len(left) <= 1 and sum(count for count, _ in left) < 0.01 * len(poses)


@pytest.mark.slow
@pytest.mark.parametrize("elements", [3, None])
def test_ten_thousand_poses_keep_their_counts(robot, workspace_poses, elements):
    """Sampled against the full model; everywhere ascending, finite and below the next mode."""
    poses = workspace_poses(10_000, 27)
    found = condensed_frequencies(robot, poses, elements, beam="timoshenko")
    assert np.isfinite(found).all()
    assert (np.diff(found, axis=1) >= 0).all()
    some = np.arange(0, 10_000, 500)
    expected = one_by_one(robot, poses[some], elements, "timoshenko", "cowper")
    np.testing.assert_allclose(found[some], expected, rtol=1e-9)


def test_the_compiled_loop_is_asked_for_or_worth_it(robot, case1, monkeypatch):
    monkeypatch.setattr(condensed, "compiled", lambda: None)
    with pytest.raises(InputError, match=r"fast = True: expected numba to be installed"):
        condensed_frequencies(robot, case1, fast=True)
    monkeypatch.setattr(condensed, "WORTHWHILE", 2)
    monkeypatch.setattr(condensed, "compiled", lambda: pytest.fail("loaded for too few poses"))
    condensed_frequencies(robot, case1)
    condensed_frequencies(robot, Pose(np.full(3, 0.5)), fast=False)
