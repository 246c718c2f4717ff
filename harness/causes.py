"""What tells the causes of an error apart: exact models from a theory's own to the richest."""

from itertools import pairwise

from analytic.model import Model
from reference_models import Named

THEORIES = ("euler-bernoulli", "rayleigh", "timoshenko")
"""Beam theories from the poorest to the richest; each adds one effect."""
EFFECTS = dict(zip(pairwise(THEORIES), ("rotary inertia", "shear"), strict=True))
"""What each theory adds to the one before it."""


def exact_chain(theory: Model) -> list[Named]:
    """Return the exact models from the theory's own limit to Timoshenko's; none without a limit.

    A shear coefficient that the theory was given stays.
    """
    limit = theory.limit()
    if not isinstance(limit, Named) or limit.name not in THEORIES:
        return []
    names = THEORIES[THEORIES.index(limit.name) :]
    shear = {**dict(limit.settings), **dict(getattr(theory, "settings", ()))}.get("shear")
    return [
        Named(name, None, (("shear", shear),) if shear is not None and name == THEORIES[-1] else ())
        for name in names
    ]


def effects(chain: list[Named]) -> list[str]:
    """Return what each model of an exact chain adds to the one before it."""
    return [EFFECTS[a.name, b.name] for a, b in pairwise(chain)]
