"""Many fits at once, against scipy's one by one and against what is known exactly."""

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.stats import chi2, f

from harness.studies.identification.fit import (
    minimise,
    profile_ends,
    rise,
    search,
)

LOW, HIGH = np.full(3, -2.0), np.full(3, 2.0)
T = np.linspace(0, 3, 9)


def model(x):
    """A decay, a growth and an offset: no parameter enters linearly with another fixed."""
    return x[:, :1] * np.exp(-T * np.exp(x[:, 1:2])) + np.sin(x[:, 2:3] * T)


def data(count, seed=0, noise=0.05):
    random = np.random.default_rng(seed)
    truth = random.uniform([0.5, 0.3, 0.3], [1.5, 1.2, 0.9], (count, 3))
    return truth, model(truth) + noise * random.standard_normal((count, len(T)))


def residuals(observed):
    return lambda x, owner: model(x) - observed[owner]


def test_minima_are_those_of_scipy_bounds_among_them():
    truth, observed = data(12)
    low, high = LOW.copy(), HIGH.copy()
    high[0] = 1.0  # holds about half of the fits
    points, sums = minimise(residuals(observed), truth * 0.8, np.ones((12, 3), bool), low, high)
    held = 0
    for i, y in enumerate(observed):
        one = least_squares(
            lambda x, y=y: model(x[None])[0] - y, truth[i] * 0.6, bounds=(low, high),
            xtol=1e-12, ftol=1e-12, gtol=1e-12,
        )  # fmt: skip
        assert sums[i] == pytest.approx(2 * one.cost, rel=1e-6)
        np.testing.assert_allclose(points[i], one.x, atol=1e-4)
        held += points[i, 0] == 1.0
    assert 0 < held < 12


def test_what_is_not_free_stays():
    truth, observed = data(4)
    free = np.ones((4, 3), bool)
    free[:, 1] = False
    found, _ = minimise(residuals(observed), truth, free, LOW, HIGH)
    np.testing.assert_array_equal(found[:, 1], truth[:, 1])
    assert (found[:, [0, 2]] != truth[:, [0, 2]]).all()
    outside, _ = minimise(residuals(observed), truth + 2, free & False, LOW, HIGH)
    np.testing.assert_array_equal(outside, truth + 2)
    free[:, 1], free[:, 2] = True, False
    beside, _ = minimise(residuals(observed), truth + np.array([0, 0, 1.5]), free, LOW, HIGH)
    np.testing.assert_array_equal(beside[:, 2], truth[:, 2] + 1.5)


def test_search_leaves_the_valley_it_starts_in():
    """A wave of many minima over a slight slope: one start stays, sixteen find the lowest."""

    def wavy(x, owner):
        return np.concatenate([x - 1.3, 2 * np.sin(6 * (x - 1.3))], axis=1)

    free, low, high = np.ones((1, 1), bool), np.array([-4.0]), np.array([4.0])
    _, stuck = minimise(wavy, np.array([[-2.9]]), free, low, high)
    assert stuck[0] > 1
    found, _, reached = search(wavy, np.array([-2.9]), free, low, high, starts=16)
    assert found[0, 0] == pytest.approx(1.3, abs=1e-6)
    assert reached[0] >= 1


def test_profile_ends_of_a_linear_model_are_the_textbook_intervals():
    """Estimate +- t s sqrt(C_jj), or z sigma sqrt(C_jj) where sigma is known."""
    random = np.random.default_rng(3)
    A = random.standard_normal((9, 3))
    y = A @ [0.3, -0.4, 0.2] + 0.1 * random.standard_normal((2, 9))

    def linear(x, owner):
        return x @ A.T - y[owner]

    estimate = np.linalg.lstsq(A, y.T)[0].T
    sums = ((estimate @ A.T - y) ** 2).sum(axis=1)
    deviation = np.sqrt(np.diag(np.linalg.inv(A.T @ A)))
    heights = {
        np.sqrt(chi2.ppf(0.9, 1)) * 0.1: rise(0.9, 1, sums=sums, freedom=6, noise=0.1),
        np.sqrt(chi2.ppf(0.9, 3)) * 0.1: rise(0.9, 3, sums=sums, freedom=6, noise=0.1),
    }
    for half, height in heights.items():
        ends, opened = profile_ends(linear, estimate, sums, LOW, HIGH, height)
        np.testing.assert_allclose(
            ends[..., 1] - estimate, np.broadcast_to(half * deviation, (2, 3)), rtol=2e-3
        )
        assert not opened.any()
    # Noise from the residuals: Scheffe's factor, with s^2 = S / 6.
    height = rise(0.9, 3, sums=sums, freedom=6, noise=None)
    ends, _ = profile_ends(linear, estimate, sums, LOW, HIGH, height)
    half = np.sqrt(3 * f.ppf(0.9, 3, 6) * sums / 6)[:, None] * deviation
    np.testing.assert_allclose(estimate - ends[..., 0], half, rtol=2e-3)


def test_ends_at_a_bound_are_open_and_curved_profiles_are_followed():
    truth, observed = data(6, seed=2, noise=0.02)
    free = np.ones((6, 3), bool)
    best, sums = minimise(residuals(observed), truth, free, LOW, HIGH)
    height = rise(0.95, 1, sums=sums, freedom=6, noise=0.02)
    ends, opened = profile_ends(residuals(observed), best, sums, LOW, HIGH, height)
    assert not opened.any()
    for i, j in np.ndindex(6, 3):
        for end in ends[i, j]:
            # The definition, by scipy: S minimised over the others has risen by the height.
            others = [k for k in range(3) if k != j]

            def held(x, i=i, j=j, end=end, others=others):
                full = np.empty(3)
                full[j], full[others] = end, x
                return model(full[None])[0] - observed[i]

            S = 2 * least_squares(held, best[i, others], xtol=1e-12, ftol=1e-12).cost
            assert S - sums[i] == pytest.approx(height[i], rel=5e-3)
    narrow_low, narrow_high = best.min(axis=0) - 1e-3, best.max(axis=0) + 1e-3
    ends, opened = profile_ends(
        residuals(observed), best, sums, narrow_low, narrow_high, 1e3 * height
    )
    assert opened.all()
    np.testing.assert_allclose(ends[:, :, 1], np.broadcast_to(narrow_high, (6, 3)))
