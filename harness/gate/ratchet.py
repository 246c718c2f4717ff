"""The accepted figures in results/baseline/: text files, tolerances that only tighten.

A tolerance is `FACTOR` times the model's own numerical noise (`harness.gate.equivalents`).
Accepting takes new values but never a wider tolerance, unless a reason is given and kept.
"""

import csv
import io
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from analytic import InputError
from harness.files import write_all
from harness.gate.equivalents import EQUIVALENTS, noise
from harness.gate.measured import Key, Measured, Shaped
from harness.gate.study import Checked
from harness.run import GATE, SPARE

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


@dataclass(frozen=True)
class Reason:
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


@dataclass(frozen=True)
class Baseline:
    """What was accepted: `figures`; by (case, model, mode), all map poses as one case, the
    measured `noise` and `tolerance`, relative; `timed_since`, by model, the first run whose seconds
    count; `reasons`.
    """

    figures: Measured
    noise: dict[Key, float]
    tolerance: dict[Key, float]
    timed_since: dict[str, str] = field(default_factory=dict)
    reasons: tuple[Reason, ...] = ()

    def allowed(self, key: Key) -> float:
        """Return the tolerance of a frequency, relative."""
        case, model, mode = key
        return self.tolerance[group(case), model, mode]

    def order_tolerance(self, key: Key) -> float:
        """Return the tolerance of an observed order: that of the frequencies, carried through.

        p = ln((f_2 - f_1) / (f_3 - f_2)) / ln r, so |dp| <= (2 d / |f_2 - f_1| + 2 d /
        |f_3 - f_2|) / ln r with d the largest error of a frequency.
        """
        case, _, mode = key
        order = self.figures.orders[key]
        values = np.array(order.frequencies)
        d = max(self.allowed((case, label, mode)) for label in order.labels) * values[-1]
        ratio = order.elements[-1] / order.elements[-2]
        return max(ORDER, float((2 * d / np.abs(np.diff(values))).sum() / np.log(ratio)))


def measure_noise(
    checked: Checked, done: Callable[[str], None] = lambda _: None
) -> dict[Key, float]:
    """Return the noise by (case, model, mode), relative: of the map, the largest of all poses.

    A mode's own largest deviation among `EQUIVALENTS`, or the model's root mean square at that
    case, if that is more: four evaluations may agree by chance.
    """
    found: dict[Key, float] = {}
    for study, equivalents in (
        (checked.cases, EQUIVALENTS),
        (checked.workspace, EQUIVALENTS[1::2]),  # every pose is another sample already
    ):
        for spec in study.specs:
            model = spec.build()
            for case in study.cases:
                modes = study.get(case, spec)
                if modes is not None:
                    frequencies = modes.frequencies[: study.count]
                    pose = case.mechanism, case.pose
                    own = noise(model, *pose, frequencies, SPARE, equivalents)
                    own = np.maximum(own, np.sqrt((own**2).mean()))
                    for i, value in enumerate(own.tolist()):
                        key = (group(case.name), spec.label, i + 1)
                        found[key] = max(found.get(key, 0.0), value)
                done(f"noise of {spec.label}")
    return found


def tolerances(noise: Mapping[Key, float]) -> dict[Key, float]:
    """Return what `noise` allows."""
    return {key: FACTOR * max(value, FLOOR) for key, value in noise.items()}


