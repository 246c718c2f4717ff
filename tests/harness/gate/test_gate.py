"""Planted regressions are caught and named: model, case, mode; a clean repeat is clean."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Any

import numpy as np
import pytest

from analytic import InputError, Limb, Material, Mechanism, Modes, Pose
from harness import answer as module
from harness.bench import Bench
from harness.cases import PRESETS
from harness.gate.figures import BETTER, FAILED, HELD, NOTED, Figures, Finding, Source, condense
from harness.gate.gate import (
    NotAcceptedError,
    accept,
    accepted,
    compare,
    failures,
    look,
    measure,
    measure_noise,
)
from harness.gate.plan import Checked, Plan, solve, standard
from harness.gate.properties import properties
from harness.gate.timing_watch import Change, Timing, slower
from reference_models import Named

ABOUT = {"time": "2026-01-01T00:00:00+00:00", "commit": "0" * 40}
CASES = (PRESETS["case1"], PRESETS["case2"])
NAMES = ("timoshenko", "exudyn-cable", "mujoco-cable")
Planted = Callable[..., Plan]


def moved(seen: Iterable[Finding]) -> list[Finding]:
    """Return all but what is as it was."""
    return [one for one in seen if one.verdict != HELD]


def plan(*names: str) -> Plan:
    """Return the standard study of some models, with the rim of the map at 0, 120 and 240 deg."""
    full = standard(CASES, names)
    return replace(full, poses=full.poses[2::12])


@dataclass(frozen=True)
class Accepted:
    """What was found once and is the baseline since, and a bench that has it all."""

    bench: Bench
    checked: Checked
    baseline: Figures

    def found(self, wrong: Plan) -> list[Finding]:
        """What the gate says, answers that were refused where they arrived before all else."""
        checked = solve(wrong, self.bench)
        refused = [one for one in failures(checked) if one.fails]
        return refused + moved(compare(self.baseline, measure(checked), checked))


@pytest.fixture(scope="module")
def once() -> Iterator[Accepted]:
    with Bench() as bench:
        checked = solve(plan(*NAMES), bench)
        now = measure(checked)
        yield Accepted(bench, checked, accept(None, now, measure_noise(checked), ABOUT, ""))


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
        report = look(checked, once.baseline)
    assert report.findings == ()
    assert report.passed
    assert report.checked["frequency"] == len(once.baseline.modes)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_a_stiffness_wrong_by_1e_6_in_one_limb(once: Accepted, plant: Planted, name: str) -> None:
    findings = once.found(plant(plan(name), name, ask=stiffer_limb))
    frequencies = [one for one in findings if one.kind == "frequency"]
    for case in ("case1", "case2"):
        for model in plan(name).everywhere:
            modes = {
                one.mode for one in frequencies if (one.case, one.model) == (case, model.label)
            }
            # A limb whose end hardly moves in a mode hardly stiffens it.
            assert len(modes) >= 4, (case, model.label)
    for one in frequencies:
        assert one.verdict in (FAILED, BETTER)
        assert isinstance(one.before, float) and isinstance(one.after, float)
        assert 0 < one.after / one.before - 1 < 5.1e-7
    assert any(one.case.startswith("workspace z=350 mm, phi=") for one in frequencies)
    assert len(condense(findings)) < len(findings)


@pytest.mark.slow
def test_an_unequal_limb_shows_without_any_baseline(once: Accepted, plant: Planted) -> None:
    """120-degree symmetry: the mapped models show it, each by itself."""
    whole = replace(plan("exudyn-cable"), cases=(), ladders=(), singles=())
    assert moved(properties(solve(whole, once.bench))) == []
    wrong = solve(plant(whole, "exudyn-cable", ask=stiffer_limb), once.bench)
    found = moved(properties(wrong))
    (one,) = [one for one in found if one.quantity == "120 deg symmetry"]
    assert one.model == "exudyn-cable@8"
    assert one.case.startswith("workspace z=") and one.mode is not None


def labels(*kept: str) -> set[str]:
    """Return the labels of the cable's meshes and of their limit, or those that end as told."""
    found = {model.label for model in plan("exudyn-cable").everywhere}
    return {one for one in found if not kept or one.removeprefix("exudyn-cable@") in kept}


