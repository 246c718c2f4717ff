"""Every bracket of the exact model holds its mode: counts at both ends in fifty digits.

The counts share nothing with the model but Mechanism, Pose and Theory's constants. A limb is cut
into pieces so short that none has a mode of its own below the frequency; each piece is the
exponential of the beam equations, and negative pivots are counted, with no closed form, no pole
and no count of a limb's own modes.
"""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf

from analytic import (
    Continuum,
    Limb,
    Material,
    Mechanism,
    NotCertifiedError,
    Platform,
    Pose,
    Rod,
    Substructure,
    condensed_frequencies,
)

STEEL = Material(200e9, 77e9, 7820.0)
DIGITS = 50


def exact_count(mechanism, pose, model, hertz):
    """Return how many modes lie below `hertz`, torsion included, in 50 digits."""
    with mp.workdps(DIGITS):
        omega2 = (2 * mp.pi * mpf(float(hertz))) ** 2
        D = mp.zeros(6)
        for i in range(3):
            D[i, i] = -omega2 * mpf(mechanism.platform.mass)
            for j in range(3):
                D[3 + i, 3 + j] = -omega2 * mpf(mechanism.platform.inertia[i][j])
        below = 0
        for limb, length, frame, point in closed(mechanism, pose):
            held, stiffness = limb_count(limb.rod, length, omega2, model.theory)
            below += held
            for d, c in zip(stiffness, frame, strict=True):
                a = [*c, *cross(point, c)]
                for i in range(6):
                    for j in range(6):
                        D[i, j] += d * a[i] * a[j]
        return below + negative_pivots(D, 6)[0]


def closed(mechanism, pose):
    """Yield every limb, its length, its axes x, y, z and A_i, both in the moving frame."""
    phi, theta, z = mpf(pose.azimuth), mpf(pose.tilt), mpf(pose.z)
    c, s, ct, st_ = mp.cos(phi), mp.sin(phi), mp.cos(theta), mp.sin(theta)
    turn = mp.matrix([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    R = turn * mp.matrix([[ct, 0, st_], [0, 1, 0], [-st_, 0, ct]]) * turn.T
    axes = [mp.matrix(limb.axis) / mp.norm(mp.matrix(limb.axis)) for limb in mechanism.limbs]
    arms = [R * mp.matrix(limb.platform_point) for limb in mechanism.limbs]
    bases = [mp.matrix(limb.base) for limb in mechanism.limbs]
    rows = [
        (e[0], e[1], -dot(e, a - b) - e[2] * z) for e, a, b in zip(axes, arms, bases, strict=True)
    ]
    xx, xy, yy, bx, by = (
        sum(r[i] * r[j] for r in rows) for i, j in ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2))
    )
    det, size = xx * yy - xy * xy, xx + yy
    if det > mpf("1e-17") * size**2:
        o = mp.matrix([(yy * bx - xy * by) / det, (xx * by - xy * bx) / det, z])
    elif size > 0:  # axes of one direction leave the other to the shortest o
        o = mp.matrix([bx / size, by / size, z])
    else:
        o = mp.matrix([0, 0, z])
    for limb, e, a, b in zip(mechanism.limbs, axes, arms, bases, strict=True):
        vector = o + a - b
        length = mp.norm(vector)
        along = vector / length
        x = mp.matrix(cross(e, along))
        x /= mp.norm(x)
        y = mp.matrix(cross(along, x))
        frame = [list(R.T * v) for v in (x, y, along)]
        yield limb, length, frame, [mpf(v) for v in limb.platform_point]


