"""Pieces of equal elements, condensed onto their ends."""

import mpmath
import numpy as np
import pytest

from analytic import Material, Rod, Section
from analytic.rod_elements import AXIAL, BENDING, bending_numbers, properties
from analytic.rod_exact import dynamic_stiffness, pieces
from analytic.theory import Theory

ROD = Rod(Material(200e9, 77e9, 7820), Section(2e-3, (3e-7, 9e-7), 4e-7, (0.7, 0.85)))
LENGTH = np.array([0.5])


def high(theory: Theory) -> float:
    """Return omega^2 just below where a piece would be cut."""
    lam = 1.0
    while pieces(properties([ROD], theory), LENGTH, 1.1 * lam) == 1:
        lam *= 1.1
    return lam


def condensed(plane: int, theory: Theory, lam: float, elements: int) -> mpmath.matrix:
    """Return D of bending over (w, theta) of the ends, node after node left out in 60 digits."""
    of, h = properties([ROD], theory), mpmath.mpf(LENGTH[0]) / elements
    EI, mass = mpmath.mpf(of.EI[0, plane]), mpmath.mpf(of.mass[0])
    numbers = bending_numbers(12 * of.shear[0, plane] / h**2, of.rotary[0, plane] / (mass * h**2))
    pair = [
        mpmath.matrix([[p, q, t, v], [q, r, -v, y], [t, -v, p, -q], [v, y, -q, r]])
        for p, q, t, v, r, y in numbers
    ]
    unit = mpmath.diag([1, h, 1, h])
    E = unit * (pair[0] * EI / h**3 - lam * mass * h * pair[1]) * unit
    D = E.copy()
    for _ in range(elements - 1):
        middle = (D[2:, 2:] + E[:2, :2]) ** -1
        both = mpmath.zeros(4)
        both[:2, :2] = D[:2, :2] - D[:2, 2:] * middle * D[2:, :2]
        both[:2, 2:] = -D[:2, 2:] * middle * E[:2, 2:]
        both[2:, :2] = both[:2, 2:].T
        both[2:, 2:] = E[2:, 2:] - E[2:, :2] * middle * E[:2, 2:]
        D = both
    return D


@pytest.mark.parametrize("elements", [2, 3, 16, 200])
@pytest.mark.parametrize("beam", ["euler-bernoulli", "timoshenko"])
def test_a_piece_is_its_elements_condensed(beam: str, elements: int) -> None:
    theory = Theory(beam)
    with mpmath.workdps(60):
        for lam in (high(theory), 1.0):
            D = dynamic_stiffness(properties([ROD], theory), LENGTH, np.array([lam]), elements)
            for plane, (dofs, sign) in enumerate(BENDING):
                found = D[0, 0][np.ix_(dofs, dofs)] * np.outer(sign, sign)
                known = condensed(plane, theory, lam, elements)
                size = np.sqrt(np.abs(np.outer(np.diag(found), np.diag(found))))
                away = np.array((known - mpmath.matrix(found)).tolist(), dtype=float)
                assert np.abs(away / size).max() < 1e-13


@pytest.mark.parametrize(("dofs", "order"), [(BENDING[0][0], 4), (AXIAL, 2)])
def test_pieces_of_many_elements_tend_to_the_exact_rod(dofs: tuple[int, ...], order: int) -> None:
    """By h^4 for Euler and Bernoulli's beam, whose elements' own omega^2 err so; the bar by h^2."""
    theory = Theory()
    rods, lam = properties([ROD], theory), np.array([high(theory)])
    exact, *found = (dynamic_stiffness(rods, LENGTH, lam, m)[0, 0] for m in (None, 8, 16))
    errors = [np.abs((D - exact)[np.ix_(dofs, dofs)]).max() for D in found]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.1)


@pytest.mark.parametrize("elements", [1, 2, 3, 5, 7, 16, 64])
def test_pieces_of_elements_are_no_longer_than_those_of_a_rod(elements: int) -> None:
    rods = properties([ROD], Theory("timoshenko"))
    for omega2 in (1e6, 1e9, 1e11):
        exact, n = (pieces(rods, LENGTH, omega2, s) for s in (None, elements))
        most = -(-elements // n)
        assert 0 < elements - (n - 1) * most <= most
        assert most == 1 or most / elements <= 1 / exact
