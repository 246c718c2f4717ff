"""The paper's model: its printed matrices, published-geometry values, symmetry and scaling."""

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse
from hypothesis import given, settings
from hypothesis import strategies as st

from analytic import (
    InputError,
    Limb,
    Material,
    Mechanism,
    Multipliers,
    Platform,
    Pose,
    Rod,
    Substructure,
    Theory,
    limbs_at,
)
from analytic.certified import brackets
from analytic.substructure import (
    independent_coordinates,
    limb_selection,
    platform_mass,
    platform_selection,
    rigid_arm,
)
from analytic.wittrick_williams import characteristic

# Euler-Bernoulli, s = 3, z = 0.49 m: from an independent implementation.
CASE1 = [137.828, 137.828, 236.529, 793.765, 881.624, 881.624]
CASE2 = [124.667, 149.510, 241.055, 720.930, 895.508, 948.819]

THEORIES = ["euler-bernoulli", "rayleigh", "timoshenko"]
poses = st.builds(
    Pose, st.floats(0.35, 0.7), st.floats(-np.pi, np.pi), st.floats(-np.radians(20), np.radians(20))
)


def frequencies(
    robot: Mechanism, pose: Pose, elements: int = 3, beam: str = THEORIES[0]
) -> np.ndarray:
    return Substructure(elements, beam).modes(robot, pose).frequencies


def test_known_values(robot: Mechanism, case1: Pose, case2: Pose) -> None:
    np.testing.assert_allclose(frequencies(robot, case1), CASE1, rtol=1e-5)
    np.testing.assert_allclose(frequencies(robot, case2), CASE2, rtol=1e-5)


@given(turn=st.floats(-np.pi, np.pi))
@settings(max_examples=30)
def test_known_values_whatever_the_heading(turn: float) -> None:
    robot = Mechanism.paper(heading=turn)
    pose = Pose(0.49, np.radians(10) + turn, np.radians(-12))
    np.testing.assert_allclose(frequencies(robot, pose), CASE2, rtol=1e-5)


@pytest.mark.parametrize("degrees", [0, 30, 90, 180, 270])
def test_no_base_orientation_is_singular(degrees: float) -> None:
    """Eq. (17) divides by zero for a limb at 90 degrees, Eq. (18) for one at 0."""
    turn = np.radians(degrees)
    pose = Pose(0.49, np.radians(10) + turn, np.radians(-12))
    np.testing.assert_allclose(frequencies(Mechanism.paper(heading=turn), pose), CASE2, rtol=1e-5)


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_axes_exactly_along_x(quarters: int) -> None:
    """Turned by right angles without rounding, an axis has R(2,2) = 0 or R(1,2) = 0 to the bit."""

    def turn(v: tuple[float, float, float]) -> tuple[float, float, float]:
        for _ in range(quarters):
            v = (-v[1], v[0], v[2])
        return v

    paper = Mechanism.paper()
    limbs = [
        Limb.rps(turn(b.base), turn(b.axis), turn(b.platform_point), b.rod) for b in paper.limbs
    ]
    assert 0.0 in limbs[0].axis[:2]
    pose = Pose(0.49, np.radians(10) + quarters * np.pi / 2, np.radians(-12))
    turned = Mechanism(tuple(limbs), paper.platform)
    np.testing.assert_allclose(frequencies(turned, pose), CASE2, rtol=1e-5)


@given(pose=poses, beam=st.sampled_from(THEORIES), elements=st.integers(1, 4))
@settings(max_examples=40)
def test_120_degree_symmetry(pose: Pose, beam: str, elements: int) -> None:
    robot = Mechanism.paper()
    turned = Pose(pose.z, pose.azimuth + 2 * np.pi / 3, pose.tilt)
    one, other = (frequencies(robot, p, elements, beam) for p in (pose, turned))
    np.testing.assert_allclose(one, other, rtol=1e-9)


