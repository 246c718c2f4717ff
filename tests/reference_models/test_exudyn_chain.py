"""Limbs of any chain in Exudyn: another program's beams, joints and assembly."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import scipy.linalg

from analytic import (
    Continuum,
    Freedom,
    InputError,
    Joint,
    Limb,
    Link,
    Material,
    Mechanism,
    Platform,
    Pose,
    Rod,
    Section,
)
from analytic.mechanism import Item
from analytic.pairing import pair
from reference_models.exudyn.beam import ExudynBeam
from reference_models.exudyn.cable import ExudynCable
from reference_models.exudyn.chain import chain_modes
from reference_models.exudyn.chain_beams import add_beams
from reference_models.mujoco.chain import MujocoChain
from reference_models.richardson import Richardson


def test_the_papers_limbs_as_chains_are_those_of_the_model_for_them() -> None:
    robot, pose = Mechanism.paper(), Pose(0.49, 0.2, -0.2)
    model = ExudynBeam(6)
    add = partial(add_beams, 6, model._kappas)
    found = chain_modes("exudyn-beam", "", 6, add, robot, pose, 8)
    known = model.modes(robot, pose, 8)
    assert found.frequencies == pytest.approx(known.frequencies, rel=1e-8)
    assert np.abs(found.limbs - known.limbs).max() < 1e-5 * np.abs(known.limbs).max()


STEEL = Material(200e9, 77e9, 7820)


def three(*chain: Item) -> Mechanism:
    """Three equal limbs of a chain under a plate."""
    limb = Limb((0.3, 0, 0), (0.2, 0, 0), chain)
    limbs = tuple(limb.turned(2 * np.pi * k / 3) for k in range(3))
    return Mechanism(limbs, Platform.disc(0.2, 0.02, 7820))


LINKED = three(
    Joint.revolute((0, 1, 0)), Link(0.1), Rod.round(STEEL, 0.05), Link(0.05), Joint.spherical()
)
POSE = Pose(0.5, 0.3, 0.15)


def test_rigid_links_are_taken() -> None:
    """At the joints they lengthen the rod's ends; shapes go along them."""
    found = Richardson(ExudynBeam(8), ExudynBeam(16), 2).modes(LINKED, POSE, 8)
    exact = Continuum("timoshenko").modes(LINKED, POSE, 8)
    assert found.frequencies == pytest.approx(exact.frequencies, rel=3e-4)
    assert (pair(found, exact, LINKED, POSE).assurance > 0.999).all()


LEANING = Joint((Freedom("rotation", (0, 1, 0)), Freedom("rotation", (1, 1, 0), "base", 1e5)))


@pytest.mark.parametrize(
    "chain",
    [(LEANING, Rod.round(STEEL, 0.05), Joint.spherical()),
     (Joint.revolute((0, 1, 0)), Joint.prismatic(None, 1e8), Rod.round(STEEL, 0.05),
      Joint.spherical())],
    ids=["skew", "two"],
)  # fmt: skip
def test_skew_freedoms_and_two_joints_at_a_place_are_taken(chain: tuple[Item, ...]) -> None:
    robot = three(*chain)
    found = Richardson(ExudynBeam(8), ExudynBeam(16), 2).modes(robot, POSE, 8)
    exact = Continuum("timoshenko").modes(robot, POSE, 8)
    np.testing.assert_allclose(found.frequencies, exact.frequencies, rtol=3e-4)
    assert (pair(found, exact, robot, POSE).assurance > 0.999).all()
    # Springs along other axes are another robot.
    square = Joint((LEANING.freedoms[0], Freedom("rotation", (1, 0, 0), "base", 1e5)))
    other = Continuum("timoshenko").modes(three(square, *chain[1:]), POSE, 8).frequencies
    assert np.abs(other / exact.frequencies - 1).max() > 0.01


def test_what_exudyn_cannot_take_is_said() -> None:
    robot = three(Joint.spherical(), LEANING, Rod.round(STEEL, 0.05), Joint.spherical())
    with pytest.raises(InputError, match=r"limb 1, .*independent freedoms at a place"):
        ExudynBeam(4).modes(robot, POSE)


