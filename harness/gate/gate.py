"""The gate: what moved since the baseline, by name, what does not hold, and what may be accepted.

A tolerance is `FACTOR` times the model's own numerical noise (`harness.gate.equivalents`).
Accepting takes new values but never a wider tolerance, unless a reason is given and kept.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from datetime import UTC, datetime
from itertools import product
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from analytic import InputError, Modes
from analytic.pairing import TRUSTED, pair
from harness.bench import SPARE, Bench, label
from harness.gate.equivalents import EQUIVALENTS, noise, relative
from harness.gate.figures import (
    BETTER,
    FACTOR,
    FAILED,
    HELD,
    NOTED,
    Count,
    Figures,
    Finding,
    Key,
    Limit,
    Order,
    Place,
    Reason,
    Shaped,
    Source,
    condense,
)  # fmt: skip
from harness.gate.plan import MODES, NOT_ASKED, Checked, Plan, group, solve
from harness.gate.properties import properties
from harness.gate.report import Report
from harness.gate.timing_watch import slower, timings
from harness.history.provenance import provenance
from harness.rows import GATE, mechanism_hash
from harness.signatures import Array
from harness.studies.refinement import MESHES, verify
from harness.workers import Failure
from reference_models import Named, parse

ANCHOR = Named("timoshenko", 4)
"""The model whose modes say what a mode looks like: solved anew in every check."""
APART = 1.001
"""Neighbours this far apart, as a ratio, can be counted between."""
SHAPE = 1e-3
"""Change of an assurance that is a change of shape: one of 3 % in the shape itself."""
FLOOR = 1e-12
"""Least noise, relative: a few thousand roundings."""
NEAR = 0.5
"""Noise above this part of a tolerance is a reason to widen it; less is chance among samples."""
NEVER = ("property", "failure")
"""Kinds of findings that cannot be accepted, for whatever reason."""


class NotAcceptedError(RuntimeError):
    """Why nothing was accepted."""


def run(
    plan: Plan, known: Figures | None, bench: Bench, history: Path | None, command: str
) -> Report:
    """Solve a plan and look; this run is in the `history` that its seconds are compared with."""
    began, now = perf_counter(), datetime.now(UTC).isoformat(timespec="seconds")
    about: dict[str, Any] = {"command": command, "time": now, **provenance()}
    checked = solve(plan, bench)
    if history is not None:
        from harness.history.store import append

        append(history, checked.rows, command)
    report = look(checked, known, about, history)
    return replace(report, about={**about, "seconds": round(perf_counter() - began, 1)})


def look(
    checked: Checked,
    known: Figures | None,
    about: Mapping[str, Any] | None = None,
    history: Path | None = None,
) -> Report:
    """Return what moved since the accepted figures `known`, and what does not hold.

    `about`: provenance; `history`: with what was solved now, to compare its seconds with.
    """
    now, about = measure(checked), about or {}
    timed, notes = [], [] if known else ["compared with no baseline"]
    if history:
        from harness.history.store import open_history

        past, accepted = open_history(history), known.timed_since if known else {}
        since = {model: datetime.fromisoformat(text) for model, text in accepted.items()}
        solved = {row["model"] for row in checked.rows}
        # What was not solved now has not changed now.
        timed = [one for one in timings(past, about["machine"], since) if one.model in solved]
        notes += [f"history: skipped {path}: {why}" for path, why in past.skipped]
    seen = [*failures(checked), *properties(checked), *slower(timed)]
    seen += compare(known, now, checked) if known else []
    notes = [*checked.plan.notes, *notes]
    return Report(checked, tuple(seen), tuple(timed), now, known, about, tuple(notes))


def measure(checked: Checked) -> Figures:
    """Return what a check compares, out of all that was solved."""
    result = Figures()
    for study in checked.studies:
        for case, model in product(study.cases, study.models):
            modes, of = study.get(case, model), (case.mechanism, case.pose)
            anchor = modes and checked.bench.solve(ANCHOR, *of, MODES + SPARE)
            if modes is None or not isinstance(anchor, Modes):
                continue
            place = case.name, label(model)
            result.mechanisms[group(case.name)] = mechanism_hash(case.mechanism)
            result.sources[label(model)] = Source(modes.theory, modes.version)
            result.counts[place] = counted(modes.frequencies, MODES)
            seen = pair(modes.first(MODES), anchor, *of)
            result.answers[place] = modes, seen, pair(anchor.first(MODES), modes, *of)
            for i, (partner, like) in enumerate(zip(seen.partner, seen.assurance, strict=True)):
                f = float(modes.frequencies[i])
                result.modes[*place, i + 1] = Shaped(f, int(partner) + 1, float(like))
                if modes.uncertainty is not None:
                    result.uncertainties[*place, i + 1] = float(modes.uncertainty[i])
    for ladder in checked.plan.ladders:
        last, formal = ladder[-MESHES:], ladder[0].info().order
        elements = tuple(n for model in last if isinstance(n := model.elements, int))
        for case in checked.cases.complete(*last) if len(last) == MESHES else ():
            for i in range(1, MODES + 1):
                values = result.followed(case.name, [label(model) for model in last], i)
                p = verify(elements, values.tolist(), formal).order
                if np.isfinite(p):
                    result.orders[case.name, ladder[0].name, i] = Order(p, formal, elements)
    return result


def counted(f: Array, count: int) -> Count:
    """Return a cut where there is most room: above the last of `count` modes, or one further.

    Where neither has room (`APART`), the widest gap from the fourth mode on.
    """
    gaps = np.divide(f[1:], f[:-1], out=np.ones(len(f) - 1), where=f[:-1] > 0)
    first = count - 1 if gaps[count - 1 :].max(initial=0.0) >= APART else 2
    number = first + 1 + int(gaps[first:].argmax())
    return Count(float(np.sqrt(f[number - 1] * f[number])), number)


def compare(before: Figures, now: Figures, checked: Checked) -> Iterator[Finding]:
    """Yield every figure of `now` that was accepted `before`, and what is new, gone or another."""
    yield from _sources(before, now)
    yield from _missing(before, now, checked)
    spoiled: set[Place] = set()
    for place in (one for one in now.counts if one in before.counts):
        found = _count(before, now, place)
        yield from found
        # Where a mode is missing the numbers above it mean something else.
        spoiled |= {place} if found[0].fails else set()
    for (case, model, mode), one in _figures(before, now):
        of = before.orders[case, model, mode].labels(model) if one.kind == "order" else [model]
        if any((case, m, mode) not in now.modes or (case, m) in spoiled for m in of):
            continue
        old, new = (figures.sources.get(of[-1]) for figures in (before, now))
        causes = [one.cause] if one.cause else []
        if old and new and old.version != new.version:
            causes.append(f"{old.version} -> {new.version}")
        yield replace(one, verdict=_verdict(one, before), cause="; ".join(causes))


def _figures(before: Figures, now: Figures) -> Iterator[tuple[Key, Finding]]:
    """Yield what is compared, with its values before and now and its tolerance; not yet judged."""
    for key, new in now.modes.items():
        if was := before.modes.get(key):
            case, model, mode = key
            yield key, Finding("frequency", model, case, mode, "f [Hz]", was.frequency,
                               new.frequency, before.tolerance(key))  # fmt: skip
            like = float(now.answers[case, model][1].matrix[mode - 1, was.partner - 1])
            looks = f"looks like mode {new.partner} (assurance {new.assurance:.3f})"
            yield key, Finding("shape", model, case, mode,
                               f"likeness with mode {was.partner} of the anchor", was.assurance,
                               like, SHAPE, cause=looks)  # fmt: skip
    for key, stated in before.uncertainties.items():
        yield key, Finding("uncertainty", key[1], key[0], key[2], "stated uncertainty [Hz]", stated,
                           now.uncertainties.get(key), before.band_tolerance(key))  # fmt: skip
    for key, order in before.orders.items():
        p = now.orders[key].p if key in now.orders else None
        yield key, Finding("order", key[1], key[0], key[2],
                           f"order on {', '.join(map(str, order.elements))}", order.p, p,
                           before.order_tolerance(key))  # fmt: skip


def _verdict(one: Finding, before: Figures) -> str:
    """Return the verdict on a figure: it held, came closer to what is right, or neither."""
    if one.moved is None or one.tolerance is None:
        return FAILED
    if (-one.moved if one.kind == "shape" else abs(one.moved)) <= one.tolerance:
        return HELD
    key, right = (one.case, one.model, one.mode or 0), np.nan
    if one.kind == "order":
        right = before.orders[key].formal
    elif one.kind == "frequency" and (limit := parse(one.model, "model").limit()):
        exact = (before.modes.get((one.case, label(limit), i)) for i in range(1, MODES + 1))
        partner = before.modes[key].partner
        right = next((m.frequency for m in exact if m and m.partner == partner), right)
    assert isinstance(one.before, float) and isinstance(one.after, float), "it moved"
    return BETTER if abs(one.after - right) < abs(one.before - right) else FAILED


def _count(before: Figures, now: Figures, place: Place) -> list[Finding]:
    """Return the count below the accepted cut: a row for each mode that is missing, or one."""
    old, (modes, _, back) = before.counts[place], now.answers[place]
    number, missing = int((modes.frequencies < old.cut).sum()), list[int | None]()
    verdict, cause = (HELD if number == old.number else FAILED), ""
    if number > old.number:
        cause = "more modes than before"
    elif number < old.number:
        cause = "mode lost"
        known = {i: before.modes.get((*place, i)) for i in range(1, MODES + 1)}
        lost = {i + 1 for i in np.flatnonzero(back.doubtful)}
        missing += [
            i for i, m in known.items() if m and m.assurance >= TRUSTED and m.partner in lost
        ]
    return [
        Finding("mode count", place[1], place[0], mode, f"modes below {old.cut:.6g} Hz",
                float(old.number), float(number), 0.0, verdict, cause)
        for mode in missing or [None]
    ]  # fmt: skip


def _missing(before: Figures, now: Figures, checked: Checked) -> Iterator[Finding]:
    """Yield every accepted model and pose without figures, unless less was asked for.

    What a program is missing for is noted; a model that is not usable any more fails.
    """
    failed = {(case.name, label(m)) for study in checked.studies for case, m in study.failures}
    skipped = checked.plan.skipped
    for case, model in dict.fromkeys(key[:2] for key in before.modes):
        if (case, model) in now.counts or (case, model) in failed:
            continue
        why, verdict = "no model has this name", FAILED
        with suppress(InputError):
            name = parse(model, "baseline").name
            why = skipped.get(name, "not in the study any more")
            if name in skipped and Named(name, None).info().program:
                verdict = NOTED
        if why != NOT_ASKED:
            yield Finding("missing", model, case, None, "accepted figures", "accepted",
                          "not measured", verdict=verdict, cause=why)  # fmt: skip


def _sources(before: Figures, now: Figures) -> Iterator[Finding]:
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


def accepted(report: Report, reason: str) -> Figures:
    """Return the accepted figures that take what was found.

    Raises `NotAcceptedError` where a property or a model fails, and `InputError` where something
    lowers the bar and no reason is given.
    """
    about = report.about
    never = [one.kind for one in report.failed if one.kind in NEVER]
    if never:
        kinds = " and ".join(sorted({*never}))
        raise NotAcceptedError(f"nothing accepted: {len(never)} x {kinds}, which cannot be")
    lower = [one for one in report.failed if one.verdict == FAILED]
    if lower and not reason:
        raise InputError("reason", None, f"why {len(lower)} findings that lower the bar are right")
    noise_now = measure_noise(report.solved)
    result = accept(report.baseline, report.now, noise_now, about, reason, lower)
    moved = {one.model for one in report.findings if one.kind == "timing"}
    since = {one.model: one.since.isoformat() for one in report.timings if one.model in moved}
    return replace(result, timed_since=result.timed_since | since)


def measure_noise(checked: Checked) -> dict[Key, float]:
    """Return the noise by (case, model, mode), relative: of the map, the largest of all poses.

    A mode's own largest deviation among `EQUIVALENTS`, or the model's root mean square at that
    case, if that is more: four evaluations may agree by chance.
    """
    found: dict[Key, float] = {}
    for study, equivalents in (
        (checked.cases, EQUIVALENTS),
        (checked.workspace, EQUIVALENTS[1::2]),  # every pose is another sample already
    ):
        listener = checked.bench.listener
        listener.expect(len(study.answers))
        for (case, model), modes in study.answers.items():
            own = noise(checked.bench, model, case, modes.frequencies[: study.count], equivalents)
            for i, value in enumerate(np.maximum(own, np.sqrt((own**2).mean())).tolist()):
                key = (group(case.name), label(model), i + 1)
                found[key] = max(found.get(key, 0.0), value)
            listener.done(f"noise of {label(model)}")
    return found


def accept(
    before: Figures | None,
    now: Figures,
    noise: Mapping[Key, float],
    about: Mapping[str, str],
    reason: str,
    lower: Sequence[Finding] = (),
) -> Figures:
    """Return the figures that take `now`: tolerances the smaller of old and newly measured.

    With a `reason` they widen where noise has come near them (`NEAR`); every one that does is
    recorded with `about` (time and commit), after the findings that `lower` the bar otherwise.
    Models not measured stay as they are, but for those that are missing among the latter.
    """
    before = before or Figures()
    gone = {one.model for one in lower if one.kind == "missing"} - now.sources.keys()
    modes, drift = dict(now.modes), dict[Key, float]()
    for key, new in now.modes.items():
        was, place = before.modes.get(key), (group(key[0]), *key[1:])
        if was is None or new.partner != was.partner or abs(new.assurance - was.assurance) >= SHAPE:
            continue
        # What did not move keeps its value: many small steps must not add up unseen.
        if (off := float(relative(new.frequency, was.frequency))) <= before.tolerance(key):
            modes[key], drift[place] = was, max(drift.get(place, 0.0), off)
    limits, wider = dict(before.limits), list[Finding]()
    for key, own in noise.items():
        # A value that is kept must still be met by what was measured.
        value = FACTOR * max(own, drift.get(key, 0.0), FLOOR)
        old = limits[key].tolerance if key in limits else np.inf
        widens = bool(reason) and value > old and own > NEAR * old
        limits[key] = Limit(own, value if widens else min(old, value))
        if widens:
            case, model, mode = key
            wider.append(Finding("tolerance", model, case, mode, "tolerance", old, value))
    reasons = [
        Reason(about["time"], about["commit"], one.quantity, one.model, place, one.mode or 0,
               str(one.before), str(one.after), reason)
        for one, place, _ in (*condense(lower), *condense(wider))
    ]  # fmt: skip
    return replace(
        before.updated(replace(now, modes=modes), gone),
        limits={key: one for key, one in limits.items() if key[1] not in gone},
        reasons=(*before.reasons, *reasons),
    )
