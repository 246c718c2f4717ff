"""The simulators' own seconds beside ours: building, linearising, projection, eigen-solution."""

from collections.abc import Sequence
from functools import cache, partial
from timeit import repeat

import numpy as np
import scipy

from harness.bench import label
from harness.tables import Cell, Number, Table
from harness.timing import Timed
from reference_models.spent import PHASES, SIMULATOR

PROJECTION, NAMELESS = "projection", ""
LARGEST = 1000
"""Coordinates up to which a dense solution is timed."""


@cache
def dense_seconds(dofs: int) -> float:
    """Return the shortest of five times of `scipy.linalg.eigh` of a pair of this size [s]."""
    random = np.random.default_rng(0).standard_normal((dofs, dofs))
    M = random @ random.T / dofs + np.eye(dofs)
    K = (random + random.T) / 2 + 2 * dofs * np.eye(dofs)
    return min(repeat(partial(scipy.linalg.eigh, K, M), number=1, repeat=5))


def simulators_table(timed: Sequence[Timed]) -> Table:
    """Return where the seconds of every simulator's answer go."""
    rows: list[tuple[Cell, ...]] = []
    for t in timed:
        own, ours = t.phases.get(SIMULATOR, 0.0), [t.phases.get(name, 0.0) for name in PHASES[1:]]
        if not own + sum(ours) or isinstance(t.way.model.elements, tuple):
            continue
        ratio: Cell = "-"
        if t.dofs and t.dofs <= LARGEST and t.phases[PROJECTION]:
            ratio = Number(t.phases[PROJECTION] / dense_seconds(t.dofs), 2)
        rows.append((
            label(t.way.model), t.way.model.info().program, "-" if t.dofs is None else t.dofs,
            *(Number(1e3 * x, 2) for x in (t.median(), own, *ours, t.phases[NAMELESS])),
            Number(100 * (1 - own / t.median()), 1), ratio,
            Number(1e3 * t.first.phases[SIMULATOR], 1),
        ))  # fmt: skip
    columns = (
        "Model", "Simulator", "dofs", "whole [ms]", f"{SIMULATOR} [ms]",
        *(f"{name} [ms]" for name in PHASES[1:]), "rest [ms]", "ours [%]", "projection / eigh",
        "first call [ms]",
    )  # fmt: skip
    notes = (
        "simulator: seconds in its own code, of every call and of the first, whose meshes and "
        "reductions may be kept; all else is ours, and rest what no column is named for; medians",
        "projection / eigh: to one scipy.linalg.eigh of a pair of as many coordinates",
    )
    return Table("The simulators' own time, and ours", columns, tuple(rows), notes)
