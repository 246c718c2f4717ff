"""The lines of a CalculiX input deck: nodes, elements, rigid bodies, springs and equations."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analytic.mechanism import Body, Material, Platform
from reference_models.protocol import ModelError

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Term = tuple[int, int, float]
"""A node, its freedom 1-3, and a factor."""

PER_LINE = 8
"""Numbers a data line; CalculiX reads 16."""
ROOM = "ROOM"
"""How the names end of springs without stiffness, which masses on rigid bodies need."""
ROUNDING = 1e-12
"""Factors of an equation below this part of its largest are rounding."""


@dataclass(frozen=True)
class Frame:
    """A rigid body in the deck, at a point of it in global axes [m].

    Attributes: the nodes that carry its displacement at `at` and its rotation; 0: the ground.
    """

    place: int
    turn: int
    at: Array


class Writer:
    """Numbers nodes and elements, and collects the lines of a deck."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.nodes = 0
        self.elements = 0
        self.equations: list[list[Term]] = []
        self.joints: list[tuple[int, int, Array]] = []
        self.coordinates = 0

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

    def add_rigid(self, name: str, points: Indices, at: Array) -> Frame:
        """Make `points` one rigid body moving with new nodes at `at`.

        The first holds displacement at `at`, the second rotation, both in degrees of freedom 1-3.
        """
        reference, rotation = self.add_nodes(np.array([at, at])).tolist()
        self.add_set(name, points.tolist())
        self.lines.append(f"*RIGID BODY,NSET={name},REF NODE={reference},ROT NODE={rotation}")
        return Frame(reference, rotation, at)

    def add_masses(self, name: str, body: Body | Platform, at: Array, axes: Array) -> Indices:
        """Write six equal masses that together are a body in `axes` (3, 3); return their nodes.

        CalculiX makes no room in its matrices for masses that a rigid body carries, and from 2.21
        on ends there. It does for springs, so each mass has one of no stiffness.
        """
        mass, places = point_masses(body)
        nodes = self.add_nodes(at + places @ axes.T)
        self.add_elements("MASS", name, nodes[:, None])
        self.lines += [f"*MASS,ELSET={name}", real(mass)]
        self.add_elements("SPRING1", name + ROOM, nodes[:, None])
        self.lines += [f"*SPRING,ELSET={name}{ROOM}", "1", real(0.0)]
        return nodes

    def add_equation(self, *terms: Term) -> None:
        """Demand that the sum of factor x freedom over (node, freedom, factor) is zero."""
        size = max(abs(factor) for *_, factor in terms)
        some = [term for term in terms if term[0] and abs(term[2]) > ROUNDING * size]
        self.equations.append(some)
        if len(some) == 1:
            ((node, freedom, _),) = some
            self.lines += ["*BOUNDARY", f"{node},{freedom},{freedom}"]
            return
        self.lines += ["*EQUATION", str(len(some))]
        self.lines += [f"{node},{freedom},{real(factor)}" for node, freedom, factor in some]

    def add_freedoms(self, name: str, at: Array, stiffness: list[float]) -> list[tuple[int, int]]:
        """Write a coordinate for each of a joint's freedoms; return their nodes and freedoms."""
        rows = -(-len(stiffness) // 3)
        nodes = self.add_nodes(np.tile(at, (rows, 1)))
        found = [(int(nodes[j // 3]), j % 3 + 1) for j in range(3 * rows)]
        for j, (node, freedom) in enumerate(found):
            if j >= len(stiffness):
                self.lines += ["*BOUNDARY", f"{node},{freedom},{freedom}"]
            elif stiffness[j]:
                spring = f"{name}F{j}"
                self.add_elements("SPRING1", spring, np.array([[node]]))
                self.lines += [f"*SPRING,ELSET={spring}", str(freedom), real(stiffness[j])]
        self.coordinates += len(stiffness)
        return found[: len(stiffness)]


def material_lines(name: str, material: Material) -> list[str]:
    """Return the lines that make the elements of the set `name` of a material."""
    return [
        f"*MATERIAL,NAME={name}",
        "*ELASTIC",
        f"{real(material.young)},{real(material.poisson)}",
        "*DENSITY",
        real(material.density),
        f"*SOLID SECTION,ELSET={name},MATERIAL={name}",
    ]


def point_masses(body: Body | Platform) -> tuple[float, Array]:
    """Return the mass of each of six points, and where they are in the body's axes, (6, 3) [m].

    The inertia J has second moments S = tr(J) / 2 - J; with principal axes v_k the points lie at
    +-sqrt(3 S_k / m) v_k.
    """
    J = np.array(body.inertia)
    S, axes = np.linalg.eigh(np.trace(J) / 2 * np.eye(3) - J)
    if S[0] < -1e-12 * S[2]:
        raise ModelError(
            "calculix-solid: bodies are made of point masses, and none have this inertia: "
            "one principal moment exceeds the sum of the other two"
        )
    arms = (axes * np.sqrt(3 * np.maximum(S, 0.0) / body.mass)).T
    return body.mass / 6, np.array(body.centre) + np.concatenate([arms, -arms])


def real(value: float) -> str:
    """Return a number in at most 20 characters, all that CalculiX reads of one."""
    return f"{value:.12E}"


def wrapped(numbers: list[int]) -> list[str]:
    """Return data lines of a few numbers each; all but the last end in a comma."""
    rows = [numbers[i : i + PER_LINE] for i in range(0, len(numbers), PER_LINE)]
    return [",".join(map(str, row)) + ("," if row is not rows[-1] else "") for row in rows]
