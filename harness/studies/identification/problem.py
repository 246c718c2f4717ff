"""What a fit minimises: a table to be explained, and a model with free parameters.

Parameters are the numbers of a case, in the units of their names.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import hypot, pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic import InputError, Mechanism, Pose
from analytic.description import PRINTED, numbers, with_numbers
from analytic.designs import Designs, regular, varied_frequencies
from harness.bench import label
from harness.case import Case
from harness.signatures import Array
from harness.studies.identification.fit import Residuals
from harness.studies.identification.table import FrequencyTable
from reference_models import Named

FAR = 10.0
"""What a residual is, of ln f, where no such mechanism can be."""
UNITS = {
    "m": ("_mm", 1e-3), "rad": ("_deg", pi / 180), "Pa": ("_GPa", 1e9), "kg/m^3": ("_kg_m3", 1.0),
    "kg": ("_kg", 1.0), "kg m^2": ("_kg_m2", 1.0), "N/m": ("_N_m", 1.0),
    "N m/rad": ("_Nm_rad", 1.0),
}  # fmt: skip
"""Ends of names, and their SI values, by SI unit."""
INERTIAS = {"disc": "disc", "printed": PRINTED}
FOLLOWS = {"disc_radius_mm": "platform_radius_mm", "platform_density_kg_m3": "density_kg_m3"}
"""A disc ends where the joints are and is made of what the rods are made of, if it does at first
and nothing else is asked."""
LETTERS = {
    "z": "z", "azimuth": "phi", "tilt": "theta", "base_radius": "r1", "platform_radius": "r2",
    "disc_radius": "R", "platform_thickness": "h", "rod_diameter": "d", "young": "E",
    "density": "rho", "platform_density": "rho_p",
}  # fmt: skip
BOUNDS = {
    "z": (0.65, 1.6), "base_radius": (0.1, 2.0), "radius": (0.5, 2.0), "diameter": (0.6, 1.4),
    "bore": (0.6, 1.4), "length": (0.65, 1.6), "platform_density": (0.25, 4.0),
    "young": (0.5, 2.0), "density": (0.5, 2.0), "stiffness": (0.1, 10.0), "": (0.25, 4.0),
}  # fmt: skip
"""Default bounds as factors of what is given, by the ends of names; the first that fits."""
ANGLES = {"azimuth": 180.0, "tilt": 45.0, "torsion": 45.0}
"""Default bounds of angles [deg]: so far from zero, or from what is given if that is beyond."""
SIGNED = (*ANGLES, "x", "y")
"""What may be zero or change its sign."""
POSED = (*SIGNED, "z")
"""What is of a pose, which may be another in each case."""


@dataclass(frozen=True)
class Parameter:
    """A number of a case: its `value`, and default bounds, in the unit of its name.

    `name` without that unit, whose SI value is `si`. What is `linear` may be zero or change its
    sign, and is fitted itself instead of its logarithm.
    """

    name: str
    value: float
    low: float
    high: float
    linear: bool
    si: float


def split(name: str) -> tuple[str, str]:
    """Return a parameter's name without its unit, and that as text."""
    end = next(end for end, _ in UNITS.values() if name.endswith(end))
    return name.removesuffix(end), end[1:].replace("_", "/")


def letter(name: str) -> str:
    """Return what a parameter is called in a product of powers."""
    own, _ = split(name)
    return LETTERS.get(own, own)


def parameters(case: Case) -> dict[str, Parameter]:
    """Return the numbers of a case by name with unit."""
    limbs = case.mechanism.limbs
    size = 500 * max(hypot(*limb.base) + hypot(*limb.platform_point) for limb in limbs)
    found = {}
    for name, number in numbers(case.mechanism, case.pose).items():
        end, si = UNITS[number.unit]
        value = number.value / si
        factors = next(pair for of, pair in BOUNDS.items() if name.endswith(of))
        low, high = sorted(factor * value for factor in factors)
        if name in SIGNED or not value:
            reach = ANGLES.get(name, size)
            middle = 0.0 if name in ANGLES and abs(value) <= reach else value
            low, high = middle - reach, middle + reach
        found[name + end] = Parameter(name, value, low, high, name in SIGNED or value <= 0, si)
    return found


def changes(known: Mapping[str, Parameter], values: Mapping[str, Any]) -> dict[str, Any]:
    """Return in SI, by their names in `numbers`, the `values` that are not as they were."""
    moved = {name: p for name, p in known.items() if np.any(values[name] != p.value)}
    return {p.name: values[name] * p.si for name, p in moved.items()}


