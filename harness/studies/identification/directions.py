"""Which products of powers of the parameters a table pins down, and which it cannot see."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr

from harness.studies.identification.parameters import letter
from harness.studies.identification.problem import Problem

Floats = NDArray[np.float64]

UNSEEN = 1e-6
"""A direction with this part of the largest singular value is one that no table can show."""
PINNED = "d / L^2 [1/m]"
"""Bending frequencies of a limb of length L and diameter d grow with it."""
STEP = 3e-4
"""Of a central difference, over the distance between the bounds."""


@dataclass(frozen=True)
class Direction:
    """A product of powers: `exponents` by parameter, the largest being 1 in size.

    `deviation` of its logarithm, 1 sigma, from the table alone; infinite where it sees nothing.
    """

    exponents: dict[str, float]
    deviation: float

    def __str__(self) -> str:
        shown = [(letter(n), e) for n, e in self.exponents.items() if abs(e) >= 0.1]
        shown.sort(key=lambda pair: -round(abs(pair[1]), 4))  # equal ones stay in their order
        return " ".join(f"{letter}^{e:.2g}" if round(e, 2) != 1 else letter for letter, e in shown)


@dataclass(frozen=True)
class Quantity:
    """A combination with a name: its `value`, and the 1 sigma deviation of its logarithm.

    `before`, as the bounds of all parameters leave it, and `after` the table is known too.
    """

    name: str
    value: float
    before: float
    after: float


def sensitivities(
    problem: Problem, values: Mapping[str, float], names: Sequence[str] = ()
) -> tuple[Problem, Floats, Floats]:
    """Return the problem of `names`, its x at `values`, and weighted d ln f / d ln p there.

    Shape (cases * modes, parameters); of what may be zero, and is, d ln f / dp over its bounds. By
    default of all parameters of the most tilted case that can move: but for the angles if none is
    tilted, and a disc's density, which would only repeat its thickness.
    """
    k = int(np.argmax([abs(case.pose.tilt) for case in problem.table.cases]))
    known, tilted = problem.known[k], problem.table.cases[k].pose.tilt
    away = {"platform_density_kg_m3"} | (set() if tilted else {"azimuth_deg", "tilt_deg"})
    able = (name for name in known if name not in away)
    found = tuple(names) or tuple(sorted(able, key=lambda name: known[name].linear))
    whole = replace(problem, names=found, bounds={})
    values = dict(zip(problem.names, problem.given, strict=True)) | dict(values)
    own = np.array([(problem.at(values)[k] | values)[name] for name in found])
    x, (low, high) = whole.to_x(own), whole.limits
    steps = STEP * (high - low)
    both = np.concatenate([x + np.diag(steps), x - np.diag(steps)])
    up, down = np.split(np.log(whole.frequencies(both)).reshape(len(both), -1), 2)
    scale = np.where(whole.linear, np.where(own, own, (high - low) / 2), 1.0)
    J = np.sqrt(problem.table.weights)[:, None] * ((up - down) / (2 * steps[:, None])).T * scale
    kept = np.isfinite(J).all(axis=0)
    if kept.all():
        return whole, x, J
    return sensitivities(problem, values, [n for n, can in zip(found, kept, strict=True) if can])


def directions(names: Sequence[str], J: Floats, noise: float) -> list[Direction]:
    """Return the products of powers that J (values, names) tells apart, best known first."""
    _, s, rows = np.linalg.svd(J, full_matrices=True)
    s = np.concatenate([s, np.zeros(len(rows) - len(s))])
    nothing = s <= UNSEEN * s[0]
    if nothing.any():
        # Any mixture is unseen as well: take those that share as few parameters as can be.
        pivots = np.sort(qr(rows[nothing], mode="r", pivoting=True)[1][: nothing.sum()])
        rows[nothing] = np.linalg.solve(rows[nothing][:, pivots], rows[nothing])
    found = []
    for size, row in zip(s, rows, strict=True):
        largest = row[np.abs(row).argmax()]
        deviation = noise / (size * abs(largest)) if size > UNSEEN * s[0] else np.inf
        found.append(Direction(dict(zip(names, row / largest, strict=True)), float(deviation)))
    return found


def quantities(whole: Problem, x: Floats, J: Floats, noise: float) -> list[Quantity]:
    """Return the named combinations, with young and density known and all else within bounds."""
    low, high = whole.limits
    own = whole.from_x(x)
    prior = ((high - low) / np.sqrt(12) / np.where(whole.linear, np.abs(own), 1.0)) ** 2
    keep = [k for k, name in enumerate(whole.names) if name not in ("young_GPa", "density_kg_m3")]
    information = J[:, keep].T @ J[:, keep] / noise**2 + np.diag(1 / prior[keep])
    covariance = np.linalg.inv(information)
    # Their values, and those a small step of the logarithm of each parameter up and down.
    steps = 1e-5 * np.eye(len(x))[keep]
    steps = np.concatenate([0 * steps[:1], steps, -steps])
    tilted = max(whole.at(dict(zip(whole.names, (own * np.exp(steps)).T, strict=True))),
                 key=lambda values: np.abs(values["tilt_deg"]).max())  # fmt: skip
    found = []
    for name, values in whole.groups(tilted).items():
        if values.all():  # without tilt one of them is zero
            up, down = np.split(np.log(np.abs(values[1:])), 2)
            slope = (up - down) / 2e-5
            before, after = np.sqrt(slope**2 @ prior[keep]), np.sqrt(slope @ covariance @ slope)
            found.append(Quantity(name, float(values[0]), float(before), float(after)))
    return found