def limb_count(rod, length, omega2, theory):
    """Return how many modes a limb has with its tip held, and d_x, d_y, d_z."""
    E, rho = mpf(rod.material.young), mpf(rod.material.density)
    A, second = mp.pi * mpf(rod.diameter) ** 2 / 4, mp.pi * mpf(rod.diameter) ** 4 / 64
    give = rotary = mpf(0)
    if theory.beam == "timoshenko":
        kappa = mpf(theory.shear_coefficient(rod.material))
        give = 1 / (kappa * mpf(rod.material.shear) * A)
    if theory.rotary_inertia:
        rotary = omega2 * rho * second
    EI, mass = E * second, omega2 * rho * A
    reach = (mass / EI) ** mpf(0.25) + mp.sqrt(mass * give) + mp.sqrt(rotary / EI)
    pieces = int(mp.ceil(reach * length / mpf(0.7)))
    h = length / pieces
    # w' = theta + V / kGA, theta' = M / EI, V' = -lambda rhoA w, M' = -V - lambda rhoI theta.
    step = mp.matrix([[0, 1, give, 0], [0, 0, 0, 1 / EI], [-mass, 0, 0, 0], [0, -rotary, -1, 0]])
    T = exponential(step * h)
    a, b, c, d = T[:2, :2], T[:2, 2:], T[2:, :2], T[2:, 2:]
    inverse = b**-1
    piece = mp.zeros(4)
    for i in range(2):
        for j in range(2):
            piece[i, j] = (inverse * a)[i, j]
            piece[i, 2 + j] = -inverse[i, j]
            piece[2 + i, j] = (c - d * inverse * a)[i, j]
            piece[2 + i, 2 + j] = (d * inverse)[i, j]
    K = mp.zeros(2 * pieces + 2)
    for k in range(pieces):
        for i in range(4):
            for j in range(4):
                K[2 * k + i, 2 * k + j] += piece[i, j]
    below, stiffness = 0, []
    tip = 2 * pieces
    for base in ([1], []):
        order = [*base, *range(2, tip), tip + 1, tip]
        some = mp.matrix([[K[i, j] for j in order] for i in order])
        count, driven = negative_pivots(some, len(order) - 1, band=5)
        below += count
        stiffness.append(driven)
    k = mp.sqrt(omega2 * rho / E)
    stiffness.append(E * A * k * mp.cot(k * length))
    below += int(mp.ceil(k * length / mp.pi)) - 1
    twist = mp.sqrt(omega2 * rho / mpf(rod.material.shear)) * length / mp.pi
    return below + max(0, int(mp.ceil(twist - mpf(0.5)))), stiffness


def exponential(X):
    total, term, k = mp.eye(4), mp.eye(4), 0
    # Far beyond the digits asked for: X is small in its own units only.
    while k < 90:
        k += 1
        term = term * X / k
        total += term
    return total


def negative_pivots(matrix, eliminated, band=None):
    """Return how many of the first pivots are negative, and the last entry that they leave."""
    A, size, below = matrix.copy(), matrix.rows, 0
    for k in range(eliminated):
        below += A[k, k] < 0
        last = size if band is None else min(size, k + band)
        for i in range(k + 1, last):
            factor = A[i, k] / A[k, k]
            if factor:
                for j in range(k + 1, last):
                    A[i, j] -= factor * A[k, j]
    return below, A[size - 1, size - 1]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def cross(a, b):
    return [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]


def check(mechanism, pose, model, count=6):
    """Every bracket holds its mode, or is refused; return the brackets, or None."""
    try:
        bounds = model.brackets(mechanism, pose, count)
    except NotCertifiedError:
        return None
    for k, (low, high) in enumerate(bounds):
        if low > 0:
            assert exact_count(mechanism, pose, model, low) <= k
            assert high / low - 1 <= 1e-9
        assert exact_count(mechanism, pose, model, high) >= k + 1
    return bounds


KINDS = ("generic", "parallel", "radial", "singular", "regular")


@st.composite
def mechanisms(draw, most=12):
    """A mechanism and a pose that closes: any axes, masses 10^-6 to 10^6 of a rod's, any size.

    "parallel" and "radial" axes leave the platform motions that little or nothing resists;
    "singular" limbs are parallel to 10^-7 ... 10^-2.
    """
    kind, n = draw(st.sampled_from(KINDS)), draw(st.integers(1, most))
    size = 10 ** draw(st.floats(-3, 3))
    heavy, slender = 10 ** draw(st.floats(-6, 6)), 10 ** draw(st.floats(-2.3, -0.5))
    equal, random = draw(st.booleans()), np.random.default_rng(draw(st.integers(0, 2**32)))
    height = size * random.uniform(0.5, 1.5)
    rods = []
    for _ in range(n):
        young = 10 ** random.uniform(9, 11.5)
        material = Material(young, young / (2 + 0.9 * random.random()), 10 ** random.uniform(3, 4))
        rods.append(Rod(material, height * slender * random.uniform(0.7, 1.4)))
    rods = [rods[0]] * n if equal or kind == "regular" else rods
    mass = heavy * np.mean([rod.material.density * rod.area * height for rod in rods])
    radius = size * 0.3 * 10 ** random.uniform(-3, 0.5)
    moments = random.uniform(0.5, 1.0, 3) * mass * radius**2
    platform = Platform.diagonal(mass, tuple(moments))
    if kind == "regular":
        radii = size * random.uniform(0.05, 1.0, 2)
        return Mechanism.regular(*radii, rods[0], platform, limbs=n), Pose(height)
    pose = Pose(height, random.uniform(-3, 3), random.uniform(-0.4, 0.4))
    limbs = []
    for i, rod in enumerate(rods):
        around = 2 * np.pi * i / n
        axis = {"generic": random.normal(size=3), "radial": [np.cos(around), np.sin(around), 0]}
        axis = np.array(axis.get(kind, [0, 1, 0]))
        axis = axis / np.linalg.norm(axis)
        point = random.normal(size=3) * size * [0.3, 0.3, 0.06]
        spread = 10 ** random.uniform(-7, -2) if kind == "singular" else 0.2
        tip = [0, 0, height] + pose.rotation @ point
        base = tip - [0, 0, height] + random.normal(size=3) * size * spread * [1, 1, 0.2]
        base = base + axis * (axis @ (tip - base))
        limbs.append(Limb.rps(tuple(base), tuple(axis), tuple(point), rod))
    return Mechanism(tuple(limbs), platform), pose


