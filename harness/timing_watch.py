"""Has a model become slower? A change point in the history, amid the machine's noise.

The quantity is ln(seconds / yardstick's seconds), the yardstick timed in the same run: how fast the
machine was that day drops out. A moving sum of Huber's clipped scores (Eichinger and Kirch,
Bernoulli 24, 2018) asks of the last 5 and the last 20 runs whether their mean exceeds what came
before. A score is clipped at 2.5 standard deviations: no single run, however slow, can fire.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from harness.check_study import YARDSTICK
from harness.store import History

WINDOWS = {5: 1.9, 20: 1.2}
"""Runs looked at together, and the mean score above which they are a change. In normal noise that
is 4.2 and 5.4 standard deviations of such a mean; docs/gate.md has the simulated alarm rates."""
LEAST = 15
"""Runs before a window that it takes to know the noise."""
MOST = 100
"""Runs before a window that are looked at: a machine ages."""
CLIP = 2.5
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


def change(series: Sequence[float]) -> Change | None:
    """Return how much the end of `series` (ln seconds, oldest first) lies above what came before.

    Of the windows the one closest to firing; None where the series is too short. Runs that raised
    an alarm never become the reference: it goes on until they are fast again.
    """
    values = np.asarray(series, dtype=float)
    found = [_moving(values, length, limit) for length, limit in WINDOWS.items()]
    return max((c for c in found if c is not None), key=lambda c: c.score, default=None)


def _moving(values: NDArray[np.float64], length: int, limit: float) -> Change | None:
    reference: list[float] = []
    last: Change | None = None
    for end in range(length, len(values) + 1):
        if last is None or not last.happened:
            # What just left the window was no alarm.
            reference += values[end - length - 1 : end - length].tolist()
        if len(reference) < LEAST:
            continue
        known = np.array(reference[-MOST:])
        middle, noise = float(np.median(known)), _noise(known)
        window = values[end - length : end]
        score = np.clip((window - middle) / noise, -CLIP, CLIP).mean() / limit
        factor = float(np.exp(np.median(window) - middle))
        last = Change(factor, float(score), noise, length, len(values))
    return last


def _noise(values: NDArray[np.float64]) -> float:
    """Return the standard deviation by mean deviation, outliers cut off, widened for few values."""
    away = np.abs(values - np.median(values))
    cut = np.minimum(away, 3 * 1.4826 * np.median(away))
    return max(QUIET, float(np.sqrt(np.pi / 2) * cut.mean() * (1 + 1 / len(values))))


def timings(
    history: History, machine: str, since: Mapping[str, datetime] | None = None
) -> list[Timing]:
    """Return every model's timing on `machine`; those with too few runs are left out.

    `since`: for some models the first run that counts, after a change that was accepted.
    """
    table = history.query(_SERIES, [machine])
    found = []
    for (model,), runs in table.group_by("model", maintain_order=True):
        name = str(model)
        times: list[datetime] = runs["time"].to_list()
        first = (since or {}).get(name, datetime.min)
        kept = [(t, x) for t, x in zip(times, runs["slowness"], strict=True) if t >= first]
        values = [x for _, x in kept]
        slower, faster = change(values), change([-x for x in values])
        if slower is None or faster is None:
            continue
        began = kept[-(slower if slower.score >= faster.score else faster).window][0]
        found.append(Timing(name, slower, faster, began))
    return found
