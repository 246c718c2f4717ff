"""NGSolve's solid rods against accepted limits, beams, closed forms, symmetry and misuse."""

import builtins
import sys
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.linalg

from analytic import (
    Continuum,
    InputError,
    Limb,
    Material,
    Mechanism,
    Platform,
    Pose,
    Rod,
    Substructure,
    Theory,
    limbs_at,
)
from analytic.dynamic_stiffness import limb_stiffness
from analytic.pairing import pair
from analytic.waves import sections
from reference_models import ModelError, UnavailableError, reference

pytest.importorskip("ngsolve", reason="ngsolve is not installed")

from reference_models.solid import ngsolve as ngsolve_solid
from reference_models.solid import ngsolve_mesh
from reference_models.solid.faces import hold
from reference_models.solid.ngsolve import NgsolveAveraged, NgsolveSolid, held_rods, lowest
from reference_models.solid.ngsolve_mesh import solid_rod
from reference_models.solid.reduction import PARTS, spectrum, statics
from reference_models.solid.rod import FAMILIES, SLENDERNESS

COARSE = (2, 1)
"""Elements and order for what does not depend on the mesh."""
STEEL = Material(200e9, 77e9, 7820.0)
# Limits of solid rods at cases 1 and 2, from meshes and programs outside this project.
LIMITS = {
    "rigid": [
        [136.65, 136.65, 233.80, 759.14, 838.92, 838.92],
        [123.72, 148.11, 238.16, 692.22, 851.73, 897.79],
    ],
    "averaged": [
        [135.88, 135.88, 232.33, 758.60, 838.01, 838.01],
        [123.06, 147.25, 236.65, 691.77, 850.91, 896.34],
    ],
}


def test_the_mesh_is_a_quarter_of_a_round_rod() -> None:
    rod = solid_rod(STEEL.poisson, 2, 2)
    one, x, y = rod.fields
    zero = np.zeros_like(one)
    volume = np.pi / 16 * SLENDERNESS
    assert np.r_[one, zero, zero] @ rod.mass @ np.r_[one, zero, zero] == pytest.approx(
        volume, rel=5e-4
    )
    A, B, C = rod.stiffness
    for still in (np.r_[one, zero, zero], np.r_[-y, x, zero]):
        np.testing.assert_allclose([abs(M @ still).max() for M in (A, B, C)], 0, atol=1e-13)
    # Stretched across by 1 in x: energy (lambda + 2 mu) V, all of it in A.
    nu = STEEL.poisson
    modulus = (1 - nu) / ((1 + nu) * (1 - 2 * nu))
    wider = np.r_[x, zero, zero]
    assert wider @ A @ wider == pytest.approx(modulus * volume, rel=5e-4)
    assert abs(wider @ C @ wider) < 1e-12
    np.testing.assert_allclose(rod.axis @ one, 1, atol=1e-12)
    np.testing.assert_allclose(rod.axis @ x, 0, atol=1e-12)
    np.testing.assert_allclose(rod.weights["tip"][0] @ one, np.pi / 16, rtol=1e-3)
    np.testing.assert_allclose(rod.weights["base"][2] @ y, np.pi / 256, rtol=1e-3)


@pytest.mark.parametrize("faces", ["rigid", "averaged"])
@pytest.mark.parametrize("aspect", [4.0, 8.0, 16.0])
def test_a_slender_solid_rod_is_a_timoshenko_beam(faces: str, aspect: float) -> None:
    robot = Mechanism.paper()
    rod = robot.limbs[0].rod
    material, d = rod.material, rod.diameter
    held = held_rods(material.poisson, 2, 2, faces)
    seen = {family: spectrum(held[family], aspect / SLENDERNESS) for family in FAMILIES}
    unit = material.young / (material.density * d**2)
    # To and beyond the first pole, and not on it.
    lam = np.array([0.1, 0.5, 0.8, 1.2, 1.5]) * seen["x"].poles[0]
    beam = limb_stiffness(
        sections(robot, Theory("timoshenko")), np.array(aspect * d), lam[:, None] * unit, None
    )[:, 0].real
    size = np.abs(beam) + np.abs(beam[0])
    for i, family in enumerate("xyz"):
        solid = PARTS * material.young * d * seen[family].stiffness(lam)
        # Faces kept plane stiffen a rod by about a tenth of a diameter of its length.
        assert np.max(np.abs(solid - beam[:, i]) / size[:, i]) < (0.5 if i < 2 else 0.15) / aspect
    shaft = np.pi / 2 / aspect * np.sqrt(material.shear / material.young)
    np.testing.assert_allclose(seen["twist"].poles[0], shaft**2, rtol=1e-3)


