"""Frequencies scale as one over the size, whatever the size; free motions are 0 Hz or refused."""

from dataclasses import replace

import numpy as np
import pytest

from analytic import Limb, Material, Mechanism, Platform, Pose, Rod
from reference_models import ModelError, UnavailableError, reference
from reference_models.protocol import hertz
from reference_models.units import Units

TILTED = (np.radians(10), np.radians(-12))
MODELS = {
    "exudyn-cable": (4, 1e-9),
    "exudyn-beam": (6, 1e-9),
    "mujoco-cable": (4, 1e-7),
    "mujoco-chain": (6, 1e-9),
    "mujoco-composite": (8, 1e-9),  # its own compiler rounds to single precision
    "ngsolve-solid": (1, 1e-9),
    "solid-limb": (2, 1e-9),
    "ngsolve-averaged": (1, 1e-9),
    "exudyn-ffrf": (1, 1e-9),
    "calculix-solid": (2, 2e-6),  # seven digits printed
}


def scaled(size: float, diameter: float = 0.1) -> Mechanism:
    steel = Material(200e9, 77e9, 7820.0)
    platform = Platform.disc(0.2 * size, 0.02 * size, 7820.0)
    return Mechanism.regular(0.3 * size, 0.2 * size, Rod(steel, diameter * size), platform)


@pytest.mark.slow
@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("size", [1e-3, 1e-2, 30.0, 1e3])
def test_frequencies_are_inverse_to_the_size(name: str, size: float) -> None:
    elements, precision = MODELS[name]
    try:
        model = reference(name, elements)
    except UnavailableError as reason:
        pytest.skip(str(reason))
    known, found = (model.modes(scaled(k), Pose(0.49 * k, *TILTED), 7) for k in (1.0, size))
    np.testing.assert_allclose(found.frequencies * size, known.frequencies, rtol=precision)
    # Shapes are of unit modal mass: displacements go as size^-1.5, rotations as size^-2.5.
    lengths = np.repeat([size**1.5, size**2.5], 3)
    if name != "calculix-solid":  # modes of seven digits
        for mine, full in ((found.platform * lengths, known.platform),
                           (found.limbs * size**1.5, known.limbs)):  # fmt: skip
            # Their sign depends on whether metres or radians are more.
            np.testing.assert_allclose(np.abs(mine), np.abs(full), rtol=1e-5, atol=1e-6)


def test_the_tilted_micro_mechanism_is_known() -> None:
    """Rods of 0.6 mm between radii of 3 and 2 mm, 4 mm high: exudyn-ffrf once gave zeros."""
    pytest.importorskip("ngsolve")
    steel = Material(200e9, 77e9, 7820.0)
    robot = Mechanism.regular(3e-3, 2e-3, Rod(steel, 6e-4), Platform.disc(2e-3, 2e-4, 7820.0))
    pose = Pose(4e-3, *TILTED)
    ffrf = reference("exudyn-ffrf", 1).modes(robot, pose).frequencies
    full = reference("ngsolve-solid", 1).modes(robot, pose).frequencies
    np.testing.assert_allclose(ffrf, full, rtol=1e-4)


@pytest.mark.parametrize(
    ("name", "elements"),
    [("exudyn-cable", 64), ("exudyn-beam", 16), ("mujoco-cable", 16), ("mujoco-chain", 16)],
)
@pytest.mark.parametrize("limbs", [1, 2])
def test_free_motions_are_zero_and_harm_no_other_mode(
    robot: Mechanism, name: str, elements: int, limbs: int
) -> None:
    """One limb leaves the platform four motions, two limbs two: 6 + n - 3 n.

    The others are the exact model's, however fine the mesh.
    """
    few, free = Mechanism(robot.limbs[:limbs], robot.platform), 6 - 2 * limbs
    model = reference(name, elements)
    found = model.modes(few, Pose(0.49), free + 3).frequencies
    assert (found[:free] == 0).all()
    exact = model.limit()
    assert exact is not None
    expected = exact.modes(few, Pose(0.49), free + 3).frequencies[free:]
    error = 1e-7 if name == "exudyn-cable" else 0.03
    np.testing.assert_allclose(found[free:], expected, rtol=error)


@pytest.mark.parametrize("name", ["exudyn-cable", "exudyn-beam", "mujoco-cable", "mujoco-chain"])
def test_thin_rods_are_not_taken_for_free_motions(name: str) -> None:
    """Rods of 500 diameters: their lowest frequencies are 3e-6 of the highest."""
    model = reference(name, 16)
    exact = model.limit()
    assert exact is not None
    thin, pose = scaled(1.0, 1e-3), Pose(0.49, *TILTED)
    found, expected = (m.modes(thin, pose).frequencies for m in (model, exact))
    np.testing.assert_allclose(found, expected, rtol=0.01)


def test_ngsolve_refuses_what_moves_freely(robot: Mechanism) -> None:
    pytest.importorskip("ngsolve")
    with pytest.raises(ModelError, match="free"):
        reference("ngsolve-solid", 1, order=1).modes(replace(robot, limbs=robot.limbs[:1]), Pose(1))


def test_nothing_negative_is_clipped() -> None:
    np.testing.assert_array_equal(hertz("m", np.array([-1e-9, 0.0]), 1e-8), [0, 0])
    assert hertz("m", np.array([4 * np.pi**2]), 1e-8) == 1
    for wrong in (-1e-7, np.nan):
        with pytest.raises(ModelError, match="m: the square of a frequency is"):
            hertz("m", np.array([wrong, 1.0]), 1e-8)


def test_units_round_nothing(robot: Mechanism) -> None:
    units = Units.of(robot, np.array([0.5, 0.49, 0.51]))
    back = Units(1 / units.length, 1 / units.mass, 1 / units.time)
    assert back.mechanism(units.mechanism(robot)) == robot
    assert back.pose(units.pose(Pose(0.49, 0.1, 0.2))) == Pose(0.49, 0.1, 0.2)
    limb = units.mechanism(robot).limbs[0]
    assert isinstance(limb, Limb)
    numbers = [*vars(limb.rod.material).values(), limb.rod.diameter, *limb.base]
    assert all(abs(x) < 100 for x in numbers)
