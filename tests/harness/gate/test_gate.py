"""Planted regressions are caught and named: model, case, mode; a clean repeat is clean."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np
import pytest

from analytic import InputError, Limb, Material, Mechanism, Modes, Pose
from harness.bench import Bench
from harness.cases import PRESETS
from harness.gate.compare import (
    BETTER,
    FAILED,
    Finding,
    broken,
    compare,
    condense,
    failures,
    slower,
)
from harness.gate.gate import NotAcceptedError, accepted, look
from harness.gate.measured import Source, measure
from harness.gate.plan import Checked, Plan, solve, standard
from harness.gate.properties import properties
from harness.gate.ratchet import Baseline, accept, measure_noise
from harness.gate.timing_watch import Change, Timing

ABOUT = {"time": "2026-01-01T00:00:00+00:00", "commit": "0" * 40}
CASES = (PRESETS["case1"], PRESETS["case2"])
NAMES = ("timoshenko", "exudyn-cable", "mujoco-cable")
Planted = Callable[..., Plan]


def plan(*names: str) -> Plan:
    """Return the standard study of some models, with the rim of the map at 0, 120 and 240 deg."""
    full = standard(CASES, names)
    return replace(full, poses=full.poses[2::12])


@dataclass(frozen=True)
class Accepted:
    """What was found once and is the baseline since, and a bench that has it all."""

    bench: Bench
    checked: Checked
    baseline: Baseline

    def found(self, wrong: Plan) -> list[Finding]:
        """What the gate says, answers that were refused where they arrived before all else."""
        checked = solve(wrong, self.bench)
        refused = [one for one in failures(checked) if one.fails]
        return refused + compare(self.baseline, measure(checked, self.bench), checked)


@pytest.fixture(scope="module")
def once() -> Iterator[Accepted]:
    with Bench() as bench:
        checked = solve(plan(*NAMES), bench)
        now = measure(checked, bench)
        yield Accepted(bench, checked, accept(None, now, measure_noise(checked, bench), ABOUT, ""))


def stiffer_limb(mechanism: Mechanism, pose: Pose) -> tuple[Mechanism, Pose]:
    """The second limb's moduli are wrong by 1e-6."""
    first, second, third = mechanism.limbs
    steel = second.rod.material
    stiffer = Material(steel.young * (1 + 1e-6), steel.shear * (1 + 1e-6), steel.density)
    wrong: Limb = second.with_rod(replace(second.rod, material=stiffer))
    return replace(mechanism, limbs=(first, wrong, third)), pose


def moved_joint(mechanism: Mechanism, pose: Pose) -> tuple[Mechanism, Pose]:
    """The first limb's joint with the base is 10 micrometres further out."""
    first, *others = mechanism.limbs
    x, y, z = first.base
    return replace(mechanism, limbs=(replace(first, base=(x + 1e-5, y, z)), *others)), pose


def swapped(modes: Modes) -> Modes:
    """The third and fourth shapes change places, their frequencies do not."""
    order = [0, 1, 3, 2, *range(4, len(modes.frequencies))]
    return replace(modes, platform=modes.platform[order], limbs=modes.limbs[order])


def without(mode: int) -> Callable[[Modes], Modes]:
    """One mode is missing, and the list is filled up from above."""

    def change(modes: Modes) -> Modes:
        keep = np.delete(np.arange(len(modes.frequencies)), mode - 1)
        f = np.append(modes.frequencies[keep], 1.5 * modes.frequencies[-1])
        last = [*keep.tolist(), len(keep)]
        bound = None if modes.uncertainty is None else modes.uncertainty[last]
        return replace(
            modes,
            frequencies=f,
            platform=modes.platform[last],
            limbs=modes.limbs[last],
            uncertainty=bound,
        )

    return change


@pytest.mark.slow
def test_a_clean_repeat_is_clean(once: Accepted) -> None:
    with Bench() as bench:
        checked = solve(plan(*NAMES), bench)
        report = look(checked, bench, once.baseline)
    assert report.findings == ()
    assert report.passed
    assert report.checked["frequency"] == len(once.baseline.figures.modes)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_a_stiffness_wrong_by_1e_6_in_one_limb(once: Accepted, plant: Planted, name: str) -> None:
    findings = once.found(plant(plan(name), name, ask=stiffer_limb))
    moved = [one for one in findings if one.kind == "frequency"]
    for case in ("case1", "case2"):
        for model in plan(name).everywhere:
            modes = {one.mode for one in moved if (one.case, one.model) == (case, model.label)}
            # A limb whose end hardly moves in a mode hardly stiffens it.
            assert len(modes) >= 4, (case, model.label)
    for one in moved:
        assert one.verdict in (FAILED, BETTER)
        assert isinstance(one.before, float) and isinstance(one.after, float)
        assert 0 < one.after / one.before - 1 < 5.1e-7
    assert any(one.case.startswith("workspace z=350 mm, phi=") for one in moved)
    assert len(condense(findings)) < len(findings)


