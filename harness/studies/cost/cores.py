"""Many poses on many cores: frequencies a second, memory, and what larger maps would take."""

import os
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import dataclass
from itertools import pairwise, product
from pathlib import Path

import numpy as np

from analytic import Mechanism, Pose
from analytic.model import Model
from harness.bench import label
from harness.case import Case
from harness.tables import Cell, Number, Table
from harness.timing import poses_around
from harness.workers import LIMIT, Children, Failure

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
        return time.perf_counter() - began, _megabytes()


def _megabytes() -> float:
    """Return the most memory that this process had [MB]; NaN where the system does not say.

    Not `ru_maxrss`: a new program inherits that of the process that started it.
    """
    try:
        status = Path("/proc/self/status").read_text()
    except OSError:
        return float("nan")
    return 1024 * int(status.split("VmHWM:")[1].split()[0]) / 1e6


@dataclass(frozen=True)
class Throughput:
    """What so many `cores` made of `poses` by a `model`.

    Attributes: `seconds`, the longest that a process took; `megabytes`, the largest of one; `load`,
    processes that wanted a core at the time, those of others included.
    """

    model: Model
    cores: int
    poses: int
    seconds: float
    megabytes: float
    count: int
    load: float

    @property
    def rate(self) -> float:
        """Frequencies a second."""
        return self.count * self.poses / self.seconds


def throughput(
    case: Case, models: Sequence[Model], poses: int, count: int, limit: float = LIMIT
) -> tuple[list[Throughput], dict[str, str]]:
    """Return what 1, 2, 4 ... and all cores make of as many `poses` a core, and what failed."""
    here = os.cpu_count() or 1
    steps = sorted({*(2**k for k in range(here.bit_length()) if 2**k < here), here})
    found: list[Throughput] = []
    failures: dict[str, str] = {}
    with closing(Children()) as children:
        children.start(here)
        for model, cores in product(models, steps):
            every = poses_around(case, poses * cores)
            edges = [poses * k for k in range(cores + 1)]
            shares = [Share(model, case.mechanism, every[a:b], count) for a, b in pairwise(edges)]
            with ThreadPoolExecutor(cores) as threads:
                answers = list(threads.map(lambda share: children.attempt(share, limit), shares))
            bad = next((a for a in answers if isinstance(a, Failure)), None)
            if bad is not None:
                failures[f"{label(model)} on {cores} cores"] = bad.reason
                continue
            seconds, memory = np.max(np.array(answers), axis=0).tolist()
            load = os.getloadavg()[0] if hasattr(os, "getloadavg") else float("nan")
            found.append(Throughput(model, cores, poses * cores, seconds, memory, count, load))
    return found, failures


def cores_table(found: Sequence[Throughput]) -> Table:
    """Return frequencies a second against the count of cores, and what a large map would take."""
    rows: list[tuple[Cell, ...]] = []
    for one in found:
        single = next(t for t in found if t.model == one.model)
        seconds = MAP / (one.poses / one.seconds)
        rows.append((
            label(one.model), one.cores, Number(one.load, 1), one.poses, Number(one.seconds, 2),
            round(one.rate), Number(one.rate / single.rate, 2), Number(one.megabytes, 0),
            Number(seconds / 3600, 2),
            Number(seconds * one.cores / MANY_CORES / 3600, 2),
        ))  # fmt: skip
    columns = ("Model", "cores", "load", "poses", "seconds", "frequencies a second", "one core = 1",
               "MB a process", "1e9 poses here [h]", f"on {MANY_CORES} such cores [h]")  # fmt: skip
    notes = (
        "a process a core, one BLAS thread each; no process keeps more than its own frequencies",
        "load: processes that wanted a core, those of others included",
        f"1e9 poses: 8 bytes a frequency are {8 * found[0].count * MAP / 1e9:.0f} GB, written by "
        "parts in a sweep" if found else "not measured",
    )  # fmt: skip
    return Table("Many poses on many cores", columns, tuple(rows), notes)
