"""Every named mechanism by every simulator: the declared theory's answer, or a reason."""

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analytic import Body, Continuum, Freedom, InputError, Joint, Limb, Link, Mechanism, Pose, Rod
from analytic.mechanism import Item
from analytic.pairing import pair
from harness.case_file import load_cases
from reference_models import ModelError, Named
from reference_models.catalogue import catalogue
from reference_models.exudyn.beam import ExudynBeam
from reference_models.exudyn.cable import ExudynCable
from reference_models.mujoco.chain import MujocoChain
from reference_models.richardson import Richardson
from reference_models.solid.calculix import CalculixSolid
from reference_models.units import Units

needs_ccx = pytest.mark.skipif(
    shutil.which("ccx") is None, reason="CalculiX is missing: apt-get install calculix-ccx"
)
CASES = load_cases(Path(__file__).parents[2] / "results" / "published" / "mechanisms.toml")
STOUT = {"rps", "four-rps"}
"""Limbs of one rod, whose high modes need finer meshes."""
COARSE = {"mujoco-cable": 3, "mujoco-composite": 3, "mujoco-chain": 4, "calculix-solid": 2,
          "exudyn-beam": 4, "exudyn-cable": 4}  # fmt: skip
UNTWISTED = {"four-rps", "six-sps"}
TAKEN = {"exudyn-beam": set(CASES), "mujoco-chain": set(CASES), "calculix-solid": set(CASES),
         "exudyn-cable": {"rps", *UNTWISTED}}  # fmt: skip
"""What simulators of any chain must answer; the others answer the paper's limbs."""


@pytest.mark.parametrize("name", [name for name, info in catalogue() if info.isolated])
def test_a_simulator_answers_or_names_the_limb(name: str) -> None:
    """What takes less than a second; answers are compared below."""
    if missing := Named(name, None).info().missing:
        pytest.skip(missing)
    model = Named(name, COARSE.get(name, 1)).build()
    answered = set()
    for case in sorted(CASES):
        mechanism, pose = CASES[case].mechanism, CASES[case].pose
        if case in TAKEN.get(name, {"rps"}):
            answered.add(case)
            continue
        with pytest.raises(InputError, match=r"limb \d, \S+'.*") as refused:
            model.modes(mechanism, pose, 8)
        assert "\n" not in str(refused.value)
    assert answered == TAKEN.get(name, {"rps"})


@pytest.mark.slow
@pytest.mark.parametrize("case", sorted(CASES))
def test_exudyn_beams_are_timoshenko_s(case: str) -> None:
    """Extrapolated, 3e-4 on f1-f8; shapes too."""
    mechanism, pose = CASES[case].mechanism, CASES[case].pose
    n = 12 if case in STOUT else 8
    found = Richardson(ExudynBeam(n), ExudynBeam(2 * n), 2).modes(mechanism, pose, 8)
    exact = Continuum("timoshenko").modes(mechanism, pose, 8)
    np.testing.assert_allclose(found.frequencies, exact.frequencies, rtol=3e-4)
    assert found.residual is not None and found.residual < 1e-12
    assert (pair(found, exact, mechanism, pose).assurance > 0.99).all()


@pytest.mark.parametrize("case", sorted(UNTWISTED))
def test_exudyn_cables_are_euler_bernoulli_s(case: str) -> None:
    """Where nothing twists a rod: 5e-5 on f1-f8 by eight elements a rod."""
    mechanism, pose = CASES[case].mechanism, CASES[case].pose
    found = ExudynCable(8).modes(mechanism, pose, 8)
    exact = Continuum().modes(mechanism, pose, 10)
    np.testing.assert_allclose(found.frequencies, exact.frequencies[:8], rtol=5e-5)
    assert (pair(found, exact, mechanism, pose).assurance > 0.99).all()