@pytest.mark.slow
def test_an_unequal_limb_shows_without_any_baseline(once: Accepted, plant: Planted) -> None:
    """120-degree symmetry: the mapped models show it, each by itself."""
    whole = replace(plan("exudyn-cable"), cases=(), ladders=(), singles=())
    assert broken(properties(solve(whole, once.bench), once.bench)) == []
    wrong = solve(plant(whole, "exudyn-cable", ask=stiffer_limb), once.bench)
    found = broken(properties(wrong, once.bench))
    (one,) = [one for one in found if one.quantity == "120 deg symmetry"]
    assert one.model == "exudyn-cable@8"
    assert one.case.startswith("workspace z=") and one.mode is not None


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES[:2])
def test_a_joint_offset_of_ten_micrometres(once: Accepted, plant: Planted, name: str) -> None:
    findings = once.found(plant(plan(name), name, ask=moved_joint))
    for case in ("case1", "case2"):
        moved = {one.mode for one in findings if one.kind == "frequency" and one.case == case}
        assert len(moved) == 6


@pytest.mark.slow
@pytest.mark.parametrize("name", ["timoshenko", "mujoco-cable"])
def test_a_swapped_pair_of_modes(once: Accepted, plant: Planted, name: str) -> None:
    """No frequency differs: their shapes do."""
    findings = once.found(plant(plan(name), name, after=swapped))
    assert {one.kind for one in findings} == {"shape"}
    named = {(one.model, one.case, one.mode) for one in findings}
    assert named >= {
        (model.label, case, mode)
        for model in plan(name).everywhere
        for case in ("case1", "case2")
        for mode in (3, 4)
    }
    assert {one.mode for one in findings} == {3, 4}
    assert all("looks like mode" in one.cause for one in findings)


@pytest.mark.slow
@pytest.mark.parametrize("mode", [1, 3, 6])
def test_a_lost_mode(once: Accepted, plant: Planted, mode: int) -> None:
    findings = once.found(plant(plan("exudyn-cable"), "exudyn-cable", after=without(mode)))
    labels = {model.label for model in plan("exudyn-cable").everywhere}
    assert {one.model for one in findings} == labels
    refused = {(one.model, one.case) for one in findings if one.kind == "failure"}
    for label in labels:
        # Where its answer is not of the theory that it declares, it never came to be compared.
        if (label, "case2") not in refused:
            (one,) = [f for f in findings if (f.model, f.case) == (label, "case2")]
            assert (one.kind, one.mode, one.cause) == ("mode count", mode, "mode lost")
            assert isinstance(one.before, float) and one.after == one.before - 1
        if (label, "case1") not in refused:
            # Case 1 has its modes in equal pairs: either of a pair is the lost one.
            (one,) = [f for f in findings if (f.model, f.case) == (label, "case1")]
            assert one.mode in {1: (1, 2), 3: (3,), 6: (5, 6)}[mode]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["timoshenko", "exudyn-cable"])
def test_a_lost_mode_shows_without_any_baseline(once: Accepted, plant: Planted, name: str) -> None:
    """Wittrick and Williams count one more than an exact model gives, or the finest mesh."""
    study = replace(plan(name), mapped=(), poses=())
    wrong = solve(plant(study, name, after=without(3)), once.bench)
    names = {one.quantity: one for one in broken(properties(wrong, once.bench))}
    refused = {one.model for one in failures(wrong) if one.fails}
    assert "modes counted on the finest mesh" in names or refused
    if name == "timoshenko":
        assert "timoshenko@exact" in refused
    assert broken(properties(solve(study, once.bench), once.bench)) == []


@pytest.mark.slow
def test_another_version_is_named_as_the_cause(once: Accepted) -> None:
    """A simulator's release, and a frequency that it moved towards the exact limit."""
    label, old = "timoshenko@16", once.baseline.figures
    f = old.modes["case1", label, 3]
    figures = replace(
        old,
        sources=old.sources | {label: Source(old.sources[label].theory, "program 1")},
        modes=old.modes | {("case1", label, 3): replace(f, frequency=f.frequency * 1.001)},
    )
    now = measure(once.checked, once.bench)
    before = replace(once.baseline, figures=figures)
    version, moved, *_ = compare(before, now, once.checked)
    assert (version.kind, version.quantity, version.before) == ("source", "version", "program 1")
    assert not version.fails
    assert (moved.model, moved.case, moved.mode, moved.verdict) == (label, "case1", 3, BETTER)
    assert moved.cause == f"program 1 -> {old.sources[label].version}"


