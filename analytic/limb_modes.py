"""A limb by its fixed-tip modes: its exact dynamic stiffness as poles and a short polynomial.

Every direction's d of `dynamic_stiffness`, scaled by the limb's length, is
    d(x) = P(x) - sum_j c_j / (x_j - x),
with the poles x_j (the limb's modes with its tip held) below a cap and a P that is smooth up to
it. Without shear and rotary inertia all of it is universal; else poles, residues and P depend on
1 / L^2 alone and are tabulated over it. How many elements a limb has, or whether it has any,
matters while the table is made, never afterwards.
"""

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from analytic.dynamic_stiffness import fixed_tip_counts, limb_stiffness
from analytic.waves import Array, Sections

MARGIN = 0.4
"""The polynomial reaches this part of the way to the first pole it leaves out."""
DEGREE = 15
"""Of the polynomial: the pole left out, 1 / MARGIN away, costs (8 to 1)^-15 < 1e-13."""
EXACT = 2e-13
"""Largest relative error of a table, against the dynamic stiffness itself."""
LARGEST = 40
"""Most Chebyshev nodes over 1 / L^2."""

Values = tuple[float, ...]


@dataclass(frozen=True)
class LimbModes:
    """The tables of one rod for lengths within `span` [m].

    Attributes: `kept` poles of the three directions; `caps` x up to which P holds, (3,); `table`
    Chebyshev coefficients over 1 / L^2, shape (q, columns), its columns being the poles, the
    residues (directions in turn), and DEGREE + 1 powers of P in 2 x / cap - 1 for each direction.
    """

    rod: Sections
    span: tuple[float, float]
    kept: tuple[int, int, int]
    caps: NDArray[np.float64]
    table: NDArray[np.float64]

    def at(
        self, lengths: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return poles x_j (N, p), residues c_j (N, p) and P's powers (DEGREE + 1, N, 3).

        N is 1 where they are the same for all lengths.
        """
        poles, columns = self.columns
        if len(self.table) > 1:
            low, high = _inverse_squares(self.span)
            u = (2 / lengths**2 - (high + low)) / (high - low)
            # T_k(u), a row each: their product with the table is one call of BLAS.
            T = np.ones((len(self.table), len(u)))
            T[1] = u
            for k in range(2, len(T)):
                np.multiply(2 * u, T[k - 1], out=T[k])
                T[k] -= T[k - 2]
            poles, columns = T.T @ poles, np.matmul(T.T, columns)
        kept = sum(self.kept)
        return poles[:, :kept], poles[:, kept:], columns

    def scaled(self, lengths: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
        """Return all of a few limbs in SI units, in fewer steps than `at` and `units`.

        Poles and residues (N p,), powers of P (N 3, DEGREE + 1) and 1 / caps (N 3,).
        """
        table, exponents = self._dimensioned
        if len(table) > 1:
            low, high = _inverse_squares(self.span)
            u = (2 / lengths**2 - (high + low)) / (high - low)
            # Chebyshev polynomials, T_k(cos a) = cos(k a).
            table = np.cos(np.arccos(u)[:, None] * np.arange(len(table))) @ table
        rows, kept = table * lengths[:, None] ** exponents, sum(self.kept)
        return (
            rows[:, :kept].ravel(),
            rows[:, kept : 2 * kept].ravel(),
            rows[:, 2 * kept : -3].reshape(-1, DEGREE + 1),
            rows[:, -3:].ravel(),
        )

    @cached_property
    def _dimensioned(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """`table` in SI units, with 1 / `caps`, and the powers of the length it is to be times."""
        frequency2, stiffness = (of[0] for of in units(self.rod, np.ones(1)))
        of_frequency2, of_stiffness = np.array([-4, -4, -2]), np.array([-3, -3, -1])
        k, each = self.direction, np.repeat(np.arange(3), DEGREE + 1)
        inverse = np.zeros((len(self.table), 3))
        inverse[0] = 1 / self.caps
        scales = [frequency2[k], (frequency2 * stiffness)[k], stiffness[each], 1 / frequency2]
        powers = [of_frequency2[k], (of_frequency2 + of_stiffness)[k], of_stiffness[each],
                  -of_frequency2]  # fmt: skip
        table = np.concatenate([self.table, inverse], axis=1) * np.concatenate(scales)
        return table, np.concatenate(powers).astype(float)

    @cached_property
    def direction(self) -> NDArray[np.intp]:
        """The direction of every pole, (p,)."""
        return np.repeat(np.arange(3), self.kept)

    @cached_property
    def columns(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The table's columns: poles and residues (q, 2 p), powers of P (DEGREE + 1, q, 3)."""
        poles = 2 * sum(self.kept)
        powers = self.table[:, poles:].reshape(-1, 3, DEGREE + 1).transpose(2, 0, 1)
        return self.table[:, :poles], np.ascontiguousarray(powers)


def units(rod: Sections, lengths: Array) -> tuple[Array, Array]:
    """Return omega^2 at x = 1 [1/s^2] and stiffness at d = 1 [N/m], each (..., 3)."""
    frequency2, stiffness = np.empty((2, *np.shape(lengths), 3))
    square = lengths * lengths
    stiffness[..., 0] = stiffness[..., 1] = bending = rod.EI / (square * lengths)
    stiffness[..., 2] = rod.EA / lengths
    frequency2[..., 0] = frequency2[..., 1] = bending / (rod.line_mass * lengths)
    frequency2[..., 2] = rod.axial_speed2 / square
    return frequency2, stiffness


def limb_modes(
    rod: Sections, shortest: float, longest: float, elements: int | None, level: int
) -> LimbModes | None:
    """Return tables for lengths in this range with `level` poles of each bending direction.

    None where no table is exact: poles of different families may cross within the range.
    """
    # Round the range outward, so that neighbouring calls share a table.
    low, high = shortest * (1 - 1e-9), longest * (1 + 1e-9)
    span = 2 ** (math.floor(4 * math.log2(low)) / 4), 2 ** (math.ceil(4 * math.log2(high)) / 4)
    values = tuple(value.item() for value in vars(rod).values())
    return _limb_modes(values, span, elements, level)


@lru_cache(maxsize=512)
def _limb_modes(
    values: Values, span: tuple[float, float], elements: int | None, level: int
) -> LimbModes | None:
    rod = Sections(*(np.array([value]) for value in values))
    universal = values[3] == 0 and values[4] == 0
    middle = np.array([np.sqrt(span[0] * span[1])])
    kept = _kept(rod, middle, elements, level)
    caps = MARGIN * _poles(rod, _nodes(span, 8), elements, np.add(kept, 1))[1].min(axis=0)
    size = 1 if universal else 8
    while True:
        made = LimbModes(rod, span, kept, caps, _table(rod, span, elements, kept, caps, size))
        if universal or _error(made, elements) < EXACT:
            return made
        if size >= LARGEST:
            return None
        size += 4


def _kept(
    rod: Sections, middle: NDArray[np.float64], elements: int | None, level: int
) -> tuple[int, int, int]:
    """Return how many poles to keep: of the bar so many that it does not set the limit."""
    bending, bar = units(rod, middle)[0][0, [0, 2]]
    limit = _poles(rod, middle, elements, np.array([level + 1, 1, 1]))[1][0, 0] * bending
    held = fixed_tip_counts(rod, middle, np.array([0.6 * limit]), elements)[0]
    available = fixed_tip_counts(rod, middle, np.array([1e9 * max(bending, bar)]), elements)[0]
    return min(level, int(available[0])), min(level, int(available[1])), int(held[2])


def _nodes(span: tuple[float, float], size: int) -> NDArray[np.float64]:
    low, high = _inverse_squares(span)
    u = np.cos(np.pi * (np.arange(size) + 0.5) / size)
    return np.asarray(1 / np.sqrt((low + high) / 2 + (high - low) / 2 * u))


def _inverse_squares(span: tuple[float, float]) -> tuple[float, float]:
    return span[1] ** -2, span[0] ** -2


def _poles(
    rod: Sections, lengths: NDArray[np.float64], elements: int | None, wanted: Array
) -> tuple[list[NDArray[np.float64]], NDArray[np.float64]]:
    """Return the first `wanted` (3,) poles x of each direction, [(N, wanted)], and the last (N, 3).

    By bisection on the count of fixed-tip modes. A chain has no more than its coordinates: the
    last is then put far above the others.
    """
    # All directions in one bisection: each count is of all three anyway.
    direction = np.repeat(np.arange(3), wanted)[:, None]
    rank = np.concatenate([np.arange(count) for count in wanted])[:, None]
    scale = units(rod, lengths)[0].T[direction[:, 0]]
    low, high = np.zeros(scale.shape), np.full(scale.shape, np.log(1e8))
    for _ in range(36):
        x = (low + high) / 2
        counts = fixed_tip_counts(rod, lengths, np.exp(x) * scale, elements)
        above = np.take_along_axis(counts, direction[..., None], axis=-1)[..., 0] > rank
        low, high = np.where(above, low, x), np.where(above, x, high)
    found = []
    for poles in np.split(np.exp(low).T, np.cumsum(wanted)[:-1], axis=1):
        missing = poles > 0.99e8
        beyond = 10 * np.max(np.where(missing, 100.0, poles), axis=1, keepdims=True)
        found.append(np.where(missing, beyond, poles))
    return found, np.stack([poles[:, -1] for poles in found], axis=1)


def _table(
    rod: Sections,
    span: tuple[float, float],
    elements: int | None,
    kept: tuple[int, int, int],
    caps: NDArray[np.float64],
    size: int,
) -> NDArray[np.float64]:
    lengths = _nodes(span, size)
    frequency2, stiffness = units(rod, lengths)
    guesses, _ = _poles(rod, lengths, elements, np.add(kept, 1))
    t = np.cos(np.pi * (np.arange(DEGREE + 1) + 0.5) / (DEGREE + 1))
    poles, residues, smooth = [], [], []
    for direction in range(3):

        def d(x: Array, direction: int = direction) -> Array:
            lam = x * frequency2[:, direction]
            value = limb_stiffness(rod, lengths, lam, elements)[..., direction]
            return np.asarray(value / stiffness[:, direction])

        exact = [_pole(d, guesses[direction], j) for j in range(kept[direction])]
        # P by Cauchy's integral on a circle, where no pole is near and nothing cancels.
        angles = np.exp(2j * np.pi * (np.arange(64) + 0.5) / 64)
        centre = caps[direction] / 2
        circle = np.broadcast_to((centre * (1 + 1.5 * angles))[:, None], (64, size))
        values = d(circle) + sum(c / (x - circle) for x, c in exact)
        order = np.arange(48)
        taylor = (angles[:, None] ** -order).T @ values / 64
        at_nodes = ((t[:, None] / 1.5) ** order @ taylor).real
        smooth.append(power_series(at_nodes))
        poles += [x for x, _ in exact]
        residues += [c for _, c in exact]
    columns = np.concatenate([np.reshape([*poles, *residues], (-1, size)), *smooth])
    # Chebyshev coefficients over 1 / L^2 from values at Chebyshev nodes.
    k = np.arange(size)
    transform = np.cos(np.pi * np.outer(k, k + 0.5) / size) * np.where(k, 2, 1)[:, None] / size
    return np.asarray(transform @ columns.T)


def _pole(d: Any, guesses: NDArray[np.float64], j: int) -> tuple[Array, Array]:
    """Return pole and residue of `d` next to `guesses[:, j]`, by two moments on a circle."""
    gaps = np.abs(np.diff(guesses, axis=1))
    radius = 0.2 * gaps[:, max(j - 1, 0) : j + 1].min(axis=1)
    angles = np.exp(2j * np.pi * (np.arange(32) + 0.5) / 32)[:, None]
    values = d(guesses[:, j] + radius * angles) * radius * angles
    residue = values.mean(axis=0).real
    shift = (values * radius * angles).mean(axis=0).real / residue
    return guesses[:, j] + shift, residue


def power_series(at_nodes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return powers of t, (n, size), from values at n Chebyshev nodes of -1..1."""
    return to_powers(chebyshev_series(at_nodes))


def chebyshev_series(at_nodes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return Chebyshev coefficients, (n, size), from values at n Chebyshev nodes of -1..1."""
    return np.asarray(_transforms(len(at_nodes))[0] @ at_nodes)


def to_powers(series: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return powers of t, (n, size), from n Chebyshev coefficients."""
    return np.asarray(_transforms(len(series))[1] @ series)


@lru_cache(maxsize=32)
def _transforms(n: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return (n, n): values at n nodes to Chebyshev coefficients, and these to powers."""
    k = np.arange(n)
    transform = np.cos(np.pi * np.outer(k, k + 0.5) / n) * np.where(k, 2, 1)[:, None] / n
    powers = np.zeros((n, n))
    for i in range(n):
        powers[: i + 1, i] = chebyshev.cheb2poly(np.eye(n)[i])[: i + 1]
    return transform, powers


def _error(made: LimbModes, elements: int | None) -> float:
    """Return the largest error relative to |d| + |x d'| between the nodes, over lengths and x."""
    lengths = np.repeat(_nodes(made.span, 13), 7)
    fraction = np.tile(np.linspace(0.03, 0.97, 7), 13)
    frequency2, stiffness = units(made.rod, lengths)
    worst = 0.0
    for direction in range(3):
        x = fraction * made.caps[direction]
        lam = x * frequency2[:, direction] * (1 + 1e-30j)
        exact = limb_stiffness(made.rod, lengths, lam, elements)[..., direction]
        exact = exact / stiffness[:, direction]
        size = np.abs(exact.real) + np.abs(exact.imag) * 1e30 + 1
        worst = max(
            worst, (np.abs(evaluate(made, lengths, direction, x) - exact.real) / size).max()
        )
    return float(worst)


def evaluate(
    made: LimbModes, lengths: NDArray[np.float64], direction: int, x: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the scaled d of one direction from the tables, shape of `x` (N,)."""
    poles, residues, powers = made.at(lengths)
    own = slice(sum(made.kept[:direction]), sum(made.kept[: direction + 1]))
    t = 2 * x / made.caps[direction] - 1
    value = (powers[..., direction] * t ** np.arange(DEGREE + 1)[:, None]).sum(axis=0)
    return np.asarray(value - (residues[:, own] / (poles[:, own] - x[:, None])).sum(axis=1))
