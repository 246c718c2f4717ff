"""Four formulations, one mechanism; a sparse solver that loses no repeated mode."""

from typing import Any

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from analytic import (
    InputError,
    Material,
    Mechanism,
    Modes,
    Multipliers,
    Platform,
    Pose,
    Rod,
    Substructure,
    Theory,
    limbs_at,
)
from analytic import lanczos as solver
from analytic.certified import brackets
from analytic.eigen import lowest_modes
from analytic.multipliers import SOLVERS
from analytic.pairing import pair
from analytic.substructure import (
    independent_coordinates,
    limb_selection,
    platform_selection,
    rigid_arm,
)
from analytic.wittrick_williams import characteristic

STEEL = Material(200e9, 77e9, 7820)
THEORIES = ["euler-bernoulli", "rayleigh", "timoshenko"]
poses = st.builds(
    Pose, st.floats(0.35, 0.7), st.floats(-np.pi, np.pi), st.floats(-np.radians(20), np.radians(20))
)


@st.composite
def mechanisms(draw: Any) -> Mechanism:
    """Any material, rods, radii, heading and platform: three limbs, since every pose closes."""
    young = draw(st.floats(1e9, 400e9))
    steel = Material(young, young / draw(st.floats(2.05, 2.95)), draw(st.floats(1e3, 2e4)))
    rods = [Rod(steel, draw(st.floats(0.02, 0.12))) for _ in range(3)]
    skew = np.array(draw(st.lists(st.floats(-0.33, 0.33), min_size=9, max_size=9))).reshape(3, 3)
    inertia = draw(st.floats(0.01, 10)) * (np.eye(3) + skew @ skew.T)
    inertia = (inertia + inertia.T) / 2
    platform = Platform(draw(st.floats(0.5, 500)), tuple(map(tuple, inertia.tolist())))  # type: ignore[arg-type]
    radii = draw(st.floats(0.2, 0.5)), draw(st.floats(0.1, 0.3))
    heading = draw(st.floats(-np.pi, np.pi))
    limbs = Mechanism.regular(*radii, rods[0], platform, heading=heading).limbs
    return Mechanism(
        tuple(limb.with_rod(rod) for limb, rod in zip(limbs, rods, strict=True)),
        platform,
    )


def formulations(elements: int, beam: str) -> list[Any]:
    return [
        Substructure(elements, beam),
        Substructure(elements, beam, solver="sparse"),
        Multipliers(elements, beam),
        Multipliers(elements, beam, solver="saddle-point"),
    ]


@given(robot=mechanisms(), pose=poses, elements=st.integers(1, 4), beam=st.sampled_from(THEORIES))
@settings(max_examples=60)
def test_formulations_agree(robot: Mechanism, pose: Pose, elements: int, beam: str) -> None:
    first, *others = (model.modes(robot, pose, 9) for model in formulations(elements, beam))
    for other in others:
        np.testing.assert_allclose(other.frequencies, first.frequencies, rtol=1e-9)
        # The first six, each found among nine: a repeated pair is not cut in two.
        assert pair(first.first(6), other, robot, pose).assurance.min() > 1 - 1e-9


@pytest.mark.parametrize("beam", THEORIES)
def test_formulations_agree_with_a_chain_of_waves(beam: str, robot: Mechanism, case2: Pose) -> None:
    """Against no matrix at all: the certified frequencies of s equal elements."""
    for s in (1, 4):
        bounds = brackets(characteristic(robot, case2, Theory(beam), s), 6)[0]
        exact = np.sqrt(bounds.mean(axis=1)) / (2 * np.pi)
        for model in formulations(s, beam):
            np.testing.assert_allclose(model.modes(robot, case2).frequencies, exact, rtol=1e-11)


@pytest.mark.parametrize("solver_name", SOLVERS)
def test_shapes_hold_the_joints_and_unit_mass(
    solver_name: str, robot: Mechanism, case2: Pose
) -> None:
    modes = Multipliers(4, solver=solver_name).modes(robot, case2)
    wanted = Substructure(4).modes(robot, case2)
    np.testing.assert_allclose(modes.platform, wanted.platform, atol=1e-9)
    np.testing.assert_allclose(modes.limbs, wanted.limbs, atol=1e-9)
    for i, arm in enumerate(limbs_at(robot, case2).arms):
        tips = modes.platform @ rigid_arm(arm).T
        np.testing.assert_allclose(modes.limbs[:, i, -1], tips, atol=1e-12)
        np.testing.assert_allclose(modes.limbs[:, i, 0], 0, atol=1e-12)


