"""The manipulator as a CalculiX input deck: solid rods, rigid end faces and platform, joints."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analytic.mechanism import Material, Mechanism, Platform
from analytic.modes import STATIONS, check_count
from analytic.pose import Pose
from reference_models.exudyn.system import Axis, rod_axes
from reference_models.placement import place
from reference_models.protocol import ModelError
from reference_models.solid.rod_mesh import RodMesh

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

PER_LINE = 8
"""Numbers a data line; CalculiX reads 16."""


@dataclass(frozen=True)
class Line:
    """One rod in the deck.

    Attributes: `anchor` and `tip`: the reference nodes of its end faces, at B_i and A_i; `weights`
    (11, 20) of the motion of the nodes numbered `nodes` that give its centre line's at `STATIONS`;
    `coordinates` left free by its rigid faces and revolute joint, without those of its tip's
    displacement, which is the platform's.
    """

    anchor: int
    tip: int
    nodes: Indices
    weights: Array
    coordinates: int


@dataclass(frozen=True)
class Deck:
    """An input deck, and which of its nodes answer.

    Attributes: `text` of the deck; `platform`: the nodes that carry the platform's displacement at
    o and its rotation; `held`: its nodes at the A_i (n,); `rods`, one a limb; `shown`: all nodes
    whose displacement is asked for, ascending.
    """

    text: str
    platform: tuple[int, int]
    held: Indices
    rods: list[Line]
    shown: Indices

    def points(self) -> Array:
        """Return the nodes as written, read back from the text: (N, 3) [m], node n at n - 1."""
        blocks = self.text.split("*NODE\n")[1:]
        rows = [row for block in blocks for row in block.split("*")[0].splitlines()]
        table = np.array([row.split(",") for row in rows], dtype=float)
        return table[np.argsort(table[:, 0]), 1:]


class Writer:
    """Numbers nodes and elements, and collects the lines of a deck."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.nodes = 0
        self.elements = 0

    def add_nodes(self, points: Array) -> Indices:
        """Write nodes at global `points` (k, 3) [m]; return their numbers."""
        numbers = self.nodes + 1 + np.arange(len(points))
        self.nodes += len(points)
        self.lines.append("*NODE")
        self.lines += [
            f"{n},{','.join(map(real, p))}" for n, p in zip(numbers, points, strict=True)
        ]
        return numbers

    def add_elements(self, kind: str, name: str, of: Indices) -> None:
        """Write elements of `kind` on the nodes `of` (k, nodes an element), as the set `name`."""
        self.lines.append(f"*ELEMENT,TYPE={kind},ELSET={name}")
        for nodes in of:
            self.elements += 1
            self.lines += wrapped([self.elements, *nodes.tolist()])

    def add_set(self, name: str, nodes: Iterable[int]) -> None:
        """Write a set of nodes."""
        self.lines.append(f"*NSET,NSET={name}")
        self.lines += [f"{n}," for n in nodes]

    def add_rigid(self, name: str, points: Indices, at: Array) -> tuple[int, int]:
        """Make `points` one rigid body moving with new nodes at `at`; return both.

        The first holds displacement at `at`, the second rotation, both in degrees of freedom 1-3.
        """
        reference, rotation = self.add_nodes(np.array([at, at])).tolist()
        self.add_set(name, points.tolist())
        self.lines.append(f"*RIGID BODY,NSET={name},REF NODE={reference},ROT NODE={rotation}")
        return reference, rotation

    def add_equation(self, *terms: tuple[int, int, float]) -> None:
        """Demand that the sum of factor x freedom over (node, freedom, factor) is zero."""
        self.lines += ["*EQUATION", str(len(terms))]
        self.lines += [f"{node},{freedom},{real(factor)}" for node, freedom, factor in terms]


