"""Counted work for limbs of any chain, from what is coupled with what: see `work`.

A column's entries below its pivot are found by elimination without numbers, in the order in which
the coordinates stand: what a column reaches is passed on to the first of it (Davis 2006, Section
4.1).
"""

from typing import Any

import numpy as np
import scipy.sparse

from analytic.chain_models import DENSE
from analytic.chain_multipliers import free_bodies
from analytic.exact_chain import exact
from analytic.mechanism import Mechanism
from analytic.pose import Pose, one_pose
from analytic.theory import Theory
from analytic.work import Work, dense, null_space_work, saddle_point_work, sparse_work

FORMULATIONS = ("paper", "null-space", "saddle-point")


def chain_work(
    formulation: str, mechanism: Mechanism, pose: Pose, elements: int, count: int = 6,
    *, sparse: bool | None = None,
) -> Work:  # fmt: skip
    """Return the work of one of `FORMULATIONS` with `elements` a rod, at one pose.

    Solved as it is here, or `sparse`, or not: multipliers are solved dense here. Raises
    `InputError` as `Substructure` and `Multipliers` do.
    """
    problem = exact(mechanism, one_pose(mechanism, pose), Theory("euler-bernoulli", "cowper"))
    net = problem.split(elements)
    if formulation == "paper":
        matrix: Any = problem.pair(net, sparse=True)[0]
        if sparse or (sparse is None and net.size > DENSE):
            return sparse_work(net.size, matrix.nnz, _reach(matrix), count)
        return Work(net.size, matrix.nnz, 2 * 8 * net.size**2, dense(net.size, count))
    free = free_bodies(problem, elements)
    own, rows = (free.K != 0) | (free.M != 0), free.C != 0
    if formulation == "null-space":
        held = rows.any(axis=0)
        left = int(held.sum()) - len(rows)
        beside = own[~held][:, held].any(axis=1)[:, None] & np.ones(left, dtype=bool)
        pattern = np.block([[own[~held][:, ~held], beside], [beside.T, np.ones((left, left))]])
        nonzeros = int(pattern.sum())
        reach = _reach(scipy.sparse.csr_array(pattern)) if sparse else None
        others = int((~held).sum())
        return null_space_work(others, int(held.sum()), len(rows), nonzeros, count, reach)
    none = np.zeros((len(rows), len(rows)), dtype=bool)
    pattern = np.block([[own, rows.T], [rows, none]])
    reach = _reach(scipy.sparse.csr_array(pattern)) if sparse else None
    return saddle_point_work(len(own), len(rows), int(pattern.sum()), count, reach)


def _reach(pattern: Any) -> list[int]:
    """Return entries below every pivot of a symmetric sparse pattern."""
    starts, columns = pattern.indptr, pattern.indices
    size = pattern.shape[0]
    below = [{c for c in columns[starts[k] : starts[k + 1]].tolist() if c > k} for k in range(size)]
    found = []
    for reach in below:
        found.append(len(reach))
        if reach:
            first = min(reach)
            below[first] |= reach - {first}
    return found
