"""What moved since the baseline: frequencies, modes, orders, versions and seconds, by name."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from analytic import InputError
from analytic.pairing import TRUSTED
from harness.bench import label
from harness.gate.equivalents import relative
from harness.gate.measured import Key, Measured, Place
from harness.gate.plan import NOT_ASKED, Checked, group
from harness.gate.properties import Property
from harness.gate.ratchet import SHAPE, Baseline
from harness.gate.timing_watch import Timing
from harness.rows import GATE
from reference_models import parse

FAILED, BETTER, NOTED = "failed", "better", "noted"
"""`BETTER` fails as well (a two-way ratchet), but is accepted without a reason."""


@dataclass(frozen=True)
class Finding:
    """One thing that is not as it was, or not as it must be.

    Attributes: `kind`, one of `KINDS`; `model`, `case`, `mode` (from 1; None where it concerns
    all); `quantity`; its value `before` and `after`; `tolerance`, the change allowed; `verdict`;
    `cause`, as far as it can be seen.
    """

    kind: str
    model: str
    case: str
    mode: int | None
    quantity: str
    before: float | str | None
    after: float | str | None
    tolerance: float | None
    verdict: str
    cause: str = ""

    @property
    def fails(self) -> bool:
        """Whether it makes the check fail."""
        return self.verdict in (FAILED, BETTER)

    def record(self) -> dict[str, Any]:
        """Return the finding as JSON has it."""
        return asdict(self)


KINDS = ("frequency", "uncertainty", "shape", "mode count", "order", "missing", "property",
         "timing", "failure", "source")  # fmt: skip
"""Every kind of finding, in the order in which tables show them."""


def compare(baseline: Baseline, now: Measured, checked: Checked) -> list[Finding]:
    """Return what of `now` differs from the baseline by more than its tolerance, and notes."""
    causes = _causes(baseline.figures, now)
    findings = _sources(baseline.figures, now) + _missing(baseline.figures, now, checked)
    spoiled: set[Place] = set()
    for place in now.counts:
        if place in baseline.figures.counts:
            lost = _count(baseline, now, place)
            findings += lost
            if lost:
                spoiled.add(place)
    for key, one in now.modes.items():
        case, model, mode = key
        old = baseline.figures.modes.get(key)
        # Where a mode is missing the numbers above it mean something else.
        if old is None or (case, model) in spoiled:
            continue
        cause = causes.get(model, "")
        if not relative(one.frequency, old.frequency) <= baseline.allowed(key):
            better = _closer(baseline.figures, now, key)
            findings.append(
                Finding("frequency", model, case, mode, "f [Hz]", old.frequency, one.frequency,
                        baseline.allowed(key), BETTER if better else FAILED, cause)
            )  # fmt: skip
        assert one.likeness is not None, "measured just now"
        like = float(one.likeness[old.partner - 1])
        if not like >= old.assurance - SHAPE:
            quantity = f"likeness with mode {old.partner} of the anchor"
            looks = f"looks like mode {one.partner} (assurance {one.assurance:.3f})"
            findings.append(
                Finding("shape", model, case, mode, quantity, old.assurance, like, SHAPE, FAILED,
                        "; ".join(filter(None, (looks, cause))))
            )  # fmt: skip
    findings += _uncertainties(baseline, now, spoiled, causes)
    return findings + _orders(baseline, now, spoiled, causes)


def _missing(before: Measured, now: Measured, checked: Checked) -> list[Finding]:
    """Return every accepted model and pose without figures, unless less was asked for."""
    failed = {(case.name, label(m)) for study in checked.studies for case, m in study.failures}
    skipped, findings = checked.plan.skipped, []
    for case, model in before.places:
        if (case, model) in now.places or (case, model) in failed:
            continue
        why = "no model has this name"
        try:
            name = parse(model, "baseline").name
        except InputError:
            pass
        else:
            why = skipped.get(name, "not in the study any more")
            if name in skipped:
                continue
        findings.append(
            Finding("missing", model, case, None, "accepted figures", "accepted", "not measured",
                    None, FAILED, why)
        )  # fmt: skip
    return findings


def _count(baseline: Baseline, now: Measured, place: Place) -> list[Finding]:
    """Return the modes that are missing, or one finding for modes that were not there."""
    case, model = place
    old, new = baseline.figures.counts[place], now.counts[place]
    assert new.spectrum is not None, "measured just now"
    number = int((new.spectrum < old.cut).sum())
    if number == old.number:
        return []
    quantity = f"modes below {old.cut:.6g} Hz"
    missing: list[int | None] = []
    if number < old.number:
        found = now.found[place]
        for mode in range(1, len(found) + 1):
            shaped = baseline.figures.modes.get((case, model, mode))
            known = shaped and shaped.assurance >= TRUSTED and shaped.partner <= len(found)
            if shaped and known and found[shaped.partner - 1] < TRUSTED:
                missing.append(mode)
    said = "mode lost" if number < old.number else "more modes than before"
    return [
        Finding("mode count", model, case, mode, quantity, float(old.number), float(number), 0.0,
                FAILED, said)
        for mode in missing or [None]
    ]  # fmt: skip


def _uncertainties(
    baseline: Baseline, now: Measured, spoiled: set[Place], causes: Mapping[str, str]
) -> list[Finding]:
    findings = []
    for key, old in baseline.figures.uncertainties.items():
        case, model, mode = key
        if key not in now.modes or (case, model) in spoiled:
            continue
        new, allowed = now.uncertainties.get(key), baseline.uncertainty_tolerance(key)
        if new is None or not relative(new, old) <= allowed:
            findings.append(
                Finding("uncertainty", model, case, mode, "stated uncertainty [Hz]", old, new,
                        allowed, FAILED, causes.get(model, ""))
            )  # fmt: skip
    return findings


def _orders(
    baseline: Baseline, now: Measured, spoiled: set[Place], causes: Mapping[str, str]
) -> list[Finding]:
    findings = []
    for key, old in baseline.figures.orders.items():
        case, name, mode = key
        new = now.orders.get(key)
        measured = all((case, one, mode) in now.modes for one in old.labels)
        if not measured or any((case, one) in spoiled for one in old.labels):
            continue
        allowed = baseline.order_tolerance(key)
        if new is None or not abs(new.p - old.p) <= allowed:
            better = new is not None and abs(new.p - old.formal) < abs(old.p - old.formal)
            findings.append(
                Finding("order", name, case, mode, f"order on {', '.join(map(str, old.elements))}",
                        old.p, None if new is None else new.p, allowed,
                        BETTER if better else FAILED, causes.get(old.labels[-1], ""))
            )  # fmt: skip
    return findings


def _closer(before: Measured, now: Measured, key: Key) -> bool:
    """Return whether a frequency came closer to the exact limit of its model's theory."""
    case, model, _ = key
    exact = now.limits.get(model)
    old, new = before.modes[key], now.modes[key]
    limits = [
        one.frequency
        for (where, other, _), one in before.modes.items()
        if (where, other) == (case, exact) and one.partner == old.partner
    ]
    if not limits:
        return False
    return abs(new.frequency - limits[0]) < abs(old.frequency - limits[0])


