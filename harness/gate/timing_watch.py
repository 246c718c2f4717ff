"""Has a model become slower? A change point in the history, amid the machine's noise.

The quantity is ln(seconds / yardstick's seconds), the yardstick timed in the same run: how fast the
machine was that day drops out. A moving sum of Huber's clipped scores (Eichinger and Kirch,
Bernoulli 24, 2018) asks of the last 5 and the last 20 runs whether their mean exceeds what came
before. A score is clipped at 2.5 standard deviations: no single run, however slow, can fire.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import groupby
from statistics import median
from typing import TYPE_CHECKING

import numpy as np

from harness.gate.figures import FAILED, HELD, NOTED, Finding
from harness.gate.plan import YARDSTICK

if TYPE_CHECKING:
    from harness.history.store import History

SHORT = 5
WINDOWS = {SHORT: 1.95, 20: 1.4}
"""Runs looked at together, and the mean score above which they are a change. In normal noise that
is 4.4 and 6.3 standard deviations of such a mean; docs/gate.md has the simulated alarm rates."""
LEAST = 15
"""Runs before a window that it takes to know the noise."""
MOST = 100
"""Runs before a window that are looked at: a machine ages."""
LONGEST = 300
"""Runs of a series that are looked at."""
CLIP = 2.5
"""Standard deviations that one run counts at most."""
QUIET = 0.03
"""Noise is taken as 3 % at least: smaller changes of seconds are of no interest."""

_SERIES = f"""
SELECT model, run, time, avg(slowness) AS slowness FROM (
    SELECT r.model, r."case", r.run, r.time,
           median(ln((r.build_s + r.solve_s) / y.solve_s)) AS slowness
    FROM rows r JOIN rows y ON y.run = r.run AND y.model = '{YARDSTICK}'
    WHERE r.mode = 1 AND r.model <> '{YARDSTICK}' AND r.machine = ?
          AND r.build_s + r.solve_s > 0 AND y.solve_s > 0
    GROUP BY ALL)
GROUP BY ALL ORDER BY model, time, run
"""


@dataclass(frozen=True)
class Change:
    """What a series says at its last run.

    Attributes: `factor`, the last runs' time against that of the runs before; `score`, their mean
    score over its threshold: a change from 1 on; `noise` of one run, relative; `window`, how many
    runs are looked at; `runs`: the length of the series.
    """

    factor: float
    score: float
    noise: float
    window: int
    runs: int

    @property
    def happened(self) -> bool:
        """Whether the last runs are slower than noise explains."""
        return self.score >= 1


@dataclass(frozen=True)
class Timing:
    """One model's seconds: `slower` and `faster` changes, and when the watched window began."""

    model: str
    slower: Change
    faster: Change
    since: datetime


def changes(series: Sequence[float]) -> list[Change | None]:
    """Return, at every run, how much the end of `series` so far lies above what came before.

    `series`: ln seconds, oldest first. Of the windows the one closest to firing; None where the
    series is too short. Runs that raised an alarm never become the reference: it goes on until
    they are fast again.
    """
    found: list[Change | None] = [None] * len(series)
    for length, limit in WINDOWS.items():
        reference, alarm = list[float](), False
        for i in range(length, len(series)):
            if not alarm:
                reference.append(series[i - length])  # it left the window, and was no alarm
            if len(reference) < LEAST:
                continue
            middle, noise = _spread(reference[-MOST:])
            window = series[i - length + 1 : i + 1]
            scores = np.clip((np.array(window) - middle) / noise, -CLIP, CLIP)
            # Over for some runs, it is over, whatever a long window still remembers.
            over = scores[-SHORT:].mean() < WINDOWS[SHORT] / 3
            score = 0.0 if over else float(scores.mean()) / limit
            factor = float(np.exp(median(window) - middle))
            other, alarm = found[i], score >= 1
            if other is None or score > other.score:
                found[i] = Change(factor, score, noise, length, i + 1)
    return found


def _spread(values: Sequence[float]) -> tuple[float, float]:
    """Return the median and the standard deviation of one more value.

    By the mean deviation, outliers cut off, widened for few values.
    """
    middle = median(values)
    away = np.abs(np.array(values) - middle)
    cut = np.minimum(away, 3 * 1.4826 * np.median(away))
    noise = float(np.sqrt(np.pi / 2) * cut.mean() * (1 + 1 / len(values)))
    return middle, max(QUIET, noise)


def timings(
    history: "History", machine: str, since: Mapping[str, datetime] | None = None
) -> list[Timing]:
    """Return every model's timing on `machine`; those with too few runs are left out.

    `since`: for some models the first run that counts, after a change that was accepted.
    """
    found = []
    rows = history.query(_SERIES, [machine]).rows()
    for name, runs in groupby(rows, key=lambda row: str(row["model"])):
        first = (since or {}).get(name, datetime.min)
        kept = [row for row in runs if row["time"] >= first]
        values = [row["slowness"] for row in kept[-LONGEST:]]
        slower, faster = ([None, *changes(x)][-1] for x in (values, [-x for x in values]))
        if slower and faster:
            began = kept[-(slower if slower.score >= faster.score else faster).window]["time"]
            found.append(Timing(name, slower, faster, began))
    return found


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