@pytest.mark.parametrize("family", FAMILIES)
def test_averaged_faces_are_held_by_their_average(family: str) -> None:
    rod = solid_rod(STEEL.poisson, 2, 2)
    held = hold(rod, family, "averaged")
    part = statics(held, 1.0)
    if not held.driven:
        assert part.tip == (0.0, 0.0)
        return
    # Statics: the energy of t = 1 is that of a rod driven at its tip; the bar's is E A / L.
    rigid = statics(hold(rod, family, "rigid"), 1.0).tip[0]
    if family == "x":
        assert abs(part.tip[0]) < 1e-10
        assert abs(rigid) < 1e-10
    else:
        assert 0.97 * rigid < part.tip[0] < rigid
    if family == "z":
        assert PARTS * part.tip[0] == pytest.approx(np.pi / 4 / SLENDERNESS, rel=1e-3)


@pytest.mark.parametrize("faces", ["rigid", "averaged"])
@pytest.mark.parametrize("case", [1])
def test_coarse_rods_are_near_the_limits(
    robot: Mechanism, case1: Pose, case2: Pose, faces: str, case: int
) -> None:
    found = NgsolveSolid(2, faces=faces).modes(robot, (case1, case2)[case])
    np.testing.assert_allclose(found.frequencies, LIMITS[faces][case], rtol=1.2e-3)
    assert found.theory == f"3-D elasticity, {faces} end faces"
    assert found.residual is not None
    assert found.residual < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("case", [0, 1])
def test_rods_with_rigid_faces_extrapolate_to_the_limits(
    robot: Mechanism, case1: Pose, case2: Pose, case: int
) -> None:
    found = reference("ngsolve-solid", elements=(2, 4)).modes(robot, (case1, case2)[case])
    np.testing.assert_allclose(found.frequencies, LIMITS["rigid"][case], rtol=1.5e-4)


@pytest.mark.slow
def test_fine_rods_with_averaged_faces_are_at_the_limits(robot: Mechanism, case2: Pose) -> None:
    found = NgsolveSolid(4, faces="averaged").modes(robot, case2)
    np.testing.assert_allclose(found.frequencies, LIMITS["averaged"][1], rtol=1.5e-4)


@pytest.mark.slow
def test_the_clamped_rim_makes_convergence_slow() -> None:
    """Cubic elements would give h^6: the rim's r^-0.29 leaves about h^1.4, averaged faces less."""
    error = {}
    for faces in ("rigid", "averaged"):
        rods = [hold(solid_rod(STEEL.poisson, n, 3), "y", faces) for n in (1, 2, 4)]
        k = np.array([statics(rod, 1.0).tip[0] for rod in rods])
        order = np.log2((k[0] - k[1]) / (k[1] - k[2]))
        assert 0.7 < order < 2
        error[faces] = (k[1] - k[2]) / k[2]
    assert error["averaged"] < 0.05 * error["rigid"] < 1e-4


def test_shapes_are_those_of_beams(robot: Mechanism, case2: Pose) -> None:
    solid = NgsolveSolid(2).modes(robot, case2)
    beam = Substructure(16, beam="timoshenko").modes(robot, case2)
    paired = pair(beam, solid, robot, case2)
    np.testing.assert_array_equal(paired.partner, range(6))
    assert paired.assurance.min() > 0.999
    # Both scaled to unit modal mass.
    size = np.linalg.norm(beam.platform, axis=1)[:, None]
    np.testing.assert_allclose(solid.platform / size, beam.platform / size, atol=0.03)