@pytest.mark.slow
@pytest.mark.parametrize("beam", ["euler-bernoulli", "rayleigh"])
@pytest.mark.parametrize("case", sorted(CASES))
def test_mujoco_chains_are_their_theory_s(case: str, beam: str) -> None:
    """Extrapolated, 1e-4 on f1-f8; shapes too."""
    mechanism, pose = CASES[case].mechanism, CASES[case].pose
    n = 12 if case in STOUT else 6
    found = Richardson(MujocoChain(n, beam), MujocoChain(2 * n, beam), 2).modes(mechanism, pose, 8)
    exact = Continuum(beam).modes(mechanism, pose, 8)
    np.testing.assert_allclose(found.frequencies, exact.frequencies, rtol=1e-4)
    assert found.residual is not None and found.residual < 1e-12
    assert (pair(found, exact, mechanism, pose).assurance > 0.99).all()


@pytest.mark.slow
@pytest.mark.parametrize("case", ["hexapod", "prs", "tricept"])
def test_mujoco_chains_converge_with_the_second_order(case: str) -> None:
    mechanism, pose = CASES[case].mechanism, CASES[case].pose
    limit = Continuum().modes(mechanism, pose, 6).frequencies
    coarse, fine = (
        np.abs(MujocoChain(n).modes(mechanism, pose).frequencies - limit) for n in (4, 8)
    )
    seen = coarse > 1e-5 * limit
    np.testing.assert_allclose(np.log2(coarse / fine)[seen], 2, atol=0.1)


@needs_ccx
@pytest.mark.slow
@pytest.mark.parametrize("case", ["prs", "rps-real", "three-upu", "flexure-hexapod"])
def test_calculix_solids_are_near_timoshenko_s_beams(case: str) -> None:
    """Rods and tubes in three dimensions, extrapolated: rigid end faces add up to 0.6 % to f1-f8.

    That is what they add to the paper's limbs. A free joint left out, or a drive's stiffness, is
    tens of per cent.
    """
    mechanism, pose = CASES[case].mechanism, CASES[case].pose
    found = Richardson(CalculixSolid(4), CalculixSolid(8), 4).modes(mechanism, pose, 8)
    exact = Continuum("timoshenko").modes(mechanism, pose, 8)
    np.testing.assert_allclose(found.frequencies, exact.frequencies, rtol=6e-3)
    assert (pair(found, exact, mechanism, pose).assurance > 0.99).all()


@needs_ccx
def test_calculix_solids_leave_out_a_limb_s_spin() -> None:
    """6-SPS: six motions need no energy; with hinges for balls at the base none does."""
    case = CASES["six-sps"]
    found = CalculixSolid(2).modes(case.mechanism, case.pose, 4).frequencies
    exact = Continuum("timoshenko").modes(case.mechanism, case.pose, 4).frequencies
    np.testing.assert_allclose(found, exact, rtol=0.03)


@pytest.mark.parametrize("base", ["S", "U"])
@pytest.mark.parametrize(
    "model",
    [ExudynBeam(2), MujocoChain(2), pytest.param(CalculixSolid(2), marks=needs_ccx)],
    ids=["beam", "chain", "solid"],
)
def test_a_platform_that_can_move_is_no_vibration(model: Any, base: str) -> None:
    """Three limbs of a hexapod leave the platform three motions, beside the spins of S-S limbs."""
    case = CASES["hexapod" if base == "U" else "six-sps"]
    half = replace(case.mechanism, limbs=case.mechanism.limbs[:3])
    with pytest.raises(ModelError, match=f"{3 if base == 'U' else 6} motions need no energy"):
        model.modes(half, case.pose, 6)


