"""Tabulated solid limbs against the meshes they come from, and the cache that keeps them."""

import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest

from analytic import InputError, Material, Mechanism, Platform, Pose, Rod
from analytic.pairing import pair
from reference_models import UnavailableError, parse, reference
from reference_models.folder import default_folder
from reference_models.solid import cache
from reference_models.solid.cache import CacheWarning, TabledLimb
from reference_models.solid.limb import SolidLimb
from reference_models.solid.table import LimbTable, coefficients, nodes, position_in

pytest.importorskip("ngsolve", reason="ngsolve is not installed")

from reference_models.solid.ngsolve import NgsolveSolid

Poses = Callable[[int, int], Pose]
COARSE = (2, 1)
"""Elements and order of rods that take milliseconds; what is tested does not depend on them."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("tables")


@pytest.fixture(scope="module")
def others(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("others")


@pytest.fixture(scope="module")
def model(folder: Path) -> SolidLimb:
    return TabledLimb(*COARSE).limb(folder)


@pytest.fixture
def cached(model: SolidLimb, folder: Path, robot: Mechanism, case2: Pose) -> Iterator[Path]:
    """The one file that case 2 needs, with its table made."""
    model.frequencies(robot, case2)
    (path,) = [p for p in folder.iterdir() if _octave(p) == 2]
    content = path.read_bytes()
    yield path
    path.write_bytes(content)


def _anew(*settings: object, folder: Path) -> SolidLimb:
    """Return a limb as a new process would make it."""
    cache._limb.cache_clear()
    return TabledLimb(*settings).limb(folder)  # type: ignore[arg-type]


def _octave(path: Path) -> int:
    with np.load(BytesIO(path.read_bytes()[:-32])) as stored:
        return int(stored["octave"])


@pytest.mark.slow
@pytest.mark.parametrize("count", [5, pytest.param(50, marks=pytest.mark.slow)])
def test_poses_are_those_of_the_meshed_rods(
    model: SolidLimb, robot: Mechanism, workspace_poses: Poses, count: int
) -> None:
    poses = workspace_poses(count, 21)
    direct = NgsolveSolid(*COARSE)
    truth = np.array([direct.modes(robot, pose).frequencies for pose in poses])
    found = model.frequencies(robot, poses)
    assert np.abs(found / truth - 1).max() < 2e-5


@pytest.mark.slow
def test_the_tables_error_is_bounded_and_the_bound_is_no_idle_one(
    model: SolidLimb, robot: Mechanism, workspace_poses: Poses
) -> None:
    """Every mode at every pose, the pose whose modes come in pairs too."""
    direct, shares = NgsolveSolid(*COARSE), []
    for pose in [Pose(0.49), *workspace_poses(15, 24)]:
        truth, found = direct.modes(robot, pose, 8), model.modes(robot, pose, 8)
        assert found.uncertainty is not None
        shares.append(np.abs(found.frequencies - truth.frequencies) / found.uncertainty)
        assert (found.uncertainty < 2e-4 * found.frequencies).all()
        assert (found.uncertainty[:6] < 1e-5 * found.frequencies[:6]).all()
    assert np.max(shares) < 1
    assert np.max(shares) > 0.1


def test_beyond_what_was_compared_nothing_is_said(
    model: SolidLimb, robot: Mechanism, case2: Pose
) -> None:
    assert model.modes(robot, case2, 20).uncertainty is None


@pytest.mark.slow
@pytest.mark.parametrize("faces", ["rigid", "averaged"])
def test_quadratic_rods_too(
    others: Path, robot: Mechanism, workspace_poses: Poses, faces: str
) -> None:
    poses = workspace_poses(3, 22)
    poses = replace(poses, z=0.5 + poses.z / 5)  # limbs of 4 to 8 diameters: one table
    direct = NgsolveSolid(1, 2, faces)
    truth = np.array([direct.modes(robot, pose).frequencies for pose in poses])
    found = TabledLimb(1, 2, faces).limb(others).frequencies(robot, poses)
    assert np.abs(found / truth - 1).max() < 2e-5


@pytest.mark.parametrize("faces", ["rigid", pytest.param("averaged", marks=pytest.mark.slow)])
def test_shapes_are_those_of_the_meshed_rods(
    others: Path, robot: Mechanism, case2: Pose, faces: str
) -> None:
    direct = NgsolveSolid(*COARSE, faces).modes(robot, case2, 9)
    tabled = TabledLimb(*COARSE, faces).limb(others).modes(robot, case2, 9)
    np.testing.assert_allclose(tabled.frequencies, direct.frequencies, rtol=1e-4)
    paired = pair(direct, tabled, robot, case2)
    np.testing.assert_array_equal(paired.partner, range(9))
    assert paired.assurance.min() > 1 - 1e-5
    np.testing.assert_allclose(tabled.platform[:6], direct.platform[:6], rtol=1e-3, atol=1e-5)
    np.testing.assert_allclose(tabled.limbs[:6], direct.limbs[:6], rtol=1e-3, atol=1e-4)
    assert tabled.theory == f"3-D elasticity, {faces} end faces"
    assert tabled.uncertainty is not None


def test_many_poses_in_any_shape(
    model: SolidLimb, robot: Mechanism, workspace_poses: Poses
) -> None:
    poses = workspace_poses(1200, 23)
    many = model.frequencies(robot, poses, 8)
    assert many.shape == (1200, 8)
    for i in (0, 499, 500, 1199):
        np.testing.assert_allclose(model.modes(robot, poses[i], 8).frequencies, many[i], rtol=1e-9)
        np.testing.assert_allclose(model.frequencies(robot, poses[i], 8), many[i], rtol=1e-9)
    square = Pose(*(np.reshape(v[:6], (2, 3)) for v in (poses.z, poses.azimuth, poses.tilt)))
    np.testing.assert_allclose(
        model.frequencies(robot, square), many[:6, :6].reshape(2, 3, 6), rtol=1e-9
    )


def test_rods_and_octaves_may_differ(model: SolidLimb) -> None:
    light = Rod(Material(100e9, 38.5e9, 4400.0), 0.06)  # the same Poisson ratio: one table
    steel = Rod(Material(200e9, 77e9, 7820.0), 0.08)
    robot = Mechanism.regular(0.3, 0.2, steel, Platform.disc(0.2, 0.02, 7820.0), limbs=4)
    mixed = replace(robot, limbs=(robot.limbs[0].with_rod(light), *robot.limbs[1:]))
    pose = Pose(0.62)
    truth = NgsolveSolid(*COARSE).modes(mixed, pose).frequencies
    np.testing.assert_allclose(model.frequencies(mixed, pose), truth, rtol=2e-5)


def test_it_is_a_model_like_any_other(
    robot: Mechanism, case2: Pose, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    named = reference("solid-limb", 2, order=1)
    assert parse("solid-limb", "models").elements == 4
    assert named.info().theory == reference("ngsolve-solid").info().theory
    found = named.modes(robot, case2)
    many = named.frequencies(
        robot, Pose(*(np.array([x]) for x in (0.49, case2.azimuth, case2.tilt)))
    )
    np.testing.assert_allclose(many[0], found.frequencies, rtol=1e-9)
    direct = reference("ngsolve-solid", 2, order=1).modes(robot, case2)
    np.testing.assert_allclose(found.frequencies, direct.frequencies, rtol=1e-5)


def test_a_chebyshev_series_gives_back_polynomials() -> None:
    a = nodes(2, 6)
    assert a.min() > 4
    assert a.max() < 8
    values = np.stack([a**-3.0, 2 + a**-1.0], axis=1)
    where = np.array([4.0, 5.0, 8.0])
    found = np.polynomial.chebyshev.chebval(position_in(2, where), coefficients(values))
    np.testing.assert_allclose(found, [where**-3.0, 2 + where**-1.0], rtol=1e-12)


def test_a_kept_table_is_not_made_again(
    cached: Path, robot: Mechanism, case2: Pose, monkeypatch: pytest.MonkeyPatch, model: SolidLimb
) -> None:
    def made(*_: object) -> LimbTable:
        raise AssertionError("made again")

    monkeypatch.setattr(cache, "limb_table", made)
    again = _anew(*COARSE, folder=cached.parent).frequencies(robot, case2)
    np.testing.assert_array_equal(again, model.frequencies(robot, case2))
    # Whatever the table depends on is in its name.
    for settings in ((1, 1, "rigid"), (1, 2, "rigid"), (2, 1, "averaged")):
        with pytest.raises(AssertionError, match="made again"):
            _anew(*settings, folder=cached.parent).frequencies(robot, case2)


@pytest.mark.parametrize(
    "damage",
    [
        lambda b: b"",
        lambda b: b"no table",
        lambda b: b[: len(b) // 2],
        lambda b: b[:2000] + bytes([b[2000] ^ 1]) + b[2001:],
        lambda b: b[:-1],
    ],
    ids=["empty", "nonsense", "cut", "a bit", "a byte short"],
)
def test_a_damaged_file_is_named_and_made_anew(
    cached: Path,
    robot: Mechanism,
    case2: Pose,
    model: SolidLimb,
    monkeypatch: pytest.MonkeyPatch,
    damage: Callable[[bytes], bytes],
) -> None:
    whole = cached.read_bytes()
    cached.write_bytes(damage(whole))
    known = model.tables(robot.limbs[0].rod.material.poisson, 2)
    monkeypatch.setattr(cache, "limb_table", lambda held, octave: known)
    with pytest.warns(CacheWarning, match=f"{cached.name} is damaged"):
        found = _anew(*COARSE, folder=cached.parent).frequencies(robot, case2)
    np.testing.assert_array_equal(found, model.frequencies(robot, case2))
    assert cached.read_bytes() == whole
    assert not [p for p in cached.parent.iterdir() if p.name.startswith(".")]


def test_a_folder_that_cannot_be_written_costs_only_the_file(
    tmp_path: Path, robot: Mechanism, case2: Pose, model: SolidLimb
) -> None:
    taken = tmp_path / "taken"
    taken.write_text("a file where the folder should be")
    with pytest.warns(CacheWarning, match="taken") as caught:
        found = _anew(*COARSE, folder=taken).frequencies(robot, case2)
    assert any("will not be kept" in str(warning.message) for warning in caught)
    np.testing.assert_array_equal(found, model.frequencies(robot, case2))


def test_the_users_cache_folder(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert default_folder() == tmp_path / "rps-bench"
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert default_folder() == Path.home() / ".cache" / "rps-bench"


def test_misuse_is_named(model: SolidLimb, robot: Mechanism, case2: Pose) -> None:
    with pytest.raises(InputError, match="2 to 64 diameters"):
        model.frequencies(robot, Pose(0.1))
    with pytest.raises(InputError, match="2 to 64 diameters"):
        model.frequencies(robot, Pose(7.0))
    with pytest.raises(InputError, match="count = 500"):
        model.frequencies(robot, case2, 500)
    for count in (0, 1.5, True):
        with pytest.raises(InputError, match="count"):
            model.frequencies(robot, case2, count)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="one pose"):
        model.modes(robot, Pose(np.array([0.4, 0.5])))
    with pytest.raises(InputError, match="faces = 'soft'"):
        reference("solid-limb", faces="soft")


def test_without_ngsolve_it_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ngsolve", None)
    with pytest.raises(UnavailableError, match="ngsolve is not installed"):
        reference("solid-limb")
