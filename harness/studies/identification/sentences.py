"""What an identification says, in plain words: every number in a sentence is computed for it."""

from collections.abc import Sequence

import numpy as np
from scipy import stats

from harness.studies.identification.directions import QUANTITIES, quantities, sensitivities
from harness.studies.identification.estimate import LEVEL, Fitted, Reading
from harness.studies.identification.result import ALIKE, closest_note, model_label, values_text

PINNED = "d / L^2 [1/m]"
"""Bending frequencies of a limb of length L and diameter d grow with it."""
BASE, PLATFORM = "base_radius_mm", "platform_radius_mm"


def sentences(results: Sequence[Fitted], ranked: Sequence[Reading]) -> list[str]:
    """Return what the fits and readings of one table say; nothing of what was not asked for."""
    lines = _pinned(results[-1])
    if ranked:
        table = ranked[0].problem.table
        most = max(len(reading.x) for reading in ranked)
        lines.append(
            f"Of {len(ranked)} readings of {table.source}, each with at most {most} free "
            f"parameters, {closest_note(ranked)}."
        )
    return lines + _one_free(ranked) + _lean(results)


def _pinned(result: Fitted) -> list[str]:
    """Return d / L^2 with its interval, beside what the given parameters make it."""
    problem, fits = result.problem, result.fits
    if any("." in name for name in problem.names):
        return []
    whole, x, J = sensitivities(problem, result.fitted)
    (found,) = (q for q in quantities(whole, x, J, float(fits.noise[0])) if q.name == PINNED)
    upper = (1 + LEVEL) / 2
    noise_known = result.assumed is not None
    width = stats.norm.ppf(upper) if noise_known else stats.t.ppf(upper, fits.freedom)
    low, high = found.value * np.exp(np.array([-1, 1]) * width * found.after)
    given = " and ".join(dict.fromkeys(f"{QUANTITIES[PINNED](base):.4f}" for base in whole.base))
    return [
        f"By {problem.table.source}, the limbs' d/L^2 is {found.value:.4f} 1/m ({low:.4f} to "
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
        f"{model_label(r.problem)}, {values_text(r)} (rms {100 * r.rms:.2f} %, at most "
        f"{100 * r.worst:.2f} % off)"
        for r in best.values()
    ]
    if not words:
        return []
    other = ""
    if len(words) == 2:
        frames = "as stated" if list(best)[1] is False else "mirrored"
        other = f"; with frames {frames} it is {words[1]}"
    return [f"The best reading with one free parameter is {words[0]}{other}."]


def _lean(results: Sequence[Fitted]) -> list[str]:
    """Return what both frames make of the base's radius, and whether the table prefers one."""
    pair = {r.problem.mirrored: r for r in results if BASE in r.problem.names}
    if len(pair) < 2:
        return []
    stated, mirrored = pair[False], pair[True]
    k = stated.problem.names.index(BASE)
    words = []
    for result in (stated, mirrored):
        low, high = result.fits.alone[0, k]
        words.append(f"{result.fits.values[0, k]:.0f} mm ({low:.0f} to {high:.0f})")
    given = stated.problem.from_x(stated.problem.start)[k]
    radius = stated.problem.base[0][PLATFORM]
    lean = "outwards" if stated.fits.values[0, k] < radius else "inwards"
    table = stated.problem.table
    count = float(table.weights.sum())
    # A fit below the rounding is as good as any other there.
    least = max(count * table.rounding**2, np.finfo(float).tiny)
    sums = [max(float(r.fits.minima.sums[0]), least) for r in (stated, mirrored)]
    better = count * np.log(sums[0] / sums[1])
    verdict = "The table does not tell the two apart"
    if abs(better) > ALIKE:
        verdict = f"The table prefers {'mirrored' if better > 0 else 'stated'} frames"
    rms = [f"{100 * np.sqrt(value / count):.2f}" for value in sums]
    return [
        f"Fitted to {table.source}: with frames as stated, the base's radius is {words[0]} at "
        f"{100 * LEVEL:.0f} %, where {given:.0f} mm is given and the platform has {radius:.0f} mm: "
        f"limbs that lean {lean}; with mirrored frames, a slip and no mechanism, it is {words[1]}. "
        f"{verdict} (rms {rms[0]} and {rms[1]} %)."
    ]
