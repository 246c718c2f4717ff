"""The limb's dynamic stiffness against assembled elements, classical roots and its own limits."""

import numpy as np
import pytest
import scipy.linalg
from scipy.optimize import brentq

from analytic import Theory
from analytic.dynamic_stiffness import fixed_tip_counts, limb_stiffness, torsion_eigenvalues
from analytic.rod_elements import element_matrices, properties
from analytic.waves import paper_rods, sections

THEORIES = [Theory("euler-bernoulli"), Theory("rayleigh"), Theory("timoshenko", 0.9)]
LENGTHS = np.array([0.45, 0.5, 0.55])
# Degrees of freedom of a node, those free at the base, and the one driven at the tip.
DIRECTIONS = (((0, 4), (4,), 0), ((1, 3), (), 1), ((2,), (), 2), ((5,), (), None))


def theories():
    return pytest.mark.parametrize("theory", THEORIES, ids=lambda t: t.beam)


def assembled(rods, length, s):
    K, M = np.zeros((2, 6 * (s + 1), 6 * (s + 1)))
    K_e, M_e = element_matrices(rods, np.full(3, length / s))[:, 0]
    for j in range(s):
        K[6 * j : 6 * j + 12, 6 * j : 6 * j + 12] += K_e
        M[6 * j : 6 * j + 12, 6 * j : 6 * j + 12] += M_e
    return K, M


def driven_and_held(K, M, s, eigenvalue):
    """Condense assembled elements onto the tip; count their modes with the tip held."""
    stiffness, counts = [], []
    for components, free, driven in DIRECTIONS:
        dofs = [6 * j + c for j in range(s + 1) for c in components if j or c in free]
        tip = None if driven is None else 6 * s + driven
        rest = [dof for dof in dofs if dof != tip]
        own = np.ix_(rest, rest)
        held = scipy.linalg.eigh(K[own], M[own], eigvals_only=True) if rest else np.zeros(0)
        counts.append((held < eigenvalue).sum())
        if tip is not None:
            D = K - eigenvalue * M
            inner = np.linalg.solve(D[own], D[rest, tip]) if rest else np.zeros(0)
            stiffness.append(D[tip, tip] - D[tip, rest] @ inner)
    return stiffness, counts


@theories()
@pytest.mark.parametrize("s", [1, 2, 3, 7])
def test_equals_assembled_elements(robot, theory, s):
    rods = sections(robot, theory)
    K, M = assembled(properties(paper_rods(robot), theory), LENGTHS[0], s)
    # To ten times the first cut-on frequency, through all families of the chain.
    for eigenvalue in np.geomspace(1e4, 1e12, 25):
        stiffness, counts = driven_and_held(K, M, s, eigenvalue)
        d = limb_stiffness(rods, LENGTHS, np.array([eigenvalue]), s)[0]
        np.testing.assert_allclose(d.real, stiffness, rtol=1e-8)
        np.testing.assert_allclose(d.imag, 0, atol=1e-9 * np.abs(d.real).max())
        assert fixed_tip_counts(rods, LENGTHS, np.array([eigenvalue]), s)[0].tolist() == counts


@theories()
@pytest.mark.parametrize("frequency", [50.0, 700.0, 3000.0])
def test_elements_converge_to_the_continuum(robot, theory, frequency):
    rods, lam = sections(robot, theory), np.array([(2 * np.pi * frequency) ** 2])
    exact = limb_stiffness(rods, LENGTHS, lam, None).real
    errors = [
        np.abs(limb_stiffness(rods, LENGTHS, lam, s).real / exact - 1).max(axis=0)
        for s in (64, 128)
    ]
    order = np.log2(errors[0] / errors[1])
    bending = 2.0 if theory.beam == "timoshenko" else 4.0
    assert order[2] == pytest.approx(2.0, abs=0.02)
    if bending == 2.0:
        assert order[:2] == pytest.approx([2.0, 2.0], abs=0.05)
    else:
        # Down to rounding: 128 elements are off by less than 1e-8.
        assert (errors[1][:2] < 1e-6).all()
        assert (order[:2] > 3.5).all() or (errors[1][:2] < 1e-10).all()


