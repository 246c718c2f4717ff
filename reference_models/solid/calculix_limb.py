"""One limb in a CalculiX deck: its rods' bricks and rigid faces, its bodies and joints.

Between two rigid bodies that follow each other, whatever joints and links are there, the motion of
one is that of the other, carried, and a twist for each freedom: u = u_before + E q. The q are
coordinates of nodes of their own, on springs where something resists.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analytic.errors import RefusedError
from analytic.mechanism import Body, Item, Joint, Rod
from analytic.modes import STATIONS
from reference_models.chain_placement import Standing
from reference_models.solid.calculix_writer import Frame, Term, Writer, material_lines
from reference_models.solid.rod_mesh import RodMesh

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Line:
    """Part of a limb's centre line: the motion at `stations` of `STATIONS`.

    `weights` (k, c) of the motion of `nodes` (k, c), and of what a rotation `turn` adds to points
    `beyond` (k, 3) away [m].
    """

    stations: Indices
    nodes: Indices
    weights: Array
    turn: int = 0
    beyond: Array | None = None


@dataclass(frozen=True)
class _Rod:
    """A rod in the deck: where it begins and ends along its limb [m], its faces and mesh."""

    begin: float
    end: float
    faces: tuple[Frame, Frame]
    mesh: RodMesh
    numbers: Indices


def add_limb(
    deck: Writer,
    limb: Standing,
    R: Array,
    platform: Frame,
    mesh: Callable[[Rod, float], RodMesh],
    kind: str,
) -> list[Line]:
    """Write a limb of elements of type `kind`, joined to the ground and to the `platform` at A_i.

    Returns its centre line. Raises `InputError` naming the limb for one without rods, or a rod that
    is not round.
    """
    chain = limb.limb.chain
    rods: dict[int, _Rod] = {
        k: _add_rod(deck, limb, k, item, mesh, kind)
        for k, item in enumerate(chain)
        if isinstance(item, Rod)
    }
    if not rods:
        found = f"limb {limb.number}, {limb.limb.described}"
        raise RefusedError("mechanism", found, "a rod in every limb for calculix-solid")
    last = max(rods)
    # From the base to the last rod everything follows what is before it, after that what is next.
    before, waiting = Frame(0, 0, limb.starts[0]), list[int]()
    for k, item in enumerate(chain[: last + 1]):
        if isinstance(item, (Rod, Body)):
            first = rods[k].faces[0] if isinstance(item, Rod) else _add_body(deck, limb, k, item)
            _join(deck, limb, R, waiting, first, before)
            before, waiting = (rods[k].faces[1] if isinstance(item, Rod) else first), []
            deck.coordinates += 6 if isinstance(item, Rod) and k < last else 0
        else:
            waiting.append(k)
    after, waiting = platform, []
    for k in range(len(chain) - 1, last, -1):
        item = chain[k]
        if isinstance(item, Body):
            body = _add_body(deck, limb, k, item)
            _join(deck, limb, R, waiting, body, after)
            after, waiting = body, []
        else:
            waiting.append(k)
    _join(deck, limb, R, waiting, rods[last].faces[1], after)
    return _centre_line(limb, list(rods.values()))


def _add_rod(
    deck: Writer,
    limb: Standing,
    k: int,
    rod: Rod,
    make: Callable[[Rod, float], RodMesh],
    kind: str,
) -> _Rod:
    """Write a rod and its rigid end faces."""
    if rod.section.diameter is None:
        found = f"limb {limb.number}, {limb.limb.described}"
        raise RefusedError("mechanism", found, "round rods and tubes for calculix-solid")
    start, stop = limb.starts[k : k + 2]
    mesh = make(rod, float(np.linalg.norm(stop - start)))
    x, y, z = limb.frame.T
    numbers = deck.add_nodes(start + mesh.nodes @ np.stack([y, -x, z]))
    name = f"ROD{limb.number - 1}I{k}"
    deck.add_elements(kind, name, numbers[mesh.elements])
    deck.lines += material_lines(name, rod.material)
    base = deck.add_rigid(f"{name}BASE", numbers[mesh.base], start)
    tip = deck.add_rigid(f"{name}TIP", numbers[mesh.tip], stop)
    deck.coordinates += 3 * (len(mesh.nodes) - len(mesh.base) - len(mesh.tip))
    begin, end = (float((x - limb.starts[0]) @ z) for x in (start, stop))
    return _Rod(begin, end, (base, tip), mesh, numbers)


def _add_body(deck: Writer, limb: Standing, k: int, body: Body) -> Frame:
    name = f"BODY{limb.number - 1}I{k}"
    axes = limb.frame if body.frame == "limb" else np.eye(3)
    masses = deck.add_masses(name, body, limb.starts[k], axes)
    return deck.add_rigid(f"{name}RIGID", masses, limb.starts[k])


def _join(
    deck: Writer, limb: Standing, R: Array, items: Sequence[int], follows: Frame, leads: Frame
) -> None:
    """Demand that `follows` moves as `leads` does but for the freedoms of the joints `items`."""
    twists: list[Array] = []
    stiffness: list[float] = []
    for k in items:
        joint: Item = limb.limb.chain[k]
        for freedom in joint.freedoms if isinstance(joint, Joint) else ():
            if freedom.stiffness == np.inf:
                continue
            axis = limb.axis(freedom, R)
            turns = freedom.kind == "rotation"
            shift = np.cross(axis, follows.at - limb.starts[k]) if turns else axis
            twists.append(np.concatenate([shift, axis if turns else np.zeros(3)]))
            stiffness.append(freedom.stiffness)
    name = f"L{limb.number - 1}N{follows.place}"
    own = deck.add_freedoms(name, follows.at, stiffness) if twists else []
    arm = follows.at - leads.at
    deck.joints.append((follows.place, leads.place, arm if leads.place else follows.at))
    for c in range(3):
        u, v = (c + 1) % 3, (c + 2) % 3
        parts = [
            (node, freedom, -float(twist[c]))
            for (node, freedom), twist in zip(own, twists, strict=True)
        ]
        turns_too: list[Term] = [
            (leads.turn, u + 1, -float(arm[v])),
            (leads.turn, v + 1, float(arm[u])),
        ]
        deck.add_equation(
            (follows.place, c + 1, 1.0), (leads.place, c + 1, -1.0), *turns_too, *parts
        )
        parts = [
            (node, freedom, -float(twist[3 + c]))
            for (node, freedom), twist in zip(own, twists, strict=True)
        ]
        deck.add_equation((follows.turn, c + 1, 1.0), (leads.turn, c + 1, -1.0), *parts)


def _centre_line(limb: Standing, rods: list[_Rod]) -> list[Line]:
    """Return the limb's centre line: rods, and what is rigid before, between and after them."""
    at = STATIONS * limb.length
    done = np.zeros(len(at), dtype=bool)
    lines = []
    for rod in rods:
        last = rod is rods[-1]
        inside = ~done & (at >= rod.begin) & (at <= rod.end)
        before = ~done & (at < rod.begin)
        after = ~done & ~inside & ~before & last
        done |= inside | before | after
        if inside.any():
            fractions = (at[inside] - rod.begin) / (rod.end - rod.begin)
            nodes, weights = rod.mesh.centre_line(np.clip(fractions, 0.0, 1.0))
            lines.append(Line(np.flatnonzero(inside), rod.numbers[nodes], weights))
        for rigid, face in ((before, rod.faces[0]), (after, rod.faces[1])):
            if rigid.any():
                beyond = limb.starts[0] + at[rigid, None] * limb.frame[:, 2] - face.at
                nodes = np.full((int(rigid.sum()), 1), face.place)
                ones = np.ones(nodes.shape)
                lines.append(Line(np.flatnonzero(rigid), nodes, ones, face.turn, beyond))
    return lines
