"""The checks by name: pure functions from `Facts` to a `Finding`."""

from dataclasses import dataclass

from harness.claims import check_cost as cost
from harness.claims import check_elements as elements
from harness.claims import check_equations as equations
from harness.claims import check_frequencies as frequencies
from harness.claims import check_printed as printed
from harness.claims import check_workspace as workspace
from harness.claims.data import Check


@dataclass(frozen=True)
class Entry:
    """A check and the groups of `Facts` that it reads, besides what is printed."""

    function: Check
    groups: tuple[str, ...] = ()


BEAMS, EQUATIONS, SLENDER = ("beams",), ("equations",), ("slender",)
TIMES, FEA_TIMES, MAPS = ("times",), ("fea_times",), ("maps",)
ALL = ("beams", "fea", "solid")

CHECKS: dict[str, Entry] = {
    "three_prs": Entry(workspace.three_prs, BEAMS),
    "mobility": Entry(equations.mobility, EQUATIONS),
    "rotation": Entry(equations.rotation, EQUATIONS),
    "angles": Entry(equations.angles, EQUATIONS),
    "plane": Entry(equations.plane, EQUATIONS),
    "lengths": Entry(equations.lengths, EQUATIONS),
    "timoshenko_stiffness": Entry(elements.timoshenko_stiffness, SLENDER),
    "timoshenko_frequencies": Entry(elements.timoshenko_frequencies, SLENDER),
    "slender": Entry(elements.slender, SLENDER),
    "rod_size": Entry(equations.rod_size, EQUATIONS),
    "inertia": Entry(equations.inertia, (*BEAMS, *EQUATIONS)),
    "compatibility": Entry(equations.compatibility, EQUATIONS),
    "blocks": Entry(printed.blocks),
    "base_angles": Entry(equations.base_angles, EQUATIONS),
    "eq17": Entry(equations.eq17, EQUATIONS),
    "eq17_vertical": Entry(equations.eq17_vertical, EQUATIONS),
    "eq18": Entry(equations.eq18, EQUATIONS),
    "dimension": Entry(equations.dimension, EQUATIONS),
    "no_multipliers": Entry(equations.no_multipliers, EQUATIONS),
    "unknowns": Entry(equations.unknowns, EQUATIONS),
    "faster": Entry(cost.faster, TIMES),
    "theoretical": Entry(frequencies.theoretical, BEAMS),
    "fea": Entry(frequencies.fea, ALL),
    "error_follows": Entry(printed.error_follows),
    "error": Entry(frequencies.error, ALL),
    "fall": Entry(elements.fall, BEAMS),
    "few_elements": Entry(elements.few_elements, BEAMS),
    "largest_printed": Entry(printed.largest_printed),
    "largest_error": Entry(frequencies.largest_error, ALL),
    "f1_diameter": Entry(elements.f1_diameter, SLENDER),
    "repeated": Entry(elements.repeated, BEAMS),
    "height": Entry(workspace.height, BEAMS),
    "one_height": Entry(frequencies.one_height, BEAMS),
    "seconds": Entry(cost.seconds, FEA_TIMES),
    "saved_follows": Entry(cost.saved_follows),
    "saved": Entry(cost.saved, FEA_TIMES),
    "angle_limits": Entry(workspace.angle_limits, MAPS),
    "cone": Entry(workspace.cone, MAPS),
    "symmetry": Entry(workspace.symmetry, MAPS),
    "falls": Entry(workspace.falls, MAPS),
    "lowest_best": Entry(workspace.lowest_best, MAPS),
}