@pytest.mark.parametrize("faces", ["rigid", "averaged"])
def test_the_shapes_close_the_joints(robot: Mechanism, case2: Pose, faces: str) -> None:
    modes = NgsolveSolid(*COARSE, faces).modes(robot, case2)
    arms = limbs_at(robot, case2).arms
    joined = modes.platform[:, None, :3] + np.cross(modes.platform[:, None, 3:], arms)
    size = np.abs(modes.limbs).max()
    # The middle of an averaged face is near its average; a rigid one moves as one.
    gap = 1e-9 if faces == "rigid" else 0.03
    np.testing.assert_allclose(modes.limbs[:, :, -1] / size, joined / size, atol=gap)
    np.testing.assert_allclose(modes.limbs[:, :, 0] / size, 0, atol=gap)


def test_turning_the_mechanism_changes_nothing(robot: Mechanism, case2: Pose) -> None:
    model = NgsolveSolid(*COARSE)
    turned = replace(case2, azimuth=case2.azimuth + 0.7)
    there = model.modes(Mechanism.paper(heading=0.7), turned)
    here = model.modes(robot, case2)
    np.testing.assert_allclose(there.frequencies, here.frequencies, rtol=1e-9)


def test_a_symmetric_pose_repeats_modes_and_shares_rods(robot: Mechanism, case1: Pose) -> None:
    ngsolve_solid._statics.cache_clear()
    found = NgsolveSolid(*COARSE).modes(robot, case1, 8).frequencies
    assert ngsolve_solid._statics.cache_info().misses == 1
    for i, j in ((0, 1), (4, 5), (6, 7)):
        assert found[i] == pytest.approx(found[j], rel=1e-9)


def test_limbs_twist_by_themselves(robot: Mechanism, case1: Pose) -> None:
    modes = NgsolveSolid(1).modes(robot, case1, 12)
    length = limbs_at(robot, case1).lengths[0]
    shaft = np.sqrt(STEEL.shear / STEEL.density) / (4 * length)
    near = np.abs(modes.frequencies / shaft - 1) < 2e-3
    still = np.abs(modes.limbs).max(axis=(1, 2, 3)) < 1e-6
    assert near.sum() >= 3
    assert (near & still).sum() == 3


@pytest.mark.slow
def test_limbs_may_differ_and_be_any_number() -> None:
    light = Rod(Material(70e9, 26e9, 2700.0), 0.06)
    robot = Mechanism.regular(0.3, 0.2, Rod(STEEL, 0.08), Platform.disc(0.2, 0.02, 7820), limbs=4)
    mixed = replace(robot, limbs=(robot.limbs[0].with_rod(light), *robot.limbs[1:]))
    pose = Pose(0.8)
    found = NgsolveSolid(1).modes(mixed, pose)
    beam = Substructure(16, beam="timoshenko").modes(mixed, pose)
    assert np.abs(found.frequencies / beam.frequencies - 1).max() < 0.015
    assert found.limbs.shape == (6, 4, 11, 3)


def test_the_eigenvalues_are_lapacks_and_repeat() -> None:
    random = np.random.default_rng(5)
    half = random.normal(size=(60, 60))
    M = half @ half.T + 60 * np.eye(60)
    values = np.repeat(np.linspace(1.0, 30.0, 20) ** 2, 3)
    root = np.linalg.cholesky(M)
    Q = np.linalg.qr(random.normal(size=(60, 60)))[0]
    K = root @ Q @ np.diag(values) @ Q.T @ root.T
    found, X = lowest(lambda F: np.linalg.solve(K, F), lambda V: M @ V, 60, 5)
    np.testing.assert_allclose(found, scipy.linalg.eigh(K, M)[0][:5], rtol=1e-9)
    np.testing.assert_allclose(X.T @ M @ X, np.eye(5), atol=1e-9)


