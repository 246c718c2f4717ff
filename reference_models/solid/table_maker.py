"""A solid rod's table over an octave of lengths, and how far it is from the rod itself."""

import numpy as np
from numpy.typing import NDArray

from reference_models.solid.faces import Held
from reference_models.solid.reduction import PARTS, Spectrum, spectrum
from reference_models.solid.rod import FAMILIES, SLENDERNESS
from reference_models.solid.table import (
    LimbTable,
    coefficients,
    extremes,
    frequency_units,
    nodes,
    stiffness_units,
)

Array = NDArray[np.float64]

FORM = 2
"""Of the numbers in a table: another where this file or the reduction comes to other numbers."""
KEPT = {"x": 2, "y": 2, "z": 0, "twist": 2}
"""Modes kept of each family; each but "twist" has one more, for all others."""
NODES = 14
LEVELS = np.array([0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0, 2.25, 2.5, 2.75, 3.0, 4.0, 5.0, 6.0])
"""Up to these multiples of the rod's lowest pole are errors measured."""

Rods = dict[str, Held]


def limb_table(held: Rods, octave: int) -> LimbTable:
    """Return the table of lengths 2^octave to 2^(octave + 1) diameters."""
    series = coefficients(np.array([_row(_spectra(held, a), a) for a in nodes(octave, NODES)]))
    owner = np.repeat(np.arange(3), [KEPT[family] + 1 for family in "xyz"])
    made = LimbTable(octave, owner, series, LEVELS, np.zeros((len(LEVELS), len(FAMILIES))))
    # Between the nodes, and at both ends, where interpolation errs most.
    errors = np.max([_errors(made, held, a) for a in extremes(octave, NODES)], axis=0)
    return LimbTable(octave, owner, series, LEVELS, np.maximum.accumulate(errors))


def _spectra(held: Rods, aspect: float) -> dict[str, Spectrum]:
    return {family: spectrum(held[family], aspect / SLENDERNESS) for family in FAMILIES}


def _row(spectra: dict[str, Spectrum], aspect: float) -> Array:
    """Return the columns of `LimbTable` at one aspect, in beam units."""
    a = np.array([aspect])
    unit, stiff = frequency_units(a)[0], stiffness_units(a)[0]
    P, Q, poles, couplings, static, shapes = [], [], [], [], [], []
    for i, family in enumerate("xyz"):
        seen = spectra[family].kept(KEPT[family])
        k, m = seen.tip
        squares = seen.couplings**2
        P.append(PARTS * (k + seen.poles @ squares) / stiff[i])
        Q.append(PARTS * (m - squares.sum()) / aspect)
        poles.append(seen.poles / unit[i])
        couplings.append(seen.couplings * np.sqrt(PARTS / aspect))
        static.append(seen.static)
        shapes.append((seen.shapes * np.sqrt(aspect / PARTS)).ravel())
    twist = spectra["twist"].poles[: KEPT["twist"]] / unit[2]
    return np.concatenate([P, Q, *poles, *couplings, twist, *static, *shapes])


def _errors(table: LimbTable, held: Rods, aspect: float) -> Array:
    """Return how far off each of `FAMILIES` is up to each of `LEVELS`, shape (levels, families).

    Of d over |d| + lambda |d'|, which is as regular at a pole as elsewhere; of twisting modes'
    omega^2, relative.
    """
    seen = _spectra(held, aspect)
    a = np.array([aspect])
    row, unit, stiff = table.scaled(a), frequency_units(a)[0], stiffness_units(a)[0]
    lowest = seen["x"].poles[0]
    fraction = (np.arange(40) + 0.5)[:, None] / 40 * np.diff(LEVELS, prepend=0.0)
    lam = (fraction + np.append(0, LEVELS[:-1])) * lowest
    result = np.zeros((len(LEVELS), len(FAMILIES)))
    step = 1e-6
    for i, family in enumerate("xyz"):
        own = table.owner == i
        x = lam[..., None] / unit[i]
        poles, c = row.poles[0, own], (row.poles * row.couplings)[0, own] ** 2
        d = row.P[0, i] - row.Q[0, i] * x[..., 0] - (c / (poles - x)).sum(axis=-1)
        exact, above, below = (
            PARTS / stiff[i] * seen[family].stiffness(lam * f) for f in (1, 1 + step, 1 - step)
        )
        size = np.abs(exact) + np.abs(above - below) / (2 * step)
        result[:, i] = np.max(np.abs(d - exact) / size, axis=0)
    twist = np.abs(row.twist[0] / (seen["twist"].poles[: KEPT["twist"]] / unit[2]) - 1)
    result[:, -1] = twist.max()
    return result