def test_cables_take_what_twists_no_rod() -> None:
    """Springs at the base, two rods on a drive that gives way sideways too."""
    base = Joint((
        Freedom("rotation", (0, 1, 0), stiffness=3e5),
        Freedom("rotation", (1, 0, 0), "limb", 2e5),
        Freedom("translation", (0, 0, 1), stiffness=1e8),
        Freedom("translation", (0, 1, 0), stiffness=4e7),
    ))  # fmt: skip
    drive = Joint((
        Freedom("translation", (0, 0, 1), "limb", 6e7),
        Freedom("translation", (1, 0, 0), "limb", 9e7),
        Freedom("rotation", (0, 1, 0), "limb", 5e5),
    ))  # fmt: skip
    tube = replace(Rod.round(STEEL, 0.06, 0.04), length=0.2)
    robot = three(base, tube, drive, Rod.round(STEEL, 0.04), Joint.spherical())
    pose = replace(POSE, x=0.0, y=0.0, azimuth=0.0, tilt=0.0)
    found = ExudynCable(12).modes(robot, pose, 6)
    exact = Continuum().modes(robot, pose, 6)
    np.testing.assert_allclose(found.frequencies, exact.frequencies, rtol=1e-6)
    assert (pair(found, exact, robot, pose).assurance > 0.999).all()
    assert found.residual is not None and found.residual < 1e-12


@pytest.mark.parametrize(
    ("chain", "said"),
    [
        ((Joint.universal((0, 1, 1)), Rod.round(STEEL, 0.05), Joint.spherical()), "turn about it"),
        ((Joint.spherical(), Rod.round(STEEL, 0.05), Joint.universal((0, 1, 0))), "a ball"),
        ((Joint.revolute((0, 1, 0)), Link(0.1), Rod.round(STEEL, 0.05), Joint.spherical()),
         "rods and joints"),
        ((Joint.revolute((0, 1, 0)), Rod(STEEL, Section(1e-3, (1e-7, 2e-7), 1e-7)),
          Joint.spherical()), "alike in every direction"),
    ],
)  # fmt: skip
def test_cables_refuse_what_has_torsion_to_carry(chain: tuple[Item, ...], said: str) -> None:
    pose = replace(POSE, x=0.0, y=0.0, azimuth=0.0, tilt=0.0)
    with pytest.raises(InputError, match=f"limb 1, .*{said}.*no torsion to carry"):
        ExudynCable(4).modes(three(*chain), pose)


@pytest.mark.parametrize("model", [ExudynBeam(2), MujocoChain(2)], ids=["beam", "chain"])
def test_rigid_struts_on_springs_are_six_springs(model: ExudynBeam | MujocoChain) -> None:
    """A hexapod without rods: K = sum k a a^T of struts along a = (z, arm x z)."""
    k, drive = 2e7, Joint.prismatic(None, 2e7)
    struts = [
        Limb(
            (0.6 * np.cos(b), 0.6 * np.sin(b), 0.0),
            (0.4 * np.cos(p), 0.4 * np.sin(p), 0.0),
            (Joint.universal((0, 0, 1)), Link(0.3), drive, Link(), Joint.spherical()),
        )
        for turn in range(3)
        for b, p in ((2 * np.pi * turn / 3 + s * 0.2, 2 * np.pi * turn / 3 + s * 0.8)
                     for s in (-1, 1))
    ]  # fmt: skip
    plate = Platform(42.0, ((1.6, 0, 0), (0, 1.6, 0), (0, 0, 3.1)), centre=(0, 0, 0.02))
    robot, at = Mechanism(tuple(struts), plate), np.array([0.05, -0.02, 0.7])
    rows = []
    for strut in struts:
        arm = np.array(strut.platform_point)
        span = at + arm - np.array(strut.base)
        z = span / np.linalg.norm(span)
        rows.append(np.concatenate([z, np.cross(arm, z)]))
    K = k * np.array(rows).T @ np.array(rows)
    omega2 = scipy.linalg.eigh(K, plate.mass_matrix, eigvals_only=True)
    found = model.modes(robot, Pose.at(at), 6)
    np.testing.assert_allclose(found.frequencies, np.sqrt(omega2) / (2 * np.pi), rtol=1e-7)
    # Struts are rigid but for their drives: their lines are straight on either side.
    np.testing.assert_allclose(found.limbs[:, :, 0], 0, atol=1e-9 * np.abs(found.limbs).max())
