"""What a platform needs to know of a limb it cannot look into: a table over the limb's length.

A round rod of diameter d and length a d, in families of motion that the tip sees through one
displacement each (bending about the revolute axis, bending across it, stretching), has
    d(lambda) = P - Q lambda - sum_j c_j / (lambda_j - lambda)
in every one of them, and twists at frequencies of its own. Beam units, E d / a^3 and
E / (rho d^2 a^4) in bending and E d / a and E / (rho d^2 a^2) along, leave every number nearly
the same for all lengths: Chebyshev series in 1 / a over an octave of a are short.
"""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from analytic.mechanism import Rod

Array = NDArray[np.float64]

DIRECTIONS = 3
OCTAVES = range(1, 6)
"""Lengths from 2 to 64 diameters; a shorter body is no rod, and its modes no smooth functions."""


@dataclass(frozen=True)
class Columns:
    """A limb's numbers at N lengths; p poles in all, `owner` (p,) giving each its direction.

    Attributes: `P`, `Q` (N, 3); `poles` (N, p); `couplings` sqrt(c_j) / lambda_j, (N, p); `twist`
    omega^2 of the twisting modes (N, w); `static` (N, 3, 11) and `shapes` (N, p, 11): the axis'
    motion at `STATIONS`, along the direction, under t = 1 and in every mode.
    """

    P: Array
    Q: Array
    poles: Array
    couplings: Array
    twist: Array
    static: Array
    shapes: Array


@dataclass(frozen=True)
class LimbTable:
    """Chebyshev coefficients over 2^`octave` <= a <= 2^(octave + 1), for one Poisson's ratio.

    Attributes: `owner` (p,); `coefficients` (q, columns): P, Q, poles, couplings, twist, static,
    shapes in turn, in beam units; `levels` (k,), omega^2 over the first pole's; `errors` (k, 4) of
    d in the three directions, over |d| + lambda |d'|, and of twisting modes' omega^2: the largest
    that was found up to each level where the table was compared with the rod itself.
    """

    octave: int
    owner: NDArray[np.intp]
    coefficients: Array
    levels: Array
    errors: Array

    def at(self, rod: Rod, lengths: Array) -> Columns:
        """Return the numbers of `rod` at `lengths` (N,) [m], in SI."""
        d, E, rho = rod.diameter, rod.material.young, rod.material.density
        a = lengths / d
        parts = self.scaled(a)
        unit = frequency_units(a) * (E / (rho * d**2))
        stiff = stiffness_units(a) * (E * d)
        mass = rho * d**3 * a[:, None]
        return Columns(
            parts.P * stiff,
            parts.Q * mass,
            parts.poles * unit[:, self.owner],
            parts.couplings * np.sqrt(mass),
            parts.twist * unit[:, 2:],
            parts.static,
            parts.shapes / np.sqrt(mass)[..., None],
        )

    def scaled(self, a: Array) -> Columns:
        """Return the numbers in beam units at aspects `a` (N,)."""
        values = chebyshev.chebvander(position_in(self.octave, a), len(self.coefficients) - 1)
        return split(values @ self.coefficients, len(self.owner))


def split(values: Array, poles: int) -> Columns:
    """Return rows of numbers (N, columns) by name."""
    N, stations = len(values), 11
    sizes = [DIRECTIONS, DIRECTIONS, poles, poles]
    twist = values.shape[1] - sum(sizes) - (DIRECTIONS + poles) * stations
    edges = np.cumsum([*sizes, twist, DIRECTIONS * stations])
    P, Q, pole, coupling, twisting, static, shapes = np.split(values, edges, axis=1)
    return Columns(
        P,
        Q,
        pole,
        coupling,
        twisting,
        static.reshape(N, DIRECTIONS, stations),
        shapes.reshape(N, poles, stations),
    )


def nodes(octave: int, count: int) -> Array:
    """Return the aspects a of `count` Chebyshev nodes of an octave."""
    u = np.cos(np.pi * (np.arange(count) + 0.5) / count)
    return np.asarray(2.0**octave / (0.75 + 0.25 * u))


def extremes(octave: int, count: int) -> Array:
    """Return aspects a half-way between `count` Chebyshev nodes, every other, and both ends."""
    u = np.cos(np.pi * np.arange(0, count + 1, 2) / count)
    return np.asarray(2.0**octave / (0.75 + 0.25 * u))


def position_in(octave: int, a: Array) -> Array:
    """Return where aspects lie in an octave: 1 / a from its long end, -1, to its short one, 1."""
    return np.asarray((2.0**octave / a - 0.75) / 0.25)


def coefficients(values: Array) -> Array:
    """Return Chebyshev coefficients (q, columns) from values at q nodes."""
    q = len(values)
    k = np.arange(q)
    transform = np.cos(np.pi * np.outer(k, k + 0.5) / q) * np.where(k, 2, 1)[:, None] / q
    return np.asarray(transform @ values)


def frequency_units(a: Array) -> Array:
    """Return omega^2 of each direction at aspect `a` (N,), in E / (rho d^2), shape (N, 3)."""
    return np.stack([a**-4.0, a**-4.0, a**-2.0], axis=-1)


def stiffness_units(a: Array) -> Array:
    """Return stiffness of each direction at aspect `a` (N,), in E d, shape (N, 3)."""
    return np.stack([a**-3.0, a**-3.0, a**-1.0], axis=-1)
