"""Independent simulators behind one protocol: none shares the analytic model's code."""

from analytic.model import Info, Model
from reference_models.catalogue import Named, accepted, catalogue, names, parse, reference
from reference_models.protocol import ModelError, UnavailableError
from reference_models.richardson import Richardson

__all__ = [
    "Info",
    "Model",
    "ModelError",
    "Named",
    "Richardson",
    "UnavailableError",
    "accepted",
    "catalogue",
    "names",
    "parse",
    "reference",
]
