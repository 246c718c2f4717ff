"""A table to be explained and a model with free parameters: what a fit minimises."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic import InputError
from analytic.designs import design_frequencies
from harness.bench import label
from harness.studies.identification.fit import Residuals
from harness.studies.identification.parameters import (
    INERTIAS,
    PARAMETERS,
    POSE,
    Parameter,
    designs,
    heading,
    starting_values,
)
from harness.studies.identification.table import FrequencyTable
from reference_models import Named

Floats = NDArray[np.float64]


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
    bounds: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    argument: str = "parameters"

    def __post_init__(self) -> None:
        cases = self.table.cases
        if self.model.info().limit != self.model.name:
            expected = "a beam theory, whose rods can be those of any mechanism"
            raise InputError("model", self.model.label, expected)
        if any(case.mechanism != cases[0].mechanism for case in cases):
            raise InputError("table", [c.name for c in cases], "cases of one mechanism")
        for name, x, low, high in zip(self.names, self.start, *self.limits, strict=True):
            if not low - 1e-12 <= x <= high + 1e-12 and name not in self.bounds:
                raise InputError(self.argument, name, "a starting value within default bounds")

    @property
    def theory(self) -> str:
        """Theory, elements and inertia of the model."""
        printed = "" if self.inertia == "disc" else f", {INERTIAS[self.inertia]}"
        return f"{label(self.model)}{printed}"

    @property
    def frames(self) -> str:
        """Whose frames these are: "stated" or "mirrored"."""
        return "mirrored" if self.mirrored else "stated"

    @property
    def label(self) -> str:
        """Theory, elements, inertia and frames of the model."""
        return self.theory + (", mirrored frames" if self.mirrored else "")

    @property
    def whole(self) -> bool:
        """Whether no parameter belongs to one case alone."""
        return not any("." in name for name in self.names)

    @cached_property
    def base(self) -> list[dict[str, float]]:
        """What each case starts from, in the units of the names."""
        return [starting_values(case) for case in self.table.cases]

    @cached_property
    def kinds(self) -> list[Parameter]:
        """What each of the names is."""
        return [PARAMETERS[name.rpartition(".")[2]] for name in self.names]

    @cached_property
    def angles(self) -> NDArray[np.bool_]:
        """Which of the names are angles, (P,)."""
        return np.array([kind.angle for kind in self.kinds], dtype=bool)

    @cached_property
    def owners(self) -> list[dict[str, str]]:
        """By which of the names each case knows the parameters that are fitted."""
        cases = self.table.cases
        known = [case.name for case in cases]
        found: list[dict[str, str]] = [{} for _ in cases]
        for name in sorted(self.names, key=lambda name: "." not in name):  # own ones first
            case, dot, own = name.rpartition(".")
            if own not in PARAMETERS or (dot and (own not in POSE or case not in known)):
                poses = ", ".join(f"{known[-1]}.{p}" for p in POSE)
                expected = f"one of {', '.join(PARAMETERS)}, or of one case as {poses}"
                raise InputError(self.argument, name, expected)
            for one, names in zip(cases, found, strict=True):
                level = PARAMETERS[own].angle and one.pose.tilt == 0
                if one.name == case or not (dot or level):
                    names.setdefault(own, name)
            if not any(name in names.values() for names in found):
                raise InputError(self.argument, name, "a case that this parameter is left for")
        return found

    def to_x(self, values: Floats) -> Floats:
        """Return x of values (..., P) in the units of the names."""
        return np.where(self.angles, values, np.log(np.where(self.angles, 1.0, values)))

    def from_x(self, x: Floats) -> Floats:
        """Return values (..., P), in the units of the names, of x."""
        return np.where(self.angles, x, np.exp(np.where(self.angles, 0.0, x)))

    @cached_property
    def given(self) -> Floats:
        """The values of the cases as they are, (P,)."""
        at = {
            name: base[own]
            for names, base in zip(self.owners[::-1], self.base[::-1], strict=True)
            for own, name in names.items()
        }
        return np.array([at[name] for name in self.names])

    @property
    def start(self) -> Floats:
        """The x of the cases as they are, (P,)."""
        return self.to_x(self.given)

    @cached_property
    def limits(self) -> tuple[Floats, Floats]:
        """Lower and upper bounds of x, (P,) each."""
        pairs = np.array([(kind.low, kind.high) for kind in self.kinds]).reshape(-1, 2)
        pairs[~self.angles] *= self.given[~self.angles, None]
        for name, pair in zip(self.names, pairs, strict=True):
            pair[:] = self.bounds.get(name, pair)
        low, high = self.to_x(pairs.T)
        return low, high

    def at(self, values: Mapping[str, Any]) -> list[dict[str, Any]]:
        """Return all parameters of each case, those that are fitted being `values` by name."""
        found = []
        for base, names in zip(self.base, self.owners, strict=True):
            given = {own: values[name] for own, name in names.items()}
            own = {**base, **given}
            # The disc ends where the joints are and is made of what the rods are made of.
            own["disc_radius_mm"] = given.get("disc_radius_mm", own["platform_radius_mm"])
            own["platform_density_kg_m3"] = given.get(
                "platform_density_kg_m3", own["density_kg_m3"]
            )
            found.append(own)
        return found

    def frequencies(self, x: Floats) -> Floats:
        """Return f [Hz] of all cases at x (M, P), shape (M, cases, modes)."""
        own = self.at(dict(zip(self.names, self.from_x(x).T, strict=True)))
        rows, (cases, modes) = len(x), self.table.frequencies.shape
        columns = {n: np.ravel([np.broadcast_to(p[n], rows) for p in own]) for n in PARAMETERS}
        mechanism = self.table.cases[0].mechanism
        f = design_frequencies(
            designs(columns, self.inertia, self.mirrored),
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
            logs = np.log(self.frequencies(x)).reshape(len(x), len(root))
            return np.asarray((logs - own) * root)

        return residuals