@given(pose=poses, beam=st.sampled_from(THEORIES))
@settings(max_examples=20)
def test_leaning_the_other_way_is_half_a_turn(pose: Pose, beam: str) -> None:
    """(phi, theta) and (phi + pi, -theta) are one rotation."""
    other = Pose(pose.z, pose.azimuth + np.pi, -pose.tilt)
    robot = Mechanism.paper()
    np.testing.assert_allclose(
        frequencies(robot, pose, 2, beam), frequencies(robot, other, 2, beam), rtol=1e-9
    )


@given(
    pose=poses,
    beam=st.sampled_from(THEORIES),
    length=st.floats(0.1, 10),
    stiff=st.floats(0.1, 10),
    heavy=st.floats(0.1, 10),
)
@settings(max_examples=30)
def test_units_scale(pose: Pose, beam: str, length: float, stiff: float, heavy: float) -> None:
    """f goes as sqrt(E / rho) / length when all lengths, moduli and densities are scaled."""

    def scaled(size: float, E: float, rho: float) -> Mechanism:
        steel = Material(200e9 * E, 77e9 * E, 7820 * rho)
        disc = Platform.disc(0.2 * size, 0.02 * size, steel.density)
        return Mechanism.regular(0.3 * size, 0.2 * size, Rod(steel, 0.1 * size), disc)

    one = frequencies(scaled(1, 1, 1), pose, 2, beam)
    other = frequencies(
        scaled(length, stiff, heavy), Pose(pose.z * length, pose.azimuth, pose.tilt), 2, beam
    )
    np.testing.assert_allclose(other, one * np.sqrt(stiff / heavy) / length, rtol=1e-8)


def test_dofs_are_the_papers(robot: Mechanism, case1: Pose) -> None:
    """U of Eq. (19) has 18 s coordinates for three limbs."""
    for s in (1, 2, 5):
        assert Substructure(s).modes(robot, case1).dofs == 18 * s


def test_H_and_Q_have_the_printed_blocks(robot: Mechanism, case2: Pose) -> None:
    s, n = 3, 3
    limbs = limbs_at(robot, case2)
    width = 18 * s + 15
    for i in range(n):
        H = limb_selection(i, n, s, limbs.arms[i]).toarray()
        start = i * (6 * s + 3)
        wanted = np.zeros((6 * s + 6, width))
        wanted[:6, start : start + 6] = np.eye(6)
        wanted[6 : 6 * s, start + 6 : start + 6 * s] = np.eye(6 * s - 6)
        wanted[6 * s : 6 * s + 3, -6:] = rigid_arm(limbs.arms[i])
        wanted[6 * s + 3 :, start + 6 * s : start + 6 * s + 3] = np.eye(3)
        np.testing.assert_array_equal(H, wanted)
    np.testing.assert_array_equal(platform_selection(n, s).toarray(), np.eye(6, width, width - 6))

    # Eq. (17) for limb 1, whose axis is y: phi_Bx = R(1,2)/R(2,2) phi_By and phi_Bz = 0.
    Q = independent_coordinates(robot.axes, s).toarray()
    assert Q.shape == (width, 18 * s)
    R = limbs.frames[0]
    np.testing.assert_allclose(Q[3:6, 0], [R[0, 1] / R[1, 1], 1, 0], atol=1e-15)
    assert not Q[:3].any()
    np.testing.assert_array_equal(Q[6 : 6 * s + 3, 1 : 6 * s - 2], np.eye(6 * s - 3))
    np.testing.assert_array_equal(Q[-6:, -6:], np.eye(6))


@given(arm=st.tuples(*[st.floats(-1, 1)] * 3), motion=st.tuples(*[st.floats(-1, 1)] * 6))
def test_rigid_arm_is_rigid_motion(arm: tuple[float, ...], motion: tuple[float, ...]) -> None:
    shift, spin = np.array(motion[:3]), np.array(motion[3:])
    wanted = shift + np.cross(spin, arm)
    np.testing.assert_allclose(rigid_arm(np.array(arm)) @ motion, wanted, atol=1e-15)


