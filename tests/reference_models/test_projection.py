"""The null-space projection against closed forms of constrained systems."""

import numpy as np
import pytest
import scipy.linalg

from analytic import InputError
from reference_models.projection import constrained_modes, null_space


def chain(masses: int, stiffness: float = 400.0, mass: float = 0.3) -> tuple[np.ndarray, ...]:
    """A chain of masses between two more, one at each end, which constraints are to hold."""
    n = masses + 2
    K = stiffness * (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    K[0, 0] = K[-1, -1] = stiffness
    J = np.zeros((2, n))
    J[0, 0] = J[1, -1] = 1.0
    k = np.arange(1, masses + 1)
    omega = 2 * np.sqrt(stiffness / mass) * np.sin(k * np.pi / (2 * (masses + 1)))
    return K, mass * np.eye(n), J, omega / (2 * np.pi)


def test_chain_of_springs_between_held_ends() -> None:
    K, M, J, expected = chain(7)
    frequencies, shapes, free = constrained_modes("chain", K, M, J, 7)
    assert free == 7
    np.testing.assert_allclose(frequencies, expected, rtol=1e-12)
    np.testing.assert_allclose(shapes.T @ M @ shapes, np.eye(7), atol=1e-12)
    np.testing.assert_allclose(J @ shapes, 0, atol=1e-14)


def test_physical_pendulum_on_a_spring() -> None:
    # Centre of mass a distance l from the pivot, coordinates x, y, angle: w^2 = k / (I + m l^2).
    m, inertia, length, k = 2.5, 0.4, 0.7, 90.0
    J = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, -length]])
    M, K = np.diag([m, m, inertia]), np.diag([0.0, 0.0, k])
    (frequency,), shape, free = constrained_modes("chain", K, M, J, 1)
    moment = inertia + m * length**2
    assert free == 1
    assert frequency == pytest.approx(np.sqrt(k / moment) / (2 * np.pi), rel=1e-13)
    np.testing.assert_allclose(
        np.abs(shape[:, 0]), np.array([0, length, 1]) / np.sqrt(moment), atol=1e-14
    )


@pytest.mark.parametrize("units", [1e-5, 1.0, 1e5])
def test_redundant_rescaled_and_empty_constraints_change_nothing(units: float) -> None:
    K, M, J, expected = chain(5)
    noise = np.full(J.shape[1], 1e-18)
    total, difference = J[0] + J[1], J[0] - J[1]
    more = np.vstack([units * total, difference / units, total, np.zeros_like(noise), noise])
    frequencies, _, free = constrained_modes("chain", K, M, more, 5)
    assert free == 5
    np.testing.assert_allclose(frequencies, expected, rtol=1e-12)


def test_without_constraints_all_is_free() -> None:
    K, M, _, _ = chain(4)
    frequencies, _, free = constrained_modes("chain", K, M, np.zeros((0, 6)), 6)
    assert free == 6
    # Free ends: w_k = 2 sqrt(k/m) sin(k pi / 2n), the first the rigid motion.
    expected = np.sqrt(400 / 0.3) * np.sin(np.arange(6) * np.pi / 12) / np.pi
    np.testing.assert_allclose(frequencies, expected, rtol=1e-12, atol=1e-6)


def test_more_modes_than_coordinates_are_refused() -> None:
    K, M, J, _ = chain(3)
    with pytest.raises(InputError, match="count = 4: expected at most 3"):
        constrained_modes("chain", K, M, J, 4)
    with pytest.raises(InputError, match="at most 0"):
        constrained_modes("chain", K, M, np.eye(5), 1)
    for count in (0, -1, 2.5, True):
        with pytest.raises(InputError, match="count"):
            constrained_modes("chain", K, M, J, count)  # type: ignore[arg-type]


@pytest.mark.parametrize("seed", range(30))
def test_the_basis_is_orthonormal_and_complete(seed: int) -> None:
    random = np.random.default_rng(seed)
    rows, columns = random.integers(1, 15, 2)
    J = random.normal(size=(rows, columns)) * (random.random((rows, columns)) < 0.2)
    J = np.vstack([J, random.normal(size=(2, rows)) @ J]) * random.uniform(0.1, 10, (rows + 2, 1))
    N = null_space(J).toarray()
    assert N.shape == (columns, columns - np.linalg.matrix_rank(J))
    np.testing.assert_allclose(J @ N, 0, atol=1e-12)
    np.testing.assert_allclose(N.T @ N, np.eye(N.shape[1]), atol=1e-12)


def test_separate_joints_keep_the_basis_sparse() -> None:
    # Forty bodies of seven coordinates, each with one constraint of its own: 6 free each.
    J = np.kron(np.eye(40), np.random.default_rng(3).normal(size=(1, 7)))
    N = null_space(J)
    assert N.shape == (280, 240)
    assert N.nnz <= 40 * 7 * 6


def test_a_free_motion_that_rounding_makes_stiff_spoils_no_other() -> None:
    """K of a limb that spins may pass for definite: one omega^2 of 1e-13 beside those from 1 on."""
    n = 12
    K = np.diag(np.r_[1e-13, np.arange(1.0, n)])
    M = np.eye(n) + 0.3 * np.ones((n, n))
    known = scipy.linalg.eigh(K, M, eigvals_only=True)
    found, _, _ = constrained_modes("m", K, M, np.zeros((0, n)), 5)
    np.testing.assert_allclose((2 * np.pi * found[1:]) ** 2, known[1:5], rtol=1e-12)
    assert found[0] < 1e-5