def accept(
    before: Baseline | None,
    now: Measured,
    noise: Mapping[Key, float],
    about: Mapping[str, str],
    reason: str,
    reasons: Sequence[Reason] = (),
) -> Baseline:
    """Return the baseline that takes `now`: tolerances the smaller of old and newly measured.

    With a `reason` they widen where noise has come near them (`NEAR`); every one that does is
    recorded with `about` (time and commit), after `reasons`, those of whatever else was accepted.
    Models not measured stay as they are.
    """
    fresh = tolerances(noise)
    if before is None:
        return Baseline(now, dict(noise), fresh, {}, tuple(reasons))
    kept, wider = dict(before.tolerance), []
    for key, value in fresh.items():
        old = kept.get(key, value)
        widen = bool(reason) and value > old and noise[key] > NEAR * old
        if widen:
            case, model, mode = key
            wider.append(Reason(about["time"], about["commit"], "tolerance", model, case, mode,
                                repr(old), repr(value), reason))  # fmt: skip
        kept[key] = value if widen else min(old, value)
    # What did not move keeps its value: many small steps must not add up unseen.
    still = {
        key: was
        for key, new in now.modes.items()
        if (was := before.figures.modes.get(key)) and _same(was, new, before.allowed(key))
    }
    return Baseline(
        before.figures.updated(replace(now, modes=now.modes | still)),
        before.noise | dict(noise),
        kept,
        before.timed_since,
        (*before.reasons, *reasons, *wider),
    )


def _same(old: Shaped, new: Shaped, allowed: float) -> bool:
    alike = new.partner == old.partner and abs(new.assurance - old.assurance) < SHAPE
    return alike and abs(new.frequency / old.frequency - 1) <= allowed


def save(folder: Path, baseline: Baseline) -> list[Path]:
    """Write the baseline into `folder`, all files or none."""
    texts = baseline.figures.tables()
    texts["tolerances.csv"] = [
        {"case": c, "model": m, "mode": i, "noise": f"{baseline.noise[c, m, i]:.3g}",
         "tolerance": f"{value:.3g}"}
        for (c, m, i), value in sorted(baseline.tolerance.items())
    ]  # fmt: skip
    texts["timings.csv"] = [
        {"model": model, "since": since} for model, since in sorted(baseline.timed_since.items())
    ]
    texts["reasons.csv"] = [vars(reason) for reason in baseline.reasons]
    headers = HEADERS | Measured.HEADERS
    files = {name: _csv(headers[name], rows) for name, rows in texts.items()}
    return write_all(folder, files, "--baseline")


HEADERS = {
    "tolerances.csv": ("case", "model", "mode", "noise", "tolerance"),
    "timings.csv": ("model", "since"),
    "reasons.csv": tuple(f.name for f in fields(Reason)),
}


def load(folder: Path) -> Baseline | None:
    """Return the baseline in `folder`; None where there is none.

    Raises `InputError` for files that are not a whole baseline.
    """
    if not folder.exists():
        return None
    texts: dict[str, list[dict[str, str]]] = {}
    expected = "a folder written by rps-bench check --accept"
    for name, header in (HEADERS | Measured.HEADERS).items():
        try:
            lines = (folder / name).read_text().splitlines()
        except OSError as error:
            raise InputError(
                "--baseline", str(folder), f"{expected} ({name}: {error.strerror})"
            ) from None
        reader = csv.DictReader(lines)
        if tuple(reader.fieldnames or ()) != header:
            raise InputError("--baseline", str(folder), f"{expected} ({name}: other columns)")
        texts[name] = list(reader)
    try:
        keyed = {
            (row["case"], row["model"], int(row["mode"])): row for row in texts["tolerances.csv"]
        }
        return Baseline(
            Measured.read(texts),
            {key: float(row["noise"]) for key, row in keyed.items()},
            {key: float(row["tolerance"]) for key, row in keyed.items()},
            {row["model"]: row["since"] for row in texts["timings.csv"]},
            tuple(_reason(row) for row in texts["reasons.csv"]),
        )
    except (ValueError, KeyError, TypeError) as error:
        raise InputError("--baseline", str(folder), f"{expected} ({error})") from None


def _reason(row: Mapping[str, str]) -> Reason:
    texts = {name: row[name] for name in HEADERS["reasons.csv"] if name != "mode"}
    return Reason(mode=int(row["mode"]), **texts)


def _csv(header: Sequence[str], rows: Sequence[Mapping[str, Any]]) -> bytes:
    text = io.StringIO()
    writer = csv.DictWriter(text, header, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue().encode()


def group(case: str) -> str:
    """Return a finding's case; of all poses of the map, the map."""
    return GATE if case.startswith(GATE) else case
