"""The accepted figures: values, and tolerances that only tighten.

A tolerance is `FACTOR` times the model's own numerical noise (`harness.gate.equivalents`).
Accepting takes new values but never a wider tolerance, unless a reason is given and kept.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from harness.bench import Bench, label
from harness.gate.equivalents import EQUIVALENTS, noise, relative
from harness.gate.measured import Key, Measured
from harness.gate.plan import Checked, group

FACTOR = 10
"""Noise is the largest of four deviations; ten times it leaves room for other processors."""
FLOOR = 1e-12
"""Least noise, relative: a few thousand roundings."""
NEAR = 0.5
"""Noise above this part of a tolerance is a reason to widen it; less is chance among samples."""
SHAPE = 1e-3
"""Change of an assurance that is a change of shape: one of 3 % in the shape itself."""
ORDER = 0.02
"""Least tolerance of an observed order."""
BAND = 1e-3
"""Least tolerance of a stated uncertainty, relative."""


class Reason(NamedTuple):
    """Why something was accepted that lowers the bar: kept for good."""

    time: str
    commit: str
    quantity: str
    model: str
    case: str
    mode: int
    before: str
    after: str
    reason: str


class Limit(NamedTuple):
    """The measured `noise` of a frequency and the `tolerance` of its changes, relative."""

    noise: float
    tolerance: float


@dataclass(frozen=True)
class Baseline:
    """What was accepted.

    Attributes: `figures`; `limits` by (case, model, mode), all map poses as one case;
    `timed_since`, by model, the first run whose seconds count; `reasons`.
    """

    figures: Measured
    limits: dict[Key, Limit]
    timed_since: dict[str, str] = field(default_factory=dict)
    reasons: tuple[Reason, ...] = ()

    def allowed(self, key: Key) -> float:
        """Return the tolerance of a frequency, relative."""
        case, model, mode = key
        return self.limits[group(case), model, mode].tolerance

    def order_tolerance(self, key: Key) -> float:
        """Return the tolerance of an observed order: that of the frequencies, carried through.

        p = ln((f_2 - f_1) / (f_3 - f_2)) / ln r, so |dp| <= (2 d / |f_2 - f_1| + 2 d /
        |f_3 - f_2|) / ln r with d the largest error of a frequency.
        """
        case, name, mode = key
        order = self.figures.orders[key]
        labels = order.labels(name)
        values = self.figures.followed(case, labels, mode)
        d = max(self.allowed((case, one, mode)) for one in labels) * values[-1]
        ratio = order.elements[-1] / order.elements[-2]
        return max(ORDER, float((2 * d / np.abs(np.diff(values))).sum() / np.log(ratio)))

    def uncertainty_tolerance(self, key: Key) -> float:
        """Return the tolerance of a stated uncertainty, relative: it is a difference of two."""
        stated, frequency = self.figures.uncertainties[key], self.figures.modes[key].frequency
        return max(BAND, FACTOR * self.allowed(key) * frequency / max(stated, 1e-300))


def measure_noise(checked: Checked, bench: Bench) -> dict[Key, float]:
    """Return the noise by (case, model, mode), relative: of the map, the largest of all poses.

    A mode's own largest deviation among `EQUIVALENTS`, or the model's root mean square at that
    case, if that is more: four evaluations may agree by chance.
    """
    found: dict[Key, float] = {}
    for study, equivalents in (
        (checked.cases, EQUIVALENTS),
        (checked.workspace, EQUIVALENTS[1::2]),  # every pose is another sample already
    ):
        bench.listener.expect(len(study.answers))
        for (case, model), modes in study.answers.items():
            frequencies = modes.frequencies[: study.count]
            own = noise(bench, model, case.mechanism, case.pose, frequencies, equivalents)
            own = np.maximum(own, np.sqrt((own**2).mean()))
            for i, value in enumerate(own.tolist()):
                key = (group(case.name), label(model), i + 1)
                found[key] = max(found.get(key, 0.0), value)
            bench.listener.done(f"noise of {label(model)}")
    return found


def accept(
    before: Baseline | None,
    now: Measured,
    noise: Mapping[Key, float],
    about: Mapping[str, str],
    reason: str,
    reasons: Sequence[Reason] = (),
    gone: Collection[str] = (),
) -> Baseline:
    """Return the baseline that takes `now`: tolerances the smaller of old and newly measured.

    With a `reason` they widen where noise has come near them (`NEAR`); every one that does is
    recorded with `about` (time and commit), after `reasons`, those of whatever else was accepted.
    Models not measured stay as they are, but for those called one of `gone`.
    """
    if before is None:
        fresh = {key: Limit(own, FACTOR * max(own, FLOOR)) for key, own in noise.items()}
        return Baseline(now, fresh, {}, tuple(reasons))
    modes, drift = dict(now.modes), dict[Key, float]()
    for key, new in now.modes.items():
        was, off = before.figures.modes.get(key), np.inf
        if was is not None and new.partner == was.partner:
            off = float(relative(new.frequency, was.frequency))
        # What did not move keeps its value: many small steps must not add up unseen.
        if was and off <= before.allowed(key) and abs(new.assurance - was.assurance) < SHAPE:
            modes[key] = was
            place = group(key[0]), *key[1:]
            drift[place] = max(drift.get(place, 0.0), off)
    limits, wider = dict(before.limits), []
    for key, own in noise.items():
        # A value that is kept must still be met by what was measured.
        value = FACTOR * max(own, drift.get(key, 0.0), FLOOR)
        old = limits[key].tolerance if key in limits else np.inf
        widens = bool(reason) and value > old and own > NEAR * old
        limits[key] = Limit(own, value if widens else min(old, value))
        if widens:
            case, model, mode = key
            wider.append(Reason(about["time"], about["commit"], "tolerance", model, case, mode,
                                repr(old), repr(value), reason))  # fmt: skip
    return Baseline(
        before.figures.without(gone).updated(replace(now, modes=modes)),
        {key: one for key, one in limits.items() if key[1] not in gone},
        before.timed_since,
        (*before.reasons, *reasons, *wider),
    )
