"""Limbs of any chain at many poses a call: the same numbers as pose by pose."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, reject, settings
from hypothesis import strategies as st

from analytic import (
    Continuum,
    Joint,
    Material,
    Mechanism,
    NotCertifiedError,
    Pose,
    Rod,
    Section,
    chain_condensed,
    condensed_frequencies,
)
from analytic.chain_models import frequencies
from analytic.core_tables import evaluate, table
from analytic.dynamic_stiffness import limb_stiffness
from analytic.limb_core import AXES, Core, in_limb_axes
from analytic.reduced import constants
from analytic.theory import Theory
from harness.case_file import load_cases
from tests.analytic.test_random_chains import robots

STEEL = Material(200e9, 77e9, 7820)
CASES = load_cases(Path(__file__).parents[2] / "results" / "published" / "mechanisms.toml")
CHAINS = sorted(name for name, case in CASES.items() if not case.mechanism.simple)
"""How far poses may go from a case's [m, rad], where not 0.08 and 0.2."""
ROOM = {"three-upu": (0.06, 0.0), "flexure-hexapod": (0.005, 0.02)}


def around(pose: Pose, shift: float, angle: float, count: int, seed: int = 1) -> Pose:
    """Return `count` poses near one: shifted and turned as far as its joints allow."""
    random = np.random.default_rng(seed)
    if pose.x is None:
        turns = random.uniform(0, 2 * np.pi, count), random.uniform(-angle, angle, count)
        return Pose(pose.z + random.uniform(-shift, shift, count), *turns)
    o = np.array([pose.x, pose.y, pose.z]) + random.uniform(-shift, shift, (count, 3))
    azimuth, tilt, torsion = random.uniform(-angle, angle, (3, count))
    turned = Pose(np.zeros(count), azimuth, tilt, torsion).rotation
    return Pose.at(o, turned @ pose.rotation)


def near(name: str, count: int) -> Pose:
    """Return poses near a named case's."""
    if name == "four-rps":  # over-constrained: it does not lean
        return Pose(np.linspace(0.42, 0.62, count))
    return around(CASES[name].pose, *ROOM.get(name, (0.08, 0.2)), count)


@pytest.fixture
def tables_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let tables answer few poses, and nothing but tables."""

    def refused(*_: object) -> None:
        raise AssertionError("a pose was left to be solved alone")

    for name in ("FEW", "FEWER"):
        monkeypatch.setattr(chain_condensed, name, 3)
    monkeypatch.setattr(chain_condensed.chain_models, "frequencies", refused)


@pytest.mark.parametrize(("elements", "beam"), [(None, "timoshenko"), (2, "euler-bernoulli")])
@pytest.mark.parametrize("name", CHAINS)
@pytest.mark.usefixtures("tables_alone")
def test_tables_give_what_single_poses_give(name: str, elements: int | None, beam: str) -> None:
    mechanism, poses = CASES[name].mechanism, near(name, 30)
    found = condensed_frequencies(mechanism, poses, elements, beam=beam, count=8)
    some = poses[::13]
    alone = frequencies(mechanism, some, Theory(beam), elements, 8)
    assert found[::13] == pytest.approx(alone, rel=5e-10)


@pytest.mark.parametrize(
    ("name", "elements"),
    [
        *(("rps-real", 1), ("four-rps", 3), ("hexapod", 5), ("six-sps", 8)),
        *(("three-upu", 16), ("flexure-hexapod", 17), ("prs", 64)),
    ],
)
@pytest.mark.usefixtures("tables_alone")
def test_tables_hold_any_number_of_elements(name: str, elements: int) -> None:
    mechanism, poses = CASES[name].mechanism, near(name, 30)
    found = condensed_frequencies(mechanism, poses, elements, beam="timoshenko")
    alone = frequencies(mechanism, poses[::29], Theory("timoshenko"), elements, 6)
    assert found[::29] == pytest.approx(alone, rel=1e-9)


@pytest.mark.parametrize("elements", [None, 64])
def test_six_poses_repay_a_table_where_each_alone_is_dear(
    elements: int | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    poses, mechanism = near("prs", 6), CASES["prs"].mechanism
    known = frequencies(mechanism, poses[:1], Theory("timoshenko"), elements, 6)
    monkeypatch.delattr(chain_condensed.chain_models, "frequencies")
    found = condensed_frequencies(mechanism, poses, elements, beam="timoshenko")
    assert found[:1] == pytest.approx(known, rel=1e-9)


def test_an_entry_near_nothing_leaves_the_others_their_digits(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A 3-UPU's limbs turn freely: the stiffness across them is all but zero, its error is not.

    Most poses are by tables nevertheless: held to that entry's error none was.
    """
    left: list[int] = []

    def alone(mechanism: Mechanism, poses: Pose, *how: Any) -> Any:
        left.append(len(poses))
        return frequencies(mechanism, poses, *how)

    monkeypatch.setattr(chain_condensed.chain_models, "frequencies", alone)
    mechanism, poses = CASES["three-upu"].mechanism, around(CASES["three-upu"].pose, 0.0128, 0, 100)
    found = condensed_frequencies(mechanism, poses, 3)
    assert sum(left) < 30
    known = frequencies(mechanism, poses[::25], Theory(), 3, 6)
    assert found[::25] == pytest.approx(known, rel=1e-9)