@pytest.mark.slow
@settings(max_examples=40, suppress_health_check=list(HealthCheck))
@given(mechanisms(), st.sampled_from(["euler-bernoulli", "rayleigh", "timoshenko"]))
def test_every_bracket_of_any_mechanism_holds_its_mode(made, beam):
    check(*made, Continuum(beam))


@settings(max_examples=60, suppress_health_check=list(HealthCheck))
@given(mechanisms())
def test_the_condensed_and_the_assembled_model_agree_or_refuse(made):
    mechanism, pose = made
    try:
        bounds = Continuum().brackets(mechanism, pose)
        condensed = condensed_frequencies(mechanism, pose)
    except NotCertifiedError:
        return
    exact = np.where(bounds[:, 0] > 0, bounds.mean(axis=1), 0.0)
    np.testing.assert_allclose(condensed, exact, rtol=2e-9)
    assert (condensed >= 0).all()


def test_a_root_far_below_the_pencil_s_has_all_its_digits():
    """Three limbs all but parallel: f1 is 1/650 of f2, where the pencil gives 70 times f1."""
    material = Material(4725706924.952979, 2320075707.584172, 1038.7897017867185)
    rod = Rod(material, 0.14431331535116435)
    ends = [
        (
            (-0.1870594578718533, 0.10385174352223311, -0.01007140467486288),
            (-0.19955840204598405, 0.10545302102790591, 0.05420821089910852),
        ),
        (
            (-0.02393773480249612, -0.04881331279609095, -0.005698194336116097),
            (-0.06275267246151392, -0.04776750297434331, 0.03245073508114846),
        ),
        (
            (-0.2307877044959827, 0.4518069566301449, 0.02659359933609481),
            (-0.37771965963123605, 0.45417713242171875, 0.08075252542693827),
        ),
    ]
    limbs = tuple(Limb.rps(base, (0, 1, 0), point, rod) for base, point in ends)
    moments = 2.583730993098645e-06, 1.7561751217163496e-06, 2.7831861757783418e-06
    mechanism = Mechanism(limbs, Platform.diagonal(19.318622457069132, moments))
    pose = Pose(1.1369616873214543, 0.24876732149455005, -0.16023048757009217)
    bounds = check(mechanism, pose, Continuum())
    assert bounds is not None
    assert bounds[1, 0] > 600 * bounds[0, 1]
    found = condensed_frequencies(mechanism, pose)
    np.testing.assert_allclose(found, bounds.mean(axis=1), rtol=1e-9)


@pytest.mark.parametrize("beam", ["euler-bernoulli", "timoshenko"])
def test_brackets_of_the_paper_hold(robot, case1, case2, beam):
    for pose in (case1, case2):
        bounds = check(robot, pose, Continuum(beam))
        assert (bounds[:, 1] / bounds[:, 0] - 1 <= 1e-12).all()


def test_the_count_can_fail(robot, case2):
    """A bracket that is one width too high is seen."""
    model = Continuum()
    low, high = model.brackets(robot, case2, 1)[0]
    assert exact_count(robot, case2, model, high + 2 * (high - low)) == 1
    assert exact_count(robot, case2, model, high) == 1
    assert exact_count(robot, case2, model, low) == 0


@pytest.mark.parametrize("share", [1, 1e-3, 1e-5, 1e-7, 1e-9, 1e-12])
def test_light_platforms(robot, case2, share):
    """The paper's mechanism with ever less inertia: all six brackets hold."""
    moments = share * np.diag(np.array(robot.platform.inertia))
    light = Mechanism(robot.limbs, Platform.diagonal(robot.platform.mass, tuple(moments)))
    bounds = check(light, case2, Continuum())
    assert (bounds[:, 1] / bounds[:, 0] - 1 <= 1e-11).all()
    condensed = condensed_frequencies(light, case2)
    np.testing.assert_allclose(condensed, bounds.mean(axis=1), rtol=1e-9)


