"""Planted regressions are caught and named: model, case, mode; a clean repeat is clean."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from functools import cache

import numpy as np
import pytest

from analytic import Limb, Material, Mechanism, Modes, Pose
from harness.gate.gate import BETTER, FAILED, Finding, broken, compare, condense, slower
from harness.gate.measured import Source, measure
from harness.gate.metamorphic import properties
from harness.gate.ratchet import Baseline, accept, measure_noise
from harness.gate.study import Checked, Plan, solve, standard
from harness.gate.timing_watch import Change, Timing
from harness.models import Model, Spec

ABOUT = {"time": "2026-01-01T00:00:00+00:00", "commit": "0" * 40}
Change_ = Callable[[Mechanism, Pose], tuple[Mechanism, Pose]]


@dataclass(frozen=True)
class Altered(Spec):
    """A model of the study that is wrong in one way."""

    before: Change_ = lambda mechanism, pose: (mechanism, pose)
    after: Callable[[Modes], Modes] = lambda modes: modes

    def build(self) -> Model:
        model, spec = super().build(), self

        class Wrong:
            def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
                return spec.after(model.modes(*spec.before(mechanism, pose), count))

        return Wrong()


def plan(names: Sequence[str]) -> Plan:
    """Return the standard study of some models, with the rim of the map at 0, 120 and 240 deg."""
    full = standard(names)
    return replace(full, poses=full.poses[2::12], condensed=False)


def altered(study: Plan, name: str, **wrong: object) -> Plan:
    """Return the study with every mesh of one model wrong."""

    def change(specs: Sequence[Spec]) -> tuple[Spec, ...]:
        return tuple(
            Altered(s.name, s.elements, **wrong) if s.name == name else s  # type: ignore[arg-type]
            for s in specs
        )

    return replace(
        study,
        ladders=tuple(change(ladder) for ladder in study.ladders),
        specs=change(study.specs),
        mapped=change(study.mapped),
    )


NAMES = ("timoshenko", "exudyn-cable", "mujoco-cable")


@cache
def accepted() -> tuple[Checked, Baseline]:
    checked = solve(plan(NAMES))
    now = measure(checked)
    return checked, accept(None, now, measure_noise(checked), ABOUT, "")


def found(name: str, **wrong: object) -> list[Finding]:
    return compare(accepted()[1], measure(solve(altered(plan([name]), name, **wrong))))


def rod(limb: Limb, factor: float) -> Limb:
    steel = limb.rod.material
    stiffer = Material(steel.young * factor, steel.shear * factor, steel.density)
    return replace(limb, rod=replace(limb.rod, material=stiffer))


def stiffer_limb(mechanism: Mechanism, pose: Pose) -> tuple[Mechanism, Pose]:
    """The second limb's moduli are wrong by 1e-6."""
    first, second, third = mechanism.limbs
    return replace(mechanism, limbs=(first, rod(second, 1 + 1e-6), third)), pose


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
        return replace(modes, frequencies=f, platform=modes.platform[last], limbs=modes.limbs[last])

    return change


@pytest.mark.slow
def test_a_clean_repeat_is_clean() -> None:
    checked, baseline = accepted()
    assert compare(baseline, measure(solve(plan(NAMES)))) == []
    assert broken(properties(checked)) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_a_stiffness_wrong_by_1e_6_in_one_limb(name: str) -> None:
    findings = found(name, before=stiffer_limb)
    moved = [one for one in findings if one.kind == "frequency"]
    labels = {spec.label for spec in plan([name]).everywhere}
    for case in ("case1", "case2"):
        for label in labels:
            modes = {one.mode for one in moved if (one.case, one.model) == (case, label)}
            # A limb whose end hardly moves in a mode hardly stiffens it.
            assert len(modes) >= 4, (case, label)
    for one in moved:
        assert one.verdict in (FAILED, BETTER)
        assert isinstance(one.before, float) and isinstance(one.after, float)
        assert 0 < one.after / one.before - 1 < 5.1e-7
    assert any(one.case.startswith("workspace z=350 mm, phi=") for one in moved)
    assert len(condense(findings)) < len(findings)