def _causes(before: Measured, now: Measured) -> dict[str, str]:
    return {
        model: f"{old.version} -> {new.version}"
        for model, new in now.sources.items()
        if (old := before.sources.get(model)) and old.version != new.version
    }


def _sources(before: Measured, now: Measured) -> list[Finding]:
    """Return other versions, theories and mechanisms, and models that are new."""
    findings = []
    for model, new in now.sources.items():
        old = before.sources.get(model)
        if old is None:
            findings.append(
                Finding("source", model, "", None, "model", None, new.version, None, NOTED,
                        "not in the baseline: rps-bench accept adds it")
            )  # fmt: skip
            continue
        for quantity, was, is_now, verdict in (
            ("version", old.version, new.version, NOTED),
            ("theory", old.theory, new.theory, FAILED),
        ):
            if was != is_now:
                findings.append(
                    Finding("source", model, "", None, quantity, was, is_now, None, verdict)
                )
    for case, mechanism in now.mechanisms.items():
        if before.mechanisms.get(case, mechanism) != mechanism:
            findings.append(
                Finding("source", "", case, None, "mechanism", before.mechanisms[case], mechanism,
                        None, FAILED, "another mechanism, not another answer")
            )  # fmt: skip
    return findings


def failures(checked: Checked) -> list[Finding]:
    """Return models that failed at a pose, and those that cannot run here."""
    gone = [
        Finding("source", model, "", None, "model", None, None, None, NOTED, f"not run: {why}")
        for model, why in checked.plan.skipped.items()
        if why != NOT_ASKED
    ]
    failed = {
        (case.name, label(model)): why
        for study in checked.studies
        for (case, model), why in study.failures.items()
    } | {(GATE, label(model)): why for model, why in checked.failures.items()}
    return gone + [
        Finding("failure", model, case, None, "answer", None, None, None, FAILED, why)
        for (case, model), why in failed.items()
    ]


def broken(properties: Sequence[Property]) -> list[Finding]:
    """Return the properties that do not hold."""
    return [
        Finding("property", one.model, one.case, one.mode, one.name, None, one.deviation,
                one.bound, FAILED, one.remark)
        for one in properties if not one.holds
    ]  # fmt: skip


def slower(found: Sequence[Timing]) -> list[Finding]:
    """Return models whose seconds changed by more than their noise; faster ones are noted."""
    findings = []
    for one in found:
        for change, verdict, factor in (
            (one.slower, FAILED, one.slower.factor),
            (one.faster, NOTED, 1 / one.faster.factor),
        ):
            if change.happened:
                findings.append(
                    Finding("timing", one.model, "", None,
                            f"seconds of the last {change.window} runs against those before", 1.0,
                            factor, change.noise, verdict, f"since {one.since:%Y-%m-%d %H:%M}")
                )  # fmt: skip
    return findings


def condense(findings: Sequence[Finding]) -> list[tuple[Finding, int]]:
    """Return what a table shows: of the map's poses each model's worst, and how many it is of.

    Worst: the largest change over its tolerance.
    """
    shown: list[tuple[Finding, int]] = []
    groups: dict[tuple[str, str, str], list[Finding]] = {}
    for one in findings:
        if group(one.case) == GATE and one.case != GATE:
            groups.setdefault((one.kind, one.model, one.verdict), []).append(one)
        else:
            shown.append((one, 1))
    return shown + [(max(some, key=excess), len(some)) for some in groups.values()]


def excess(one: Finding) -> float:
    """Return a finding's change over its tolerance; infinite where that has no meaning."""
    change = moved(one)
    if change is None or not one.tolerance:
        return float(np.inf)
    return abs(change) / one.tolerance


def moved(one: Finding) -> float | None:
    """Return the change: relative for frequencies and seconds, else the difference."""
    if not (isinstance(one.before, float) and isinstance(one.after, float)):
        return None
    if one.kind in ("frequency", "uncertainty", "timing") and one.before:
        return one.after / one.before - 1
    return one.after - one.before
