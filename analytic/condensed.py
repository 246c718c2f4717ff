"""Natural frequencies of thousands of poses a call, at a cost that no element count enters."""

import numpy as np
from numpy.typing import NDArray

from analytic.dynamic_stiffness import Sections, limb_stiffness, torsion_eigenvalues
from analytic.errors import count as whole
from analytic.kernel import compiled
from analytic.mechanism import Mechanism
from analytic.modes import check_count
from analytic.pose import Pose
from analytic.reduced import Floats, Reduced, geometry, reduced
from analytic.theory import Theory
from analytic.wittrick_williams import Characteristic

CHUNK = 500
"""Poses solved at once: what fits into the processor's cache."""
CONVERGED = 1e-11
"""Relative change of omega^2 at which the iteration ends; the error is a hundredth of it."""
CLOSE = 1e-3
"""The last mode wanted stays this far, relative, below where the tables end."""
GRADED = 1e-6
"""An eigenvalue below this part of the largest has lost too many digits for 1e-9."""
LEVELS = 6
"""Most limb modes a bending direction before a pose is left to certified bisection."""


def condensed_frequencies(
    mechanism: Mechanism,
    poses: Pose,
    elements: int | None = None,
    *,
    beam: str = "euler-bernoulli",
    shear: str | float = "cowper",
    count: int = 6,
) -> NDArray[np.float64]:
    """Return the `count` lowest frequencies [Hz] at every pose, shape (*poses.shape, count).

    Those of `Substructure(elements, beam, shear)`, or of `Continuum(beam, shear)` where `elements`
    is None, to 1e-9. Every pose is checked by the Wittrick-Williams count of the exact limbs; one
    that fails is solved by certified bisection. Memory does not grow with the number of poses.
    Raises `InputError` for a pose out of reach, or more modes than the model has.
    """
    theory = Theory(beam, shear)
    available = 10_000
    if elements is not None:
        available = 6 + len(mechanism.limbs) * (6 * whole("elements", elements) - 2)
    count = check_count(count, available)
    flat = Pose(*(np.ravel(value) for value in (poses.z, poses.azimuth, poses.tilt)))
    result = np.empty((len(flat), count))
    for start in range(0, len(flat), CHUNK):
        part = slice(start, start + CHUNK)
        rods, lengths, vectors = geometry(mechanism, theory, flat[part])
        result[part] = _chunk(rods, lengths, vectors, elements, count)
    return np.asarray(np.sqrt(np.maximum(result, 0)) / (2 * np.pi)).reshape(*poses.shape, count)


def _chunk(
    rods: Sections, lengths: Floats, vectors: Floats, elements: int | None, count: int
) -> Floats:
    """Return the lowest omega^2 (N, count), torsion of the limbs among them."""
    n = lengths.shape[1]
    coupled = count if elements is None else min(count, 6 + n * (5 * elements - 2))
    values = np.full((len(lengths), coupled), np.inf)
    left = np.arange(len(lengths))
    level = 1 + max(0, coupled - 6) // (2 * n)
    for more in range(LEVELS):
        problem = reduced(rods, lengths[left], vectors[left], elements, level + more)
        if problem is None:
            break
        if 6 + problem.poles.shape[1] < coupled:
            continue
        found, good = _solve(problem, rods, elements, coupled)
        values[left[good]] = found[good]
        left = left[~good]
        if not left.size:
            break
    for i in left:
        one = Characteristic(rods, lengths[i], vectors[i].reshape(n, 3, 6), elements)
        values[i] = one.coupled(coupled).mean(axis=1)
    torsion = torsion_eigenvalues(rods, lengths, 1, elements)[..., 0]
    if coupled == count and torsion.min() > values.max():
        return values
    torsion = torsion_eigenvalues(rods, lengths, count, elements).reshape(len(lengths), -1)
    return np.sort(np.concatenate([values, torsion], axis=1), axis=1)[:, :count]


def _solve(
    problem: Reduced, rods: Sections, elements: int | None, count: int
) -> tuple[Floats, NDArray[np.bool_]]:
    """Return omega^2 (N, count), and where they are certain to be the lowest, (N,)."""
    # A chord of P from zero to the softest limb's first mode: right where modes are wanted.
    N = len(problem.lengths)
    end = np.minimum(problem.poles.min(axis=1), problem.limit)[:, None]
    ends = problem.smooth(np.concatenate([np.zeros((N, 1)), end], axis=1))
    P, slope = ends[:, 0], (ends[:, 1] - ends[:, 0]) / end
    fast = compiled()
    if fast is None:
        start, motion = problem.pencil(P, slope)
        found, settled = corrected(problem, P, slope, start, motion, count)
    else:
        start, found = np.empty((N, 6 + problem.poles.shape[1])), np.empty((N, count))
        settled = np.empty(N, dtype=bool)
        arrays = (problem.poles, problem.residues, problem.owner, problem.powers, problem.caps)
        fast(problem.vectors, P, slope, *arrays, CONVERGED, start, found, settled)
    found = np.where(settled[:, None], found, start[:, :count])
    inside = found[:, -1] * (1 + CLOSE) < problem.limit
    inside &= found[:, 0] > GRADED * start[:, -1]
    poor = inside & ~settled
    if poor.any():
        found[poor] = _by_rank(problem[poor], start[poor, :count])
    good = inside & _counted(problem, rods, elements, found)
    return found, good