@pytest.mark.parametrize("case", sorted(CASES))
def test_units_of_the_robot_round_nothing(case: str) -> None:
    mechanism, pose = CASES[case].mechanism, CASES[case].pose
    units = Units(0.25, 64.0, 2.0**-12)
    back = Units(1 / units.length, 1 / units.mass, 1 / units.time)
    assert back.pose(units.pose(pose)) == pose
    again = back.mechanism(units.mechanism(mechanism))
    for limb, other in zip(again.limbs, mechanism.limbs, strict=True):
        assert (limb.base, limb.platform_point) == (other.base, other.platform_point)
        assert [item for item in limb.chain if not isinstance(item, Joint)] == [
            item for item in other.chain if not isinstance(item, Joint)
        ]
        # A direction is made a unit vector anew, which may round it.
        for f, g in zip(freedoms(limb), freedoms(other), strict=True):
            assert f.stiffness == g.stiffness
            np.testing.assert_allclose(f.axis, g.axis, rtol=0, atol=1e-15)
    assert again.platform == mechanism.platform


def freedoms(limb: Limb) -> list[Freedom]:
    return [f for item in limb.chain if isinstance(item, Joint) for f in item.freedoms]


def resized(mechanism: Mechanism, k: float) -> Mechanism:
    """The mechanism k times as large, of the same materials: frequencies go as 1 / k."""

    def freedom_unit(kind: str) -> float:
        return k**3 if kind == "rotation" else k

    def tensor(J: tuple[tuple[float, ...], ...]) -> tuple[tuple[float, ...], ...]:
        return tuple(tuple(x * k**5 for x in row) for row in J)

    def place(x: tuple[float, ...]) -> tuple[float, ...]:
        return tuple(v * k for v in x)

    def item(i: Item) -> Item:
        if isinstance(i, Joint):
            stiff = (replace(f, stiffness=f.stiffness * freedom_unit(f.kind)) for f in i.freedoms)
            return replace(i, freedoms=tuple(stiff))
        if isinstance(i, Body):
            return Body(i.mass * k**3, tensor(i.inertia), place(i.centre), i.frame)  # type: ignore[arg-type]
        length = None if i.length is None else i.length * k
        if isinstance(i, Link):
            return Link(length)
        assert i.section.diameter is not None
        return replace(
            Rod.round(i.material, i.section.diameter * k, i.section.bore * k), length=length
        )

    def limb(of: Limb) -> Limb:
        chain = tuple(map(item, of.chain))
        return Limb(place(of.base), place(of.platform_point), chain, of.reference)  # type: ignore[arg-type]

    own = mechanism.platform
    platform = replace(
        own, mass=own.mass * k**3, inertia=tensor(own.inertia), centre=place(own.centre)
    )
    return Mechanism(tuple(map(limb, mechanism.limbs)), platform)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "model", "error"),
    [
        *((case, model, 1e-8) for case in ("hexapod", "prs", "six-sps", "three-upu")
          for model in (ExudynBeam(4), MujocoChain(4))),
        ("six-sps", ExudynCable(4), 1e-8),
        pytest.param("prs", CalculixSolid(2), 2e-6, marks=needs_ccx),  # seven digits
        pytest.param("three-upu", CalculixSolid(2), 2e-6, marks=needs_ccx),
    ],
    ids=str,
)  # fmt: skip
def test_frequencies_are_inverse_to_the_size(case: str, model: Any, error: float) -> None:
    mechanism, pose = CASES[case].mechanism, CASES[case].pose
    known = model.modes(mechanism, pose, 8).frequencies
    for k in (1e-3, 1e-2, 30.0, 1e3):
        xyz = {n: getattr(pose, n) for n in "xyz" if getattr(pose, n) is not None}
        there: Pose = replace(pose, **{name: value * k for name, value in xyz.items()})
        found = model.modes(resized(mechanism, k), there, 8).frequencies
        np.testing.assert_allclose(found * k, known, rtol=error)


@pytest.mark.parametrize("model", [ExudynBeam(2), MujocoChain(2)])
def test_the_published_hexapod_by_simulators(model: ExudynBeam | MujocoChain) -> None:
    """Rigid struts with bodies, no rod anywhere: six modes, and nothing to converge."""
    (case,) = load_cases(Path("stewart-simscape")).values()
    exact = Continuum().modes(case.mechanism, case.pose, 6).frequencies
    assert model.modes(case.mechanism, case.pose, 6).frequencies == pytest.approx(exact, rel=1e-7)
