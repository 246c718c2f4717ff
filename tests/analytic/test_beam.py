"""Elements against the published closed forms, entry by entry, and against closed-form beams."""

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st

from analytic import STATIONS, Material, Rod, Theory
from analytic.beam import centre_lines, strains
from analytic.rod_elements import Properties, element_matrices, properties

THEORIES = ["euler-bernoulli", "rayleigh", "timoshenko"]
XZ, YZ = [0, 4, 6, 10], [1, 3, 7, 9]
SIGNS = np.array([1, -1, 1, -1])

materials = st.builds(
    lambda young, nu, density: Material(young, young / (2 * (1 + nu)), density),
    st.floats(1e9, 4e11),
    st.floats(-0.3, 0.45),
    st.floats(500, 2e4),
)
rods = st.builds(Rod, materials, st.floats(1e-3, 0.5))


def alone(rod: Rod, theory: Theory) -> Properties:
    return properties([rod], theory)


def element(rod: Rod, length: float, theory: Theory) -> np.ndarray:
    own, h = alone(rod, theory), np.array([length])
    found = element_matrices(own, h)
    # Of rods that bend alike in every direction, said once.
    again = element_matrices(own.alike(), h)
    np.testing.assert_allclose(again, found, rtol=1e-14, atol=1e-14 * np.abs(found).max())
    return found[:, 0]


def przemieniecki(rod: Rod, length: float, theory: Theory) -> tuple[np.ndarray, np.ndarray]:
    """Bending K and M of Przemieniecki (1968), Sections 5.6 and 11.4, typed from his tables."""
    E, rho, A, I = (  # noqa: E741
        rod.material.young,
        rod.material.density,
        rod.area,
        rod.second_moment,
    )
    L = length
    p = theory.shear_flexibility(rod) / L**2
    K = (
        E * I / ((1 + p) * L**3)
        * np.array([
            [12, 6 * L, -12, 6 * L],
            [6 * L, (4 + p) * L**2, -6 * L, (2 - p) * L**2],
            [-12, -6 * L, 12, -6 * L],
            [6 * L, (2 - p) * L**2, -6 * L, (4 + p) * L**2],
        ])
    )  # fmt: skip
    a = 13 / 35 + 7 * p / 10 + p**2 / 3
    b = 9 / 70 + 3 * p / 10 + p**2 / 6
    c = (11 / 210 + 11 * p / 120 + p**2 / 24) * L
    d = (13 / 420 + 3 * p / 40 + p**2 / 24) * L
    e = (1 / 105 + p / 60 + p**2 / 120) * L**2
    f = (1 / 140 + p / 60 + p**2 / 120) * L**2
    M = (
        rho * A * L / (1 + p) ** 2
        * np.array([[a, c, b, -d], [c, e, d, -f], [b, d, a, -c], [-d, -f, -c, e]])
    )  # fmt: skip
    if theory.rotary_inertia:
        g, h = 6 / 5, (1 / 10 - p / 2) * L
        j = (2 / 15 + p / 6 + p**2 / 3) * L**2
        k = (-1 / 30 - p / 6 + p**2 / 6) * L**2
        M = M + rho * I / ((1 + p) ** 2 * L) * np.array(
            [[g, h, -g, h], [h, j, -h, k], [-g, -h, g, -h], [h, k, -h, j]]
        )
    return K, M


