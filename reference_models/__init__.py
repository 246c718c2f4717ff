"""Independent simulators behind one protocol: none shares the analytic model's code."""

from reference_models.protocol import (
    Info,
    ModelError,
    ReferenceModel,
    UnavailableError,
    catalogue,
    names,
    reference,
)
from reference_models.richardson import Richardson

__all__ = [
    "Info",
    "ModelError",
    "ReferenceModel",
    "Richardson",
    "UnavailableError",
    "catalogue",
    "names",
    "reference",
]