def test_static_stiffness_of_one_limb_by_hand() -> None:
    """One vertical limb held by nothing but itself: its tip moves on EA/L and 3 EI/L^3."""
    steel = Material(200e9, 77e9, 7820)
    rod, L = Rod(steel, 0.03), 0.5
    limb = Limb.rps((0, 0, 0), (0, 1, 0), (0, 0, 0), rod)
    robot = Mechanism((limb,), Platform.diagonal(1e4, (1.0, 1.0, 1.0)))
    omega = 2 * np.pi * Substructure(4).modes(robot, Pose(L), 6).frequencies
    stiffness = 1e4 * omega**2  # the platform's mass dwarfs the limb's
    EI, EA = steel.young * rod.second_moment, steel.young * rod.area
    # Free to spin about o and to swing about the revolute axis; stiff across and along.
    np.testing.assert_allclose(stiffness[4:], [3 * EI / L**3, EA / L], rtol=1e-4)
    assert (omega[:4] < 1e-2 * omega[4]).all()


@pytest.mark.parametrize(
    ("beam", "order"), [("euler-bernoulli", 4), ("rayleigh", 4), ("timoshenko", 2)]
)
def test_observed_order(beam: str, order: int, robot: Mechanism, case2: Pose) -> None:
    steps = (4, 8, 16) if order == 4 else (16, 32, 64)
    coarse, middle, fine = (frequencies(robot, case2, s, beam) for s in steps)
    observed = np.log2((coarse - middle) / (middle - fine))
    np.testing.assert_allclose(observed, order, atol=0.15)


@given(pose=poses, beam=st.sampled_from(THEORIES[:2]))
@settings(max_examples=15)
def test_more_elements_never_raise_a_frequency(pose: Pose, beam: str) -> None:
    """Rayleigh's principle on nested meshes; Timoshenko's depend on the element's length."""
    coarse, fine = (frequencies(Mechanism.paper(), pose, s, beam) for s in (2, 4))
    assert (fine <= coarse * (1 + 1e-10)).all()


STEEL = Material(200e9, 77e9, 7820)
PLATE = Platform.disc(0.2, 0.02, 7820)
TIP = Mechanism(
    (Limb.rps((0, 0, 0), (0, 1, 0), (0, 0, 0), Rod(STEEL, 0.02)),),
    Platform(2.45, ((1e-4, 0, 0), (0, 1e-4, 0), (0, 0, 1e-4))),
)
LOOSE = {
    "one limb": (Mechanism(Mechanism.paper().limbs[:1], PLATE), Pose(0.49), 4),
    "two limbs": (Mechanism(Mechanism.paper().limbs[:2], PLATE), Pose(0.49, 0.3, 0.1), 2),
    "a mast": (TIP, Pose(1.0), 4),
}


def all_formulations(s: int, beam: str) -> list:
    return [
        Substructure(s, beam),
        Substructure(s, beam, solver="sparse"),
        Multipliers(s, beam),
        Multipliers(s, beam, solver="saddle-point"),
    ]


def waves(robot: Mechanism, pose: Pose, s: int, beam: str, count: int) -> np.ndarray:
    """The certified frequencies of s equal elements: no matrix has a part in them."""
    bounds = brackets(characteristic(robot, pose, Theory(beam), s), count)[0]
    return np.sqrt(np.where(bounds[:, 0] > 0, bounds.mean(axis=1), 0.0)) / (2 * np.pi)


@pytest.mark.parametrize("name", LOOSE)
@pytest.mark.parametrize("s", [1, 3, 64, 256, 512])
def test_free_motions_are_zero_and_cost_no_digits(name: str, s: int) -> None:
    robot, pose, free = LOOSE[name]
    wanted = waves(robot, pose, s, "timoshenko", 9)
    assert (wanted[:free] == 0).all() and wanted[free] > 0
    for model in all_formulations(s, "timoshenko"):
        found = model.modes(robot, pose, 9).frequencies
        assert (found[:free] == 0).all()
        np.testing.assert_allclose(found[free:], wanted[free:], rtol=1e-11)
        np.testing.assert_array_equal(model.frequencies(robot, pose, 1), [0.0])


@pytest.mark.parametrize("s", [8, 9, 64, 512])
def test_digits_do_not_fall_with_elements(s: int, robot: Mechanism, case2: Pose) -> None:
    wanted = waves(robot, case2, s, "euler-bernoulli", 6)
    for model in all_formulations(s, "euler-bernoulli"):
        found = model.modes(robot, case2).frequencies
        np.testing.assert_allclose(found, wanted, rtol=1e-11)


