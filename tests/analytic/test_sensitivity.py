"""Exact derivatives of frequencies against finite differences of another model of this package."""

from dataclasses import replace

import numpy as np
import pytest

from analytic import (
    Continuum,
    InputError,
    Material,
    Mechanism,
    Platform,
    Pose,
    Rod,
    Section,
    Substructure,
    condensed_frequencies,
    frequency_sensitivities,
)


def with_rods(robot, name, step, which):
    limbs = []
    for i, limb in enumerate(robot.limbs):
        rod = limb.rod
        if which is None or i == which:
            if name == "diameter":
                rod = replace(rod, section=Section.round(rod.diameter + step))
            else:
                changed = {name: getattr(rod.material, name) + step}
                rod = replace(rod, material=replace(rod.material, **changed))
        limbs.append(limb.with_rod(rod))
    return replace(robot, limbs=tuple(limbs))


def with_radius(robot, name, step, which):
    limbs = []
    for i, limb in enumerate(robot.limbs):
        x, y, z = getattr(limb, name)
        factor = 1 + (step / np.hypot(x, y) if which is None or i == which else 0)
        limbs.append(replace(limb, **{name: (x * factor, y * factor, z)}))
    return replace(robot, limbs=tuple(limbs))


def moved(robot, pose, parameter, step):
    """Return mechanism and pose with `parameter` changed by `step`."""
    name, _, which = parameter.removesuffix("]").partition("[")
    limb = int(which) if which else None
    if name in ("z", "azimuth", "tilt"):
        return robot, replace(pose, **{name: getattr(pose, name) + step})
    if name in ("base_radius", "platform_radius"):
        field = {"base_radius": "base", "platform_radius": "platform_point"}[name]
        return with_radius(robot, field, step, limb), pose
    if name == "mass":
        return replace(
            robot, platform=replace(robot.platform, mass=robot.platform.mass + step)
        ), pose
    if name.startswith("inertia"):
        inertia = np.array(robot.platform.inertia)
        i, j = ("xyz".index(letter) for letter in name[-2:])
        inertia[i, j] += step
        inertia[j, i] = inertia[i, j]
        rows = tuple(tuple(row) for row in inertia.tolist())
        return replace(robot, platform=replace(robot.platform, inertia=rows)), pose
    return with_rods(robot, name, step, limb), pose


BEAM = "euler-bernoulli"
STEPS = {
    "z": 1e-3,
    "azimuth": 1e-3,
    "tilt": 1e-3,
    "young": 4e8,
    "shear": 2e8,
    "density": 10.0,
    "diameter": 2e-4,
    "diameter[1]": 2e-4,
    "young[2]": 4e8,
    "base_radius": 1e-3,
    "base_radius[0]": 1e-3,
    "platform_radius": 1e-3,
    "mass": 0.1,
    "inertia_xx": 1e-3,
    "inertia_zz": 1e-3,
    "inertia_xy": 1e-3,
    "inertia_yz": 1e-3,
}


def frequencies(robot, pose, elements, beam, count):
    if elements is None:
        return Continuum(beam).brackets(robot, pose, count).mean(axis=1)
    return Substructure(elements, beam).modes(robot, pose, count).frequencies


def differences(robot, pose, elements, beam, count):
    """Central differences of fourth order, shape (count, parameters)."""
    columns = []
    for parameter, step in STEPS.items():
        h = step / 20  # so short that no two modes change places within it
        f = [
            frequencies(*moved(robot, pose, parameter, k * h), elements, beam, count)
            for k in (-2, -1, 1, 2)
        ]
        columns.append((8 * (f[2] - f[1]) - (f[3] - f[0])) / (12 * h))
    return np.stack(columns, axis=1)


@pytest.mark.slow
@pytest.mark.parametrize("beam", ["euler-bernoulli", "rayleigh", "timoshenko"])
@pytest.mark.parametrize("elements", [None, 1, 3])
def test_equal_finite_differences(robot, beam, elements):
    """Ten modes, torsion of limbs among them; the assembled model knows none of these formulas."""
    pose = Pose(0.53, 0.3, -0.21)
    exact = frequency_sensitivities(robot, pose, list(STEPS), elements, beam=beam, count=10)
    close = differences(robot, pose, elements, beam, 10)
    scale = np.maximum(np.abs(close).max(axis=0), 1e-30)
    np.testing.assert_allclose(exact / scale, close / scale, atol=1e-6)


@pytest.mark.parametrize("parameter", ["tilt", "diameter[0]", "young[1]", "z", "inertia_xx"])
def test_repeated_modes_part_as_predicted(robot, case1, parameter):
    """Where a pair splits, the derivatives are those of its lower and its upper branch."""
    exact = frequency_sensitivities(robot, case1, [parameter])[:, 0]
    h = STEPS[parameter.replace("[0]", "[1]").replace("young[1]", "young[2]")] / 10
    f = [frequencies(*moved(robot, case1, parameter, k * h), None, BEAM, 6) for k in range(4)]
    one_sided = (-11 * f[0] + 18 * f[1] - 9 * f[2] + 2 * f[3]) / (6 * h)
    np.testing.assert_allclose(exact, one_sided, rtol=1e-5, atol=1e-5 * np.abs(exact).max())


def test_scaling_laws(robot, case2):
    """Stiffer and lighter throughout by the same factor: f ~ sqrt(E / rho), platform included."""
    found = frequency_sensitivities(
        robot,
        case2,
        ["young", "shear", "density", "mass", "inertia_xx", "inertia_yy", "inertia_zz"],
        beam="timoshenko",
    )
    f = condensed_frequencies(robot, case2, beam="timoshenko")
    material, platform = robot.limbs[0].rod.material, robot.platform
    stiff = found[:, 0] * material.young + found[:, 1] * material.shear
    np.testing.assert_allclose(stiff, f / 2, rtol=1e-10)
    moments = np.diag(platform.inertia)
    heavy = found[:, 2] * material.density + found[:, 3] * platform.mass + found[:, 4:] @ moments
    np.testing.assert_allclose(heavy, -f / 2, rtol=1e-10)


def test_modes_at_a_pole():
    """Five modes of eight limbs leave the platform still: f of a pinned beam, ~ 1 / L^2 and ~ d."""
    rod = Rod(Material(200e9, 77e9, 7820), 0.05)
    robot, pose = (
        Mechanism.regular(0.3, 0.2, rod, Platform.disc(0.2, 0.02, 7820), limbs=8),
        Pose(0.4),
    )
    found = frequency_sensitivities(robot, pose, ["z", "diameter", "mass"], count=9)[4:]
    f = condensed_frequencies(robot, pose, count=9)[4:]
    np.testing.assert_allclose(found[:, 0], -2 * f * 0.4 / (0.4**2 + 0.1**2), rtol=1e-8)
    np.testing.assert_allclose(found[:, 1], f / 0.05, rtol=1e-8)
    np.testing.assert_allclose(found[:, 2], 0, atol=1e-8)


def test_refuses_bad_input(robot, case1):
    for name in ("length", "diameter[3]", "z[0]", "inertia_zx", 3):
        with pytest.raises(InputError, match="parameters"):
            frequency_sensitivities(robot, case1, [name])
    with pytest.raises(InputError, match="one pose"):
        frequency_sensitivities(robot, Pose([0.4, 0.5]), ["z"])
    with pytest.raises(InputError, match="count"):
        frequency_sensitivities(robot, case1, ["z"], count=0)
    with pytest.raises(InputError, match="moves freely"):
        frequency_sensitivities(replace(robot, limbs=robot.limbs[:1]), Pose(0.5), ["z"])
