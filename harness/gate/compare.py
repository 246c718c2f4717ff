"""What moved since the baseline: frequencies, modes, orders, versions and seconds, by name."""

from collections.abc import Iterator, Sequence
from contextlib import suppress

from analytic import InputError
from analytic.pairing import TRUSTED
from harness.bench import label
from harness.gate.equivalents import relative
from harness.gate.finding import FAILED, HELD, NOTED, Finding, judged
from harness.gate.measured import Key, Measured, Place
from harness.gate.plan import NOT_ASKED, Checked
from harness.gate.ratchet import SHAPE, Baseline
from harness.gate.timing_watch import Timing
from harness.rows import GATE
from harness.workers import Failure
from reference_models import Named, parse


def compare(baseline: Baseline, now: Measured, checked: Checked) -> Iterator[Finding]:
    """Yield every figure of `now` that the baseline holds, and what is new, gone or another."""
    before = baseline.figures
    causes = {
        model: f"{old.version} -> {new.version}"
        for model, new in now.sources.items()
        if (old := before.sources.get(model)) and old.version != new.version
    }
    yield from _sources(before, now)
    yield from _missing(before, now, checked)
    spoiled: set[Place] = set()
    for place in (one for one in now.counts if one in before.counts):
        counted = _count(before, now, place)
        yield from counted
        # Where a mode is missing the numbers above it mean something else.
        spoiled |= {place} if counted[0].fails else set()

    def comparable(case: str, mode: int, *models: str) -> bool:
        return all((case, m, mode) in now.modes and (case, m) not in spoiled for m in models)

    for key, new in now.modes.items():
        case, model, mode = key
        was, cause = before.modes.get(key), causes.get(model, "")
        if was is None or not comparable(case, mode, model):
            continue
        allowed = baseline.allowed(key)
        same = bool(relative(new.frequency, was.frequency) <= allowed)
        verdict = judged(same, not same and _closer(before, now, key))
        yield Finding("frequency", model, case, mode, "f [Hz]", was.frequency, new.frequency,
                      allowed, verdict, cause)  # fmt: skip
        like = float(now.answers[case, model][1].matrix[mode - 1, was.partner - 1])
        looks = f"looks like mode {new.partner} (assurance {new.assurance:.3f})"
        yield Finding("shape", model, case, mode, f"likeness with mode {was.partner} of the anchor",
                      was.assurance, like, SHAPE, judged(like >= was.assurance - SHAPE),
                      "; ".join(filter(None, (looks, cause))))  # fmt: skip
    for key, stated in before.uncertainties.items():
        case, model, mode = key
        if comparable(case, mode, model):
            band, allowed = now.uncertainties.get(key), baseline.uncertainty_tolerance(key)
            same = band is not None and bool(relative(band, stated) <= allowed)
            yield Finding("uncertainty", model, case, mode, "stated uncertainty [Hz]", stated, band,
                          allowed, judged(same), causes.get(model, ""))  # fmt: skip
    for key, order in before.orders.items():
        case, model, mode = key
        labels = order.labels(model)
        if comparable(case, mode, *labels):
            p = now.orders[key].p if key in now.orders else None
            allowed = baseline.order_tolerance(key)
            same = p is not None and abs(p - order.p) <= allowed
            better = p is not None and abs(p - order.formal) < abs(order.p - order.formal)
            yield Finding("order", model, case, mode,
                          f"order on {', '.join(map(str, order.elements))}", order.p, p, allowed,
                          judged(same, better), causes.get(labels[-1], ""))  # fmt: skip


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
    """Return the count below the accepted cut: a row for each mode that is missing, or one."""
    case, model = place
    old, (modes, _, back) = before.counts[place], now.answers[place]
    number = int((modes.frequencies < old.cut).sum())
    missing: list[int | None] = []
    if number < old.number:
        found = back.assurance
        for mode in range(1, len(found) + 1):
            one = before.modes.get((case, model, mode))
            if one and one.assurance >= TRUSTED and one.partner <= len(found):
                missing += [mode] if found[one.partner - 1] < TRUSTED else []
    lost = "mode lost" if number < old.number else "more modes than before"
    verdict, said = (HELD, "") if number == old.number else (FAILED, lost)
    return [
        Finding("mode count", model, case, mode, f"modes below {old.cut:.6g} Hz",
                float(old.number), float(number), 0.0, verdict, said)
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


def failures(checked: Checked) -> Iterator[Finding]:
    """Yield models that failed at a pose, and those that cannot run here.

    The latter are failures too where they were asked for by name.
    """
    for name, why in checked.plan.skipped.items():
        if why != NOT_ASKED:
            verdict = FAILED if name in checked.plan.asked else NOTED
            yield Finding("source", name, "", None, "model", verdict=verdict,
                          cause=f"not run: {why}")  # fmt: skip
    for study in checked.studies:
        for (case, model), why in study.failures.items():
            if (case, model) in study.refused:
                yield Finding("source", label(model), case.name, None, "model", verdict=NOTED,
                              cause=f"not run: {why}")  # fmt: skip
            else:
                yield Finding("failure", label(model), case.name, None, "answer", cause=why)
    for model, batch in checked.batches.items():
        if isinstance(batch, Failure):
            yield Finding("failure", label(model), GATE, None, "answer", cause=batch.reason)


def slower(found: Sequence[Timing]) -> Iterator[Finding]:
    """Yield models whose seconds changed by more than their noise, those that are faster as notes;
    and one row for each of the others."""
    for one in found:
        if not (one.slower.happened or one.faster.happened):
            yield Finding("timing", one.model, "", None, "seconds", verdict=HELD)
        for change, verdict, factor in (
            (one.slower, FAILED, one.slower.factor),
            (one.faster, NOTED, 1 / one.faster.factor),
        ):
            if change.happened:
                quantity = f"seconds of the last {change.window} runs against those before"
                yield Finding("timing", one.model, "", None, quantity, 1.0, factor, change.noise,
                              verdict, f"since {one.since:%Y-%m-%d %H:%M}")  # fmt: skip