def test_many_elements_lose_no_digits(robot):
    rods, lam = sections(robot, THEORIES[0]), np.array([(2 * np.pi * 300.0) ** 2])
    exact = limb_stiffness(rods, LENGTHS, lam, None).real[:, :2]
    # h^4 is beyond rounding here: what is left is the rounding of the closed form itself.
    many = limb_stiffness(rods, LENGTHS, lam, 4096).real[:, :2]
    np.testing.assert_allclose(many, exact, rtol=1e-11)


def test_classical_roots(robot):
    """Pinned-pinned beams (n pi)^4, clamped-pinned tan x = tanh x, and quarter waves."""
    rods = sections(robot, THEORIES[0])
    unit = (rods.EI / rods.line_mass / LENGTHS**4)[0]
    across = [
        brentq(lambda x: np.sin(x) - np.cos(x) * np.tanh(x), n * np.pi, (n + 0.5) * np.pi)
        for n in (1, 2, 3)
    ]
    bar = np.pi**2 * rods.axial_speed2[0] / LENGTHS[0] ** 2
    shaft = np.pi**2 * rods.torsion_speed2[0] / LENGTHS[0] ** 2
    roots = [
        [unit * (n * np.pi) ** 4 for n in (1, 2, 3)],
        [unit * x**4 for x in across],
        [bar * n**2 for n in (1, 2, 3)],
        [shaft * (n - 0.5) ** 2 for n in (1, 2, 3)],
    ]
    for direction, of_direction in enumerate(roots):
        for below, root in enumerate(of_direction):
            near = root * np.array([1 - 1e-11, 1 + 1e-11])
            counts = fixed_tip_counts(rods, LENGTHS, near[:, None], None)[:, 0, direction]
            assert counts.tolist() == [below, below + 1]
    torsion = torsion_eigenvalues(rods, LENGTHS, 3, None)
    np.testing.assert_allclose(torsion[0], roots[3], rtol=1e-14)


def test_both_sides_of_the_cut_on_frequency(robot):
    """Timoshenko's second family starts with the shear mode; finite elements count the same."""
    theory = THEORIES[2]
    rods = sections(robot, theory)
    cut_on = (12 * rods.EI / rods.flexibility / rods.line_inertia)[0]
    near = cut_on * np.array([0.5, 1 - 1e-10, 1 + 1e-10, 2.0])
    counts = fixed_tip_counts(rods, LENGTHS, near[:, None], None)[:, 0]
    assert (counts[2] - counts[1]).tolist() == [1, 0, 0, 0]
    fine = fixed_tip_counts(rods, LENGTHS, near[[0, 3], None], 600)[:, 0]
    np.testing.assert_array_equal(fine, counts[[0, 3]])
    exact, coarse, finer = (
        limb_stiffness(rods, LENGTHS, near[[0, 3], None], s).real for s in (None, 3000, 6000)
    )
    order = np.log2(np.abs(coarse / exact - 1) / np.abs(finer / exact - 1))
    np.testing.assert_allclose(order, 2, atol=0.1)


@theories()
def test_nothing_overflows(robot, theory):
    rods = sections(robot, theory)
    for s in (None, 3):
        d = limb_stiffness(rods, LENGTHS * 100, np.array([[1e-3], [1e9], [1e15]]), s)
        assert np.isfinite(d).all()


@theories()
@pytest.mark.parametrize("s", [None, 1, 3])
def test_complex_step_is_the_derivative(robot, theory, s):
    rods, h = sections(robot, theory), 1e-5
    for lam in (np.array([2e5]), np.array([1.2e7]), np.array([1e9])):
        d = limb_stiffness(rods, LENGTHS, lam * (1 + 1e-30j), s)
        plus, minus = (limb_stiffness(rods, LENGTHS, lam * (1 + e), s).real for e in (h, -h))
        np.testing.assert_allclose(d.imag * 1e30, (plus - minus) / (2 * h), rtol=2e-5)
        d = limb_stiffness(rods, LENGTHS * (1 + 1e-30j), lam, s)
        plus, minus = (limb_stiffness(rods, LENGTHS * (1 + e), lam, s).real for e in (h, -h))
        np.testing.assert_allclose(d.imag * 1e30, (plus - minus) / (2 * h), rtol=5e-5)
