"""A slip in the analytic model is seen: planted one at a time, some simulator keeps its numbers."""

import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from analytic import (
    InputError,
    Mechanism,
    Pose,
    Section,
    Substructure,
    kinematics,
    network,
    placed,
    platform,
    pose,
)
from analytic.theory import Theory
from harness.case_file import load_cases
from reference_models import UnavailableError, reference

Array = NDArray[np.float64]
CASES = load_cases(Path(__file__).parents[2] / "results" / "published" / "mechanisms.toml")


@dataclass(frozen=True)
class Slip:
    """What is wrong in `analytic`: `owner`.`name` becomes `wrong`; `seen_by` a simulator."""

    owner: Any
    name: str
    wrong: Callable[[Any], Any]
    seen_by: str
    theory: str = "euler-bernoulli"


def _eq_1(right: Any) -> Any:
    return lambda azimuth, tilt: right(azimuth, -tilt)


def _eq_2(right: Any) -> Any:
    """The other sign of x and y; joints that this opens are believed to be closed."""
    return _believed(right, _eq_2_noticed(right))


def _eq_2_sign_of_r(right: Any) -> Any:
    """The other sign of R's terms in x and y, those of the platform's points."""

    def wrong(places: Any, R: Any, z: Any, across: Any) -> Any:
        back = [tuple(-entry for entry in row) for row in R]
        (x, y, _), _ = right(places, back, z, across)
        return right(places, R, z, lambda _: (x, y))

    return _believed(right, wrong)


def _eq_2_noticed(right: Any) -> Any:
    """The other sign of x and y, where it is looked at whether joints are closed."""

    def wrong(places: Any, R: Any, z: Any, across: Any) -> Any:
        return right(places, R, z, lambda gaps: tuple(-xy for xy in across(gaps)))

    return wrong


def _believed(right: Any, wrong: Any) -> Any:
    def both(*given: Any) -> Any:
        (_, closed), (centre, limbs) = right(*given), wrong(*given)
        return centre, [(*limb[:2], off) for limb, (*_, off) in zip(limbs, closed, strict=True)]

    return both


def _eq_3(right: Any) -> Any:
    return lambda e, v: right(e, (-v[0], v[1], v[2]))


def _doubled(name: str) -> Callable[[Any], property]:
    """Twice what a section says, as the analytic model reads it; solids are made of diameters."""

    def said(section: Section) -> Any:
        value = vars(section)[name]
        return 2 * value if isinstance(value, float) else tuple(2 * one for one in value)

    return lambda _: property(said, lambda section, value: vars(section).update({name: value}))


SLIPS = {
    "Eq. 1": Slip(pose, "leaned", _eq_1, "exudyn-cable"),
    "Eq. 2, sign of x and y": Slip(pose, "held", _eq_2, "exudyn-cable"),
    "Eq. 2, sign of R": Slip(pose, "held", _eq_2_sign_of_r, "mujoco-cable"),
    "Eq. 2, refused": Slip(pose, "held", _eq_2_noticed, "exudyn-cable"),
    "Eq. 3": Slip(kinematics, "_framed", _eq_3, "exudyn-cable"),
    "A": Slip(Section, "area", _doubled("area"), "ngsolve-averaged"),
    "I": Slip(Section, "second_moments", _doubled("second_moments"), "ngsolve-averaged"),
    "kappa": Slip(
        Theory, "shear_coefficient", lambda right: lambda *given: 2 * right(*given), "exudyn-beam",
        "timoshenko",
    ),
}  # fmt: skip
"""Of Section 2 and Eqs. (1)-(3), (10)-(13)."""


def _backwards(right: Any) -> Any:
    return lambda self, arm: right(self, -arm)


def _arms_turned(right: Any) -> Any:
    def wrong(*given: Any) -> Any:
        found = right(*given)
        return replace(found, arms=-found.arms)

    return wrong


def _other_side(right: Any) -> Any:
    return lambda mass, inertia, centre: right(mass, inertia, -centre)


def _other_way(right: Any) -> Any:
    return lambda self, item: right(self, item) * np.array([1, 1, 1, 1, -1, 1])[:, None]


