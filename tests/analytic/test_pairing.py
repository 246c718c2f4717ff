"""Modes are told apart by shape, repeated ones by their subspace."""

from dataclasses import replace

import numpy as np
import pytest

from analytic import Mechanism, Modes, Pose, Substructure
from analytic.pairing import mass_vectors, pair


@pytest.fixture(scope="module")
def modes(robot: Mechanism, case2: Pose) -> Modes:
    return Substructure(6).modes(robot, case2, 8)


def reordered(modes: Modes, order: list[int]) -> Modes:
    return replace(modes, platform=modes.platform[order], limbs=modes.limbs[order])


def test_a_model_pairs_with_itself(modes: Modes, robot: Mechanism, case2: Pose) -> None:
    pairing = pair(modes, modes, robot, case2)
    assert not pairing.reordered.any()
    np.testing.assert_allclose(pairing.assurance, 1)
    off = pairing.matrix - np.diag(np.diag(pairing.matrix))
    assert off.max() < 1e-3  # mass-weighted shapes are orthogonal


def test_a_swapped_pair_is_found_and_said(modes: Modes, robot: Mechanism, case2: Pose) -> None:
    order = [0, 1, 2, 4, 3, 5, 6, 7]
    pairing = pair(modes, reordered(modes, order), robot, case2)
    assert pairing.partner.tolist() == order
    assert pairing.reordered.tolist() == [False] * 3 + [True] * 2 + [False] * 3


def test_a_mode_beyond_the_list_is_found(modes: Modes, robot: Mechanism, case2: Pose) -> None:
    order = [0, 1, 2, 3, 4, 6, 5, 7]
    pairing = pair(modes.first(6), reordered(modes, order), robot, case2)
    assert pairing.partner.tolist() == [0, 1, 2, 3, 4, 6]


@pytest.mark.parametrize("split", [0.0, 1e-4])
def test_a_turned_repeated_pair_is_one_subspace(
    robot: Mechanism, case1: Pose, split: float
) -> None:
    modes = Substructure(4).modes(robot, case1)
    c, s = np.cos(0.7), np.sin(0.7)
    turn = np.array([[c, -s], [s, c]])
    platform, limbs = modes.platform.copy(), modes.limbs.copy()
    platform[:2] = turn @ platform[:2]
    limbs[:2] = np.einsum("ij,j...->i...", turn, limbs[:2])
    frequencies = modes.frequencies.copy()
    frequencies[1] *= 1 + split
    turned = replace(modes, platform=platform, limbs=limbs, frequencies=frequencies)
    pairing = pair(modes, turned, robot, case1)
    np.testing.assert_allclose(pairing.assurance, 1, atol=1e-9)
    assert not pairing.reordered.any()


def test_an_unknown_shape_is_doubtful(modes: Modes, robot: Mechanism, case2: Pose) -> None:
    random = np.random.default_rng(1)
    strange = modes.platform.copy(), modes.limbs.copy()
    strange[1][3] = random.normal(size=strange[1][3].shape)
    other = replace(modes, platform=strange[0], limbs=strange[1])
    assert pair(modes, other, robot, case2).doubtful.tolist() == [k == 3 for k in range(8)]


def test_torsion_pairs_with_torsion(robot: Mechanism, case1: Pose) -> None:
    """A limb's torsion moves no centre line; it must not be taken for another mode."""
    many = Substructure(6).modes(robot, case1, 20)
    still = np.linalg.norm(mass_vectors(many, robot, case1), axis=1) < 1e-3
    assert still.sum() == 3
    pairing = pair(many, many, robot, case1)
    assert still[pairing.partner[still]].all()
    assert not pairing.doubtful.any()
