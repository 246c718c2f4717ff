"""The scripts of the Exudyn models: every call that the model makes, written down as it is made."""

from collections.abc import Callable
from typing import Any

import numpy as np

from analytic.mechanism import Mechanism
from analytic.modes import check_count
from analytic.pose import Pose, one_pose
from reference_models.catalogue import Named
from reference_models.export import Export, about
from reference_models.exudyn import beam, cable
from reference_models.exudyn.beam import ExudynBeam
from reference_models.exudyn.cable import ExudynCable
from reference_models.exudyn.system import Axis, Line, add_platform, add_spherical, rod_axes
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
        return f"np.zeros({value.shape})" if not value.size else f"np.array({written([*value])})"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(written, value))}]"
    if isinstance(value, np.generic):
        return repr(value.item())
    return repr(value)


def cables(mechanism: Mechanism, pose: Pose, elements: int | None = None, count: int = 6) -> Export:
    """Return the script of `exudyn-cable`."""
    model = ExudynCable() if elements is None else ExudynCable(elements)
    return _script(model._add_rod, Named(cable.NAME, model.elements), mechanism, pose, count)


def beams(mechanism: Mechanism, pose: Pose, elements: int | None = None, count: int = 6) -> Export:
    """Return the script of `exudyn-beam`."""
    model = ExudynBeam() if elements is None else ExudynBeam(elements)
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
    top = "\n".join([*about(mechanism, pose, named), "Run `python rps.py`: it prints hertz."])
    text = f'"""{top}\n"""\n{START}\n' + "\n".join(lines) + "\n" + END.format(count=count)
    return Export({"rps.py": text}, "python rps.py", named)
