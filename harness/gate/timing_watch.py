"""Has a model become slower? A change point in the history, amid the machine's noise.

The quantity is ln(seconds / yardstick's seconds), the yardstick timed in the same run: how fast the
machine was that day drops out. A moving sum of Huber's clipped scores (Eichinger and Kirch,
Bernoulli 24, 2018) asks of the last 5 and the last 20 runs whether their mean exceeds what came
before. A score is clipped at 2.5 standard deviations: no single run, however slow, can fire.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from itertools import groupby
from statistics import median
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from harness.gate.yardstick import YARDSTICK

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
    values = np.asarray(series, dtype=float)
    courses = [_moving(values, length, limit) for length, limit in WINDOWS.items()]
    return [
        max((one for one in found if one is not None), key=lambda one: one.score, default=None)
        for found in zip(*courses, strict=True)
    ]


def _moving(values: NDArray[np.float64], length: int, limit: float) -> list[Change | None]:
    reference: list[float] = []
    found: list[Change | None] = []
    alarm = False
    for i in range(len(values)):
        if i >= length and not alarm:
            reference.append(float(values[i - length]))  # it left the window, and was no alarm
        if len(reference) < LEAST:
            found.append(None)
            continue
        middle, noise = _spread(np.array(reference[-MOST:]))
        window = values[i - length + 1 : i + 1]
        scores = np.minimum(np.maximum((window - middle) / noise, -CLIP), CLIP)
        # Over for some runs, it is over, whatever a long window still remembers.
        over = scores[-SHORT:].mean() < WINDOWS[SHORT] / 3
        score = 0.0 if over else float(scores.mean()) / limit
        factor = float(np.exp(median(window.tolist()) - middle))
        found.append(Change(factor, score, noise, length, i + 1))
        alarm = score >= 1
    return found


def _spread(values: NDArray[np.float64]) -> tuple[float, float]:
    """Return the median and the standard deviation of one more value.

    By the mean deviation, outliers cut off, widened for few values.
    """
    middle = median(values.tolist())
    away = np.abs(values - middle)
    cut = np.minimum(away, 3 * 1.4826 * median(away.tolist()))
    noise = float(np.sqrt(np.pi / 2) * cut.mean() * (1 + 1 / len(values)))
    return middle, max(QUIET, noise)


def timings(
    history: "History", machine: str, since: Mapping[str, datetime] | None = None
) -> list[Timing]:
    """Return every model's timing on `machine`; those with too few runs are left out.

    `since`: for some models the first run that counts, after a change that was accepted.
    """
    rows = history.query(_SERIES, [machine]).rows()
    found = []
    for name, runs in groupby(rows, key=lambda row: str(row["model"])):
        first = (since or {}).get(name, datetime.min)
        kept = [(row["time"], row["slowness"]) for row in runs if row["time"] >= first]
        values = [x for _, x in kept[-LONGEST:]]
        slower, faster = ([None, *changes(x)][-1] for x in (values, [-x for x in values]))
        if slower is None or faster is None:
            continue
        began = kept[-(slower if slower.score >= faster.score else faster).window][0]
        found.append(Timing(name, slower, faster, began))
    return found
