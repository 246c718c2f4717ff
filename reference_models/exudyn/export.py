"""The scripts of the Exudyn models: every call that the model makes, written down as it is made."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from analytic.mechanism import Mechanism
from analytic.modes import check_count
from analytic.pose import Pose, one_pose
from reference_models.catalogue import Named
from reference_models.chain_placement import stand
from reference_models.export import SOLVE, Export, about, shift_of
from reference_models.exudyn import beam, cable
from reference_models.exudyn.beam import ExudynBeam
from reference_models.exudyn.cable import ExudynCable
from reference_models.exudyn.chain import Built, rigid
from reference_models.exudyn.chain_beams import add_beams
from reference_models.exudyn.system import (
    Axis,
    Line,
    add_platform,
    add_rigid_nodes,
    add_spherical,
    rod_axes,
)
from reference_models.placement import place

START = """
import exudyn as exu
import numpy as np

items = exu.itemInterface
exu.config.printToConsole = False
exu.config.suppressWarnings = True  # of parameters' old names, which every version knows
SC = exu.SystemContainer()
mbs = SC.AddSystem()
"""
END = """
# --- the lowest modes: Exudyn projects on what the joints leave free
mbs.Assemble()
frequencies, _ = mbs.ComputeODE2Eigenvalues(convert2Frequencies=True)
print(*(f"{{f:.6f}}" for f in frequencies[:{count}]), sep="\\n")
SC.Reset()
"""
CHAIN_END = """
# --- the lowest modes, by Exudyn's own matrices and constraints
SPINS = {spins}  # limbs that may turn about themselves
mbs.Assemble()
M, K, _, J = mbs.ComputeLinearizedSystem(returnConstraintJacobian=True)
print(*(f"{{f:.9f}}" for f in lowest(M, K, J.T, {count}, {shift!r})), sep="\\n")
SC.Reset()
"""
SAID = {
    "GenericJoint": "a joint: 0 where it is free, of three shifts and three turns in its own axes",
    "RigidBodySpringDamper": "what resists those [N/m, N m/rad]",
    "NodeRigidBodyEP": "nodes of a rod, or of a body: place and Euler parameters",
    "ObjectBeamGeometricallyExact": "elements of the rod, sheared, with rotary inertia",
    "physicsMass=0.0": "bodies without mass by which joints hold the rod's ends",
    "MarkerBodyRigid": "where a joint takes hold",
    "ObjectGround": "the base, at B_i",
    "ObjectRigidBody": "a body",
    "BeamSection": "the rod's section: x along it, then y and minus x of its limb",
}
"""What stands above calls of a chain; the first that is in a line is said."""


class Section:
    """A beam section of the script: what is set of it is written."""

    _at: tuple[list[str], str]

    def __init__(self, lines: list[str], name: str) -> None:
        lines.append(f"{name} = exu.BeamSection()")
        object.__setattr__(self, "_at", (lines, name))

    def __repr__(self) -> str:
        return self._at[1]

    def __setattr__(self, name: str, value: Any) -> None:
        self._at[0].append(f"{self}.{name} = {written(value)}")


class Items:
    """Stands for `exudyn.itemInterface`: what it makes is the text of the call."""

    def __getattr__(self, kind: str) -> Callable[..., str]:
        def make(**given: Any) -> str:
            inside = ", ".join(f"{key}={written(value)}" for key, value in given.items())
            return f"items.{kind}({inside})"

        return make


class Exudyn:
    """Stands for the module, as far as it is used to build a system."""

    itemInterface = Items()  # noqa: N815  Exudyn's own name

    def __init__(self, lines: list[str]) -> None:
        self.lines, self.sections = lines, 0

    def BeamSection(self) -> Section:
        """Return a new section."""
        self.sections += 1
        return Section(self.lines, f"section{self.sections}")

    def __getattr__(self, name: str) -> Any:
        return self  # names of output variables, not used while building


class System:
    """Stands for a main system: writes what is added, and returns its number as Exudyn does."""

    def __init__(self, lines: list[str]) -> None:
        self.lines = lines
        self.numbers = {"Node": -1, "Object": -1, "Marker": -1}

    def _add(self, kind: str, item: str) -> int:
        self.numbers[kind] += 1
        self.lines.append(f"mbs.Add{kind}({item})  # {kind.lower()} {self.numbers[kind]}")
        return self.numbers[kind]

    def AddNode(self, item: str) -> int:
        """Write it; return its number."""
        return self._add("Node", item)

    def AddObject(self, item: str) -> int:
        """Write it; return its number."""
        return self._add("Object", item)

    def AddMarker(self, item: str) -> int:
        """Write it; return its number."""
        return self._add("Marker", item)


def written(value: Any) -> str:
    """Return the Python text of an argument, numbers to the last bit."""
    if isinstance(value, np.ndarray):
        return f"np.array({written(value.tolist())})" if value.size else f"np.zeros({value.shape})"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(written, value))}]"
    if isinstance(value, np.generic):
        return repr(value.item())
    return repr(value)


def cables(mechanism: Mechanism, pose: Pose, elements: int | None = None, count: int = 6) -> Export:
    """Return the script of `exudyn-cable`, or, for limbs of other chains, that of `exudyn-beam`."""
    if not mechanism.simple:
        return beams(mechanism, pose, elements, count)
    model = ExudynCable() if elements is None else ExudynCable(elements)
    return _script(model._add_rod, Named(cable.NAME, model.elements), mechanism, pose, count)


def beams(mechanism: Mechanism, pose: Pose, elements: int | None = None, count: int = 6) -> Export:
    """Return the script of `exudyn-beam`."""
    model = ExudynBeam() if elements is None else ExudynBeam(elements)
    if not mechanism.simple:
        return _chains(model, mechanism, pose, count)
    return _script(model._add_rod, Named(beam.NAME, model.elements), mechanism, pose, count)


def _script(
    add_rod: Callable[[Any, Any, Axis], Line],
    named: Named,
    mechanism: Mechanism,
    pose: Pose,
    count: int,
) -> Export:
    placed = place(mechanism, one_pose(mechanism, pose))
    assert isinstance(named.elements, int), "one mesh"
    check_count(count, 6 + 3 * len(mechanism.limbs) * named.elements)
    lines: list[str] = []
    exu, mbs, say = Exudyn(lines), System(lines), lines.append
    say("# --- the rigid platform, its centre of mass at o")
    _, body = add_platform(exu, mbs, mechanism.platform, placed.centre, placed.rotation)
    for i, (limb, axis) in enumerate(
        zip(mechanism.limbs, rod_axes(mechanism, placed), strict=True), start=1
    ):
        say(f"\n# --- limb {i}: nodes and elements of its rod, then the revolute joint at B_{i}")
        line = add_rod(exu, mbs, axis)
        say(f"# the spherical joint at A_{i}")
        add_spherical(exu, mbs, body, limb.platform_point, line.tip)
    return _written(mechanism, pose, named, START, lines, END.format(count=count))


def _chains(model: ExudynBeam, mechanism: Mechanism, pose: Pose, count: int) -> Export:
    o, R, limbs = stand(mechanism, one_pose(mechanism, pose))
    named = Named(beam.NAME, model.elements)
    lines: list[str] = []
    exu, mbs, say = Exudyn(lines), System(lines), lines.append
    say("# --- the rigid platform, its node at o")
    (node,) = add_rigid_nodes(exu, mbs, o[None], R)
    body = rigid(exu, mbs, node, mechanism.platform, np.eye(3))
    add: Any = partial(add_beams, model.elements, model._kappas)
    for limb in limbs:
        own: list[str] = []
        exu.lines = mbs.lines = own
        add(exu, mbs, limb, body, R, Built())
        lines += [f"\n# --- limb {limb.number}: {limb.limb.described}", *_commented(own)]
    spins = sum(limb.may_spin for limb in limbs)
    end = CHAIN_END.format(count=count, spins=spins, shift=shift_of(limbs))
    return _written(mechanism, pose, named, START + SOLVE, lines, end)


def _commented(lines: list[str]) -> Iterator[str]:
    """Yield the lines of a limb, a comment above each run of equal calls."""
    before = ""
    for line in lines:
        kind = next((kind for kind in SAID if kind in line), before)
        if kind != before:
            yield f"# {SAID[kind]}"
        before = kind
        yield line


def _written(
    mechanism: Mechanism, pose: Pose, named: Named, start: str, lines: list[str], end: str
) -> Export:
    top = "\n".join([*about(mechanism, pose, named), "Run `python rps.py`: it prints hertz."])
    text = f'"""{top}\n"""\n{start}\n' + "\n".join(lines) + "\n" + end
    return Export({"rps.py": text}, "python rps.py", named)
