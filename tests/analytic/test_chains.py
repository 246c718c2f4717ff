"""Limbs of any chain: given values, closed forms, elements against none, what is refused."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from analytic import (
    Body,
    Continuum,
    Freedom,
    InputError,
    Joint,
    Limb,
    Link,
    Material,
    Mechanism,
    Multipliers,
    NotCertifiedError,
    Platform,
    Pose,
    Rod,
    Section,
    Substructure,
)
from analytic.chain_models import element_modes, exact_modes, multiplier_modes
from analytic.exact_chain import exact
from analytic.rod_elements import element_matrices, properties, shear_coefficients
from analytic.rod_exact import dynamic_stiffness, pieces
from analytic.stiffness import stiffness
from analytic.theory import Theory
from harness.case_file import load_cases

STEEL = Material(200e9, 77e9, 7820)
PLATE = Platform.disc(0.2, 0.02, 7820)
CASES = load_cases(
    Path(__file__).parents[2] / "results" / "published" / "mechanisms.toml",
)
GIVEN = """
rps|euler-bernoulli|124.665975 149.507123 241.043346 720.339940 894.736495 947.888615 1222.737178 1448.755661
rps|rayleigh|124.331897 149.100684 240.035562 711.940140 881.782704 933.922035 1198.583680 1435.724264
rps|timoshenko|123.007035 147.184205 236.520412 691.177267 850.021926 895.309441 1115.478977 1309.175531
rps|euler-bernoulli@3|124.667479 149.509792 241.055479 720.930237 895.507884 948.818850 1225.045997 1465.356718
rps|timoshenko@3|123.014076 147.196470 236.577499 693.496888 853.434509 899.376787 1123.332880 1320.310665
hexapod|euler-bernoulli|84.846150 90.546425 105.981168 111.194901 113.297922 113.569221 114.741202 116.560692
hexapod|rayleigh|84.793589 90.476565 105.818380 110.995922 113.094588 113.365117 114.534654 116.344887
hexapod|timoshenko|84.728146 90.381323 105.564671 110.681190 112.769663 113.038185 114.201255 115.993498
hexapod|euler-bernoulli@3|84.847796 90.548734 105.986696 111.201592 113.304521 113.575797 114.747691 116.567326
hexapod|timoshenko@3|84.731458 90.385987 105.576000 110.694951 112.783554 113.052097 114.215226 116.007997
prs|euler-bernoulli|27.301282 29.958389 51.306234 334.828142 356.337482 371.605427 413.282037 419.728724
prs|rayleigh|27.296324 29.952892 51.291281 334.744081 356.185028 371.463455 411.759943 418.205606
prs|timoshenko|27.177342 29.821969 51.060146 334.129302 355.165413 370.574001 405.235965 411.916208
prs|euler-bernoulli@3|27.301295 29.958406 51.306347 334.865724 356.394844 371.658086 413.590774 420.032128
prs|timoshenko@3|27.177382 29.822020 51.060481 334.230321 355.327746 370.725421 406.080937 412.722225
"""  # noqa: E501  a table of an oracle that shares no code with this package
ROWS = [line.split("|") for line in GIVEN.strip().splitlines()]


@pytest.mark.parametrize(("name", "model", "values"), ROWS, ids=[f"{r[0]}-{r[1]}" for r in ROWS])
def test_values_of_another_implementation_are_met(name: str, model: str, values: str) -> None:
    """To the last digit printed, with elements and without, by the code for chains."""
    case, (beam, _, elements) = CASES[name], model.partition("@")
    found = (
        element_modes(case.mechanism, case.pose, Theory(beam), int(elements), 8)
        if elements
        else exact_modes(case.mechanism, case.pose, Theory(beam), 8)
    )
    expected = [float(value) for value in values.split()]
    assert found.frequencies == pytest.approx(expected, rel=0, abs=6e-7)


def richardson(mechanism: Mechanism, pose: Pose, beam: str, count: int, s: int = 4) -> np.ndarray:
    """Return the limit of s, 2 s and 4 s elements, whose errors go with h^2 and h^4."""
    one, two, four = (
        Substructure(k * s, beam).frequencies(mechanism, pose, count) for k in (1, 2, 4)
    )
    return (16 * (4 * four - two) - (4 * two - one)) / 45


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(CASES))
def test_elements_converge_to_the_model_without(name: str) -> None:
    case = CASES[name]
    found = Continuum("timoshenko").modes(case.mechanism, case.pose, 8).frequencies
    assert richardson(case.mechanism, case.pose, "timoshenko", 8) == pytest.approx(found, rel=1e-6)


@pytest.mark.parametrize("solver", ["null-space", "saddle-point"])
@pytest.mark.parametrize("name", sorted(CASES))
def test_free_bodies_with_multipliers_agree(name: str, solver: str) -> None:
    """All motions and constraints of joints give what independent coordinates give."""
    mechanism, pose = CASES[name].mechanism, CASES[name].pose
    mine = element_modes(mechanism, pose, Theory("timoshenko"), 2, 8)
    its = multiplier_modes(mechanism, pose, Theory("timoshenko"), 2, solver, 8)
    assert its.frequencies == pytest.approx(mine.frequencies, rel=1e-9)
    gaps = np.diff(mine.frequencies) / mine.frequencies[1:]
    if gaps.min() > 1e-4:  # shapes of repeated modes are a choice
        size = np.abs(mine.limbs).max()
        assert np.abs(its.limbs) == pytest.approx(np.abs(mine.limbs), rel=0, abs=1e-6 * size)


def test_multipliers_of_chains_say_what_they_cannot_take() -> None:
    case = CASES["hexapod"]
    with pytest.raises(InputError, match="revolute"):
        Multipliers(2, base="free").modes(case.mechanism, case.pose)
    with pytest.raises(InputError, match="3000"):
        Multipliers(100).modes(case.mechanism, case.pose)


def test_the_papers_limbs_are_a_case_of_chains() -> None:
    """The code for chains gives what the code for R-P-S limbs gives: to rounding."""
    robot, pose = Mechanism.paper(), Pose(0.49, 0.3, -0.2)
    for beam in ("euler-bernoulli", "rayleigh", "timoshenko"):
        theory = Theory(beam)
        mine = element_modes(robot, pose, theory, 3, 12)
        its = Substructure(3, beam).modes(robot, pose, 12)
        assert mine.frequencies == pytest.approx(its.frequencies, rel=1e-12)
        assert np.abs(mine.limbs - its.limbs).max() < 1e-8 * np.abs(its.limbs).max()
        exactly, known = (
            exact_modes(robot, pose, theory, 12),
            Continuum(beam).modes(robot, pose, 12),
        )
        assert exactly.frequencies == pytest.approx(known.frequencies, rel=1e-11)
        assert np.abs(exactly.platform - known.platform).max() < 1e-6 * np.abs(known.platform).max()


def test_the_papers_limb_is_known_by_its_joints_whatever_its_axis() -> None:
    """The last bit of an axis of length 1, and a limb whose first joint turns about nothing."""
    rod, random = Rod.round(STEEL, 0.05), np.random.default_rng(0)
    for axis in random.normal(size=(200, 3)):
        limb = Limb.rps((1, 0, 0), tuple(axis), (0.5, 0, 0), rod)
        assert limb.simple and limb.turned(0.3).simple and limb.with_rod(rod).simple
    ends = (Joint(()), Joint.universal((0, 1, 0)), Joint.revolute((0, 1, 0), stiffness=1.0))
    assert not any(Limb((1, 0, 0), (0, 0, 0), (j, rod, Joint.spherical())).simple for j in ends)


def test_exact_pieces_at_low_frequency_are_elements() -> None:
    """D = K - omega^2 M + O(omega^4), for any section; and a piece in two is the same piece."""
    section = Section(2e-3, (3e-7, 9e-7), 4e-7, (0.7, 0.85))
    rods = properties([Rod(STEEL, section)], Theory("timoshenko"))
    length, omega2 = np.array([0.5]), np.array([1.0])
    K, M = element_matrices(rods, length)[:, 0]
    D = dynamic_stiffness(rods, length, omega2)[0, 0]
    size = np.sqrt(np.outer(np.diag(K), np.diag(K)))
    assert np.abs((D - K + omega2 * M) / size).max() < 1e-13
    # The frequency is high: a quarter of the first mode with ends held.
    lam = np.array([1 / (4 * 0.02 / np.pi**4 * rods.mass[0] / rods.EI.min())])
    half, whole = (dynamic_stiffness(rods, L, lam)[0, 0] for L in (length / 2, length))
    middle = half[6:, 6:] + half[:6, :6]
    both = np.block([[half[:6, :6], np.zeros((6, 6))], [np.zeros((6, 6)), half[6:, 6:]]])
    coupled = np.concatenate([half[:6, 6:], half[6:, :6]])
    joined = both - coupled @ np.linalg.solve(middle, coupled.T)
    assert np.abs((joined - whole) / size).max() < 1e-12


def test_a_cut_rod_has_no_mode_with_ends_held() -> None:
    rods = properties([Rod(STEEL, Section.round(0.1))], Theory("timoshenko"))
    for omega2 in (1e6, 1e8, 1e10):
        n = pieces(rods, np.array([1.0]), omega2)
        length = np.array([1.0 / n])
        K, M = element_matrices(rods, length / 32)[:, 0]
        big_k, big_m = np.zeros((2, 6 * 33, 6 * 33))
        for e in range(32):
            part = slice(6 * e, 6 * e + 12)
            big_k[part, part] += K
            big_m[part, part] += M
        inside = slice(6, -6)
        lowest = np.linalg.eigvals(np.linalg.solve(big_m[inside, inside], big_k[inside, inside]))
        assert lowest.real.min() > omega2


def test_sections_say_what_books_say() -> None:
    tube = Section.round(0.05, 0.036)
    assert tube.area == pytest.approx(math.pi * (0.025**2 - 0.018**2))
    assert tube.torsion_constant == pytest.approx(math.pi / 2 * (0.025**4 - 0.018**4))
    thin = Rod(STEEL, Section.round(0.1, 0.0999999))
    nu = STEEL.poisson
    assert shear_coefficients(thin, Theory("timoshenko"))[0] == pytest.approx(
        2 * (1 + nu) / (4 + 3 * nu), rel=1e-5
    )  # Cowper's thin tube
    solid = Rod(STEEL, Section.round(0.1, 1e-9))
    assert shear_coefficients(solid, Theory("timoshenko"))[0] == pytest.approx(
        6 * (1 + nu) / (7 + 6 * nu)
    )


def test_a_platform_on_one_clamped_rod_is_a_cantilever_with_a_tip_mass() -> None:
    """(beta L) of cos cosh + 1 + mu beta L (cos sinh - sin cosh) = 0, in two planes apart."""
    section = Section(1e-3, (2e-7, 5e-7), 3e-7)
    rod, mass = Rod(STEEL, section), 3.0
    tiny = Platform.diagonal(mass, (1e-12, 1e-12, 1e-12))
    limb = Limb((0, 0, 0), (0, 0, 0), (rod,), reference=(0, 1, 0))
    found = Continuum().modes(Mechanism((limb,), tiny), Pose.at((0, 0, 1.0)), 2).frequencies
    share = mass / (7820 * section.area)

    def gap(b: float) -> float:
        return (math.cos(b) * math.cosh(b) + 1) + share * b * (
            math.cos(b) * math.sinh(b) - math.sin(b) * math.cosh(b)
        )

    low, high = 0.1, 1.8
    for _ in range(100):
        low, high = (
            ((low + high) / 2, high) if gap((low + high) / 2) > 0 else (low, (low + high) / 2)
        )
    line = 200e9 / (7820 * section.area)
    expected = [low**2 / (2 * math.pi) * math.sqrt(line * second) for second in (2e-7, 5e-7)]
    assert found == pytest.approx(expected, rel=1e-8)


def test_a_payload_is_a_platform_with_both() -> None:
    """Fixing a body to the platform is adding its mass matrix."""
    loaded = PLATE.carrying(4.0, (0.1, -0.05, 0.2), ((0.3, 0, 0), (0, 0.2, 0), (0, 0, 0.4)))
    alone = Platform(4.0, ((0.3, 0, 0), (0, 0.2, 0), (0, 0, 0.4)), centre=(0.1, -0.05, 0.2))
    assert loaded.mass_matrix == pytest.approx(PLATE.mass_matrix + alone.mass_matrix)


def test_a_stiff_spring_is_no_joint_and_a_locked_one_neither() -> None:
    robot, pose = CASES["hexapod"].mechanism, CASES["hexapod"].pose

    def with_drive(stiffness: float) -> np.ndarray:
        limbs = []
        for limb in robot.limbs:
            items = list(limb.chain)
            items[2] = Joint.prismatic(stiffness=stiffness)
            limbs.append(replace(limb, chain=tuple(items)))
        mechanism = Mechanism(tuple(limbs), robot.platform)
        return Continuum().modes(mechanism, pose, 6).frequencies

    assert with_drive(1e13) == pytest.approx(with_drive(math.inf), rel=1e-5)
    assert (with_drive(1e8) < with_drive(math.inf)).all()


def test_a_turned_robot_and_a_renumbered_one_have_the_same_frequencies() -> None:
    for name in ("hexapod", "three-upu", "tricept"):
        case = CASES[name]
        found = Continuum().modes(case.mechanism, case.pose, 6).frequencies
        limbs = case.mechanism.limbs
        other = Mechanism((*limbs[1:], limbs[0]), case.mechanism.platform)
        assert Continuum().modes(other, case.pose, 6).frequencies == pytest.approx(found, rel=1e-10)
        angle = 0.7
        c, s = math.cos(angle), math.sin(angle)
        T = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        # The base turns; the platform's own frame turns with it.
        turned = Mechanism(
            tuple(limb.turned(angle) for limb in limbs),
            Platform(
                case.mechanism.platform.mass,
                (T @ np.array(case.mechanism.platform.inertia) @ T.T).tolist(),
                centre=tuple(T @ np.array(case.mechanism.platform.centre)),
            ),
        )
        o = np.array([case.pose.x, case.pose.y, case.pose.z])
        pose = Pose.at(T @ o, T @ case.pose.rotation @ T.T)
        assert Continuum().modes(turned, pose, 6).frequencies == pytest.approx(found, rel=1e-9)


def test_repeated_modes_of_a_hexapod_at_home_are_all_found() -> None:
    case = CASES["hexapod-home"]
    found = Continuum().modes(case.mechanism, case.pose, 12).frequencies
    for k, f in enumerate(found):
        below = Continuum().count_below(case.mechanism, case.pose, float(f) * (1 - 1e-8))
        above = Continuum().count_below(case.mechanism, case.pose, float(f) * (1 + 1e-8))
        assert below <= k < above
    assert found[0] == pytest.approx(found[1], rel=1e-10)


def test_spins_are_recognised() -> None:
    case = CASES["six-sps"]
    assert exact(case.mechanism, case.pose, Theory()).spins == 6
    other = CASES["hexapod"]
    assert exact(other.mechanism, other.pose, Theory()).spins == 0


def limb_of(*chain: object, base: tuple = (0.3, 0, 0), point: tuple = (0.2, 0, 0)) -> Limb:
    return Limb(base, point, chain)  # type: ignore[arg-type]


def ring(*chain: object, copies: int = 3) -> Mechanism:
    limb = limb_of(*chain)
    limbs = tuple(limb.turned(2 * math.pi * k / copies) for k in range(copies))
    return Mechanism(limbs, PLATE)


ROD, SHORT = Rod.round(STEEL, 0.05), Rod(STEEL, Section.round(0.05), 0.2)
BRIEF = Rod(STEEL, Section.round(0.05), 0.05)
LONG = Rod(STEEL, Section.round(0.05), 0.9)
U, R, S = Joint.universal((0, 1, 0)), Joint.revolute((0, 1, 0)), Joint.spherical()
AT = Pose.at((0, 0, 0.5))
ALONG = Joint.universal((-0.1, 0, 0.5))
SPRING = Joint.prismatic(stiffness=1e8)
BODY = Body(1.0, ((1, 0, 0), (0, 1, 0), (0, 0, 1)))
REFUSED = {
    "movable in 3": (ring(U, ROD, S), AT, "3 ways"),
    "movable by a free drive": (
        ring(R, SHORT, Joint.prismatic(stiffness=0.0), ROD, S), Pose(0.5), "can move",
    ),
    "S beside R": (ring(R, ROD, S, R), Pose(0.5), "limb 1"),
    "two adapt": (None, lambda: limb_of(R, ROD, ROD, S), "adapts"),
    "none adapts": (None, lambda: limb_of(R, SHORT, S), "adapts"),
    "U along its limb": (
        Mechanism((limb_of(ALONG, ROD, S), *ring(R, ROD, S).limbs), PLATE),
        AT, "limb 1",
    ),
    "R off its plane": (ring(R, ROD, S), Pose.at((0, 0.05, 0.5)), "A_1"),
    "too short": (
        ring(Joint.prismatic((0, 0, 1), 1e8, slider="above"), R, BRIEF, S),
        Pose(0.5), "reach",
    ),
    "nothing left": (ring(R, LONG, Joint.prismatic(stiffness=1e8), ROD, S), Pose(0.5), "limb 1"),
    "impossible inertia": (None, lambda: Body(1.0, ((1, 0, 0), (0, 1, 0), (0, 0, 2.5))), "exceeds"),
    "U-U out of line": (
        ring(U, ROD, Joint.universal((0, 1, 0), "platform")),
        Pose.at((0, 0, 0.5), Pose(0, 0.4, 0.3).rotation), "in line",
    ),
    "x and y unsaid": (ring(U, ROD, S, copies=6), Pose(0.5), "x and y"),
    "rigid limb": (ring(R, Link(), S), Pose(0.5), "limb 1 with no rod that is rigid"),
    "body on a rigid limb": (
        Mechanism((limb_of(S, Link(), BODY, SPRING, S), *ring(R, ROD, S).limbs), PLATE),
        Pose(0.5), "limb 1 with a body",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", sorted(REFUSED))
def test_what_cannot_be_is_refused_in_a_sentence(name: str) -> None:
    mechanism, pose, words = REFUSED[name]
    with pytest.raises(InputError, match=words):
        if mechanism is None:
            pose()  # type: ignore[operator]
        else:
            exact(mechanism, pose, Theory()).split(1)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", ["prs", "rps-real"])
def test_a_platform_too_heavy_for_the_digits_is_refused_in_a_sentence(name: str) -> None:
    mechanism, pose = CASES[name].mechanism, CASES[name].pose
    plate = mechanism.platform
    inertia = tuple(tuple(1e14 * entry for entry in row) for row in plate.inertia)
    heavy = replace(mechanism, platform=replace(plate, mass=1e14 * plate.mass, inertia=inertia))
    with pytest.raises(NotCertifiedError, match="masses so unlike"):
        Continuum().modes(heavy, pose)


def test_timoshenko_needs_shear_coefficients_of_a_general_section() -> None:
    rod = Rod(STEEL, Section(1e-3, (1e-7, 2e-7), 1e-7))
    case = ring(R, rod, S)
    with pytest.raises(InputError, match="shear_coefficients"):
        Continuum("timoshenko").modes(case, Pose(0.5))
    assert Continuum().modes(case, Pose(0.5)).frequencies[0] > 0


def test_freedoms_say_whose_axes_they_are_in() -> None:
    """A tilt stiffness about the limb's own axis is not one about the global one."""

    def with_frame(frame: str) -> np.ndarray:
        rest = (Freedom("rotation", (1, 0, 0), frame, 1e4),)
        joint = Joint((*R.freedoms, *rest))
        return Continuum().modes(ring(joint, ROD, S), Pose(0.5), 6).frequencies

    assert np.abs(with_frame("limb") / with_frame("base") - 1).max() > 1e-4


