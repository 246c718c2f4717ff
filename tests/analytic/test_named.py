"""Every named model answers the one protocol, and its answers are one another's."""

from typing import Any

import numpy as np
import pytest

from analytic import (
    Condensed,
    Continuum,
    InputError,
    Mechanism,
    Model,
    Multipliers,
    Pose,
    Substructure,
    named,
)

NAMES = ["euler_bernoulli", "rayleigh", "timoshenko", "multipliers", "condensed"]
FEW = Pose(np.array([0.45, 0.49, 0.6]), 0.3, np.array([0.1, 0.0, -0.2]))


@pytest.mark.parametrize("name", NAMES)
def test_protocol(name: str, robot: Mechanism) -> None:
    factory = getattr(named, name)
    model = factory(elements=2)
    assert isinstance(model, Model) and model.elements == 2
    assert hash(model) == hash(factory(elements=2)) and model != factory(elements=3)
    found = model.frequencies(robot, FEW, 7)
    assert found.shape == (3, 7)
    one_by_one = [model.modes(robot, pose, 7).frequencies for pose in FEW]
    np.testing.assert_allclose(found, one_by_one, rtol=1e-9)
    np.testing.assert_allclose(model.frequencies(robot, FEW[1]), found[1, :6], rtol=1e-9)
    assert model.frequencies(robot, Pose(np.zeros(0))).shape == (0, 6)
    assert not model.info().isolated and factory.info() == factory(elements=4).info()


@pytest.mark.parametrize("name", NAMES)
def test_models_converge_to_their_limit_at_their_order(name: str, robot: Mechanism) -> None:
    factory = getattr(named, name)
    model, info = factory(), factory.info()
    limit = model.limit()
    assert limit == limit.limit() and limit.elements is None
    assert limit == getattr(named, info.limit.replace("-", "_"))(elements=None)
    assert limit.info().theory == info.theory
    exact = limit.frequencies(robot, FEW, 3)
    coarse, fine = (factory(s).frequencies(robot, FEW, 3) - exact for s in (16, 32))
    np.testing.assert_allclose(np.log2(coarse / fine), info.order, atol=0.1)


def test_without_elements(robot: Mechanism) -> None:
    assert named.timoshenko(None, shear="0.9") == Continuum("timoshenko", "0.9")
    assert named.condensed(None, beam="rayleigh") == Condensed(None, "rayleigh")
    with pytest.raises(InputError, match=r"elements = None: .* multipliers has no exact model"):
        named.multipliers(None)


@pytest.mark.parametrize("elements", [1, 3, None])
def test_condensed_modes_are_the_models(elements: Any, robot: Mechanism, case2: Pose) -> None:
    found = Condensed(elements, "timoshenko").modes(robot, case2)
    full = Continuum("timoshenko") if elements is None else Substructure(elements, "timoshenko")
    wanted = full.modes(robot, case2)
    assert (found.model, found.elements) == ("condensed", elements)
    np.testing.assert_allclose(found.frequencies, wanted.frequencies, rtol=1e-9)
    np.testing.assert_allclose(found.platform, wanted.platform, atol=1e-9)
    np.testing.assert_allclose(found.limbs, wanted.limbs, atol=1e-9)


def test_condensed_modes_refuse_what_the_model_denies(
    robot: Mechanism, case2: Pose, monkeypatch: pytest.MonkeyPatch
) -> None:
    honest = Condensed.frequencies
    monkeypatch.setattr(Condensed, "frequencies", lambda *args: honest(*args) * (1 + 1e-8))
    with pytest.raises(ArithmeticError, match="condensed frequencies differ"):
        Condensed(3).modes(robot, case2)


def test_settings_that_a_model_has_not() -> None:
    for settings in ({"mesh": 3}, {"beam": "rayleigh"}):
        with pytest.raises(InputError, match="settings of timoshenko"):
            named.timoshenko(3, **settings)
    assert named.multipliers(3, solver="saddle-point") == Multipliers(3, solver="saddle-point")
