"""Properties hold for the models, fail for wrong ones, and their bounds are not idle."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from analytic import Continuum, Material, Mechanism, Modes, Pose, Substructure
from harness.cases import PRESETS
from harness.gate.equivalents import EQUIVALENTS, in_length_unit, in_mass_unit, noise
from harness.gate.metamorphic import Property, properties, rounding
from harness.gate.study import Plan, solve, standard
from harness.models import Model, Spec

CASE = PRESETS["case2"]


@dataclass(frozen=True)
class Wrong(Spec):
    """An analytic model that answers for another mechanism or pose, or with other numbers."""

    ask: Callable[[Mechanism, Pose], tuple[Mechanism, Pose]] = lambda mechanism, pose: (
        mechanism,
        pose,
    )
    factor: Callable[[Mechanism, Pose], float] = lambda mechanism, pose: 1.0

    def build(self) -> Model:
        model, spec = super().build(), self

        class Answer:
            def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
                modes = model.modes(*spec.ask(mechanism, pose), count)
                return replace(modes, frequencies=modes.frequencies * spec.factor(mechanism, pose))

        return Answer()


def study(name: str, elements: int | None, **wrong: object) -> Plan:
    """Return a study of one model alone, at case 2 and nowhere on the map."""
    one = Wrong(name, elements, **wrong)  # type: ignore[arg-type]
    return replace(standard([name]), cases=(CASE,), ladders=(), specs=(one,), mapped=(), poses=())


def failed(plan: Plan) -> set[str]:
    return {one.name for one in properties(solve(replace(plan, condensed=False))) if not one.holds}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("wrong", "name"),
    [
        ({"factor": lambda m, p: 1 + 1e-10 * m.limbs[0].base[0]}, "limbs renumbered"),
        ({"factor": lambda m, p: 1 + 1e-10 * p.azimuth}, "axes turned by 57.3 deg"),
        ({"factor": lambda m, p: m.limbs[0].rod.material.young ** 1e-9}, "time unit 1.7 s"),
        ({"factor": lambda m, p: m.platform.mass**1e-9}, "mass unit 1/0.3 kg"),
        ({"factor": lambda m, p: p.z**1e-9}, "lengths in mm"),
        ({"factor": lambda m, p: 1 + 1e-7}, "limbs without mass"),
        ({"factor": lambda m, p: 1 + 1e-8}, "Wittrick-Williams count"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_wrong_model_breaks_its_property(wrong: dict[str, object], name: str) -> None:
    """Each by little, each under its own name."""
    assert name in failed(study("euler-bernoulli", None, **wrong))


@pytest.mark.slow
def test_all_properties_hold() -> None:
    names = ["euler-bernoulli", "rayleigh", "timoshenko", "multipliers", "mujoco-cable"]
    full = standard(names)
    found = properties(solve(replace(full, poses=full.poses[2::12])))
    assert [one for one in found if not one.holds] == []
    assert len({one.name for one in found}) >= 18
    # A bound that nothing comes near says little: of rounding, each is within a factor of 1e4.
    rounded = [one for one in found if one.remark == "rounding" and one.deviation > 0]
    assert len(rounded) > 20
    assert all(one.deviation > 1e-4 * one.bound for one in rounded)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("change", "name"),
    [
        (lambda f: f * (1 + 1e-6), "s -> infinity is exact"),
        (lambda f: f * (1 + 3e-9), "condensed = pose by pose, cases"),
        (lambda f: f * 1.01, "elements only stiffen"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_wrong_limit_breaks_what_leans_on_it(change: Callable[[float], float], name: str) -> None:
    plan = standard(["rayleigh"])
    (exact,) = plan.specs
    wrong = Wrong(exact.name, None, factor=lambda m, p: change(1.0))
    assert failed(replace(plan, specs=(wrong,), mapped=())) >= {name}


@pytest.mark.slow
def test_theories_in_the_wrong_order_are_seen() -> None:
    plan = standard(["rayleigh", "timoshenko"])
    soft = Wrong("timoshenko", None, factor=lambda m, p: 1.1)
    rayleigh = Spec("rayleigh", None)
    found = failed(
        replace(plan, cases=(CASE,), ladders=(), specs=(rayleigh, soft), mapped=(), poses=())
    )
    assert found >= {"rayleigh above timoshenko", "kappa -> infinity is rayleigh"}


@pytest.mark.parametrize("elements", [1, 3, 8])
def test_rounding_is_bounded(elements: int) -> None:
    """Every equivalent question differs by less than the bound, at poses of no symmetry."""
    spec = Spec("timoshenko", elements)
    model = Substructure(elements, "timoshenko")
    for pose in (CASE.pose, Pose(0.41, 0.7, 0.2), Pose(0.66, -2.0, 0.3)):
        f = model.modes(CASE.mechanism, pose).frequencies
        bound = rounding(spec, CASE.mechanism, pose, 6)
        assert (noise(model, CASE.mechanism, pose, f, 2) <= 2 * bound).all()
        assert bound.max() < 1e-9


def test_units_change_what_they_should() -> None:
    """A change of unit is one of the numbers given, not only of the answer."""
    model = Continuum()
    f = model.modes(CASE.mechanism, CASE.pose).frequencies
    for change in (in_length_unit(1000.0), in_mass_unit(0.3)):
        mechanism, pose = change(CASE.mechanism, CASE.pose)
        assert mechanism != CASE.mechanism
        again = model.modes(mechanism, pose).frequencies
        np.testing.assert_allclose(again, f, rtol=4e-12)
    timed = EQUIVALENTS[-1]
    mechanism, pose = timed.change(CASE.mechanism, CASE.pose)
    np.testing.assert_allclose(model.modes(mechanism, pose).frequencies, 1.7 * f, rtol=4e-12)
    steel = mechanism.limbs[0].rod.material
    assert isinstance(steel, Material) and steel.young == pytest.approx(1.7**2 * 200e9)


def test_what_does_not_hold_is_told_from_what_does() -> None:
    assert Property("p", "m", "c", 1, 1e-12, 2e-12, "").holds
    assert not Property("p", "m", "c", 1, 3e-12, 2e-12, "").holds
    assert not Property("p", "m", "c", 1, float("nan"), 2e-12, "").holds