@pytest.mark.parametrize("beam", THEORIES)
@given(rod=rods, length=st.floats(0.01, 3.0))
def test_every_entry(beam: str, rod: Rod, length: float) -> None:
    theory = Theory(beam)
    K, M = element(rod, length, theory)
    bending = przemieniecki(rod, length, theory)
    E, G, rho = rod.material.young, rod.material.shear, rod.material.density
    bar, shaft = np.array([[1, -1], [-1, 1]]) / length, np.array([[2, 1], [1, 2]]) * length / 6
    expected = np.zeros((2, 12, 12))
    for kind, (stiff, heavy) in enumerate(
        ((E * rod.area * bar, G * rod.polar_moment * bar),
         (rho * rod.area * shaft, rho * rod.polar_moment * shaft))
    ):  # fmt: skip
        expected[kind][np.ix_(XZ, XZ)] = bending[kind]
        expected[kind][np.ix_(YZ, YZ)] = bending[kind] * np.outer(SIGNS, SIGNS)
        expected[kind][np.ix_([2, 8], [2, 8])] = stiff
        expected[kind][np.ix_([5, 11], [5, 11])] = heavy
    for found, wanted in zip((K, M), expected, strict=True):
        # Entries differ in unit by a power of the length: scale before comparing.
        scale = np.sqrt(np.outer(np.diag(wanted), np.diag(wanted)))
        np.testing.assert_allclose(found / scale, wanted / scale, rtol=0, atol=2e-13)


@pytest.mark.parametrize("beam", THEORIES)
@given(rod=rods, length=st.floats(0.01, 3.0))
def test_rigid_motion_costs_nothing_and_weighs_all(beam: str, rod: Rod, length: float) -> None:
    theory = Theory(beam)
    K, M = element(rod, length, theory)
    mass = rod.material.density * rod.area * length
    moves = np.zeros((6, 12))
    for k in range(3):
        moves[k, [k, 6 + k]] = 1  # translation
        moves[3 + k, [3 + k, 9 + k]] = 1  # rotation about the first node
    moves[3, 7], moves[4, 6] = -length, length
    scale = np.sqrt(np.diag(K))
    # Rounding is that of K's own entries: a short element is far stiffer in shear than in bending.
    assert np.abs(moves @ (K / scale)).max() <= 1e-11 * np.abs(scale).max()
    inertia = moves @ M @ moves.T
    np.testing.assert_allclose(np.diag(inertia)[:3], mass, rtol=1e-12)
    section = rod.material.density * rod.second_moment * length if theory.rotary_inertia else 0.0
    np.testing.assert_allclose(inertia[4, 4], mass * length**2 / 3 + section, rtol=1e-12)
    np.testing.assert_allclose(inertia[5, 5], mass * rod.diameter**2 / 8, rtol=1e-12)


def cantilever(rod: Rod, length: float, elements: int, theory: Theory) -> np.ndarray:
    size = 6 * (elements + 1)
    K, M = np.zeros((size, size)), np.zeros((size, size))
    k, m = element(rod, length / elements, theory)
    for e in range(elements):
        part = slice(6 * e, 6 * e + 12)
        K[part, part] += k
        M[part, part] += m
    return np.sqrt(scipy.linalg.eigh(K[6:, 6:], M[6:, 6:], eigvals_only=True))


def test_cantilever_against_closed_forms() -> None:
    steel = Material(200e9, 77e9, 7820)
    rod, length = Rod(steel, 0.02), 1.0
    omega = cantilever(rod, length, 24, Theory())
    wave = np.sqrt(steel.young * rod.second_moment / (steel.density * rod.area))
    roots = np.array([1.875104068711961, 4.694091132974175, 7.854757438237613])
    error = omega[:6:2] / (wave * roots**2) - 1
    # A cubic element's own error is (beta h)^4 / 1440 of the frequency.
    np.testing.assert_allclose(error, (roots / 24) ** 4 / 1440, rtol=0.02)
    np.testing.assert_allclose(omega[1:6:2], omega[:6:2], rtol=1e-9)
    shaft = np.pi / 2 * np.sqrt(steel.shear / steel.density)
    bar = np.pi / 2 * np.sqrt(steel.young / steel.density)
    for wanted in (shaft, bar):
        # A linear element's own error is (pi / 2 s)^2 / 24.
        assert np.abs(omega / wanted - 1).min() < 1.1 * (np.pi / 48) ** 2 / 24


