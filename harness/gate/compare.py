"""What moved since the baseline: frequencies, modes, orders, versions and seconds, by name."""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass

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
from harness.workers import Failure
from reference_models import Named, parse

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
    before: float | str | None = None
    after: float | str | None = None
    tolerance: float | None = None
    verdict: str = FAILED
    cause: str = ""

    @property
    def fails(self) -> bool:
        """Whether it makes the check fail."""
        return self.verdict in (FAILED, BETTER)

    @property
    def moved(self) -> float | None:
        """The change: relative for frequencies and seconds, else the difference."""
        if not (isinstance(self.before, float) and isinstance(self.after, float)):
            return None
        if self.kind in ("frequency", "uncertainty", "timing") and self.before:
            return self.after / self.before - 1
        return self.after - self.before


KINDS = ("frequency", "uncertainty", "shape", "mode count", "order", "missing", "property",
         "timing", "failure", "source")  # fmt: skip
"""Every kind of finding, in the order in which tables show them."""


def compare(baseline: Baseline, now: Measured, checked: Checked) -> list[Finding]:
    """Return what of `now` differs from the baseline by more than its tolerance, and notes."""
    before = baseline.figures
    causes = {
        model: f"{old.version} -> {new.version}"
        for model, new in now.sources.items()
        if (old := before.sources.get(model)) and old.version != new.version
    }
    findings = [*_sources(before, now), *_missing(before, now, checked)]
    spoiled: set[Place] = set()
    for place in (one for one in now.counts if one in before.counts):
        lost = _count(before, now, place)
        findings += lost
        # Where a mode is missing the numbers above it mean something else.
        spoiled |= {place} if lost else set()
    for key, new in now.modes.items():
        case, model, mode = key
        was = before.modes.get(key)
        if was is None or (case, model) in spoiled:
            continue
        cause, allowed = causes.get(model, ""), baseline.allowed(key)
        if not relative(new.frequency, was.frequency) <= allowed:
            verdict = BETTER if _closer(before, now, key) else FAILED
            findings.append(Finding("frequency", model, case, mode, "f [Hz]", was.frequency,
                                    new.frequency, allowed, verdict, cause))  # fmt: skip
        assert new.likeness is not None, "measured just now"
        like = float(new.likeness[was.partner - 1])
        if not like >= was.assurance - SHAPE:
            looks = f"looks like mode {new.partner} (assurance {new.assurance:.3f})"
            findings.append(
                Finding("shape", model, case, mode, f"likeness with mode {was.partner} of the "
                        "anchor", was.assurance, like, SHAPE, FAILED,
                        "; ".join(filter(None, (looks, cause))))
            )  # fmt: skip
    for key, stated in before.uncertainties.items():
        case, model, mode = key
        if key not in now.modes or (case, model) in spoiled:
            continue
        band, allowed = now.uncertainties.get(key), baseline.uncertainty_tolerance(key)
        if band is None or not relative(band, stated) <= allowed:
            findings.append(
                Finding("uncertainty", model, case, mode, "stated uncertainty [Hz]", stated, band,
                        allowed, FAILED, causes.get(model, ""))
            )  # fmt: skip
    for key, order in before.orders.items():
        case, model, mode = key
        labels = order.labels(model)
        if any((case, x, mode) not in now.modes or (case, x) in spoiled for x in labels):
            continue
        p = now.orders[key].p if key in now.orders else None
        allowed = baseline.order_tolerance(key)
        if p is None or not abs(p - order.p) <= allowed:
            better = p is not None and abs(p - order.formal) < abs(order.p - order.formal)
            quantity = f"order on {', '.join(map(str, order.elements))}"
            findings.append(
                Finding("order", model, case, mode, quantity, order.p, p, allowed,
                        BETTER if better else FAILED, causes.get(labels[-1], ""))
            )  # fmt: skip
    return findings


def _missing(before: Measured, now: Measured, checked: Checked) -> Iterator[Finding]:
    """Yield every accepted model and pose without figures, unless less was asked for.

    What a program is missing for is noted; a model that is not usable any more fails.
    """
    failed = {(case.name, label(m)) for study in checked.studies for case, m in study.failures}
    for case, model in before.places:
        if (case, model) in now.places or (case, model) in failed:
            continue
        why, verdict = "no model has this name", FAILED
        with suppress(InputError):
            name = parse(model, "baseline").name
            why = checked.plan.skipped.get(name, "not in the study any more")
            if why == NOT_ASKED:
                continue
            if name in checked.plan.skipped and Named(name, None).info().program:
                verdict = NOTED
        yield Finding("missing", model, case, None, "accepted figures", "accepted", "not measured",
                      verdict=verdict, cause=why)  # fmt: skip


