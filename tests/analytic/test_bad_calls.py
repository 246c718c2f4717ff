"""Bad arguments of `analytic` are refused in one sentence that names them."""

import numpy as np
import pytest

from analytic import (
    Continuum,
    InputError,
    Limits,
    Material,
    Mechanism,
    Multipliers,
    Platform,
    Pose,
    Rod,
    Substructure,
    condensed_frequencies,
    frequency_sensitivities,
    limbs_at,
    position,
    reachable,
    regular_workspace,
)

STEEL = Material(200e9, 77e9, 7820.0)
PAPER = Mechanism.paper()
POSE = Pose(0.49, np.radians(10), np.radians(-12))
DISC = PAPER.platform
MODELS = (Substructure(1), Multipliers(1), Continuum())


def thin(diameter):
    return Mechanism.regular(0.3, 0.2, Rod(STEEL, diameter), DISC)


CALLS = {
    "elements": lambda: Substructure(elements=1_000_000),
    "elements, condensed": lambda: condensed_frequencies(PAPER, POSE, elements=10**30),
    "beam": lambda: Continuum(["timoshenko"]),
    "beam, condensed": lambda: condensed_frequencies(PAPER, POSE, beam=["timoshenko"]),
    "shear": lambda: Continuum("timoshenko", 1e-300),
    "Rod.diameter": lambda: Rod(STEEL, 1e-12),
    "Rod.diameter, large": lambda: Rod(STEEL, 1e200),
    "Material.young": lambda: Material(10**400, 77e9, 7820.0),
    "Material.young, soft": lambda: Material(1e-300, 77e9, 7820.0),
    "Material.density": lambda: Material(200e9, 77e9, 1e300),
    "Material.shear": lambda: Material(1e-30, 77e9, 7820.0),
    "pose, thin": lambda: Substructure(3).modes(thin(1e-9), POSE),
    "pose, thin, exact": lambda: Continuum().modes(thin(1e-7), POSE),
    "pose, thin, many": lambda: condensed_frequencies(thin(1e-7), POSE),
    "limbs": lambda: Mechanism.regular(0.3, 0.2, Rod(STEEL, 0.1), DISC, limbs=10**30),
    "Mechanism.limbs": lambda: Mechanism(None, DISC),
    "inertia": lambda: Mechanism.paper(inertia=["disc"]),
    "Pose.z": lambda: Pose(1e300),
    "pose, many": lambda: condensed_frequencies(PAPER, (0.49, 0, 0)),
    "pose, limbs": lambda: limbs_at(PAPER, None),
    "mechanism": lambda: position(POSE, PAPER),
    "mechanism, many": lambda: condensed_frequencies(POSE, PAPER),
    "limits": lambda: reachable(PAPER, POSE, None),
    "layers": lambda: regular_workspace(PAPER, "a", Limits()),
    "parameters": lambda: frequency_sensitivities(PAPER, POSE, "z"),
}


@pytest.mark.parametrize("name", CALLS)
def test_refused_in_a_sentence(name):
    with pytest.raises(InputError, match=rf"^{name.partition(',')[0]} = [^\n]*: expected ") as told:
        CALLS[name]()
    assert len(str(told.value)) < 300


@pytest.mark.parametrize("model", MODELS, ids=lambda model: type(model).__name__)
def test_swapped_and_missing_arguments(model):
    with pytest.raises(InputError, match=r"^mechanism = Pose"):
        model.modes(POSE, PAPER)
    for wrong in (None, (0.49, 0.0, 0.0)):
        with pytest.raises(InputError, match=r"^pose = .*: expected a Pose"):
            model.modes(PAPER, wrong)


@pytest.mark.parametrize("kind", [np.uint8, np.int8])
def test_small_integers_count_as_any(kind):
    small = Substructure(kind(60)).modes(PAPER, POSE).frequencies
    np.testing.assert_array_equal(small, Substructure(60).modes(PAPER, POSE).frequencies)
    many = condensed_frequencies(PAPER, POSE, elements=kind(60), count=kind(6))
    np.testing.assert_allclose(many, small, rtol=1e-9)


def test_limbs_in_one_place_are_one_limb_three_times_as_strong():
    """And so are one limb with a third of the platform; besides, they bend without it."""
    third = Platform.diagonal(DISC.mass / 3, tuple(np.diag(np.array(DISC.inertia)) / 3))
    three = Continuum().modes(Mechanism((PAPER.limbs[0],) * 3, DISC), Pose(0.49)).frequencies
    one = Continuum().modes(Mechanism(PAPER.limbs[:1], third), Pose(0.49)).frequencies
    assert (three[:4] == 0).all()
    assert (one[:4] == 0).all()
    np.testing.assert_allclose(three[4], one[4], rtol=1e-11)


def test_an_inertia_asymmetric_by_rounding_is_accepted():
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    tensor = turn @ np.diag([1, 2, 2.5]) @ turn.T
    assert (tensor != tensor.T).any()
    kept = np.array(Platform(1.0, tuple(map(tuple, tensor.tolist()))).inertia)
    np.testing.assert_array_equal(kept, kept.T)
    np.testing.assert_allclose(kept, tensor, rtol=1e-14)
    with pytest.raises(InputError, match="symmetric"):
        Platform(1.0, ((1, 0.1, 0), (0.1 + 1e-9, 1, 0), (0, 0, 1)))


def test_moments_that_no_body_has_are_refused():
    Platform.diagonal(1.0, (0.1, 0.1, 0.2))  # a plate of no thickness
    Platform.diagonal(1.0, (0.1, 0.2, 0.1 + 0.2))  # the last bit above
    for moments in ((0.1, 0.1, 0.5), (0.1, 0.1, 0.2001)):
        with pytest.raises(InputError, match=r"none exceeds .*, not 0\.1, 0\.1"):
            Platform.diagonal(1.0, moments)


def test_sensitivities_to_what_the_joints_forbid_are_refused():
    with pytest.raises(InputError, match=r"platform_radius\[0\].*joints let change"):
        frequency_sensitivities(PAPER, POSE, ["z", "platform_radius[0]"])
    # Together, or at a level platform, every A_i stays in its plane.
    assert np.isfinite(frequency_sensitivities(PAPER, POSE, ["platform_radius", "tilt"])).all()
    assert np.isfinite(frequency_sensitivities(PAPER, Pose(0.49), ["platform_radius[0]"])).all()


@pytest.mark.parametrize("count", [80, 300])
def test_more_modes_than_tables_hold(count):
    """Of limbs with up to 50 bending modes below, all by bisection: the exact ones."""
    many = condensed_frequencies(PAPER, POSE, count=count)
    np.testing.assert_allclose(many, Continuum().modes(PAPER, POSE, count).frequencies, rtol=1e-9)
