"""What is asked for where nothing is said: cases, models and modes by name."""

from collections.abc import Iterable
from dataclasses import replace

from reference_models import Named

PAPER_CASES = "case1,case2"
PAPER_ELEMENTS = 3
"""What the paper settles on, Section 3.3."""
STAND_IN = "exudyn-beam"
"""The reference that stands for the paper's ANSYS: sheared beams between ideal joints."""
USUAL = (STAND_IN, "exudyn-cable", "exudyn-ffrf", "mujoco-composite", "mujoco-cable",
         "mujoco-chain", "calculix-solid", "ngsolve-solid", "ngsolve-averaged")  # fmt: skip
"""The order in which references stand in tables; others follow."""
TABLE_ONE = (STAND_IN, "exudyn-cable", "exudyn-ffrf", "mujoco-composite", "mujoco-cable",
             "calculix-solid", "ngsolve-solid")  # fmt: skip
"""References of Table I where none are named: one of each kind, on meshes that are `quick`."""
QUICKEST = (STAND_IN, "exudyn-cable", "mujoco-composite", "mujoco-cable")
"""Those that answer within a second."""
SOLIDS = ("calculix-solid", "ngsolve-solid")
"""What can stand for three-dimensional truth, the first that can run here."""
LIMB_SOLIDS = ("ngsolve-solid", "calculix-solid")
"""The same, the quickest first: it reduces each limb by itself."""
QUICK = {"calculix-solid": (4, 8), "exudyn-ffrf": (1, 2)}
"""Meshes that take less time than a model's own two; their uncertainty says what that costs."""
GATE_MAP = (
    Named("timoshenko", None), Named("euler-bernoulli", 3), Named("exudyn-cable", 8),
    Named("exudyn-beam", 12), Named("mujoco-cable", 8), Named("condensed", 3),
    Named("condensed", None),
)  # fmt: skip
"""What the gate solves at every pose of its map of the workspace."""
GATE_MORE = (Named("multipliers", 3), Named("condensed", 3), Named("condensed", None))
"""What the gate solves at its cases beside ladders, exact models and extrapolated ones."""
PAPER_MODEL = Named("euler-bernoulli", PAPER_ELEMENTS)
TWINS = (
    (PAPER_MODEL, Named("euler-bernoulli", 3, (("solver", "sparse"),))),
    (PAPER_MODEL, Named("multipliers", 3)),
    (PAPER_MODEL, Named("multipliers", 3, (("solver", "saddle-point"),))),
    (PAPER_MODEL, Named("condensed", 3)),
    (Named("euler-bernoulli", None), Named("condensed", None)),
)
"""The same equations, put together or solved in another way: equal but for rounding."""
CONFORMING = ("euler-bernoulli", "rayleigh", "multipliers")
"""Models whose elements can only stiffen: none of their frequencies is below the exact one."""
DEFAULTS = {"references": STAND_IN, "modes": "1-6"}
"""Texts of arguments that are left out."""


def quick(solid: Named) -> Named:
    """Return a model on the coarser meshes of `QUICK`, if it has some there."""
    return replace(solid, elements=QUICK.get(solid.name, solid.elements))


def solid_truth(names: Iterable[str] = SOLIDS) -> Named | None:
    """Return the first solid of `names` that can run here, extrapolated; None where none can."""
    for name in names:
        info = Named(name, None).info()
        if not info.missing:
            return Named(name, info.refinements)
    return None


def in_usual_order(names: Iterable[str]) -> list[str]:
    """Return names of models as tables list them: the usual ones first, then others by name."""
    return sorted(names, key=lambda name: (name not in USUAL, (*USUAL, name).index(name), name))
