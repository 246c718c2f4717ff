"""Which products of powers of the parameters a table pins down, and which it cannot see."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr

from harness.studies.identification.fit import central_jacobian
from harness.studies.identification.parameters import PARAMETERS
from harness.studies.identification.problem import Problem
from harness.studies.identification.table import FrequencyTable

Floats = NDArray[np.float64]

EVERYTHING = (
    "z_mm",
    "base_radius_mm",
    "platform_radius_mm",
    "disc_radius_mm",
    "platform_thickness_mm",
    "rod_diameter_mm",
    "young_GPa",
    "density_kg_m3",
    "azimuth_deg",
    "tilt_deg",
)
"""What the directions are made of; a second density would only repeat the thickness."""
UNSEEN = 1e-6
"""A direction with this part of the largest singular value is one that no table can show."""


@dataclass(frozen=True)
class Direction:
    """A product of powers: `exponents` by parameter, the largest being 1 in size.

    `deviation` of its logarithm, 1 sigma, from the table alone; infinite where it sees nothing.
    """

    exponents: dict[str, float]
    deviation: float

    def __str__(self) -> str:
        shown = [(PARAMETERS[n].letter, e) for n, e in self.exponents.items() if abs(e) >= 0.1]
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


def sensitivities(problem: Problem, values: dict[str, float]) -> tuple[Problem, Floats, Floats]:
    """Return the problem of EVERYTHING, its x at `values`, and the weighted d ln f / d ln p there.

    Shape (cases * modes, parameters). Without a tilted case the angles are left out.
    """
    whole = replace(problem, names=_known_to(problem.table), bounds={})
    tilted = max(range(len(whole.base)), key=lambda k: abs(whole.base[k]["tilt_deg"]))
    base = whole.base[tilted] | values
    x = np.array([whole.to_x(name, base[name]) for name in whole.names])
    low, high = whole.limits
    residuals = whole.residuals(problem.table.logarithms[None])
    J = central_jacobian(residuals, x, low, high)
    scale = [base[name] if PARAMETERS[name].angle else 1.0 for name in whole.names]
    return whole, x, J * scale


def _known_to(table: FrequencyTable) -> tuple[str, ...]:
    """Return EVERYTHING, without the angles if no case is tilted."""
    tilted = any(case.pose.tilt != 0 for case in table.cases)
    return tuple(name for name in EVERYTHING if tilted or not PARAMETERS[name].angle)


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
    angles = np.array([PARAMETERS[name].angle for name in whole.names])
    low, high = whole.limits
    own = whole.from_x(x)
    scale = np.where(angles, own, 1.0)
    prior = (high - low) / np.sqrt(12) / np.abs(scale)
    keep = [k for k, name in enumerate(whole.names) if name not in ("young_GPa", "density_kg_m3")]
    information = J[:, keep].T @ J[:, keep] / noise**2 + np.diag(prior[keep] ** -2.0)
    covariance = np.linalg.inv(information)
    values = dict(zip(whole.names, own, strict=True))
    found = []
    for name, quantity in QUANTITIES.items():
        if "theta" in name and "tilt_deg" not in values:
            continue
        gradient = np.array([_slope(quantity, values, whole.names[k]) for k in keep])
        before = np.sqrt((gradient**2 * prior[keep] ** 2).sum())
        after = np.sqrt(gradient @ covariance @ gradient)
        found.append(Quantity(name, quantity(values), float(before), float(after)))
    return found


def _slope(
    quantity: Callable[[dict[str, float]], float], values: dict[str, float], name: str
) -> float:
    """Return d ln q / d ln p by a central difference."""
    h = 1e-5
    up, down = ({**values, name: values[name] * factor} for factor in (np.exp(h), np.exp(-h)))
    return float((np.log(abs(quantity(up))) - np.log(abs(quantity(down)))) / (2 * h))


def _length(p: dict[str, float]) -> float:
    """Return the limb's length without tilt [m]."""
    across = p["base_radius_mm"] - p["platform_radius_mm"]
    return float(np.hypot(p["z_mm"], across) / 1e3)


def _platform_mass(p: dict[str, float]) -> float:
    """Return the platform's mass over that of three limbs."""
    platform = p["disc_radius_mm"] ** 2 * p["platform_thickness_mm"]
    return platform / (3 * p["rod_diameter_mm"] ** 2 / 4 * 1e3 * _length(p))


QUANTITIES: dict[str, Callable[[dict[str, float]], float]] = {
    "d / L^2 [1/m]": lambda p: p["rod_diameter_mm"] / 1e3 / _length(p) ** 2,
    "L [m]": _length,
    "d / L": lambda p: p["rod_diameter_mm"] / 1e3 / _length(p),
    "r1 / L": lambda p: p["base_radius_mm"] / 1e3 / _length(p),
    "r2 / L": lambda p: p["platform_radius_mm"] / 1e3 / _length(p),
    "(r2 - r1) / L": lambda p: (p["platform_radius_mm"] - p["base_radius_mm"]) / 1e3 / _length(p),
    "Jz / (m r2^2)": lambda p: 0.5 * (p["disc_radius_mm"] / p["platform_radius_mm"]) ** 2,
    "m / (three limbs)": _platform_mass,
    "r2 sin(theta) / L": lambda p: (
        p["platform_radius_mm"] / 1e3 * abs(np.sin(np.radians(p["tilt_deg"]))) / _length(p)
    ),
}
"""L is the length of a limb without tilt, m the platform's mass."""
