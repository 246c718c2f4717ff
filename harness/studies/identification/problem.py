"""A table to be explained and a model with free parameters: what a fit minimises."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic import InputError
from analytic.designs import design_frequencies
from harness.studies.identification.fit import Residuals
from harness.studies.identification.parameters import (
    PARAMETERS,
    POSE,
    designs,
    heading,
    pose_values,
    starting_values,
)
from harness.studies.identification.table import FrequencyTable
from reference_models import Named

Floats = NDArray[np.float64]
Bounds = Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class Problem:
    """A table, a model, and the `names` of parameters that may be fitted to it.

    A name may be prefixed by a case, as in case2.z_mm; else all cases share the parameter, azimuth
    and tilt those cases that are tilted. `model` is a theory with its elements, `inertia` "disc"
    or "printed" (Eq. 8), `mirrored` as in `Designs`; `bounds` override the default ones, in the
    units of the names; `argument` is named where a name is refused. Parameters are handled as x:
    the logarithm of the value, or an angle itself.
    """

    table: FrequencyTable
    model: Named
    names: tuple[str, ...]
    inertia: str = "disc"
    mirrored: bool = False
    bounds: Bounds = field(default_factory=dict)
    argument: str = "parameters"

    def __post_init__(self) -> None:
        cases = self.table.cases
        if self.model.info().limit != self.model.name:
            expected = "a beam theory, whose rods can be those of any mechanism"
            raise InputError("model", self.model.label, expected)
        for name in self.names:
            self._reaches(name)
        if any(case.mechanism != cases[0].mechanism for case in cases):
            raise InputError("table", [c.name for c in cases], "cases of one mechanism")
        for name in self.bounds:
            if name not in self.names:
                raise InputError("bounds", name, f"one of the parameters {', '.join(self.names)}")
        low, high = self.limits
        for name, a, b, x in zip(self.names, low, high, self.start, strict=True):
            if not a < b:
                raise InputError("bounds", name, "a lower bound below the upper one")
            if not a - 1e-12 <= x <= b + 1e-12 and name not in self.bounds:
                raise InputError(self.argument, name, "a starting value within default bounds")

    def _reaches(self, name: str) -> list[int]:
        """Return which cases `name` belongs to."""
        case, dot, own = name.rpartition(".")
        cases = self.table.cases
        known = [c.name for c in cases]
        if own not in PARAMETERS or (dot and (own not in POSE or case not in known)):
            poses = ", ".join(f"{known[-1]}.{p}" for p in POSE)
            expected = f"one of {', '.join(PARAMETERS)}, or of one case as {poses}"
            raise InputError(self.argument, name, expected)
        if dot:
            return [known.index(case)]
        special = {known.index(n.rpartition(".")[0]) for n in self.names if n.endswith(f".{own}")}
        shared = [k for k in range(len(cases)) if k not in special]
        if PARAMETERS[own].angle:
            shared = [k for k in shared if cases[k].pose.tilt != 0]
        if not shared:
            raise InputError(self.argument, name, "a case that this parameter is left for")
        return shared

    @property
    def base(self) -> list[dict[str, float]]:
        """What each case starts from, in the units of the names."""
        own = starting_values(self.table.cases[0])
        return [own | pose_values(case) for case in self.table.cases]

    def kind(self, name: str) -> str:
        """Return the parameter that `name` is, without its case."""
        return name.rpartition(".")[2]

    def to_x(self, name: str, value: float) -> float:
        """Return the x of a value."""
        return value if PARAMETERS[self.kind(name)].angle else float(np.log(value))

    def from_x(self, x: Floats) -> Floats:
        """Return values, in the units of the names, of x (..., P)."""
        angles = np.array([PARAMETERS[self.kind(name)].angle for name in self.names], dtype=bool)
        return np.where(angles, x, np.exp(np.where(angles, 0.0, x)))

    @property
    def start(self) -> Floats:
        """The x of the cases as they are, (P,)."""
        base = self.base
        return np.array([self.to_x(n, base[self._reaches(n)[0]][self.kind(n)]) for n in self.names])

    @property
    def limits(self) -> tuple[Floats, Floats]:
        """Lower and upper bounds of x, (P,) each."""
        pairs = []
        for name, x in zip(self.names, self.start, strict=True):
            parameter = PARAMETERS[self.kind(name)]
            if name in self.bounds:
                pair = [self.to_x(name, value) for value in self.bounds[name]]
            elif parameter.angle:
                pair = [parameter.low, parameter.high]
            else:
                pair = [x + np.log(parameter.low), x + np.log(parameter.high)]
            pairs.append(pair)
        low, high = np.reshape(pairs, (-1, 2)).T
        return low, high

    def at(self, values: Mapping[str, Any]) -> list[dict[str, Any]]:
        """Return all parameters of each case, those that are fitted being `values` by name."""
        found = []
        for k, base in enumerate(self.base):
            given = {self.kind(n): values[n] for n in self.names if k in self._reaches(n)}
            own = {**base, **given}
            # The disc ends where the joints are and is made of what the rods are made of.
            if "disc_radius_mm" not in given:
                own["disc_radius_mm"] = own["platform_radius_mm"]
            if "platform_density_kg_m3" not in given:
                own["platform_density_kg_m3"] = own["density_kg_m3"]
            found.append(own)
        return found

    def frequencies(self, x: Floats) -> Floats:
        """Return f [Hz] of all cases at x (M, P), shape (M, cases, modes)."""
        rows = len(x)
        columns: dict[str, Floats] = {}
        for k, own in enumerate(self.at(dict(zip(self.names, self.from_x(x).T, strict=True)))):
            for name, value in own.items():
                column = columns.setdefault(name, np.empty((len(self.table.cases), rows)))
                column[k] = value
        mechanism = self.table.cases[0].mechanism
        cases, modes = self.table.frequencies.shape
        f = design_frequencies(
            designs(
                {name: column.ravel() for name, column in columns.items()},
                self.inertia,
                self.mirrored,
            ),
            self.model.elements if isinstance(self.model.elements, int) else None,
            beam=self.model.name,
            shear=dict(self.model.settings).get("shear", "cowper"),
            poisson=mechanism.limbs[0].rod.material.poisson,
            heading=heading(mechanism),
            modes=modes,
        )
        return np.asarray(f.reshape(cases, rows, modes).swapaxes(0, 1))

    def residuals(self, observed: Floats) -> Residuals:
        """Return what a fit minimises: weighted ln f - `observed`, (T, cases * modes).

        The fit's `owner` says which row of `observed` it is for; a single row serves all.
        """
        root = np.sqrt(self.table.weights)

        def residuals(x: Floats, owner: NDArray[np.intp]) -> Floats:
            own = observed if len(observed) == 1 else observed[owner]
            return np.asarray((np.log(self.frequencies(x)).reshape(len(x), -1) - own) * root)

        return residuals
