"""Counted work against the matrices and factors themselves, and how it grows."""

import numpy as np
import pytest
import scipy.sparse

from analytic import Material, Mechanism, Multipliers, Platform, Pose, Rod, Substructure, work
from analytic.chain_work import FORMULATIONS, chain_work
from analytic.lanczos import factor
from analytic.multipliers import null_space

STEEL = Material(200e9, 77e9, 7820)


def robot(limbs: int) -> Mechanism:
    plate = Platform.disc(0.2, 0.02, 7820)
    return Mechanism.regular(0.3, 0.2, Rod(STEEL, 0.1), plate, limbs=limbs, heading=0.3)


@pytest.mark.parametrize("limbs", [3, 4])
@pytest.mark.parametrize("s", [1, 2, 3, 9])
def test_substructure_is_counted_exactly(s: int, limbs: int) -> None:
    K, _ = Substructure(s).matrices(robot(limbs), Pose(0.5))
    dense, sparse = (work.substructure(s, limbs, sparse=kind) for kind in (False, True))
    assert dense.dofs == sparse.dofs == K.shape[0]
    assert dense.nonzeros == sparse.nonzeros == K.nnz
    # The pattern, filled with numbers among which none cancels.
    filled = K.copy()
    filled.data = -np.random.default_rng(0).uniform(0.5, 1.5, K.nnz)
    filled = scipy.sparse.csr_array(
        (filled + filled.T) / 2 + 1e3 * scipy.sparse.eye_array(len(filled.indptr) - 1)
    )
    factors = factor(filled)
    stored = factors.L.nnz + factors.U.nnz - K.shape[0]
    assert sparse.bytes == 12 * (2 * K.nnz + stored)


@pytest.mark.parametrize("limbs", [3, 5])
@pytest.mark.parametrize("s", [1, 2, 3, 9])
def test_multipliers_are_counted_from_above(s: int, limbs: int) -> None:
    K, _, C = Multipliers(s).matrices(robot(limbs), Pose(0.5))
    N = null_space(C)
    reduced = N.T @ K @ N
    counted = work.null_space(s, limbs)
    assert counted.dofs == N.shape[1]
    assert reduced.nnz <= counted.nonzeros <= 2 * reduced.nnz
    augmented = work.saddle_point(s, limbs)
    assert augmented.dofs == sum(C.shape)
    assert K.nnz + 2 * C.nnz == pytest.approx(augmented.nonzeros, rel=0.1)


@pytest.mark.parametrize("sparse", [False, True])
@pytest.mark.parametrize("s", [1, 2, 3, 9])
def test_work_of_chains_is_that_of_the_papers_limbs(s: int, sparse: bool) -> None:
    """By what is coupled: the paper's way to the last operation; joints hold what they hold."""
    known = (work.substructure, work.null_space, work.saddle_point)
    for name, count in zip(FORMULATIONS, known, strict=True):
        found = chain_work(name, robot(3), Pose(0.5, 0.3, 0.1), s, sparse=sparse)
        right = count(s, 3, sparse=sparse)
        if name == "paper":
            assert found == right
        assert found.dofs == right.dofs
        assert found.nonzeros == pytest.approx(right.nonzeros, rel=0.1)
        assert found.flops == pytest.approx(right.flops, rel=0.1)


def slope(count: object, steps: tuple[int, int], **kind: bool) -> float:
    few, many = (count(s, **kind).flops for s in steps)  # type: ignore[operator]
    return float(np.log(many / few) / np.log(steps[1] / steps[0]))


@pytest.mark.parametrize("count", [work.substructure, work.null_space, work.saddle_point])
def test_growth(count: object) -> None:
    """Dense solutions grow with the cube of the elements, sparse ones with their number."""
    assert slope(count, (64, 128)) == pytest.approx(3, abs=0.1)
    assert slope(count, (64, 128), sparse=True) == pytest.approx(1, abs=0.05)


def test_the_rivals_need_more() -> None:
    for s in (1, 3, 8, 64):
        for kind in (False, True):
            paper, null, saddle = (
                count(s, sparse=kind).flops
                for count in (work.substructure, work.null_space, work.saddle_point)
            )
            assert paper < null and paper < saddle
    assert work.condensed().flops < work.substructure(2).flops