def test_timoshenko_tip_deflection() -> None:
    steel = Material(200e9, 77e9, 7820)
    rod, length, theory = Rod(steel, 0.1), 0.4, Theory("timoshenko", 0.9)
    K, _ = element(rod, length, theory)
    tip = np.linalg.solve(K[6:, 6:], np.eye(6)[0])[0]
    bending = length**3 / (3 * steel.young * rod.second_moment)
    shear = length / (0.9 * steel.shear * rod.area)
    assert tip == pytest.approx(bending + shear, rel=1e-12)


@pytest.mark.parametrize(("shear", "kappa"), [("0.9", 0.9), ("6/7", 6 / 7), (0.5, 0.5)])
def test_named_shear_coefficients(shear: str | float, kappa: float) -> None:
    assert Theory("timoshenko", shear).shear_coefficient(Material(200e9, 77e9, 1)) == kappa


def test_cowper() -> None:
    steel = Material(200e9, 77e9, 7820)
    assert Theory("timoshenko").shear_coefficient(steel) == pytest.approx(0.8863, abs=5e-5)
    assert Theory("timoshenko").label(steel) == "Timoshenko, kappa=0.8863"


@pytest.mark.parametrize("beam", THEORIES)
@given(data=st.data())
def test_centre_line_follows_rigid_motion(beam: str, data: st.DataObject) -> None:
    rod, length = data.draw(rods), data.draw(st.floats(0.05, 2.0))
    elements, theory = data.draw(st.integers(1, 6)), Theory(beam)
    spin = np.array(data.draw(st.tuples(*[st.floats(-1, 1)] * 3)))
    nodes = np.linspace(0, length, elements + 1)
    along = np.outer(nodes, [0, 0, 1])
    motion = np.concatenate([np.cross(spin, along), np.tile(spin, (elements + 1, 1))], axis=1)
    section, h = alone(rod, theory), np.array([length / elements])
    found = centre_lines(section, h, motion[None, ..., None])[0, ..., 0]
    wanted = np.cross(spin, np.outer(STATIONS * length, [0, 0, 1]))
    np.testing.assert_allclose(found, wanted, atol=1e-12)


@pytest.mark.parametrize("beam", THEORIES)
@given(rod=rods, length=st.floats(0.01, 3.0), data=st.data())
def test_strains_are_the_elements_energy(
    beam: str, rod: Rod, length: float, data: st.DataObject
) -> None:
    theory = Theory(beam)
    K, _ = element(rod, length, theory)
    motion = np.array(data.draw(st.lists(st.floats(-1, 1), min_size=12, max_size=12)))
    motion[[3, 4, 5, 9, 10, 11]] /= length
    e = strains(alone(rod, theory), np.array([length]), motion.reshape(1, 2, 6, 1))
    size = np.abs(motion) @ np.abs(K) @ np.abs(motion)
    np.testing.assert_allclose((e**2).sum(), motion @ K @ motion, rtol=1e-9, atol=1e-13 * size)


@pytest.mark.parametrize("beam", THEORIES)
@pytest.mark.parametrize("elements", [1, 2, 5])
def test_strains_of_rigid_motion_are_rounding(beam: str, elements: int) -> None:
    """Squared, they are far below what any mode has: K loses that as its elements get shorter."""
    rod, length, theory = Rod(Material(200e9, 77e9, 7820), 0.1), 0.5, Theory(beam)
    spin = np.array([0.3, -0.5, 0.7])
    along = np.outer(np.linspace(0, length, elements + 1), [0, 0, 1])
    motion = np.concatenate([np.cross(spin, along), np.tile(spin, (elements + 1, 1))], axis=1)
    h = np.array([length / elements])
    e = strains(alone(rod, theory), h, motion[None, ..., None])
    stiffest = rod.material.young * rod.area / h[0]
    assert (e**2).sum() < 1e-30 * stiffest
