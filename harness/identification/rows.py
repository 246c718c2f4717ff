"""What an identification finds as rows of the history of runs."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.cases import Case
from harness.identification.identify import Identification, Reading
from harness.identification.parameters import described
from harness.identification.problem import Problem
from harness.run import mode_rows, settings

IDENTIFIED = "identified"
"""The case in a row: a fitted mechanism is not that of the table's case, which is in `settings`."""


def history_rows(
    results: Sequence[Identification], ranked: Sequence[Reading]
) -> list[dict[str, Any]]:
    """Return one row a case and mode of every fit, and of the best reading of each number of
    free parameters; those with mirrored frames left out, for they are no mechanism.
    """
    found = {_key(r.problem): (r.problem, r.fits.values[0]) for r in results}
    best: dict[int, Reading] = {}
    for reading in sorted(ranked, key=lambda reading: reading.rms):
        if len(reading.x) and not reading.problem.mirrored:
            best.setdefault(len(reading.x), reading)
    for count in sorted(best):
        problem = best[count].problem
        found.setdefault(_key(problem), (problem, best[count].values))
    return [
        row
        for problem, values in found.values()
        if not problem.mirrored
        for row in _rows(problem, values)
    ]


def _key(problem: Problem) -> tuple[object, ...]:
    return problem.spec, problem.names, problem.inertia, problem.mirrored


def _rows(problem: Problem, values: NDArray[np.float64]) -> list[dict[str, Any]]:
    """Return what the model says of the mechanism with the fitted `values`.

    To six digits, beyond which another seed finds others (5e-6 measured): another machine's last
    bits then hardly ever make of the same fit another mechanism with a hash of its own.
    """
    fitted = {n: float(f"{v:.6g}") for n, v in zip(problem.names, values.tolist(), strict=True)}
    table, spec = problem.table, problem.spec
    model, count = spec.build(), table.frequencies.shape[1]
    found = []
    for case, own in zip(table.cases, problem.at(fitted), strict=True):
        mechanism, pose = described(own, problem.inertia, case.mechanism)
        how = settings(spec, count, table=table.source, case=case.name, fitted=fitted)
        modes = model.modes(mechanism, pose, count)
        found += mode_rows(Case(IDENTIFIED, mechanism, pose, ""), spec, how, modes, count)
    return found