@pytest.mark.slow
def test_what_is_no_longer_measured_is_a_finding(once: Accepted) -> None:
    """A mesh, a case, a map that left the study; a model that less was asked for is none."""
    full = plan(*NAMES)

    def missing(changed: Plan) -> dict[tuple[str, str], str]:
        found = once.found(changed)
        assert all(one.kind == "missing" and one.fails for one in found)
        return {(one.model, one.case): one.cause for one in found}

    exact = [one for one in full.singles if one.elements is not None]
    assert missing(replace(full, singles=tuple(exact))) == {
        ("timoshenko@exact", "case1"): "not in the study any more",
        ("timoshenko@exact", "case2"): "not in the study any more",
    }
    assert {case for _, case in missing(replace(full, cases=CASES[:1]))} == {"case2"}
    assert len(missing(replace(full, poses=full.poses[:-1]))) == len(full.mapped)
    assert missing(plan("timoshenko")) == {}
    figures = once.baseline.figures
    renamed = replace(
        figures,
        modes=figures.modes | {("case1", "gone@4", 1): figures.modes["case1", "timoshenko@4", 1]},
    )
    now = measure(once.checked, once.bench)
    (one,) = compare(replace(once.baseline, figures=renamed), now, once.checked)
    assert (one.kind, one.model, one.cause) == ("missing", "gone@4", "no model has this name")


@pytest.mark.slow
def test_a_smaller_uncertainty_is_a_finding(once: Accepted) -> None:
    """What is extrapolated states how far off it may be: a millionth of that is another claim."""

    checked = solve(plan("exudyn-cable"), once.bench)
    surer = {
        key: modes if modes.uncertainty is None
        else replace(modes, uncertainty=1e-6 * modes.uncertainty)
        for key, modes in checked.cases.answers.items()
    }  # fmt: skip
    # The bench itself extrapolates: no model can state it.
    wrong = replace(checked, cases=replace(checked.cases, answers=surer))
    findings = compare(once.baseline, measure(wrong, once.bench), wrong)
    assert {(one.kind, one.model) for one in findings} == {("uncertainty", "exudyn-cable@8+16")}
    assert len(findings) == 12
    names = {one.quantity for one in broken(properties(wrong, once.bench))}
    assert names == {"extrapolated is exact"}


@pytest.mark.slow
def test_kilohertz_for_hertz_is_no_pass_and_not_accepted(once: Accepted, plant: Planted) -> None:
    """Without a baseline as well: its shapes are not those of such frequencies."""
    study = replace(plan("exudyn-cable"), mapped=(), poses=())
    checked = solve(plant(study, "exudyn-cable", factor=lambda m, p: 1e-3), once.bench)
    report = look(checked, once.bench, None)
    assert not report.passed
    assert {one.kind for one in report.failed} == {"failure"}
    with pytest.raises(NotAcceptedError, match="x failure, which cannot be"):
        accepted(replace(report, about=ABOUT), checked, once.bench, "a good reason")


@pytest.mark.slow
def test_one_percent_is_not_accepted_into_a_new_baseline(once: Accepted, plant: Planted) -> None:
    """Its theory has an exact limit, and one percent is not on the way there."""
    study = replace(plan("exudyn-cable"), mapped=(), poses=())
    checked = solve(plant(study, "exudyn-cable", factor=lambda m, p: 1.01), once.bench)
    report = look(checked, once.bench, None)
    assert {one.quantity for one in report.failed} & {"s -> infinity is exact", "answer"}
    with pytest.raises(NotAcceptedError, match=r"\d x .*, which cannot be"):
        accepted(replace(report, about=ABOUT), checked, once.bench, "a good reason")


@pytest.mark.slow
def test_what_lowers_the_bar_takes_a_reason_and_what_is_gone_goes(once: Accepted) -> None:
    """A model that left the study stays in the baseline until it is said why it goes."""
    full = plan(*NAMES)
    meshed, mapped = (
        tuple(m for m in some if m.elements is not None) for some in (full.singles, full.mapped)
    )
    less = replace(full, singles=meshed, mapped=mapped)
    checked = solve(less, once.bench)
    report = replace(look(checked, once.bench, once.baseline), about=ABOUT)
    with pytest.raises(InputError, match=r"why \d+ findings that lower the bar are right"):
        accepted(report, checked, once.bench, "")
    new = accepted(report, checked, once.bench, "it is elsewhere now")
    assert "timoshenko@exact" in once.baseline.figures.sources
    assert "timoshenko@exact" not in new.figures.sources
    assert not any("timoshenko@exact" in key for key in (*new.figures.modes, *new.tolerance))
    assert {(one.model, one.reason) for one in new.reasons} == {
        ("timoshenko@exact", "it is elsewhere now")
    }


def test_zero_comparisons_are_no_pass() -> None:
    with Bench() as bench:
        nothing = replace(
            standard(CASES, ["timoshenko"]),
            cases=(), ladders=(), singles=(), mapped=(), poses=(),
        )  # fmt: skip
        checked = solve(nothing, bench)
        report = look(checked, bench, None)
    assert report.failed == [] and not report.passed
    assert "nothing was compared" in report.sentences()[0]


def test_a_slower_model_fails_and_a_faster_one_is_noted() -> None:
    steady = Change(1.0, 0.1, 0.2, 5, 30)
    slow, fast = Change(2.0, 1.3, 0.2, 5, 30), Change(2.0, 1.3, 0.2, 5, 30)
    day = datetime(2026, 1, 1)
    one, two = slower([Timing("a", slow, steady, day), Timing("b", steady, fast, day)])
    assert (one.model, one.after, one.fails) == ("a", 2.0, True)
    assert (two.model, two.after, two.fails) == ("b", 0.5, False)
