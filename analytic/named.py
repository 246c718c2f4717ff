"""Analytic models by the names that a catalogue gives them."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from analytic.condensed import Condensed
from analytic.continuum import Continuum
from analytic.errors import InputError
from analytic.model import Info, Model
from analytic.multipliers import Multipliers
from analytic.substructure import Substructure


@dataclass(frozen=True)
class Named:
    """A way to make the models of one `name`.

    `build` makes one of `elements` a limb; `exact` the one without elements, where there is one.
    """

    name: str
    build: Callable[..., Model]
    exact: Callable[..., Model] | None = None

    def __call__(self, elements: int | None = 3, **settings: Any) -> Model:
        """Return the model of `elements` a limb, or without elements for None.

        Raises `InputError` for settings that it does not have, or None where no exact model is.
        """
        try:
            if elements is not None:
                return self.build(elements=elements, **settings)
            if self.exact is not None:
                return self.exact(**settings)
        except TypeError as error:
            raise InputError("settings", settings, f"settings of {self.name} ({error})") from None
        raise InputError(
            "elements", elements, f"elements a limb, for {self.name} has no exact model"
        )

    def info(self) -> Info:
        """Return what the model is as it stands by default."""
        return self().info()


def _theory(beam: str) -> Named:
    def build(**settings: Any) -> Model:
        return Substructure(beam=beam, **settings)

    def exact(**settings: Any) -> Model:
        return Continuum(beam=beam, **settings)

    return Named(beam, build, exact)


euler_bernoulli = _theory("euler-bernoulli")
rayleigh = _theory("rayleigh")
timoshenko = _theory("timoshenko")
multipliers = Named("multipliers", Multipliers)
condensed = Named("condensed", Condensed, Condensed)
