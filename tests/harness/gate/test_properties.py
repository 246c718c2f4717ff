"""Properties hold for the models, fail for wrong ones, and their bounds are not idle."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from analytic import Material, Mechanism, Platform, Pose, Rod
from harness.answer import Batch
from harness.bench import Bench
from harness.case import Case
from harness.cases import PRESETS
from harness.gate import equivalents as module
from harness.gate.equivalents import (
    EQUIVALENTS,
    UNITS,
    in_units,
    noise,
    precision,
    relative,
    seen,
)
from harness.gate.gate import failures
from harness.gate.plan import Plan, solve, standard
from harness.gate.properties import properties
from reference_models import Named

CASE = PRESETS["case2"]
Planted = Callable[..., Plan]


@pytest.fixture(scope="module")
def bench() -> Iterator[Bench]:
    with Bench() as one:
        yield one


def study(name: str, elements: int | None = None) -> Plan:
    """Return a study of one model alone, at case 2 and nowhere on the map."""
    one = Named(name, elements)
    plan = standard([CASE], [name])
    return replace(plan, ladders=(), singles=(one,), mapped=(), poses=())


def failed(plan: Plan, bench: Bench) -> set[str]:
    return {one.quantity for one in properties(solve(plan, bench)) if one.fails}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("factor", "name"),
    [
        (lambda m, p: 1 + 1e-10 * m.limbs[0].base[0], "limbs renumbered"),
        (lambda m, p: 1 + 1e-10 * p.azimuth, "axes turned by 57.3 deg"),
        (lambda m, p: m.limbs[0].rod.material.young ** 1e-9, "time unit 1.7 s"),
        (lambda m, p: m.platform.mass**1e-9, "mass unit 1/0.3 kg"),
        (lambda m, p: p.z**1e-9, "lengths in mm"),
        (lambda m, p: 1 + 1e-7, "limbs without mass"),
        (lambda m, p: 1 + 1e-8, "Wittrick-Williams count"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_wrong_model_breaks_its_property(
    bench: Bench, plant: Planted, factor: Any, name: str
) -> None:
    """Each by little, each under its own name."""
    assert name in failed(plant(study("euler-bernoulli"), "euler-bernoulli", factor=factor), bench)


@pytest.mark.slow
def test_all_properties_hold(bench: Bench) -> None:
    names = ["euler-bernoulli", "rayleigh", "timoshenko", "multipliers", "condensed",
             "mujoco-cable", "exudyn-cable", "exudyn-beam"]  # fmt: skip
    full = standard([PRESETS["case1"], CASE], names)
    found = properties(solve(replace(full, poses=full.poses[2::12]), bench))
    assert [one for one in found if one.fails] == []
    assert len({one.quantity for one in found}) >= 20
    for model in full.ladders:
        own = {one.quantity for one in found if one.model in (model[0].name, model[0].label)}
        assert own >= {"s -> infinity is exact", *(one.name for one in UNITS)}
    # A bound that nothing comes near says little: of rounding, each is within a factor of 1e4.
    sizes = [(one.after, one.tolerance) for one in found if one.cause == "rounding" and one.after]
    derived = [(off, bound) for off, bound in sizes if bound < 1e-9]
    assert len(derived) > 20
    assert all(off > 1e-4 * bound for off, bound in derived)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("factor", "name"),
    [
        (1 + 1e-6, "s -> infinity is exact"),
        (0.99, "elements only stiffen"),
    ],
)
def test_a_wrong_mesh_is_far_from_its_limit(
    bench: Bench, plant: Planted, factor: float, name: str
) -> None:
    plan = replace(standard([CASE], ["rayleigh"]), singles=(), mapped=(), poses=())
    wrong = plant(plan, "rayleigh", factor=lambda m, p: factor)
    assert name in failed(wrong, bench)
    assert failed(plan, bench) == set()


@pytest.mark.slow
def test_theories_in_the_wrong_order_are_seen(bench: Bench, plant: Planted) -> None:
    plan = replace(
        standard([CASE], ["rayleigh", "timoshenko"]), ladders=(), mapped=(), poses=()
    )  # fmt: skip
    wrong = plant(plan, "timoshenko", factor=lambda m, p: 1.1)
    refused = solve(wrong, bench)
    assert {one.model for one in failures(refused) if one.fails} == {"timoshenko@exact"}
    right = solve(plan, bench)
    answers = {
        (case, model): replace(modes, frequencies=(1.1 if model.name == "timoshenko" else 1.0)
                               * modes.frequencies)
        for (case, model), modes in right.cases.answers.items()
    }  # fmt: skip
    off = replace(right, cases=replace(right.cases, answers=answers))
    assert "rayleigh above timoshenko" in {one.quantity for one in properties(off) if one.fails}


@pytest.mark.slow
def test_twins_that_differ_are_seen(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    plan = study("euler-bernoulli", 3)
    twins = ((Named("euler-bernoulli", 3), Named("euler-bernoulli", 4)),)
    monkeypatch.setattr(module, "TWINS", twins)
    assert failed(plan, bench) == {"euler-bernoulli@4 = euler-bernoulli@3"}


@pytest.mark.slow
def test_many_poses_a_call_are_the_poses_one_by_one(bench: Bench) -> None:
    plan = standard([CASE], ["condensed"])
    plan = replace(plan, ladders=(), singles=(), poses=plan.poses[2::12])
    checked = solve(plan, bench)
    timed = {(row["case"], row["model"]) for row in checked.rows}
    assert timed >= {("workspace", "condensed@3"), ("workspace", "condensed@3, many poses a call")}
    names = {(one.quantity, one.model) for one in properties(checked) if not one.fails}
    assert names >= {("many poses a call, map", f"condensed@{s}") for s in (3, "exact")}
    off = {
        model: replace(one, table=one.table * (1 + 3e-9))
        for model, one in checked.batches.items()
        if isinstance(one, Batch)
    }
    assert len(off) == len(checked.batches)
    found = properties(replace(checked, batches=off))
    assert {one.quantity for one in found if one.fails} == {"many poses a call, map"}


def test_a_mechanism_without_symmetry_has_none_to_keep(bench: Bench) -> None:
    """Two equal limbs and one thicker: no turn brings it back, so none is asked for."""
    robot = Mechanism.paper()
    thick = robot.limbs[0].with_rod(Rod(robot.limbs[0].rod.material, 0.12))
    uneven = replace(robot, limbs=(thick, *robot.limbs[1:]))
    for mechanism, named in ((robot, True), (uneven, False)):
        case = Case("mine", mechanism, CASE.pose, "a test")
        plan = standard([case], ["euler-bernoulli"])
        plan = replace(plan, cases=(), ladders=(), singles=(), poses=plan.poses[2::12])
        found = properties(solve(plan, bench))
        assert ("120 deg symmetry" in {one.quantity for one in found}) == named
        assert all(not one.fails for one in found)


@pytest.mark.parametrize("elements", [1, 3, 8])
def test_the_bound_of_rounding_holds_and_is_derived(bench: Bench, elements: int) -> None:
    model = Named("timoshenko", elements)
    for pose in (CASE.pose, Pose(0.41, 0.7, 0.2), Pose(0.66, -2.0, 0.3)):
        f = model.modes(CASE.mechanism, pose).frequencies
        case = replace(CASE, pose=pose)
        bound = precision(model, case)
        assert (noise(bench, model, case, f) <= 2 * bound).all()
        assert bound.max() < 1e-9


def test_units_change_what_they_should() -> None:
    """A change of unit is one of the numbers given, not only of the answer."""
    model = Named("euler-bernoulli", None)
    f = model.modes(CASE.mechanism, CASE.pose).frequencies
    for change in (in_units(length=1e-3), in_units(mass=1 / 0.3)):
        case = change(CASE)
        assert case.mechanism != CASE.mechanism
        again = model.modes(case.mechanism, case.pose).frequencies
        np.testing.assert_allclose(again, f, rtol=4e-12)
    timed = EQUIVALENTS[-1]
    case = timed.change(CASE)
    again = model.modes(case.mechanism, case.pose).frequencies
    np.testing.assert_allclose(again, 1.7 * f, rtol=4e-12)
    steel = case.mechanism.limbs[0].rod.material
    assert isinstance(steel, Material) and steel.young == pytest.approx(1.7**2 * 200e9)
    heavy = in_units(mass=1 / 0.3, length=0.1)(CASE).mechanism
    assert isinstance(heavy.platform, Platform)
    assert heavy.platform.mass == pytest.approx(0.3 * CASE.mechanism.platform.mass)


def test_what_does_not_hold_is_told_from_what_does() -> None:
    for deviation, fails in ((1e-12, False), (3e-12, True), (float("nan"), True)):
        _, one = seen("p", "m", "", CASE, np.array([deviation]), np.array([2e-12]))
        assert one.fails == fails


def test_two_zeros_are_equal_and_zero_is_like_no_other_number() -> None:
    np.testing.assert_array_equal(relative([0.0, 1.0, 0.0, 3.0], [0.0, 0.0, 2.0, 2.0]),
                                  [0.0, np.inf, 1.0, 0.5])  # fmt: skip