def test_dofs_and_sizes(robot: Mechanism, case1: Pose) -> None:
    """Three limbs: 18 (s + 1) + 6 coordinates, 24 constraints, 18 s left."""
    for s in (1, 3):
        K, M, C = Multipliers(s).matrices(robot, case1)
        assert K.shape == M.shape == (18 * s + 24,) * 2
        assert C.shape == (24, 18 * s + 24)
        assert np.linalg.matrix_rank(C.toarray()) == 24
        assert Multipliers(s).modes(robot, case1).dofs == 18 * s
        assert Multipliers(s, solver="saddle-point").modes(robot, case1).dofs == 18 * s + 48


def test_the_constraints_are_the_substructures(robot: Mechanism, case2: Pose) -> None:
    """What the paper's H_i and Q allow is what C allows, no more and no less."""
    s, n = 2, 3
    arms = limbs_at(robot, case2).arms
    parts = [limb_selection(i, n, s, arms[i]) for i in range(n)] + [platform_selection(n, s)]
    allowed = sp.vstack(parts) @ independent_coordinates(robot.axes, s)
    C = Multipliers(s).matrices(robot, case2)[2]
    assert abs(C @ allowed).max() < 1e-15
    assert np.linalg.matrix_rank(allowed.toarray()) == C.shape[1] - C.shape[0]


@pytest.mark.parametrize("solver_name", SOLVERS)
@pytest.mark.parametrize("limbs", [3, 4])
@pytest.mark.parametrize("elements", [1, 3])
def test_without_the_base_nothing_holds_the_mechanism(
    solver_name: str, limbs: int, elements: int
) -> None:
    """Ref. 15 as the paper words it: six motions of the whole and three of every limb are free."""
    robot = Mechanism.regular(
        0.3, 0.2, Rod(STEEL, 0.1), Platform.disc(0.2, 0.02, 7820), limbs=limbs
    )
    free = 6 + 3 * limbs
    model = Multipliers(elements, solver=solver_name, base="free")
    found = model.modes(robot, Pose(0.49), free + 3).frequencies
    assert (found < 1e-5 * found[free]).sum() == free
    held = Substructure(elements).modes(robot, Pose(0.49), 1).frequencies[0]
    assert found[free] > 5 * held, "and the first vibration is none of the mechanism's"
    other = Multipliers(elements, solver=SOLVERS[0], base="free")
    wanted = other.modes(robot, Pose(0.49), free + 3).frequencies[free:]
    np.testing.assert_allclose(found[free:], wanted, rtol=1e-9)


def test_free_motions_are_rigid(robot: Mechanism, case2: Pose) -> None:
    """Written down by hand: every body moves as a rigid one, and A_i stay together."""
    K, _, C = Multipliers(2, base="free").matrices(robot, case2)
    limbs = limbs_at(robot, case2)
    o = robot.bases[0] + limbs.lengths[0] * limbs.frames[0][:, 2] - limbs.arms[0]
    random = np.random.default_rng(3)
    shift, spin = random.normal(size=(2, 3))
    u = []
    for i in range(3):
        own = random.normal(size=3)  # about A_i, besides the motion of the whole
        tip = o + limbs.arms[i]
        for x in np.linspace(robot.bases[i], tip, 3):
            moved = shift + np.cross(spin, tip - o) + np.cross(own, x - tip)
            u += [moved, own]
    motion = np.concatenate([*u, shift, spin])
    assert np.abs(C @ motion).max() < 1e-14
    assert np.abs(K @ motion).max() < 1e-12 * abs(K).max()


@pytest.mark.slow
def test_multiplicity_is_never_lost() -> None:
    """Symmetric poses of three to six limbs: pairs, and torsion of all limbs at once."""
    for limbs in (3, 4, 6):
        platform = Platform.disc(0.2, 0.02, 7820)
        robot = Mechanism.regular(0.3, 0.2, Rod(STEEL, 0.1), platform, limbs=limbs)
        for z in np.linspace(0.3, 0.8, 12):
            for s in (1, 2, 4, 8):
                K, M = Substructure(s).matrices(robot, Pose(z))
                wanted = lowest_modes(K.toarray(), M.toarray(), 13)[0]
                for count in (1, 2, 5, 9, 13):
                    found = lowest_modes(K, M, count)[0]
                    np.testing.assert_allclose(found, wanted[:count], rtol=1e-9)


