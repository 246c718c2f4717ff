"""Many mechanisms a call: each as its own full model has it."""

from dataclasses import replace

import numpy as np
import pytest

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
    limbs_at,
)
from analytic.designs import Designs, design_frequencies

POISSON = 0.3


def some_designs(count: int, seed: int, stoutest: float = 0.15) -> Designs:
    """Rods from slender to stout, tilted and upright, heavy platforms and light ones."""
    random = np.random.default_rng(seed)
    draw = random.uniform
    mass = draw(5, 60, count)
    r = draw(0.1, 0.3, count)
    tilt = np.where(np.arange(count) % 3 == 0, 0.0, draw(-0.4, 0.4, count))
    return Designs(
        draw(0.35, 0.8, count), draw(-3, 3, count), tilt, draw(0.1, 0.5, count), r,
        draw(0.03, stoutest, count), draw(60e9, 220e9, count), draw(2000, 9000, count), mass,
        mass * r**2 * draw(0.3, 0.4, count), mass * r**2 * draw(0.4, 0.6, count),
    )  # fmt: skip


def mechanism(designs: Designs, i: int, heading: float = 0.0) -> tuple[Mechanism, Pose]:
    material = Material(
        designs.young[i], designs.young[i] / (2 * (1 + POISSON)), designs.density[i]
    )
    moments = (designs.across[i], designs.across[i], designs.polar[i])
    robot = Mechanism.regular(
        designs.base_radius[i],
        designs.platform_radius[i],
        Rod(material, designs.diameter[i]),
        Platform.diagonal(designs.mass[i], moments),
        heading=heading,
    )
    return robot, Pose(designs.z[i], designs.azimuth[i], designs.tilt[i])


@pytest.mark.parametrize(
    ("beam", "elements"),
    [
        ("euler-bernoulli", 3),
        pytest.param("rayleigh", 3, marks=pytest.mark.slow),
        pytest.param("timoshenko", 3, marks=pytest.mark.slow),
        pytest.param("timoshenko", None, marks=pytest.mark.slow),
    ],
)
def test_equals_the_model_of_each_design(beam, elements):
    designs = some_designs(6, 4)
    found = design_frequencies(designs, elements, beam=beam, poisson=POISSON, heading=0.4)
    model = Continuum(beam) if elements is None else Substructure(elements, beam)
    expected = [model.modes(*mechanism(designs, i, 0.4)).frequencies for i in range(6)]
    np.testing.assert_allclose(found, expected, rtol=1e-8)


def test_mirrored_frames_are_those_of_limbs_from_above():
    """A rod has no up and down: leaning to the wrong side is hanging from B_i mirrored in A_i.

    Where the platform is level it is then a mirror image of the mechanism, which sounds alike.
    """
    one = some_designs(3, 5)
    one = replace(one, tilt=np.array([0.3, -0.2, 0.0]))
    found = design_frequencies(replace(one, mirrored=True), 3)
    stated = design_frequencies(one, 3)
    for i in range(3):
        robot, pose = mechanism(one, i)
        tips = limbs_at(robot, pose).arms[:, 2] + pose.z
        hanging = [
            Limb.rps((*limb.base[:2], 2 * tip), limb.axis, limb.platform_point, limb.rod)
            for limb, tip in zip(robot.limbs, tips, strict=True)
        ]
        above = Substructure(3).modes(Mechanism(tuple(hanging), robot.platform), pose)
        np.testing.assert_allclose(found[i], above.frequencies, rtol=1e-8)
    np.testing.assert_allclose(found[2], stated[2], rtol=1e-9)
    assert (np.abs(found[:2] / stated[:2] - 1).max(axis=1) > 0.005).all()


def test_scale_and_material_only_enter_as_they_must():
    """Twice as long halves all frequencies; so does a quarter of E / rho."""
    one = some_designs(5, 6)
    f = design_frequencies(one, 3)
    lengths = ("z", "base_radius", "platform_radius", "diameter")
    longer = {name: 2 * getattr(one, name) for name in lengths}
    grown = replace(one, **longer, mass=8 * one.mass, across=32 * one.across, polar=32 * one.polar)
    np.testing.assert_allclose(design_frequencies(grown, 3), f / 2, rtol=1e-9)
    softer = replace(one, young=one.young / 4)
    np.testing.assert_allclose(design_frequencies(softer, 3), f / 2, rtol=1e-9)


def test_bad_designs_are_refused():
    good = some_designs(2, 7)
    with pytest.raises(InputError, match=r"Designs\.diameter"):
        replace(good, diameter=np.array([0.1, -0.1]))
    with pytest.raises(InputError, match=r"Designs\.tilt"):
        replace(good, tilt=np.array([0.1, np.nan]))
    with pytest.raises(InputError, match="matching shapes"):
        replace(good, z=np.ones(3))