@pytest.mark.parametrize("s", [1, 3, 12])
@pytest.mark.parametrize("size", [1e-3, 1e-2, 1e2, 1e3])
def test_digits_do_not_depend_on_size(s: int, size: float) -> None:
    for k, z in ((1.0, 0.49), (size, 0.49 * size)):
        disc = Platform.disc(0.2 * k, 0.02 * k, 7820)
        robot = Mechanism.regular(0.3 * k, 0.2 * k, Rod(STEEL, 0.1 * k), disc)
        found = [
            m.modes(robot, Pose(z, 0.2, 0.1)).frequencies for m in all_formulations(s, "rayleigh")
        ]
        if k == 1.0:
            wanted = found
    np.testing.assert_allclose(np.multiply(found, size), wanted, rtol=1e-10)


@pytest.mark.parametrize("tilt", [1e-2, 1e-4, 1e-6])
def test_a_motion_that_is_all_but_free_keeps_its_digits(tilt: float) -> None:
    """Two opposite limbs in one plane let the platform swing across it, but for a little tilt."""
    robot = Mechanism.regular(0.3, 0.2, Rod(STEEL, 0.05), PLATE, limbs=2)
    pose = Pose(0.5, 0.0, tilt)
    wanted = waves(robot, pose, 3, "rayleigh", 8)
    for model in all_formulations(3, "rayleigh"):
        found = model.modes(robot, pose, 8).frequencies
        np.testing.assert_allclose(found, wanted, rtol=1e-9)


def test_solvers_end_whatever_the_rods() -> None:
    """Rods a sixteen-hundredth of their length: the space is used up before Lanczos converges."""
    plastic = Material(3e9, 1.1e9, 1200.0)
    paper = Mechanism.paper()
    limbs = tuple(
        Limb.rps(x.base, x.axis, x.platform_point, Rod(m, 3e-4))
        for x, m in zip(paper.limbs, (STEEL, plastic, plastic), strict=True)
    )
    robot = Mechanism(limbs, paper.platform)
    for s in (1, 3, 64):
        first, *others = (
            m.modes(robot, Pose(0.49)).frequencies for m in all_formulations(s, "rayleigh")
        )
        for other in others:
            np.testing.assert_allclose(other, first, rtol=1e-9)


def test_frequencies_are_those_of_the_modes(robot: Mechanism, case2: Pose) -> None:
    for s in (1, 3, 8, 9, 40):
        for count in (1, 6, 18):
            model = Substructure(s, "timoshenko")
            wanted = model.modes(robot, case2, count).frequencies
            np.testing.assert_allclose(model.frequencies(robot, case2, count), wanted, rtol=1e-11)


@pytest.mark.parametrize("s", [1, 2, 3, 7])
def test_the_pair_is_the_papers_product(s: int, case2: Pose) -> None:
    """K = Q^T (sum H_i^T K_i H_i) Q as printed, matrix by matrix, for limbs unlike each other."""
    regular = Mechanism.regular(0.3, 0.2, Rod(STEEL, 0.1), PLATE, limbs=3, heading=0.4)
    limbs = [
        Limb.rps(x.base, x.axis, x.platform_point, Rod(STEEL, d))
        for x, d in zip(regular.limbs, (0.1, 0.05, 0.03), strict=True)
    ]
    robot, pose = Mechanism(tuple(limbs), PLATE), Pose(0.49, 0.6, 0.2)
    model, n = Substructure(s, "timoshenko"), 3
    at = limbs_at(robot, pose)
    K_free, M_free, _ = Multipliers(s, "timoshenko").matrices(robot, pose)
    H = [limb_selection(i, n, s, at.arms[i]) for i in range(n)] + [platform_selection(n, s)]
    H_r = scipy.sparse.vstack(H) @ independent_coordinates(robot.axes, s)
    for found, free in zip(model.matrices(robot, pose), (K_free, M_free), strict=True):
        wanted = (H_r.T @ free @ H_r).toarray()
        np.testing.assert_allclose(found.toarray(), wanted, atol=1e-14 * np.abs(wanted).max())