@np.errstate(divide="ignore", invalid="ignore", over="ignore")
def corrected(
    problem: Reduced, P: Floats, slope: Floats, start: Floats, motion: Floats, count: int
) -> tuple[Floats, NDArray[np.bool_]]:
    """Correct the lowest `start` values for the curvature of P; also say where that converged.

    In the basis of the start's vectors the matrix is diag(start) - lambda + V^T rho(lambda) V,
    with rho small: y_j = -(V^T rho V y)_j / (start_j - lambda), and lambda by Rayleigh's quotient.
    Repeated modes may divide zero by zero; they do not settle.
    """
    lowest = start[:, :count]
    limit = problem.limit[:, None]
    transposed = np.ascontiguousarray(motion.swapaxes(1, 2))
    x, value = transposed[:, :count], lowest
    own = np.arange(count)
    gap = start[:, None, :] - lowest[..., None]
    slower = np.zeros_like(lowest)
    before: tuple[Floats, Floats] | None = None
    for _ in range(4):
        rho = (
            problem.smooth(np.minimum(value, limit))
            - P[:, None]
            - slope[:, None] * value[..., None]
        )
        difference = gap + (lowest - value)[..., None]
        difference[:, own, own] = 1.0
        y = -((rho * x) @ motion) / difference
        y[:, own, own] = 1.0
        x = y @ transposed
        norm = (y * y).sum(axis=-1)
        quotient = ((y * y * gap).sum(axis=-1) + (rho * x * x).sum(axis=-1)) / norm
        answer = lowest + quotient
        change = np.abs(answer - value) / np.abs(answer)
        settled = (change.max(axis=1) < CONVERGED) & (norm.max(axis=1) < 1.01)
        # The quotient is all but linear in lambda: a secant finds where it meets the diagonal.
        if before is not None:
            step = value - before[0]
            np.divide(answer - before[1], step, out=slower, where=np.abs(step) > 1e-8 * value)
            slower[np.abs(slower) > 0.5] = 0.0
        before = value, answer
        value = value + (answer - value) / (1 - slower)
        if settled.all():
            break
    return value, settled


def _by_rank(problem: Reduced, guess: Floats) -> Floats:
    """Return the roots by rank: the k-th eigenvalue of the matrix frozen at the k-th root itself.

    Newton's iteration on each, safe for roots that (nearly) repeat.
    """
    value, limit = guess.copy(), problem.limit
    for k in range(guess.shape[1]):
        for _ in range(8):
            here = np.minimum(value[:, k], limit)[:, None]
            P, slope = _tangent(problem, here)
            previous = value[:, k].copy()
            value[:, k] = problem.pencil(P, slope)[0][:, k]
            if (np.abs(value[:, k] - previous) < CONVERGED * value[:, k]).all():
                break
    return value


def _tangent(problem: Reduced, eigenvalue: Floats) -> tuple[Floats, Floats]:
    """Return P_k(0) and slope of the tangent of P_k at `eigenvalue` (N, 1), each (N, 3 n)."""
    t = 2 * eigenvalue / problem.caps - 1
    k = np.arange(problem.powers.shape[-1])
    P = (problem.powers * t[..., None] ** k).sum(axis=-1)
    slope = (problem.powers[..., 1:] * k[1:] * t[..., None] ** k[:-1]).sum(axis=-1)
    slope *= 2 / problem.caps
    return P - slope * eigenvalue, slope


def _counted(
    problem: Reduced, rods: Sections, elements: int | None, found: Floats
) -> NDArray[np.bool_]:
    """Say where the last root has the rank it should have among the exact limbs' modes, (N,).

    As many modes below it as were found proves that none was missed, for those found differ: their
    vectors are all but orthogonal. Where it repeats and more lie below, fewer must lie just before.
    """
    count = found.shape[1]
    good = _below(problem, rods, elements, found[:, -1] * (1 + 1e-8)) - count
    for i in np.flatnonzero(good > 0):
        one = problem[i : i + 1]
        before = _below(one, rods, elements, found[i : i + 1, -1] * (1 - 1e-8))
        good[i] = 0 if before[0] < count else 1
    return np.asarray(good == 0)


def _below(
    problem: Reduced, rods: Sections, elements: int | None, eigenvalue: Floats
) -> NDArray[np.int64]:
    """Return how many modes lie below `eigenvalue` (N,), torsion apart: Wittrick and Williams."""
    d = limb_stiffness(rods, problem.lengths, eigenvalue[:, None], elements).real
    a = problem.vectors
    D = (a * d.reshape(len(d), -1, 1)).swapaxes(1, 2) @ a
    D -= eigenvalue[:, None, None] * np.eye(6)
    held = (problem.poles < eigenvalue[:, None]).sum(axis=1)
    return np.asarray(held + (np.linalg.eigvalsh(D) < 0).sum(axis=1))
