"""Analytic models by the names that a catalogue gives them."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from analytic.condensed_model import Condensed
from analytic.continuum import Continuum
from analytic.errors import InputError
from analytic.model import Info, Model
from analytic.multipliers import Multipliers
from analytic.substructure import Substructure


@dataclass(frozen=True)
class Maker:
    """Makes the models of one `name`.

    `build` makes one of `elements` a limb; `exact` the one without elements, where there is one;
    `settings`: what both take besides.
    """

    name: str
    settings: tuple[str, ...]
    build: Callable[..., Model]
    exact: Callable[..., Model] | None = None

    def __call__(self, elements: int | None = 3, **settings: Any) -> Model:
        """Return the model of `elements` a limb, or without elements for None.

        Raises `InputError` for settings that it does not have, or None where no exact model is.
        """
        unknown = [key for key in settings if key not in self.settings]
        if unknown:
            expected = f"only {', '.join(self.settings)}" if self.settings else "none"
            raise InputError(f"settings of {self.name}", unknown[0], expected)
        if elements is not None:
            return self.build(elements=elements, **settings)
        if self.exact is None:
            expected = f"elements a limb, for {self.name} has no exact model"
            raise InputError("elements", elements, expected)
        # Without elements there is one way to solve: none to choose.
        return self.exact(**{key: value for key, value in settings.items() if key != "solver"})

    def info(self) -> Info:
        """Return what the model is as it stands by default."""
        return self().info()


def _theory(beam: str) -> Maker:
    def build(**settings: Any) -> Model:
        return Substructure(beam=beam, **settings)

    def exact(**settings: Any) -> Model:
        return Continuum(beam=beam, **settings)

    own = ("shear", "solver") if beam == "timoshenko" else ("solver",)
    return Maker(beam, own, build, exact)


euler_bernoulli = _theory("euler-bernoulli")
rayleigh = _theory("rayleigh")
timoshenko = _theory("timoshenko")
multipliers = Maker("multipliers", ("base", "beam", "shear", "solver"), Multipliers)
condensed = Maker("condensed", ("beam", "fast", "shear"), Condensed, Condensed)