def test_elements_of_any_integer_type(robot: Mechanism, case1: Pose) -> None:
    wanted = frequencies(robot, case1, 200)
    found = Substructure(np.uint8(200)).modes(robot, case1).frequencies  # type: ignore[arg-type]
    np.testing.assert_array_equal(found, wanted)
    for model in (Substructure, Multipliers):
        with pytest.raises(InputError, match="elements = 1000000: expected at most 1000"):
            model(1_000_000)


@given(pose=poses, elements=st.integers(1, 5), beam=st.sampled_from(THEORIES))
@settings(max_examples=20)
def test_sparse_is_dense(pose: Pose, elements: int, beam: str) -> None:
    robot = Mechanism.paper()
    dense, sparse = (
        Substructure(elements, beam, solver=solver).modes(robot, pose)
        for solver in ("dense", "sparse")
    )
    np.testing.assert_allclose(sparse.frequencies, dense.frequencies, rtol=1e-9)


def test_sparse_finds_repeated_modes(robot: Mechanism, case1: Pose) -> None:
    modes = Substructure(12, solver="sparse").modes(robot, case1)
    np.testing.assert_allclose(modes.frequencies, frequencies(robot, case1, 12), rtol=1e-9)


def test_shapes_satisfy_the_equations(robot: Mechanism, case2: Pose) -> None:
    """Platform and limb ends move together, and the shapes carry all of the unit modal mass."""
    modes = Substructure(6).modes(robot, case2)
    limbs = limbs_at(robot, case2)
    for i in range(3):
        tips = modes.platform @ rigid_arm(limbs.arms[i]).T
        np.testing.assert_allclose(modes.limbs[:, i, -1], tips, atol=1e-13)
        np.testing.assert_allclose(modes.limbs[:, i, 0], 0, atol=1e-15)
    M_p = platform_mass(robot, case2)
    rod = robot.limbs[0].rod
    mass = np.einsum("mi,ij,mj->m", modes.platform, M_p, modes.platform)
    simpson = np.array([1, 4, 2, 4, 2, 4, 2, 4, 2, 4, 1]) / 30
    for i, length in enumerate(limbs.lengths):
        square = (modes.limbs[:, i] ** 2).sum(axis=2) @ simpson
        mass += rod.material.density * rod.area * length * square
    np.testing.assert_allclose(mass, 1, atol=2e-3)  # Simpson's rule over eleven stations


def test_matrices_are_the_rayleigh_quotient(robot: Mechanism, case2: Pose) -> None:
    model = Substructure(2, "timoshenko")
    K, M = (matrix.toarray() for matrix in model.matrices(robot, case2))
    np.testing.assert_allclose(K, K.T, atol=1e-9 * np.abs(K).max())
    values = scipy.linalg.eigh(K, M, eigvals_only=True)
    assert (values > 0).all()
    found = model.modes(robot, case2, 36).frequencies
    np.testing.assert_allclose(np.sqrt(values) / (2 * np.pi), found, rtol=1e-9)


def test_unequal_limbs_and_any_inertia() -> None:
    """A limb split in two halves side by side moves as before, besides moving against itself."""
    steel = Material(200e9, 77e9, 7820)
    whole, half = Rod(steel, 0.1), Rod(Material(100e9, 38.5e9, 3910), 0.1)
    inertia = ((0.3, 0.05, 0.0), (0.05, 0.4, 0.02), (0.0, 0.02, 0.5))
    limbs = Mechanism.regular(0.3, 0.2, whole, Platform(20, inertia)).limbs
    last = limbs[2]
    halves = (Limb.rps(last.base, last.axis, last.platform_point, half),) * 2
    pose = Pose(0.5, 0.3, 0.2)
    one = frequencies(Mechanism(limbs, Platform(20, inertia)), pose)
    split = Mechanism((*limbs[:2], *halves), Platform(20, inertia))
    other = Substructure(3).modes(split, pose, 12).frequencies
    closest = other[np.abs(other - one[:, None]).argmin(axis=1)]
    np.testing.assert_allclose(closest, one, rtol=1e-9)
    assert len(set(closest)) == 6