@pytest.mark.usefixtures("tables_alone")
def test_repeated_modes_at_home_are_all_there() -> None:
    case = CASES["hexapod-home"]
    poses = Pose.at(np.stack([[0, 0, z] for z in np.linspace(0.7, 0.85, 12)]))
    found = condensed_frequencies(case.mechanism, poses, count=8)
    assert found[:, 0] == pytest.approx(found[:, 1], rel=1e-9)
    alone = Continuum().modes(case.mechanism, poses[5], 8).frequencies
    assert found[5] == pytest.approx(alone, rel=5e-10)


def test_what_no_table_answers_is_solved_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    case = CASES["prs"]
    poses = near("prs", 24)
    expected = condensed_frequencies(case.mechanism, poses)
    monkeypatch.setattr(chain_condensed, "table", lambda *_: None)
    assert condensed_frequencies(case.mechanism, poses) == pytest.approx(expected, rel=5e-10)


def test_many_modes_need_more_poles_and_get_them() -> None:
    case = CASES["hexapod"]
    poses = near("hexapod", 40)
    found = condensed_frequencies(case.mechanism, poses, count=22)
    alone = frequencies(case.mechanism, poses[:1], Theory(), None, 22)
    assert found[:1] == pytest.approx(alone, rel=5e-10)
    fewer = condensed_frequencies(case.mechanism, poses, count=5)
    assert found[:, :5] == pytest.approx(fewer, rel=1e-9)


@pytest.mark.parametrize("elements", [None, 3, 16, 23, 1000])
def test_a_table_of_the_papers_limb_is_its_dynamic_stiffness(elements: int | None) -> None:
    """Diagonal, and what the code for R-P-S limbs computes another way."""
    theory = Theory("timoshenko")
    rod = Rod(STEEL, Section.round(0.1))
    ideal = in_limb_axes(Joint.revolute(AXES[1]), [("rotation", AXES[1], 0.0)])
    ball = in_limb_axes(Joint.spherical(), [("rotation", axis, 0.0) for axis in AXES])
    core = Core((ideal, rod, ball), ((), (), ()), elements, theory)
    made = table(core, 0.35, 0.6, 3.0)
    assert made is not None
    rods = constants(Mechanism.paper(), theory).rods
    for length in (0.35, 0.47, 0.6):
        for part in (0.01, 0.3, 0.9):
            lam = part * made.caps(np.array([length]))
            S = evaluate(made, np.array([length]), lam)[0]
            one = replace(rods, **{k: v[:1] for k, v in vars(rods).items()})
            d = limb_stiffness(one, np.array([length]), lam, elements)[0]
            assert np.diag(S) == pytest.approx(d.ravel(), rel=1e-9)
            assert np.abs(S - np.diag(np.diag(S))).max() == 0


@pytest.mark.slow
@settings(max_examples=3)
@given(robots(), st.sampled_from(["rayleigh", "timoshenko"]), st.sampled_from([None, 1, 3]))
def test_random_chains_agree_with_single_poses(
    robot: tuple[Mechanism, Pose], beam: str, elements: int | None
) -> None:
    mechanism, pose = robot
    size = float(np.hypot(*mechanism.limbs[0].base[:2]))
    poses = around(pose, 0.05 * size, 0.1, 6)
    with pytest.MonkeyPatch.context() as patch:
        for name in ("FEW", "FEWER"):
            patch.setattr(chain_condensed, name, 0)
        try:
            found = condensed_frequencies(mechanism, poses, elements, beam=beam, count=8)
            alone = frequencies(mechanism, poses[:2], Theory(beam), elements, 8)
        except NotCertifiedError:
            reject()
    assert found[:2] == pytest.approx(alone, rel=1e-9)
