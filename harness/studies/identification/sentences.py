"""What an identification says, in plain words: every number in a sentence is computed for it."""

from collections.abc import Sequence

import numpy as np
from scipy import stats

from harness.studies.identification.directions import combinations
from harness.studies.identification.estimate import LEVEL, Fit, Reading
from harness.studies.identification.result import ALIKE, closest_note

PINNED = "d / L^2 [1/m]"
"""Bending frequencies of a limb of length L and diameter d grow with it."""
BASE, PLATFORM = "base_radius_mm", "platform_radius_mm"


def sentences(fits: Sequence[Fit], ranked: Sequence[Reading]) -> list[str]:
    """Return what the fits and readings of one table say; nothing of what was not asked for."""
    lines = _pinned(fits[-1]) if fits[-1].problem.whole else []
    if ranked:
        most = max(len(reading.x) for reading in ranked)
        lines.append(
            f"Of {len(ranked)} readings of {ranked[0].problem.table.source}, each with at most "
            f"{most} free parameters, {closest_note(ranked)}."
        )
    lines += _one_free(ranked)
    with_base = [one for one in fits if BASE in one.problem.names]
    return lines + (_lean(*with_base) if len(with_base) == 2 else [])


def _pinned(one: Fit) -> list[str]:
    """Return d / L^2 with its interval, beside what the given parameters make it."""
    (found,) = (q for q in one.quantities if q.name == PINNED)
    known = one.assumed is not None
    width = (stats.norm if known else stats.t(one.freedom)).ppf((1 + LEVEL) / 2)
    low, high = found.value * np.exp(np.array([-1, 1]) * width * found.after)
    given = " and ".join(dict.fromkeys(f"{combinations(p)[PINNED]:.4f}" for p in one.problem.base))
    return [
        f"By {one.problem.table.source}, the limbs' d/L^2 is {found.value:.4f} 1/m ({low:.4f} to "
        f"{high:.4f} at {100 * LEVEL:.0f} %, E and rho as given); the given parameters make it "
        f"{given} 1/m."
    ]


def _one_free(ranked: Sequence[Reading]) -> list[str]:
    """Return the best reading with one free parameter, and that with the other frames."""
    best: dict[bool, Reading] = {}
    for reading in sorted(ranked, key=lambda reading: reading.rms):
        if len(reading.x) == 1:
            best.setdefault(reading.problem.mirrored, reading)
    words = [
        f"{r.problem.label}, {r} (rms {100 * r.rms:.2f} %, at most {r.worst:.2f} % off)"
        for r in best.values()
    ]
    if len(words) == 2:
        words[1] = f"with frames {'mirrored' if list(best)[1] else 'as stated'} it is {words[1]}"
    return [f"The best reading with one free parameter is {'; '.join(words)}."] if words else []


def _lean(stated: Fit, mirrored: Fit) -> list[str]:
    """Return what both frames make of the base's radius, and whether the table prefers one."""
    problem, table = stated.problem, stated.problem.table
    k = problem.names.index(BASE)
    words = [
        f"{one.fitted[BASE]:.0f} mm ({one.alone[k, 0]:.0f} to {one.alone[k, 1]:.0f})"
        for one in (stated, mirrored)
    ]
    radius = problem.base[0][PLATFORM]
    lean = "outwards" if stated.fitted[BASE] < radius else "inwards"
    # A fit below the rounding is as good as any other there.
    least = max(table.rounding, 1e-150)
    rms = [max(one.rms, least) for one in (stated, mirrored)]
    better = 2 * float(table.weights.sum()) * np.log(rms[0] / rms[1])
    verdict = "The table does not tell the two apart"
    if abs(better) > ALIKE:
        verdict = f"The table prefers {'mirrored' if better > 0 else 'stated'} frames"
    return [
        f"Fitted to {table.source}: with frames as stated, the base's radius is {words[0]} at "
        f"{100 * LEVEL:.0f} %, where {problem.given[k]:.0f} mm is given and the platform has "
        f"{radius:.0f} mm: limbs that lean {lean}; with mirrored frames, a slip and no mechanism, "
        f"it is {words[1]}. {verdict} (rms {100 * rms[0]:.2f} and {100 * rms[1]:.2f} %)."
    ]
