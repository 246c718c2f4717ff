"""Limbs of any chain in Exudyn: another program's beams, joints and assembly."""

import numpy as np
import pytest

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
)
from analytic.mechanism import Item
from analytic.pairing import pair
from reference_models.exudyn.beam import ExudynBeam
from reference_models.exudyn.chain import chain_modes
from reference_models.mujoco.chain import MujocoChain
from reference_models.richardson import Richardson


def test_the_papers_limbs_as_chains_are_those_of_the_model_for_them() -> None:
    robot, pose = Mechanism.paper(), Pose(0.49, 0.2, -0.2)
    model = ExudynBeam(6)
    found = chain_modes("exudyn-beam", "", 6, model._kappas, robot, pose, 8)
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


def test_what_exudyn_cannot_take_is_said() -> None:
    rod = Rod.round(STEEL, 0.05)
    leaning = Joint((Freedom("rotation", (0, 1, 0)), Freedom("rotation", (1, 1, 0), "base", 1e5)))
    for robot, said in (
        (three(leaning, rod, Joint.spherical()), "right angles"),
        (three(Joint.revolute((0, 1, 0)), Joint.prismatic(None, 1e8), rod, Joint.spherical()),
         "one joint at a place"),
    ):  # fmt: skip
        with pytest.raises(InputError, match=f"limb 1, .*{said}"):
            ExudynBeam(4).modes(robot, POSE)
        # Others do take it.
        known = Continuum().modes(robot, POSE).frequencies
        chain = Richardson(MujocoChain(8), MujocoChain(16), 2).modes(robot, POSE).frequencies
        np.testing.assert_allclose(chain, known, rtol=1e-4)