def spoilt(name: str, i: int, value: float) -> Callable[[Modes], Modes]:
    def change(modes: Modes) -> Modes:
        values = getattr(modes, name).copy()
        values[i] = value * values[i]
        return replace(modes, **{name: values})

    return change


def times(factor: float) -> Any:
    return {"factor": lambda mechanism, pose: factor}


MESHES, LIMIT = labels("4", "8", "16"), labels("8+16")
BOTH = {(label, case.name) for label in MESHES | LIMIT for case in CASES}
EXTRAPOLATED = {(label, case.name) for label in LIMIT for case in CASES}
Places = set[tuple[str, str]]
# What is planted in exudyn-cable; whose answers are refused where they arrive, and at which case;
# and what the gate finds of the others.
PLANTED: dict[str, tuple[dict[str, Any], Places, set[str]]] = {
    "kHz for Hz": (times(1e-3), BOTH, set()),
    "rad/s for Hz": (times(2 * np.pi), BOTH, set()),
    "one percent": (times(1.01), EXTRAPOLATED, {"frequency"}),
    "one in a thousand": (times(1.001), EXTRAPOLATED, {"frequency"}),
    "one in 1e9": (times(1 + 1e-9), set(), {"frequency"}),
    "a limb 1e-6 stiffer": ({"ask": stiffer_limb}, set(), {"frequency"}),
    "a joint 10 micrometres off": ({"ask": moved_joint}, set(), {"frequency"}),
    "shapes 3 and 4 swapped": ({"after": swapped}, BOTH, set()),
    "shapes times 2": (
        {"after": lambda m: replace(m, platform=2 * m.platform, limbs=2 * m.limbs)},
        BOTH, set(),
    ),
    "a mode of no motion": ({"after": spoilt("limbs", 2, 0.0)}, BOTH, set()),
    "NaN": ({"after": spoilt("frequencies", 2, np.nan)}, BOTH, set()),
    "unsorted": ({"after": spoilt("frequencies", 2, 10.0)}, BOTH, set()),
    "an open joint": ({"after": lambda m: replace(m, residual=1e-3)}, BOTH, set()),
    "mode 1 lost": ({"after": without(1)}, BOTH, set()),
    "mode 3 lost": ({"after": without(3)}, BOTH, set()),
    "mode 6 lost": (
        {"after": without(6)}, EXTRAPOLATED | {("exudyn-cable@4", "case2")}, {"mode count"},
    ),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("fault", PLANTED)
def test_a_planted_fault_is_refused_or_found(once: Accepted, plant: Planted, fault: str) -> None:
    """Each where it is said, by name, at both cases; refused numbers never come to be compared."""
    wrong, refused, kinds = PLANTED[fault]
    study = replace(plan("exudyn-cable"), mapped=(), poses=())
    findings = [
        one for one in once.found(plant(study, "exudyn-cable", **wrong))
        if not one.case.startswith("workspace")
    ]  # fmt: skip
    places = {(one.model, one.case) for one in findings if one.kind == "failure"}
    assert places == refused
    found = {(one.model, one.case): one.kind for one in findings if one.kind != "failure"}
    assert {*found.values()} - {"order", "uncertainty"} == kinds
    if kinds:
        assert {*found} | refused >= BOTH - EXTRAPOLATED
    assert all(one.fails for one in findings)


@pytest.mark.slow
def test_a_wrong_flag_of_torsion_shows_without_any_baseline(once: Accepted, plant: Planted) -> None:
    """Missing modes are refused where they arrive; made up ones show where limbs twist low."""
    name = "rods twist as declared"
    for model, twists in (("exudyn-cable", True), ("timoshenko", False)):
        study = replace(plan(model), mapped=(), poses=(), cases=CASES[1:])
        wrong = solve(plant(study, model, twists=twists), once.bench)
        refused = {one.model for one in failures(wrong) if one.fails}
        if model == "exudyn-cable":
            assert refused == MESHES | LIMIT
        else:
            assert refused == set()
            assert name in {one.quantity for one in moved(properties(wrong))}
        right = properties(solve(study, once.bench))
        assert moved(right) == []
        assert name in {one.quantity for one in right}


@pytest.mark.slow
def test_an_extrapolation_of_the_wrong_sign_is_refused(
    once: Accepted, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Away from the limit: what lies on the other side is not of the theory."""
    right = module.extrapolated

    def wrong(coarse: Modes, fine: Modes, *more: Any) -> Modes:
        found = right(coarse, fine, *more)
        count = len(found.frequencies)
        return replace(found, frequencies=2 * fine.frequencies[:count] - found.frequencies)

    monkeypatch.setattr(module, "extrapolated", wrong)
    with Bench() as bench:
        checked = solve(replace(plan(*NAMES[1:]), mapped=(), poses=()), bench)
        report = look(checked, once.baseline)
    named = {one.model for one in report.failed if not one.case.startswith("workspace")}
    assert named == {"exudyn-cable@8+16", "mujoco-cable@8+16"}


@pytest.mark.slow
def test_what_is_no_longer_measured_is_a_finding(
    once: Accepted, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A mesh, a case, a pose, the whole map, a name: but what was not asked for is none."""
    full = plan(*NAMES)

    def missing(changed: Plan) -> dict[tuple[str, str], tuple[str, str]]:
        found = [one for one in once.found(changed) if one.kind != "source"]
        assert {one.kind for one in found} <= {"missing"}
        return {(one.model, one.case): (one.verdict, one.cause) for one in found}

    exact = [one for one in full.singles if one.elements is not None]
    assert missing(replace(full, singles=tuple(exact))) == {
        ("timoshenko@exact", case.name): (FAILED, "not in the study any more") for case in CASES
    }
    assert {case for _, case in missing(replace(full, cases=CASES[:1]))} == {"case2"}
    on_map = len(full.poses) * len(full.mapped)
    assert len(missing(replace(full, poses=full.poses[:-1]))) == len(full.mapped)
    assert len(missing(replace(full, poses=()))) == on_map
    smaller = [
        replace(case, name=f"{case.name}.", pose=replace(case.pose, tilt=0.9 * case.pose.tilt))
        for case in full.poses
    ]
    assert len(missing(replace(full, poses=tuple(smaller)))) == on_map
    assert missing(plan("timoshenko")) == {}
    # A program that is not installed is noted; a model that cannot be imported any more fails.
    part = plan(*NAMES[:2])
    gone = replace(part, skipped={**part.skipped, "mujoco-cable": "cannot run here: no mujoco"})
    assert {verdict for verdict, _ in missing(gone).values()} == {NOTED}
    broken_info = replace(Named("mujoco-cable", None).info(), program="")
    monkeypatch.setattr(Named, "info", lambda self: broken_info)
    found = moved(compare(once.baseline, measure(once.checked), replace(
        once.checked, plan=gone, cases=replace(once.checked.cases, answers={}, models=())
    )))  # fmt: skip
    assert found == []  # all were measured
    monkeypatch.undo()


@pytest.mark.slow
def test_what_the_baseline_says_is_what_is_compared(once: Accepted) -> None:
    """Another frequency, order, count, uncertainty, shape, theory, mechanism or name in it."""
    figures, label = once.baseline, "timoshenko@16"
    key, place = ("case1", label, 3), ("case1", label)
    order, band = ("case1", "timoshenko", 4), ("case2", "exudyn-cable@8+16", 5)
    was, source = figures.modes[key], figures.sources[label]
    counted = figures.counts[place]
    changes: dict[str, tuple[str, Any]] = {
        "frequency": ("modes", {key: was._replace(frequency=was.frequency * (1 + 1e-9))}),
        "shape": ("modes", {key: was._replace(partner=was.partner + 2)}),
        "mode count": ("counts", {place: counted._replace(number=counted.number - 1)}),
        "order": ("orders", {order: figures.orders[order]._replace(p=1.0)}),
        "uncertainty": ("uncertainties", {band: 1e-6 * figures.uncertainties[band]}),
        "missing": ("modes", {("case1", "gone@4", 1): was}),
        "source": ("sources", {label: Source("another", source.version)}),
        "source ": ("mechanisms", {"case1": "0123456789ab"}),
    }
    now = measure(once.checked)
    assert moved(compare(once.baseline, now, once.checked)) == []
    for kind, (name, changed) in changes.items():
        wrong = replace(figures, **{name: getattr(figures, name) | changed})
        (one,) = moved(compare(wrong, now, once.checked))
        assert one.kind == kind.strip() and one.fails
        assert label in (one.model, label) if kind == "missing" else True
    older = replace(figures, sources=figures.sources | {label: Source(source.theory, "program 1")},
                    modes=figures.modes | changes["frequency"][1])  # fmt: skip
    version, other = moved(compare(older, now, once.checked))
    assert (version.quantity, version.before, version.fails) == ("version", "program 1", False)
    assert (other.model, other.case, other.mode) == (label, "case1", 3)
    assert other.cause == f"program 1 -> {source.version}" and other.verdict == BETTER


@pytest.mark.slow
def test_kilohertz_for_hertz_is_no_pass_and_not_accepted(once: Accepted, plant: Planted) -> None:
    """Without a baseline as well: exact beams have other frequencies."""
    study = replace(plan("exudyn-cable"), mapped=(), poses=())
    checked = solve(plant(study, "exudyn-cable", factor=lambda m, p: 1e-3), once.bench)
    report = look(checked, None)
    assert not report.passed
    assert {one.kind for one in report.failed} == {"failure"}
    with pytest.raises(NotAcceptedError, match="x failure, which cannot be"):
        accepted(replace(report, about=ABOUT), "a good reason")


@pytest.mark.slow
def test_one_percent_is_not_accepted_into_a_new_baseline(once: Accepted, plant: Planted) -> None:
    """Of meshes it is found; what is extrapolated from them is refused."""
    study = replace(plan("exudyn-cable"), mapped=(), poses=())
    checked = solve(plant(study, "exudyn-cable", factor=lambda m, p: 1.01), once.bench)
    report = look(checked, None)
    assert {one.model for one in report.failed if one.kind == "failure"} == LIMIT
    assert "s -> infinity is exact" in {one.quantity for one in report.failed}
    with pytest.raises(NotAcceptedError, match=r"\d x .*, which cannot be"):
        accepted(replace(report, about=ABOUT), "a good reason")


@pytest.mark.slow
def test_what_lowers_the_bar_takes_a_reason_and_what_is_gone_goes(once: Accepted) -> None:
    """A model that left the study stays in the baseline until it is said why it goes."""
    full = plan(*NAMES)
    meshed, mapped = (
        tuple(m for m in some if m.elements is not None) for some in (full.singles, full.mapped)
    )
    less = replace(full, singles=meshed, mapped=mapped)
    checked = solve(less, once.bench)
    report = replace(look(checked, once.baseline), about=ABOUT)
    with pytest.raises(InputError, match=r"why \d+ findings that lower the bar are right"):
        accepted(report, "")
    new = accepted(report, "it is elsewhere now")
    assert "timoshenko@exact" in once.baseline.sources
    assert "timoshenko@exact" not in new.sources
    assert not any("timoshenko@exact" in key for key in (*new.modes, *new.limits))
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
        report = look(checked, None)
    assert report.failed == [] and not report.passed
    assert "nothing was compared" in report.sentences()[0]


def test_a_slower_model_fails_and_a_faster_one_is_noted() -> None:
    steady = Change(1.0, 0.1, 0.2, 5, 30)
    slow, fast = Change(2.0, 1.3, 0.2, 5, 30), Change(2.0, 1.3, 0.2, 5, 30)
    day = datetime(2026, 1, 1)
    one, two = slower([Timing("a", slow, steady, day), Timing("b", steady, fast, day)])
    assert (one.model, one.after, one.fails) == ("a", 2.0, True)
    assert (two.model, two.after, two.fails) == ("b", 0.5, False)
