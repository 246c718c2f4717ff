"""The deck of `calculix-solid` with comments, for anybody's ccx."""

from collections.abc import Iterator

from analytic.mechanism import Mechanism
from analytic.pose import Pose, one_pose
from reference_models.catalogue import Named
from reference_models.export import Export, about
from reference_models.solid.calculix import CalculixSolid
from reference_models.solid.calculix_deck import write
from reference_models.solid.calculix_run import NAME
from reference_models.solid.calculix_writer import ROOM

TOP = (
    "Run `ccx rps`: the frequencies [Hz] are in rps.dat, columns CYCLES/TIME.",
    "All but *RIGID BODY with a ROT NODE is common to CalculiX and Abaqus. For the latter give",
    "*RIGID BODY, TIE NSET=..., REF NODE=... and, for freedoms 1-3 of the ROT NODE, 4-6 of the",
    "reference node.",
)


def export(mechanism: Mechanism, pose: Pose, elements: int | None = None, count: int = 6) -> Export:
    """Return the deck `rps.inp`; raises as `calculix_deck.write`."""
    model = CalculixSolid() if elements is None else CalculixSolid(elements)
    one_pose(mechanism, pose)
    deck = write(mechanism, pose, model._mesh, model.element, count)
    named = Named(NAME, model.elements)
    top = [f"** {line}" for line in (*about(mechanism, pose, named), *TOP)]
    text = "\n".join([*top, *_commented(deck.text.splitlines()), ""])
    return Export({"rps.inp": text}, "ccx rps", named)


def _commented(lines: list[str]) -> Iterator[str]:
    """Yield the lines, a comment before each part."""
    for line in lines:
        head, _, rest = line.partition("NSET=")
        name = rest.partition(",")[0]
        number = int("".join(c for c in name.partition("I")[0] if c.isdigit()) or 0) + 1
        if line.startswith("*ELEMENT,TYPE=C3D20R"):
            yield f"** --- limb {number}: 20-node bricks with reduced integration"
        elif line.startswith("*ELEMENT,TYPE=SPRING1") and line.endswith(ROOM):
            yield "** They have no stiffness: CalculiX makes room in its matrices for springs only."
        elif line.startswith("*ELEMENT,TYPE=SPRING1"):
            yield "** A joint's freedom that something resists: a spring on its coordinate"
        elif head == "*RIGID BODY," and name.endswith("BASE"):
            yield f"** The face of limb {number}'s rod towards the base is rigid. REF NODE holds"
            yield "** its displacement, ROT NODE its rotation, in freedoms 1-3."
        elif head == "*RIGID BODY," and name.endswith("TIP"):
            yield f"** So is its face towards A_{number}. Joints are equations: what follows moves"
            yield "** as what it is joined to, but for coordinates of the joint's freedoms."
        elif head == "*RIGID BODY," and name.endswith("RIGID"):
            yield f"** A body of limb {number}, made of six masses"
        elif head == "*RIGID BODY,":
            yield "** --- the platform: the points A_i and six masses are one rigid body"
        elif line == "*ELEMENT,TYPE=MASS,ELSET=MASSES":
            yield "** Six equal masses that together have the platform's mass and inertia."
        elif line == "*STEP":
            yield "** --- the lowest modes"
        yield line
