"""Many poses on many cores: frequencies a second, memory, and what larger maps would take."""

import os
import resource
import sys
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from analytic import Mechanism, Pose
from analytic.model import Model
from harness.bench import label
from harness.cases import Case
from harness.tables import Cell, Number, Table
from harness.timing import poses_around
from harness.workers import LIMIT, Child

MAP, MANY_CORES = 1e9, 64
"""Poses of a large map, and cores of a machine that it is for."""
WARM = 100


@dataclass(frozen=True)
class Share:
    """A share of the poses, as a process solves it: seconds, and its largest memory [MB]."""

    model: Model
    mechanism: Mechanism
    poses: Pose
    count: int

    def solve(self) -> tuple[float, float]:
        """Return seconds and memory; the first poses are solved twice, to load what is needed."""
        self.model.frequencies(self.mechanism, self.poses[:WARM], self.count)
        began = time.perf_counter()
        self.model.frequencies(self.mechanism, self.poses, self.count)
        seconds = time.perf_counter() - began
        unit = 1 if sys.platform == "darwin" else 1024
        return seconds, unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6


@dataclass(frozen=True)
class Throughput:
    """What so many `cores` made of `poses` by a `model`.

    Attributes: `seconds`, the longest that a process took; `megabytes`, the largest of one.
    """

    model: Model
    cores: int
    poses: int
    seconds: float
    megabytes: float
    count: int

    @property
    def rate(self) -> float:
        """Frequencies a second."""
        return self.count * self.poses / self.seconds


def throughput(
    case: Case, models: Sequence[Model], poses: int, count: int, limit: float = LIMIT
) -> list[Throughput]:
    """Return what 1, 2, 4 ... and all cores make of as many `poses` a core."""
    here = os.cpu_count() or 1
    steps = sorted({*(2**k for k in range(here.bit_length()) if 2**k < here), here})
    found = []
    for model in models:
        for cores in steps:
            every = poses_around(case, poses * cores)
            edges = [poses * k for k in range(cores + 1)]
            shares = [Share(model, case.mechanism, every[a:b], count) for a, b in pairwise(edges)]
            answers = _at_once(shares, limit)
            seconds, memory = np.max(answers, axis=0)
            found.append(Throughput(model, cores, poses * cores, seconds, memory, count))
    return found


def _at_once(shares: Sequence[Share], limit: float) -> list[tuple[float, float]]:
    """Return the answers of all shares, each in a process of its own."""
    answers: list[tuple[float, float]] = [(float("nan"), float("nan"))] * len(shares)
    children = [Child() for _ in shares]

    def solve(k: int) -> None:
        found = children[k].solve(shares[k], limit)
        if isinstance(found, tuple):
            answers[k] = found

    threads = [threading.Thread(target=solve, args=(k,)) for k in range(len(shares))]
    try:
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    finally:
        for child in children:
            child.close()
    return answers


def cores_table(found: Sequence[Throughput]) -> Table:
    """Return frequencies a second against the count of cores, and what a large map would take."""
    rows: list[tuple[Cell, ...]] = []
    for one in found:
        single = next(t for t in found if t.model == one.model and t.cores == 1)
        seconds = MAP / (one.poses / one.seconds)
        rows.append((
            label(one.model), one.cores, one.poses, Number(one.seconds, 2), round(one.rate),
            Number(one.rate / single.rate, 2), round(one.megabytes), Number(seconds / 3600, 2),
            Number(seconds * one.cores / MANY_CORES / 3600, 2),
        ))  # fmt: skip
    columns = ("Model", "cores", "poses", "seconds", "frequencies a second", "one core = 1",
               "MB a process", "1e9 poses here [h]", f"on {MANY_CORES} such cores [h]")  # fmt: skip
    notes = (
        "a process a core, one BLAS thread each; no process keeps more than its own frequencies",
        f"1e9 poses: 8 bytes a frequency are {8 * found[0].count * MAP / 1e9:.0f} GB, written by "
        "parts in a sweep" if found else "not measured",
    )  # fmt: skip
    return Table("Many poses on many cores", columns, tuple(rows), notes)
