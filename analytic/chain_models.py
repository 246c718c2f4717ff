"""Frequencies and modes of limbs of any chain: with elements, and without."""

import time
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from analytic.chain_multipliers import free_bodies, lowest
from analytic.chain_shapes import centre_lines, node_motions
from analytic.eigen import hertz
from analytic.exact_chain import Exact, exact
from analytic.lanczos import lowest_sparse
from analytic.mechanism import Mechanism
from analytic.modes import Modes, check_count
from analytic.network import Network
from analytic.pose import Pose, one_pose
from analytic.theory import Theory

Floats = NDArray[np.float64]

DENSE = 280
"""Coordinates up to which LAPACK is quicker than Lanczos."""
REPEATED = 1e-9
"""Modes whose omega^2 are closer than this, relative, share one eigenspace."""


def element_modes(
    mechanism: Mechanism, pose: Pose, theory: Theory, elements: int, count: int
) -> Modes:
    """Return the `count` lowest modes with `elements` a rod, above motions of limbs' own.

    Raises `InputError` as `exact_chain.exact` does, or for more modes than coordinates.
    """
    begin = time.perf_counter()
    problem = exact(mechanism, one_pose(mechanism, pose), theory)
    net = problem.split(elements)
    values, U, built = _solved(problem, net, count)
    return _modes(
        problem, net, U, values, np.zeros(count), "substructure",
        f"rps-bench, {'sparse' if net.size > DENSE else 'dense'}", elements, theory, mechanism,
        (begin, built),
    )  # fmt: skip


def _solved(problem: Exact, net: Network, count: int) -> tuple[Floats, Floats, float]:
    """Return omega^2 (count,), coordinates (net.size, count) and when K and M were built."""
    count = check_count(count, net.size - problem.spins)
    sparse = net.size > DENSE
    K: Any
    M: Any
    K, M = problem.pair(net, sparse=sparse)
    built = time.perf_counter()
    still = problem.spins
    # Spins make K singular; a shift by less than any vibration makes it definite again.
    shift = 1e-3 * problem.first if still else 0.0
    if sparse:
        values, U = lowest_sparse(K, M, count + still, shift)
    else:
        size = len(K)
        mu, U = scipy.linalg.eigh(
            M, K + shift * M, subset_by_index=(size - count - still, size - 1)
        )
        values, U = 1 / mu[::-1] - shift, (U / np.sqrt(mu))[:, ::-1]
    return values[still:], U[:, still:], built


def held_modes(
    mechanism: Mechanism, pose: Pose, theory: Theory, elements: int, below: float
) -> Modes | None:
    """Return the modes below a frequency [Hz] of limbs whose platform is held, `elements` a rod.

    None where there is none. Motions of limbs' own that need no energy are left out. Raises as
    `element_modes`.
    """
    begin = time.perf_counter()
    problem = exact(mechanism, one_pose(mechanism, pose), theory)
    net = problem.split(elements)
    K, M = problem.pair(net)
    built = time.perf_counter()
    own = slice(0, net.size - 6)
    values, U = scipy.linalg.eigh(K[own, own], M[own, own])
    kept = slice(problem.spins, int((values < (2 * np.pi * below) ** 2).sum()))
    values = np.maximum(values[kept], 0.0)
    if not len(values):
        return None
    U = np.vstack([U[:, kept], np.zeros((6, len(values)))])
    return _modes(
        problem, net, U, values, np.zeros(len(values)), "substructure", "rps-bench, platform held",
        elements, theory, mechanism, (begin, built),
    )  # fmt: skip


def exact_modes(mechanism: Mechanism, pose: Pose, theory: Theory, count: int) -> Modes:
    """Return the `count` lowest modes without elements, each the middle of a counted bracket.

    Raises `InputError` as `exact_chain.exact` does, `NotCertifiedError` where rounding leaves a
    bracket too wide.
    """
    begin = time.perf_counter()
    problem = exact(mechanism, one_pose(mechanism, pose), theory)
    built = time.perf_counter()
    omega2 = _middles(problem, count)
    net = problem.cut(float(omega2[-1]))
    groups = np.split(np.arange(count), np.flatnonzero(np.diff(omega2) > REPEATED * omega2[1:]) + 1)
    U = np.empty((net.size, count))
    for group in groups:
        U[:, group] = problem.eigenspace(net, float(omega2[group].mean()), len(group))
    return _modes(
        problem, net, U, omega2, omega2, "continuum", "rps-bench, Wittrick-Williams", None,
        theory, mechanism, (begin, built),
    )  # fmt: skip


def _middles(problem: Exact, count: int) -> Floats:
    """Return the middles of the brackets, ascending: those of repeated modes differ by rounding."""
    return np.sort(problem.brackets(count).mean(axis=1))


def multiplier_modes(
    mechanism: Mechanism, pose: Pose, theory: Theory, elements: int, solver: str, count: int
) -> Modes:
    """Return the `count` lowest modes of free bodies and constraints, see `Multipliers`.

    Raises `InputError` as `element_modes` does, or for more coordinates than dense matrices take.
    """
    begin = time.perf_counter()
    problem = exact(mechanism, one_pose(mechanism, pose), theory)
    net = problem.split(elements)
    count = check_count(count, net.size - problem.spins)
    free = free_bodies(problem, elements)
    built = time.perf_counter()
    still = problem.spins
    shift = 1e-3 * problem.first if still else 0.0
    values, u, unknowns = lowest(free, solver, count + still, problem.unit, shift)
    values, u = values[still:], u[:, still:]
    inner = 6 * np.arange(elements + 1)[:, None] + np.arange(6)
    nodes = [u[free.nodes[p.group, p.item][:, None, None] + inner] for p in net.rods]
    return Modes(
        frequencies=hertz(values),
        platform=u[-6:].T,
        limbs=centre_lines(problem, net, nodes, u[-6:], np.zeros(count)),
        theory=theory.labels(mechanism),
        model="multipliers",
        version=f"rps-bench, {solver}",
        elements=elements,
        dofs=unknowns,
        residual=None,
        build_seconds=built - begin,
        solve_seconds=time.perf_counter() - built,
    )


def _modes(
    problem: Exact,
    net: Network,
    U: Floats,
    omega2: Floats,
    bending: Floats,
    model: str,
    version: str,
    elements: int | None,
    theory: Theory,
    mechanism: Mechanism,
    times: tuple[float, float],
) -> Modes:
    return Modes(
        frequencies=hertz(omega2),
        platform=U[-6:].T,
        limbs=centre_lines(problem, net, node_motions(net, U), U[-6:], bending),
        theory=theory.labels(mechanism),
        model=model,
        version=version,
        elements=elements,
        dofs=net.size - problem.spins,
        residual=None,
        build_seconds=times[1] - times[0],
        solve_seconds=time.perf_counter() - times[1],
    )


def frequencies(
    mechanism: Mechanism, poses: Pose, theory: Theory, elements: int | None, count: int
) -> Floats:
    """Return the `count` lowest frequencies [Hz] at every pose, (*poses.shape, count)."""
    flat = poses.ravel()
    found = np.empty((len(flat), count))
    for i, pose in enumerate(flat):
        if elements is None:
            found[i] = hertz(_middles(exact(mechanism, pose, theory), count))
        else:
            problem = exact(mechanism, pose, theory)
            found[i] = hertz(_solved(problem, problem.split(elements), count)[0])
    return found.reshape(*poses.shape, count)
