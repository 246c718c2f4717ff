"""A table to be explained and a model with free parameters: what a fit minimises."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic import InputError
from analytic.designs import Designs, regular, varied_frequencies
from harness.bench import label
from harness.studies.identification.fit import Residuals
from harness.studies.identification.parameters import (
    FOLLOWS,
    INERTIAS,
    Parameter,
    changes,
    parameters,
)
from harness.studies.identification.table import FrequencyTable
from reference_models import Named

Floats = NDArray[np.float64]
FAR = 10.0
"""What a residual is, of ln f, where no such mechanism can be."""


@dataclass(frozen=True)
class Problem:
    """A table, a model, and the `names` of parameters that may be fitted to it.

    A name may be prefixed by a case, as in case2.z_mm; else all cases share the parameter, azimuth
    and tilt those cases that are tilted. `model` is a theory with its elements, `inertia` "disc"
    or "printed" (Eq. 8), `mirrored` as in `Designs`: both only of limbs that are `regular`;
    `bounds` override the default ones, in the units of the names; `argument` is named where a name
    is refused. Parameters are handled as x: the logarithm of the value, or what is `linear` itself.
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
        if any(known.keys() != self.known[0].keys() for known in self.known):
            raise InputError("table", [c.name for c in cases], "x and y in all poses, or in none")
        for name, given in (("frames", self.frames), ("inertia", self.inertia)):
            if given not in ("stated", "disc") and not self.regular:
                expected = "three equal R-P-S limbs and a disc for such a slip"
                raise InputError(name, given, expected)
        assert len(self.limits) == 2, "names and bounds are refused here"

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

    @property
    def named(self) -> bool:
        """Whether combinations of its parameters have names."""
        return self.whole and self.regular

    @cached_property
    def regular(self) -> bool:
        """Whether the mechanism is one of `Designs`, of which many are solved a call."""
        return all(c.pose.x is None and regular(c.mechanism) for c in self.table.cases)

    @cached_property
    def known(self) -> list[dict[str, Parameter]]:
        """The parameters of each case by name."""
        return [parameters(case) for case in self.table.cases]

    @property
    def base(self) -> list[dict[str, float]]:
        """What each case starts from, in the units of the names."""
        return [{name: p.value for name, p in known.items()} for known in self.known]

    @cached_property
    def owners(self) -> list[dict[str, str]]:
        """By which of the names each case knows the parameters that are fitted."""
        cases = [case.name for case in self.table.cases]
        found: list[dict[str, str]] = [{} for _ in cases]
        for name in sorted(self.names, key=lambda name: "." not in name):  # own ones first
            case, dot, own = name.rpartition(".")
            known = self.known[0]
            if own not in known or (dot and not (known[own].posed and case in cases)):
                poses = ", ".join(f"{cases[-1]}.{n}" for n, p in known.items() if p.posed)
                expected = f"one of {', '.join(known)}, or of one case as {poses}"
                raise InputError(self.argument, name, expected)
            for one, names in zip(self.table.cases, found, strict=True):
                level = own in ("azimuth_deg", "tilt_deg") and one.pose.tilt == 0
                if one.name == case or not (dot or level):
                    names.setdefault(own, name)
            if not any(name in names.values() for names in found):
                raise InputError(self.argument, name, "a case that this parameter is left for")
        return found

    @cached_property
    def kinds(self) -> list[Parameter]:
        """What each of the names is, in the first case that has it."""
        at = {
            name: known[own]
            for names, known in zip(self.owners[::-1], self.known[::-1], strict=True)
            for own, name in names.items()
        }
        return [at[name] for name in self.names]

    @cached_property
    def linear(self) -> NDArray[np.bool_]:
        """Which of the names are fitted themselves, (P,)."""
        return np.array([kind.linear for kind in self.kinds], dtype=bool)

    @property
    def given(self) -> Floats:
        """The values of the cases as they are, (P,)."""
        return np.array([kind.value for kind in self.kinds])

    def to_x(self, values: Floats) -> Floats:
        """Return x of values (..., P) in the units of the names."""
        return np.where(self.linear, values, np.log(np.where(self.linear, 1.0, values)))

    def from_x(self, x: Floats) -> Floats:
        """Return values (..., P), in the units of the names, of x."""
        return np.where(self.linear, x, np.exp(np.where(self.linear, 0.0, x)))

    @property
    def start(self) -> Floats:
        """The x of the cases as they are, (P,)."""
        return self.to_x(self.given)

    @cached_property
    def limits(self) -> tuple[Floats, Floats]:
        """Lower and upper bounds of x, (P,) each."""
        pairs = []
        for name, kind in zip(self.names, self.kinds, strict=True):
            pairs.append(self.bounds.get(name, (kind.low, kind.high)))
            if pairs[-1][0] <= 0 and not kind.linear:
                raise InputError("bounds", f"{name}={pairs[-1][0]:g}..", "bounds above 0")
        low, high = self.to_x(np.reshape(pairs, (-1, 2)).T)
        return low, high

    def at(self, values: Mapping[str, Any]) -> list[dict[str, Any]]:
        """Return all parameters of each case, those that are fitted being `values` by name."""
        found = []
        for base, names in zip(self.base, self.owners, strict=True):
            given = {own: values[name] for own, name in names.items()}
            own = {**base, **given}
            for name, leader in FOLLOWS.items():
                both = name in base and leader in base and name not in given
                if both and np.isclose(base[name], base[leader], rtol=1e-9):
                    own[name] = own[leader]
            found.append(own)
        return found

    def frequencies(self, x: Floats) -> Floats:
        """Return f [Hz] of all cases at x (M, P), shape (M, cases, modes).

        NaN where there can be no such mechanism.
        """
        rows, (cases, modes) = len(x), self.table.frequencies.shape
        at = self.at(dict(zip(self.names, self.from_x(x).T, strict=True)))
        columns = {n: np.ravel([np.broadcast_to(p[n], rows) for p in at]) for n in self.known[0]}
        f = varied_frequencies(
            self.table.cases[0].mechanism,
            self.table.cases[0].pose,
            changes(self.known[0], columns),
            self.model.elements if isinstance(self.model.elements, int) else None,
            beam=self.model.name,
            shear=dict(self.model.settings).get("shear", "cowper"),
            modes=modes,
            form=INERTIAS[self.inertia],
            mirrored=self.mirrored,
        )
        f = np.broadcast_to(f, (cases * rows, modes))
        return f.reshape(cases, rows, modes).swapaxes(0, 1)

    def groups(self, values: Mapping[str, Any]) -> dict[str, Floats]:
        """Return the combinations with a name, from values of all parameters or arrays of them."""
        si = {p.name: values[name] * p.si for name, p in self.known[0].items()}
        return Designs.of(si, INERTIAS[self.inertia]).groups

    def residuals(self, observed: Floats) -> Residuals:
        """Return what a fit minimises: weighted ln f - `observed`, (T, cases * modes).

        The fit's `owner` says which row of `observed` it is for; a single row serves all.
        """
        root = np.sqrt(self.table.weights)
        for case, row in zip(self.table.cases, self.table.frequencies, strict=True):
            if not self.regular:  # or it says why not, before any fit
                self.model.frequencies(case.mechanism, case.pose, len(row))

        def residuals(x: Floats, owner: NDArray[np.intp]) -> Floats:
            own = observed if len(observed) == 1 else observed[owner]
            logs = np.log(self.frequencies(x)).reshape(len(x), len(root))
            return np.asarray(np.nan_to_num(logs - own, nan=FAR) * root)

        return residuals