def _back(right: Any) -> Any:
    return lambda R, matrix: right(R.swapaxes(-1, -2), matrix)


CHAIN_SLIPS = {
    "carried along a link": (network.Map, "carried", _backwards, "tricept"),
    "from limb to global axes": (network, "_turned", _back, "hexapod"),
    "o to A_i": (placed, "_placed", _arms_turned, "rps-real"),
    "a joint's axis": (placed.Placed, "twists", _other_way, "prs"),
    "the platform's centre": (platform, "body_mass", _other_side, "rps-real"),
}
"""Wrong signs in what carries motion along a chain: owner, name, what is wrong, who shows it."""


def forget() -> None:
    """Have the analytic model compute all anew."""
    for name, module in list(sys.modules.items()):
        if name.startswith("analytic"):
            for thing in vars(module).values():
                getattr(thing, "cache_clear", lambda: None)()


@pytest.fixture
def unknown() -> Iterator[None]:
    forget()
    yield
    forget()


@pytest.mark.usefixtures("unknown")
@pytest.mark.parametrize("slip", SLIPS.values(), ids=SLIPS)
def test_a_slip_in_the_analytic_model_is_seen(
    robot: Mechanism, slip: Slip, monkeypatch: pytest.MonkeyPatch
) -> None:
    try:
        simulator = reference(slip.seen_by, 1 if "ngsolve" in slip.seen_by else 4)
    except UnavailableError as reason:
        pytest.skip(str(reason))
    # A tilt whose sign is seen: limbs at 0, 120 and 240 degrees, a pose with no mirror.
    at = Pose(0.49, np.radians(10), np.radians(-12))
    right = Substructure(3, beam=slip.theory).modes(robot, at).frequencies
    before = simulator.modes(robot, at).frequencies
    right_one = getattr(slip.owner, slip.name, None)  # a section's fields are its instances'
    for owner in {slip.owner, kinematics} if slip.name == "held" else {slip.owner}:
        monkeypatch.setattr(owner, slip.name, slip.wrong(right_one), raising=False)
    for placed_by in (kinematics._of_one, lambda *_: None):  # by numbers, then as many poses are
        monkeypatch.setattr(kinematics, "_of_one", placed_by)
        forget()
        try:
            wrong = Substructure(3, beam=slip.theory).modes(robot, at).frequencies
            assert slip.wrong is not _eq_2_noticed
            assert np.abs(wrong / right - 1).max() > 1e-3
        except InputError:  # refused: seen at once
            assert slip.wrong is _eq_2_noticed
    np.testing.assert_array_equal(simulator.modes(robot, at).frequencies, before)


@pytest.mark.usefixtures("unknown")
@pytest.mark.parametrize("slip", CHAIN_SLIPS.values(), ids=CHAIN_SLIPS)
@pytest.mark.parametrize("seen_by", ["exudyn-beam", "mujoco-chain", "calculix-solid"])
def test_a_wrong_sign_along_a_chain_is_seen(
    slip: tuple[Any, str, Any, str], seen_by: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The simulator that agreed, keeps its numbers and no longer agrees."""
    owner, name, wrong, case = slip
    mechanism, pose = CASES[case].mechanism, CASES[case].pose
    try:
        simulator = reference(seen_by, 2 if seen_by == "calculix-solid" else 4)
    except UnavailableError as reason:
        pytest.skip(str(reason))
    right = Substructure(3, beam="timoshenko").modes(mechanism, pose, 4).frequencies
    before = simulator.modes(mechanism, pose, 4).frequencies
    assert np.abs(before / right - 1).max() < 0.05
    monkeypatch.setattr(owner, name, wrong(getattr(owner, name)))
    forget()
    try:
        slipped = Substructure(3, beam="timoshenko").modes(mechanism, pose, 4).frequencies
        assert np.abs(before / slipped - 1).max() > 2 * np.abs(before / right - 1).max()
    except InputError:
        pass  # refused: seen at once
    np.testing.assert_array_equal(simulator.modes(mechanism, pose, 4).frequencies, before)
