"""Numbers of a description by name: read, changed one by one, and solved many at once."""

from dataclasses import replace

import numpy as np
import pytest

from analytic import (
    Body,
    Freedom,
    InputError,
    Joint,
    Limb,
    Material,
    Mechanism,
    Platform,
    Pose,
    Rod,
    Section,
    Substructure,
)
from analytic.description import PRINTED, numbers, with_numbers
from analytic.designs import Designs, design_frequencies, regular, varied_frequencies

STEEL = Material(200e9, 77e9, 7820.0)
ALUMINIUM = Material(70e9, 26e9, 2700.0)
POSE = Pose(0.49, np.radians(10), np.radians(-12))


def tubes(young: float = 70e9) -> Mechanism:
    """Three limbs of a tube and a rod, a drive between them and a body on it."""
    tube = Rod(
        replace(ALUMINIUM, young=young, shear=26e9 * young / 70e9), Section.round(0.07, 0.05), 0.2
    )
    drive = Joint((Freedom("translation", (0, 0, 1), "limb", 1e8),), name="P")
    nut = Body(1.5, ((0.01, 0, 0), (0, 0.01, 0), (0, 0, 0.01)), frame="limb")
    chain = (Joint.revolute((0, 1, 0)), tube, nut, drive, Rod.round(STEEL, 0.04), Joint.spherical())
    limb = Limb((0.3, 0.0, 0.0), (0.2, 0.0, 0.0), chain)
    limbs = tuple(limb.turned(2 * np.pi * k / 3) for k in range(3))
    return Mechanism(limbs, Platform.diagonal(20.0, (0.25, 0.25, 0.4)))


def test_equal_parts_are_one_number_and_others_are_numbered() -> None:
    found = numbers(tubes(), POSE)
    assert {name: number.value for name, number in found.items()} == pytest.approx(
        {
            "z": 0.49, "azimuth": POSE.azimuth, "tilt": POSE.tilt, "base_radius": 0.3,
            "platform_radius": 0.2, "platform_mass": 20.0, "platform_inertia_xx": 0.25,
            "platform_inertia_zz": 0.4, "rod1_diameter": 0.07, "rod1_bore": 0.05,
            "rod1_length": 0.2, "material1_young": 70e9, "material1_density": 2700.0,
            "body_mass": 1.5, "P_stiffness": 1e8, "rod2_diameter": 0.04,
            "material2_young": 200e9, "material2_density": 7820.0,
        }
    )  # fmt: skip
    assert len(found["rod1_bore"].places) == 3 and len(found["platform_inertia_xx"].places) == 2


def test_a_changed_number_is_that_of_a_mechanism_made_so() -> None:
    """Poisson's ratio stays, a tube grows with its hole, and moments change together."""
    moved, there = with_numbers(tubes(), POSE, {"material1_young": 80e9, "z": 0.5})
    assert there == replace(POSE, z=0.5)
    model = Substructure(2)
    expected = model.frequencies(tubes(80e9), there)
    np.testing.assert_allclose(model.frequencies(moved, there), expected, rtol=1e-10)
    both = {"rod1_diameter": 0.04, "rod1_bore": 0.03, "platform_inertia_xx": 1.0,
            "platform_inertia_zz": 1.9, "base_radius": 0.33}  # fmt: skip
    found = numbers(*with_numbers(tubes(), POSE, both))
    assert {name: found[name].value for name in both} == pytest.approx(both)
    assert with_numbers(tubes(), POSE, {}) == (tubes(), POSE)
    with pytest.raises(InputError, match="less than the diameter"):
        with_numbers(tubes(), POSE, {"rod1_bore": 0.08})
    with pytest.raises(InputError, match="none exceeds the sum"):
        with_numbers(tubes(), POSE, {"platform_inertia_zz": 0.6})


@pytest.mark.parametrize("printed", [False, True])
def test_a_disc_has_its_sizes(printed: bool) -> None:
    """Whatever they were made of, and whether Eq. 8 or the body made the moments of them."""
    make = Platform.as_printed if printed else Platform.disc
    robot = replace(Mechanism.paper(), platform=make(0.2, 0.02, 7820.0))
    found = numbers(robot, POSE)
    sizes = {"disc_radius": 0.2, "platform_thickness": 0.02, "platform_density": 7820.0}
    assert {name: found[name].value for name in sizes} == pytest.approx(sizes, rel=1e-12)
    other = {"disc_radius": 0.25, "platform_thickness": 0.03, "platform_density": 2700.0}
    other |= {"platform_radius": 0.25} if printed else {}
    moved, _ = with_numbers(robot, POSE, other)
    expected = make(0.25, 0.03, 2700.0)
    assert moved.platform.mass == pytest.approx(expected.mass)
    np.testing.assert_allclose(moved.platform.inertia, expected.inertia, rtol=1e-12)
    swapped, _ = with_numbers(robot, POSE, {}, "disc" if printed else PRINTED)
    assert swapped.platform.form != robot.platform.form
    # A density that no rod has is found from the moments.
    if not printed:
        light = numbers(replace(robot, platform=make(0.2, 0.03, 2700.0)), POSE)
        assert light["platform_density"].value == pytest.approx(2700.0, rel=1e-9)


def test_many_at_once_are_each_by_itself() -> None:
    """Regular designs in one call and others one by one; NaN where rods do not reach."""
    sizes = np.array([0.09, 0.11])
    robot = Mechanism.paper()
    assert regular(robot) and not regular(tubes())
    for mechanism, name in ((robot, "rod_diameter"), (tubes(), "rod1_diameter")):
        found = varied_frequencies(mechanism, POSE, {name: sizes}, 2, modes=4)
        for size, row in zip(sizes.tolist(), found, strict=True):
            there = with_numbers(mechanism, POSE, {name: size})
            np.testing.assert_allclose(row, Substructure(2).frequencies(*there, 4), rtol=1e-8)
    lengths = {"rod1_length": np.array([0.2, 5.0])}
    found = varied_frequencies(tubes(), POSE, lengths, 1, modes=3)
    assert np.isfinite(found[0]).all() and np.isnan(found[1]).all()
    assert varied_frequencies(tubes(), POSE, {}, 1, modes=3).shape == (1, 3)
    values = {name: number.value for name, number in numbers(robot, POSE).items()}
    np.testing.assert_allclose(
        design_frequencies(Designs.of(values), 3, poisson=200 / 154 - 1)[0],
        Substructure(3).frequencies(robot, POSE), rtol=1e-8,
    )  # fmt: skip