def test_six_equal_limbs():
    """Limbs between pins are modes of the whole: pi / 2 L^2 sqrt(EI / rho A), three times."""
    robot = Mechanism.regular(
        0.3, 0.05, Rod(STEEL, 0.1), Platform.disc(0.05, 0.02, 7820.0), limbs=6
    )
    bounds = check(robot, Pose(0.3), Continuum(), 10)
    length = np.hypot(0.3, 0.25)
    pinned = np.pi / 2 / length**2 * np.sqrt(200e9 / 7820) * 0.1 / 4
    assert pinned == pytest.approx(1302.27188119, rel=1e-11)
    assert bounds[4:7].mean(axis=1) == pytest.approx(pinned, rel=1e-12)


@pytest.mark.parametrize("n", range(1, 13))
def test_equal_limbs_of_any_number(n):
    robot = Mechanism.regular(
        0.3, 0.05, Rod(STEEL, 0.1), Platform.disc(0.05, 0.02, 7820.0), limbs=n
    )
    bounds = Continuum().brackets(robot, Pose(0.3), 9)
    condensed = condensed_frequencies(robot, Pose(0.3), count=9)
    exact = np.where(bounds[:, 0] > 0, bounds.mean(axis=1), 0.0)
    np.testing.assert_allclose(condensed, exact, rtol=1e-9)
    fine = Substructure(24).modes(robot, Pose(0.3), 9).frequencies
    # 24 linear shafts have (pi / 48)^2 / 24 = 1.8e-4 too much.
    moving = exact > 0
    np.testing.assert_allclose(fine[moving], exact[moving], rtol=1.9e-4)


def tip_mass(size=1.0):
    """A cantilever with a point mass of its own mass at the tip."""
    rod = Rod(Material(200e9, 77e9, 7800.0), 0.02 * size)
    mass = 7800.0 * rod.area * size
    limb = Limb.rps((0, 0, 0), (0, 1, 0), (0, 0, 0), rod)
    return Mechanism((limb,), Platform.diagonal(mass, (4e-5 * mass * size**2,) * 3)), Pose(size)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_free_motions_are_zero_and_the_rest_exact(size):
    robot, pose = tip_mass(size)
    unit = np.sqrt(200e9 / 7800.0) * 0.02 / 4 / (2 * np.pi * size)
    for found in (
        Continuum().modes(robot, pose).frequencies,
        condensed_frequencies(robot, pose),
    ):
        assert (found[:4] == 0).all()
        np.testing.assert_allclose(found[4:] / unit, [1.557298, 10.714402], atol=1e-6)
    check(robot, pose, Continuum())


@pytest.mark.parametrize("size", [1e-3, 1e-2, 0.3, 7.0, 1e3])
@pytest.mark.parametrize("beam", ["euler-bernoulli", "timoshenko"])
def test_frequencies_scale_as_one_over_size(robot, case2, size, beam):
    def grown(k):
        limbs = (
            Limb.rps(
                tuple(k * x for x in limb.base),
                limb.axis,
                tuple(k * x for x in limb.platform_point),
                Rod(limb.rod.material, k * limb.rod.diameter),
            )
            for limb in robot.limbs
        )
        moments = k**5 * np.diag(np.array(robot.platform.inertia))
        platform = Platform.diagonal(k**3 * robot.platform.mass, tuple(moments))
        return Mechanism(tuple(limbs), platform), Pose(k * case2.z, case2.azimuth, case2.tilt)

    model = Continuum(beam)
    small = model.modes(*grown(size), 9).frequencies * size
    np.testing.assert_allclose(small, model.modes(robot, case2, 9).frequencies, rtol=2e-12)
    many = condensed_frequencies(*grown(size), beam=beam, count=9) * size
    np.testing.assert_allclose(many, small, rtol=1e-9)


def test_what_cannot_be_certified_is_said():
    """Limbs parallel to 1e-11 leave a motion too slow to tell."""
    rod, tilt = Rod(STEEL, 0.02), 1e-11
    limbs = tuple(
        Limb.rps((x + tilt * k**2, y, 0), (0, 1, 0), (x, y, 0), rod)
        for k, (x, y) in enumerate([(0.2, 0.1), (-0.2, 0.1), (-0.2, -0.1), (0.2, -0.1)])
    )
    robot = Mechanism(limbs, Platform.disc(0.2, 0.02, 7820.0))
    with pytest.raises(NotCertifiedError, match=r"double precision cannot certify"):
        Continuum().modes(robot, Pose(0.5))