def test_without_ngsolve_it_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ngsolve", None)
    assert "pip install 'ngsolve>=6.2.2608'" in NgsolveSolid.info().missing
    with pytest.raises(UnavailableError, match="ngsolve is not installed"):
        reference("ngsolve-solid")
    with pytest.raises(UnavailableError, match="ngsolve is not installed"):
        NgsolveSolid().modes(Mechanism.paper(), Pose(0.49))


def test_without_its_system_library(monkeypatch: pytest.MonkeyPatch) -> None:
    lacking = "libopenblas.so.0: cannot open shared object file: No such file or directory"
    real = builtins.__import__

    def unlinked(module: str, *arguments: Any) -> Any:
        if module == "ngsolve":
            raise ImportError(lacking)
        return real(module, *arguments)

    monkeypatch.setattr(builtins, "__import__", unlinked)
    missing = NgsolveSolid.info().missing
    assert missing.startswith("ngsolve cannot be imported: libopenblas.so.0 is missing; install")
    assert "apt-get install libquadmath0" in missing


def test_a_failing_mesher_is_a_model_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: Any) -> None:
        raise RuntimeError("no mesh")

    monkeypatch.setattr(ngsolve_mesh, "_mesh", fail)
    with pytest.raises(ModelError, match="ngsolve-solid: no mesh"):
        solid_rod(0.123, 1, 1)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda robot: NgsolveSolid(0), "elements = 0"),
        (lambda robot: NgsolveSolid(2.5), "elements = 2.5"),  # type: ignore[arg-type]
        (lambda robot: NgsolveSolid(9), "elements = 9: expected at most 8 with order 2"),
        (lambda robot: NgsolveSolid(order=0), "order = 0"),
        (lambda robot: NgsolveSolid(order=7), "order = 7"),
        (lambda robot: NgsolveSolid(faces="soft"), "faces = 'soft': expected one of rigid"),
        (lambda robot: reference("ngsolve-solid", mesh=3), "settings"),
        (lambda robot: NgsolveSolid(1).modes(robot, Pose(np.array([0.4, 0.5]))), "one pose"),
        (lambda robot: NgsolveSolid(1).modes(robot, Pose(0.49), 0), "count = 0"),
        (lambda robot: NgsolveSolid(1).modes(robot, Pose(0.49), 10**6), "count = 1000000"),
    ],
)
def test_misuse_is_named(robot: Mechanism, call: Callable[[Mechanism], Any], words: str) -> None:
    with pytest.raises(InputError) as caught:
        call(robot)
    assert words in str(caught.value)


def test_a_pose_out_of_the_joints_reach_is_refused(robot: Mechanism) -> None:
    first = robot.limbs[0]
    skewed = Limb.rps(first.base, (1.0, 1.0, 0.0), first.platform_point, first.rod)
    with pytest.raises(InputError, match="revolute joint's plane"):
        NgsolveSolid(1).modes(replace(robot, limbs=(skewed, *robot.limbs[1:])), Pose(0.49, 0, 0.2))


def test_slender_rods_converge_too(robot: Mechanism, case1: Pose) -> None:
    """Modes 60 times apart: rounding of the lowest must not look like the highest's error."""
    thin = Rod(robot.limbs[0].rod.material, 0.02)
    limbs = tuple(limb.with_rod(thin) for limb in robot.limbs)
    slender = Mechanism(limbs, robot.platform)
    found = NgsolveSolid(2).modes(slender, case1, 10).frequencies
    exact = Continuum("timoshenko").modes(slender, case1, 10).frequencies
    np.testing.assert_allclose(found[:6], exact[:6], rtol=5e-3)  # the mesh is stretched fivefold


def test_averaged_faces_have_a_name_of_their_own() -> None:
    averaged = reference("ngsolve-averaged", elements=2).build()
    assert averaged == NgsolveAveraged(2) and averaged.faces == "averaged"
    assert "averaged end faces" in NgsolveAveraged.info().theory
    assert "rigid end faces" in NgsolveSolid.info().theory