def test_static_stiffness_of_a_cantilever_is_the_books() -> None:
    """EA / L, 3 EI / L^3 with the end free to turn, GJ / L; and the rod gives way alone."""
    section = Section(1e-3, (2e-7, 5e-7), 3e-7)
    limb = Limb((0, 0, 0), (0, 0, 0), (Rod(STEEL, section),), reference=(0, 1, 0))
    found = stiffness(Mechanism((limb,), PLATE), Pose.at((0, 0, 2.0)), beam="euler-bernoulli")
    flexible = np.diag(found.compliance)
    E, L = 200e9, 2.0
    expected = [L**3 / (3 * E * 5e-7), L**3 / (3 * E * 2e-7), L / (E * 1e-3),
                L / (E * 2e-7), L / (E * 5e-7), L / (77e9 * 3e-7)]  # fmt: skip
    assert flexible == pytest.approx(expected, rel=1e-9)
    assert found.shares == pytest.approx(np.ones((1, 6)))


def test_every_newton_of_compliance_is_some_part_s() -> None:
    """Shares sum to one, springs in a row add, and a slow load sees the same stiffness."""
    for name in ("hexapod", "prs", "six-sps", "flexure-hexapod"):
        case = CASES[name]
        found = stiffness(case.mechanism, case.pose)
        assert found.shares.sum(axis=0) == pytest.approx(np.ones(6), rel=1e-8)
        assert (found.shares > -1e-9).all()
    case = CASES["hexapod"]
    soft = tuple(
        replace(limb, chain=(*limb.chain[:2], Joint.prismatic(stiffness=3e7), *limb.chain[3:]))
        for limb in case.mechanism.limbs
    )
    more = stiffness(Mechanism(soft, case.mechanism.platform), case.pose)
    found = stiffness(case.mechanism, case.pose)
    drives = [k for k, part in enumerate(found.parts) if part[2] == "P"]
    added = found.shares[drives].sum(axis=0) * np.diag(found.compliance)
    assert np.diag(more.compliance - found.compliance) == pytest.approx(added, rel=0.02)
