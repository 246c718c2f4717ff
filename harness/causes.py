"""What tells the causes of an error apart: exact models from a theory's own to the richest."""

from analytic.model import Model
from reference_models import Named, accepted

THEORIES = ("euler-bernoulli", "rayleigh", "timoshenko")
"""Beam theories from the poorest to the richest; each adds one effect."""
RICHEST = Named(THEORIES[-1], None)
"""The exact model of the richest of them."""
EFFECTS = ("rotary inertia", "shear")
"""What each theory adds to the one before it."""


def exact(name: str, like: Model) -> Named:
    """Return the exact model of the theory `name`, with the shear coefficient that `like` has."""
    shear = [pair for pair in getattr(like, "settings", ()) if pair[0] == "shear"]
    return Named(name, None, tuple(shear) if "shear" in accepted(name) else ())


def exact_chain(theory: Model) -> list[Named]:
    """Return the exact models from the theory's own limit to Timoshenko's; none without a limit.

    A shear coefficient that the theory was given stays.
    """
    limit = theory.limit()
    if not isinstance(limit, Named) or limit.name not in THEORIES:
        return []
    return [exact(name, theory) for name in THEORIES[THEORIES.index(limit.name) :]]


def effects(chain: list[Named]) -> list[str]:
    """Return what each model of an exact chain adds to the one before it."""
    return list(EFFECTS[len(THEORIES) - len(chain) :])