def test_a_block_too_narrow_is_noticed(monkeypatch: pytest.MonkeyPatch, robot: Mechanism) -> None:
    """The inertia count finds what a solver left out."""
    K, M = Substructure(6).matrices(robot, Pose(0.49))
    wanted = lowest_modes(K.toarray(), M.toarray(), 6)[0]
    honest, blocks = solver._block_lanczos, []

    def forgetful(apply: Any, M: Any, count: int, block: int) -> np.ndarray:
        blocks.append(block)
        u = honest(apply, M, count + 1, block + 1)
        return np.delete(u, 1 if len(blocks) == 1 else count, axis=1)

    monkeypatch.setattr(solver, "_block_lanczos", forgetful)
    np.testing.assert_allclose(lowest_modes(K, M, 6)[0], wanted, rtol=1e-9)
    assert blocks == [8, 16]


def test_inertia_counts_eigenvalues(robot: Mechanism, case2: Pose) -> None:
    K, M = Substructure(5).matrices(robot, case2)
    values = scipy.linalg.eigh(K.toarray(), M.toarray(), eigvals_only=True)
    random = np.random.default_rng(0)
    for value in np.exp(random.uniform(np.log(values[0] / 2), np.log(2 * values[-1]), 100)):
        pivots = solver.pivots(solver.factor(K - value * M))
        assert (pivots < 0).sum() == (values < value).sum()


def test_sparse_with_a_free_motion() -> None:
    """One limb alone swings freely: K is singular, and the dense answer is given."""
    limb = Mechanism.regular(0.3, 0.2, Rod(STEEL, 0.1), Platform.disc(0.2, 0.02, 7820)).limbs[:1]
    robot = Mechanism(limb, Platform.disc(0.2, 0.02, 7820))
    dense, sparse, saddle = (
        model.modes(robot, Pose(0.49), 8).frequencies
        for model in (
            Substructure(3),
            Substructure(3, solver="sparse"),
            Multipliers(3, solver="saddle-point"),
        )
    )
    assert (dense[:4] < 1e-5 * dense[4]).all() and dense[4] > 1
    for other in (sparse, saddle):
        assert (other[:4] < 1e-5 * dense[4]).all()
        np.testing.assert_allclose(other[4:], dense[4:], rtol=1e-9)


@pytest.mark.parametrize("count", [12, 18])
def test_all_the_modes_there_are(count: int, robot: Mechanism, case2: Pose) -> None:
    first, *others = (
        m.modes(robot, case2, count).frequencies for m in formulations(1, THEORIES[2])
    )
    for other in others:
        np.testing.assert_allclose(other, first, rtol=1e-9)


def test_hundreds_of_elements(robot: Mechanism, case1: Pose) -> None:
    """Rounding of K grows with s^4; strains keep the digits, and the sparse solvers the pairs."""
    for model in (Substructure(200, solver="sparse"), Multipliers(200, solver="saddle-point")):
        modes: Modes = model.modes(robot, case1)
        bounds = brackets(characteristic(robot, case1, Theory(), 200), 6)[0]
        exact = np.sqrt(bounds.mean(axis=1))
        np.testing.assert_allclose(modes.frequencies, exact / (2 * np.pi), rtol=1e-11)


@pytest.mark.parametrize(
    ("settings_", "named", "expected"),
    [
        ({"solver": "schur"}, "solver = 'schur'", "null-space, saddle-point"),
        ({"base": "clamped"}, "base = 'clamped'", "revolute, free"),
        ({"elements": 0}, "elements = 0", "at least 1"),
        ({"beam": "bar"}, "beam = 'bar'", "euler-bernoulli"),
    ],
)
def test_bad_settings(settings_: dict[str, Any], named: str, expected: str) -> None:
    with pytest.raises(InputError) as refused:
        Multipliers(**settings_)
    assert named in str(refused.value) and expected in str(refused.value)


def test_too_many_modes(robot: Mechanism, case1: Pose) -> None:
    for name in SOLVERS:
        with pytest.raises(InputError, match="count = 19: expected at most 18"):
            Multipliers(1, solver=name).modes(robot, case1, 19)
