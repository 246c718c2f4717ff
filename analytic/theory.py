"""Which beam theory a model assumes, and the shear coefficient that goes with it."""

from dataclasses import dataclass

from analytic import __version__
from analytic.errors import InputError, number
from analytic.mechanism import Material, Mechanism, Rod
from analytic.model import Info

BEAMS = {
    "euler-bernoulli": "Euler-Bernoulli",
    "rayleigh": "Rayleigh",
    "timoshenko": "Timoshenko",
}
SHEAR_COEFFICIENTS = ("cowper", "0.9", "6/7")

LEAST_SHEAR = 1e-6
"""No section has a smaller shear coefficient, nor one above its inverse."""


@dataclass(frozen=True)
class Theory:
    """A beam theory: what a section may do, and what of it has inertia.

    `beam`: "euler-bernoulli" (no shear, no rotary inertia), "rayleigh" (rotary inertia) or
    "timoshenko" (both). `shear`: the shear coefficient kappa of a solid round section, "cowper"
    for 6 (1 + nu) / (7 + 6 nu), "0.9", "6/7" or any number above 0; only Timoshenko uses it.
    """

    beam: str = "euler-bernoulli"
    shear: str | float = "cowper"

    def __post_init__(self) -> None:
        if not isinstance(self.beam, str) or self.beam not in BEAMS:
            raise InputError("beam", self.beam, f"one of {', '.join(BEAMS)}")
        if isinstance(self.shear, str):
            if self.shear not in SHEAR_COEFFICIENTS:
                known = ", ".join(SHEAR_COEFFICIENTS)
                raise InputError("shear", self.shear, f"one of {known}, or a positive number")
        else:
            coefficient = number("shear", self.shear, "a positive shear coefficient", positive=True)
            if not LEAST_SHEAR <= coefficient <= 1 / LEAST_SHEAR:
                raise InputError("shear", self.shear, "a positive shear coefficient of about one")

    @property
    def rotary_inertia(self) -> bool:
        """Whether the sections' rotation has inertia."""
        return self.beam != "euler-bernoulli"

    def shear_coefficient(self, material: Material) -> float:
        """Return kappa for a solid round section of `material`."""
        if not isinstance(self.shear, str):
            return float(self.shear)
        if self.shear == "cowper":
            nu = material.poisson
            return 6 * (1 + nu) / (7 + 6 * nu)
        return {"0.9": 0.9, "6/7": 6 / 7}[self.shear]

    def shear_flexibility(self, rod: Rod) -> float:
        """Return 12 EI / (kappa G A) [m^2]: zero without shear deformation."""
        if self.beam != "timoshenko":
            return 0.0
        kappa = self.shear_coefficient(rod.material)
        return 12 * rod.material.young * rod.second_moment / (kappa * rod.material.shear * rod.area)

    def labels(self, mechanism: Mechanism) -> str:
        """Return the theory's name for the rods of `mechanism`, which may be of many materials."""
        materials = {rod.material for limb in mechanism.limbs for rod in limb.rods}
        return "; ".join(sorted(map(self.label, materials))) or "rigid limbs on springs"

    def label(self, material: Material) -> str:
        """Return the theory's name for a table, with kappa where it matters."""
        name = BEAMS[self.beam]
        if self.beam != "timoshenko":
            return name
        return f"{name}, kappa={self.shear_coefficient(material):.4g}"

    def info(self) -> Info:
        """Return what every analytic model of this theory is; its exact model bears its name."""
        name = BEAMS[self.beam]
        if self.beam == "timoshenko":
            name += f", kappa {'by Cowper' if self.shear == 'cowper' else f'= {self.shear}'}"
        return Info(
            theory=name,
            program="rps-bench",
            version=__version__,
            order=2 if self.beam == "timoshenko" else 4,
            refinements=None,
            ladder=(3, 4, 8, 16),
            limit=self.beam,
            isolated=False,
        )


class OfTheory:
    """A model whose rods obey the theory that its `beam` and `shear` choose (see `Theory`)."""

    beam: str
    shear: str | float

    def __post_init__(self) -> None:
        Theory(self.beam, self.shear)

    @property
    def theory(self) -> Theory:
        """The beam theory of the rods."""
        return Theory(self.beam, self.shear)

    def info(self) -> Info:
        """Return what the model is."""
        return self.theory.info()
