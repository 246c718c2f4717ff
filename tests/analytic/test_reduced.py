"""Signs of eigenvalues by elimination: those of the eigenvalues themselves."""

import numpy as np

from analytic.reduced import negative


def test_negative_eigenvalues_are_counted() -> None:
    random = np.random.default_rng(4)
    for size in (1, 2, 6):
        D = random.standard_normal((2000, size, size)) * 10 ** random.uniform(-3, 9, (2000, 1, 1))
        D = D + D.swapaxes(1, 2)
        np.testing.assert_array_equal(negative(D), (np.linalg.eigvalsh(D) < 0).sum(axis=1))


def test_pivots_that_vanish() -> None:
    """Zero on the diagonal, or all but: elimination down it fails, eigenvalues do not."""
    for small in (0.0, 1e-18, -1e-18):
        D = np.array([[[small, 1.0], [1.0, small]], [[small, 1.0], [1.0, -3.0]], np.eye(2)])
        np.testing.assert_array_equal(negative(D), [1, 1, 0])


def test_entries_that_grow_are_not_believed() -> None:
    """After a pivot of 1e-20 nothing is left of the other entries; pivoting would keep them."""
    D = np.array([[[1e-20, 1, 1], [1, 1, 0], [1, 0, c]] for c in (-5.0, -1.5, -0.5, 0.5, 5.0)])
    wanted = (np.linalg.eigvalsh(D) < 0).sum(axis=1)
    np.testing.assert_array_equal(negative(D), wanted)