def _count(before: Measured, now: Measured, place: Place) -> list[Finding]:
    """Return the modes that are missing, or one finding for modes that were not there."""
    case, model = place
    old, spectrum = before.counts[place], now.counts[place].spectrum
    assert spectrum is not None, "measured just now"
    number = int((spectrum < old.cut).sum())
    if number == old.number:
        return []
    missing: list[int | None] = []
    if number < old.number:
        found = now.found[place]
        for mode in range(1, len(found) + 1):
            one = before.modes.get((case, model, mode))
            if one and one.assurance >= TRUSTED and one.partner <= len(found):
                missing += [mode] if found[one.partner - 1] < TRUSTED else []
    said = "mode lost" if number < old.number else "more modes than before"
    return [
        Finding("mode count", model, case, mode, f"modes below {old.cut:.6g} Hz",
                float(old.number), float(number), 0.0, FAILED, said)
        for mode in missing or [None]
    ]  # fmt: skip


def _closer(before: Measured, now: Measured, key: Key) -> bool:
    """Return whether a frequency came closer to the exact limit of its model's theory."""
    case, model, _ = key
    old, new, limit = before.modes[key], now.modes[key], parse(model, "model").limit()
    exact = None if limit is None else label(limit)
    for (where, other, _), one in before.modes.items():
        if (where, other, one.partner) == (case, exact, old.partner):
            return abs(new.frequency - one.frequency) < abs(old.frequency - one.frequency)
    return False


def _sources(before: Measured, now: Measured) -> Iterator[Finding]:
    """Yield other versions, theories and mechanisms, and models that are new."""
    for model, new in now.sources.items():
        old = before.sources.get(model)
        if old is None:
            yield Finding("source", model, "", None, "model", None, new.version, None, NOTED,
                          "not in the baseline: rps-bench accept adds it")  # fmt: skip
            continue
        for quantity, verdict in (("version", NOTED), ("theory", FAILED)):
            was, now_is = getattr(old, quantity), getattr(new, quantity)
            if was != now_is:
                yield Finding("source", model, "", None, quantity, was, now_is, None, verdict)
    for case, mechanism in now.mechanisms.items():
        was = before.mechanisms.get(case, mechanism)
        if was != mechanism:
            yield Finding("source", "", case, None, "mechanism", was, mechanism,
                          cause="another mechanism, not another answer")  # fmt: skip


def failures(checked: Checked) -> list[Finding]:
    """Return models that failed at a pose, and those that cannot run here."""
    gone = [
        Finding("source", model, "", None, "model", verdict=NOTED, cause=f"not run: {why}")
        for model, why in checked.plan.skipped.items()
        if why != NOT_ASKED
    ]
    gone += [
        Finding("source", label(model), case.name, None, "model", verdict=NOTED,
                cause=f"not run: {study.failures[case, model]}")
        for study in checked.studies
        for case, model in study.failures
        if (case, model) in study.refused
    ]  # fmt: skip
    failed = {
        (case.name, label(model)): why
        for study in checked.studies
        for (case, model), why in study.failures.items()
        if (case, model) not in study.refused
    } | {
        (GATE, label(model)): one.reason
        for model, one in checked.batches.items()
        if isinstance(one, Failure)
    }
    return gone + [
        Finding("failure", model, case, None, "answer", cause=why)
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
    return [
        Finding("timing", one.model, "", None,
                f"seconds of the last {change.window} runs against those before", 1.0,
                factor, change.noise, verdict, f"since {one.since:%Y-%m-%d %H:%M}")
        for one in found
        for change, verdict, factor in (
            (one.slower, FAILED, one.slower.factor),
            (one.faster, NOTED, 1 / one.faster.factor),
        )
        if change.happened
    ]  # fmt: skip


def condense(findings: Sequence[Finding]) -> list[tuple[Finding, int]]:
    """Return what a table shows: of the map's poses each model's worst, and how many it is of.

    Worst: the largest change over its tolerance; what has no such change is worst of all.
    """

    def excess(one: Finding) -> float:
        return abs(one.moved) / one.tolerance if one.moved is not None and one.tolerance else np.inf

    shown: list[tuple[Finding, int]] = []
    groups: dict[tuple[str, str, str], list[Finding]] = {}
    for one in findings:
        if group(one.case) == GATE and one.case != GATE:
            groups.setdefault((one.kind, one.model, one.verdict), []).append(one)
        else:
            shown.append((one, 1))
    return shown + [(max(some, key=excess), len(some)) for some in groups.values()]