def described(case: Case, values: Mapping[str, float], form: str | None) -> tuple[Mechanism, Pose]:
    """Return the mechanism and the pose of a case with its parameters changed to `values`.

    `form` of a disc as `with_numbers` takes it.
    """
    return with_numbers(case.mechanism, case.pose, changes(parameters(case), values), form)


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
    def form(self) -> str:
        """What is made of the platform's disc."""
        return INERTIAS[self.inertia]

    @property
    def theory(self) -> str:
        """Theory, elements and inertia of the model."""
        return label(self.model) + ("" if self.inertia == "disc" else f", {self.form}")

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
    def regular(self) -> bool:
        """Whether the mechanism is one of `Designs`, of which many are solved a call."""
        return all(c.pose.x is None and regular(c.mechanism) for c in self.table.cases)

    @cached_property
    def known(self) -> list[dict[str, Parameter]]:
        """The parameters of each case by name."""
        return [parameters(case) for case in self.table.cases]

    @cached_property
    def owners(self) -> list[dict[str, str]]:
        """By which of the names each case knows the parameters that are fitted."""
        cases = [case.name for case in self.table.cases]
        found: list[dict[str, str]] = [{} for _ in cases]
        for name in sorted(self.names, key=lambda name: "." not in name):  # own ones first
            case, dot, own = name.rpartition(".")
            known = self.known[0]
            if own not in known or (dot and not (known[own].name in POSED and case in cases)):
                poses = ", ".join(f"{cases[-1]}.{n}" for n, p in known.items() if p.name in POSED)
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
        each = zip(self.owners[::-1], self.known[::-1], strict=True)  # the first is the last word
        at = {name: known[own] for names, known in each for own, name in names.items()}
        return [at[name] for name in self.names]

    @cached_property
    def linear(self) -> NDArray[np.bool_]:
        """Which of the names are fitted themselves, (P,)."""
        return np.array([kind.linear for kind in self.kinds], dtype=bool)

    @property
    def given(self) -> Array:
        """The values of the cases as they are, (P,)."""
        return np.array([kind.value for kind in self.kinds])

    def to_x(self, values: Array) -> Array:
        """Return x of values (..., P) in the units of the names."""
        return np.log(values, out=np.array(values), where=~self.linear)

    def from_x(self, x: Array) -> Array:
        """Return values (..., P), in the units of the names, of x."""
        return np.exp(x, out=np.array(x), where=~self.linear)

    @property
    def start(self) -> Array:
        """The x of the cases as they are, (P,)."""
        return self.to_x(self.given)

    @cached_property
    def limits(self) -> tuple[Array, Array]:
        """Lower and upper bounds of x, (P,) each."""
        pairs = []
        for name, kind in zip(self.names, self.kinds, strict=True):
            pairs.append(self.bounds.get(name, (kind.low, kind.high)))
            if pairs[-1][0] <= 0 and not kind.linear:
                raise InputError("bounds", f"{name}={pairs[-1][0]:g}..", "bounds above 0")
        low, high = self.to_x(np.reshape(pairs, (-1, 2)).T)
        return low, high

    def at(self, values: Mapping[str, Any]) -> list[dict[str, Any]]:
        """Return all parameters of each case: those in `values` by name, else as they are."""
        found = []
        for known, names in zip(self.known, self.owners, strict=True):
            base = {name: p.value for name, p in known.items()}
            given = {own: values[name] for own, name in names.items() if name in values}
            own = {**base, **given}
            for name, leader in FOLLOWS.items():
                ends = base.get(name, np.nan), base.get(leader, np.nan)
                if name not in given and np.isclose(*ends, rtol=1e-9):
                    own[name] = own[leader]
            found.append(own)
        return found

    def frequencies(self, x: Array) -> Array:
        """Return f [Hz] of all cases at x (M, P), shape (M, cases, modes).

        NaN where there can be no such mechanism.
        """
        rows, (cases, modes), first = len(x), self.table.frequencies.shape, self.table.cases[0]
        at = self.at(dict(zip(self.names, self.from_x(x).T, strict=True)))
        columns = {n: np.ravel([np.broadcast_to(p[n], rows) for p in at]) for n in self.known[0]}
        f = varied_frequencies(
            first.mechanism,
            first.pose,
            changes(self.known[0], columns),
            self.model.elements if isinstance(self.model.elements, int) else None,
            beam=self.model.name,
            shear=dict(self.model.settings).get("shear", "cowper"),
            modes=modes,
            form=self.form,
            mirrored=self.mirrored,
        )
        f = np.broadcast_to(f, (cases * rows, modes))
        return f.reshape(cases, rows, modes).swapaxes(0, 1)

    def groups(self, values: Mapping[str, Any]) -> dict[str, Array]:
        """Return the combinations with a name, from values of all parameters or arrays of them."""
        si = {p.name: values[name] * p.si for name, p in self.known[0].items()}
        return Designs.of(si, self.form).groups

    def residuals(self, observed: Array) -> Residuals:
        """Return what a fit minimises: weighted ln f - `observed`, (T, cases * modes).

        The fit's `owner` says which row of `observed` it is for; a single row serves all.
        """
        root = np.sqrt(self.table.weights)
        for case in () if self.regular else self.table.cases:  # or it says why not, before any fit
            self.model.frequencies(case.mechanism, case.pose, self.table.frequencies.shape[1])

        def residuals(x: Array, owner: NDArray[np.intp]) -> Array:
            own = observed if len(observed) == 1 else observed[owner]
            logs = np.log(self.frequencies(x)).reshape(len(x), len(root))
            return np.nan_to_num(logs - own, nan=FAR) * root

        return residuals