@pytest.mark.slow
def test_an_unequal_limb_shows_without_any_baseline() -> None:
    """120-degree symmetry: the mapped models show it, each by itself."""
    whole = replace(plan(["exudyn-cable"]), cases=(), ladders=())
    assert broken(properties(solve(whole))) == []
    (one,) = broken(properties(solve(altered(whole, "exudyn-cable", before=stiffer_limb))))
    assert (one.quantity, one.model) == ("120 deg symmetry", "exudyn-cable@8")
    assert one.case.startswith("workspace z=") and one.mode is not None


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES[:2])
def test_a_joint_offset_of_ten_micrometres(name: str) -> None:
    findings = found(name, before=moved_joint)
    for case in ("case1", "case2"):
        moved = {one.mode for one in findings if one.kind == "frequency" and one.case == case}
        assert len(moved) == 6


@pytest.mark.slow
@pytest.mark.parametrize("name", ["timoshenko", "mujoco-cable"])
def test_a_swapped_pair_of_modes(name: str) -> None:
    """No frequency differs: their shapes do."""
    findings = found(name, after=swapped)
    assert {one.kind for one in findings} == {"shape"}
    named = {(one.model, one.case, one.mode) for one in findings}
    assert named >= {
        (spec.label, case, mode)
        for spec in plan([name]).everywhere
        for case in ("case1", "case2")
        for mode in (3, 4)
    }
    assert {one.mode for one in findings} == {3, 4}
    assert all("looks like mode" in one.cause for one in findings)


@pytest.mark.slow
@pytest.mark.parametrize("mode", [1, 3, 6])
def test_a_lost_mode(mode: int) -> None:
    findings = found("exudyn-cable", after=without(mode))
    labels = {spec.label for spec in plan(["exudyn-cable"]).everywhere}
    assert {one.model for one in findings} == labels
    for label in labels:
        (one,) = [f for f in findings if (f.model, f.case) == (label, "case2")]
        assert (one.kind, one.mode, one.cause) == ("mode count", mode, "mode lost")
        assert isinstance(one.before, float) and one.after == one.before - 1
        # Case 1 has its modes in equal pairs: either of a pair is the lost one.
        (one,) = [f for f in findings if (f.model, f.case) == (label, "case1")]
        assert one.mode in {1: (1, 2), 3: (3,), 6: (5, 6)}[mode]


@pytest.mark.slow
def test_a_lost_mode_shows_without_any_baseline() -> None:
    """Wittrick and Williams count one more than the exact model gives."""
    study = replace(plan(["timoshenko"]), ladders=(), mapped=(), poses=())
    wrong = altered(study, "timoshenko", after=without(3))
    names = {one.quantity: one for one in broken(properties(solve(wrong)))}
    assert names["Wittrick-Williams count"].mode in (3, 4)
    assert broken(properties(solve(study))) == []


@pytest.mark.slow
def test_another_version_is_named_as_the_cause() -> None:
    """A simulator's release, and a frequency that it moved towards the exact limit."""
    checked, baseline = accepted()
    label, old = "timoshenko@16", baseline.figures
    f = old.modes["case1", label, 3]
    figures = replace(
        old,
        sources=old.sources | {label: Source(old.sources[label].theory, "program 1")},
        modes=old.modes | {("case1", label, 3): replace(f, frequency=f.frequency * 1.001)},
    )
    version, moved, *_ = compare(replace(baseline, figures=figures), measure(checked))
    assert (version.kind, version.quantity, version.before) == ("source", "version", "program 1")
    assert not version.fails
    assert (moved.model, moved.case, moved.mode, moved.verdict) == (label, "case1", 3, BETTER)
    assert moved.cause == f"program 1 -> {old.sources[label].version}"


def test_a_slower_model_fails_and_a_faster_one_is_noted() -> None:
    steady = Change(1.0, 0.1, 0.2, 5, 30)
    slow, fast = Change(2.0, 1.3, 0.2, 5, 30), Change(2.0, 1.3, 0.2, 5, 30)
    day = datetime(2026, 1, 1)
    one, two = slower([Timing("a", slow, steady, day), Timing("b", steady, fast, day)])
    assert (one.model, one.after, one.fails) == ("a", 2.0, True)
    assert (two.model, two.after, two.fails) == ("b", 0.5, False)