def write(
    mechanism: Mechanism, pose: Pose, mesh: Callable[[Axis], RodMesh], kind: str, count: int
) -> Deck:
    """Return the deck for the `count` lowest modes, of elements of type `kind` on a rod's `mesh`.

    Raises `InputError` for a pose out of reach or more modes than coordinates, and `ModelError`
    for a platform whose inertia no body has.
    """
    placed = place(mechanism, pose)
    o, R = placed.centre, placed.rotation
    deck = Writer()
    rods = [
        _add_rod(deck, f"ROD{i}", axis, mesh(axis), kind)
        for i, axis in enumerate(rod_axes(mechanism, placed))
    ]
    # The platform's six coordinates beside those of the rods.
    check_count(count, 6 + sum(rod.coordinates for rod in rods))
    mass, places = _point_masses(mechanism.platform)
    held = deck.add_nodes(o + np.array([limb.platform_point for limb in mechanism.limbs]) @ R.T)
    masses = deck.add_nodes(o + places @ R.T)
    deck.add_elements("MASS", "MASSES", masses[:, None])
    deck.lines += ["*MASS,ELSET=MASSES", real(mass)]
    platform = deck.add_rigid("PLATFORM", np.concatenate([held, masses]), o)
    for rod, point in zip(rods, held.tolist(), strict=True):
        for freedom in (1, 2, 3):
            deck.add_equation((rod.tip, freedom, 1.0), (point, freedom, -1.0))
    ends = [node for rod in rods for node in (rod.anchor, rod.tip)]
    lines = [node for rod in rods for node in rod.nodes.ravel().tolist()]
    shown = sorted({*lines, *ends, *platform, *held.tolist()})
    deck.add_set("SHOWN", shown)
    deck.lines += ["*STEP", "*FREQUENCY", str(count), "*NODE PRINT,NSET=SHOWN", "U", "*END STEP"]
    return Deck("\n".join([*deck.lines, ""]), platform, held, rods, np.array(shown))


def _add_rod(deck: Writer, name: str, axis: Axis, mesh: RodMesh, kind: str) -> Line:
    """Write one rod, its rigid end faces and its revolute joint."""
    along, about, across = axis.frame.T
    numbers = deck.add_nodes(axis.base + mesh.nodes @ np.stack([about, across, along]))
    deck.add_elements(kind, name, numbers[mesh.elements])
    deck.lines += _material(name, axis.rod.material)
    anchor, turn = deck.add_rigid(f"{name}BASE", numbers[mesh.base], axis.base)
    tip, _ = deck.add_rigid(f"{name}TIP", numbers[mesh.tip], axis.tip)
    deck.lines += ["*BOUNDARY", f"{anchor},1,3"]
    # The base turns about the revolute axis e alone: each component follows the largest of e.
    largest = int(np.abs(about).argmax())
    for k in {0, 1, 2} - {largest}:
        factor = -about[k] / about[largest]
        deck.add_equation((turn, k + 1, 1.0), (turn, largest + 1, factor))
    nodes, weights = mesh.centre_line(STATIONS)
    inner = len(mesh.nodes) - len(mesh.base) - len(mesh.tip)
    return Line(anchor, tip, numbers[nodes], weights, 3 * inner + 1 + 3)


def _material(name: str, material: Material) -> list[str]:
    return [
        f"*MATERIAL,NAME={name}",
        "*ELASTIC",
        f"{real(material.young)},{real(material.poisson)}",
        "*DENSITY",
        real(material.density),
        f"*SOLID SECTION,ELSET={name},MATERIAL={name}",
    ]


def _point_masses(platform: Platform) -> tuple[float, Array]:
    """Return the mass of each of six points, and where they are in the moving frame, (6, 3) [m].

    The inertia J has second moments S = tr(J) / 2 - J; with principal axes v_k the points lie at
    +-sqrt(3 S_k / m) v_k.
    """
    J = np.array(platform.inertia)
    S, axes = np.linalg.eigh(np.trace(J) / 2 * np.eye(3) - J)
    if S[0] < -1e-12 * S[2]:
        raise ModelError(
            "calculix-solid: the platform is made of point masses, and none have this inertia: "
            "one principal moment exceeds the sum of the other two"
        )
    arms = (axes * np.sqrt(3 * np.maximum(S, 0.0) / platform.mass)).T
    return platform.mass / 6, np.concatenate([arms, -arms])


def real(value: float) -> str:
    """Return a number in at most 20 characters, all that CalculiX reads of one."""
    return f"{value:.12E}"


def wrapped(numbers: list[int]) -> list[str]:
    """Return data lines of a few numbers each; all but the last end in a comma."""
    rows = [numbers[i : i + PER_LINE] for i in range(0, len(numbers), PER_LINE)]
    return [",".join(map(str, row)) + ("," if row is not rows[-1] else "") for row in rows]
