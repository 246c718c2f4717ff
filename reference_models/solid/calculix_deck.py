"""The manipulator as a CalculiX input deck: solid rods, rigid end faces and bodies, joints."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analytic.mechanism import Mechanism, Rod
from analytic.modes import check_count
from analytic.pose import Pose
from reference_models.chain_placement import Standing, largest_gap, stand
from reference_models.solid.calculix_limb import Line, add_limb
from reference_models.solid.calculix_writer import Frame, Term, Writer
from reference_models.solid.rod_mesh import RodMesh

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Deck:
    """An input deck, and which of its nodes answer.

    Attributes: `text` of the deck; `platform`: the nodes that carry the platform's displacement at
    o and its rotation; `held`: its nodes at the A_i (n,); `lines`, those of every limb; `joints`:
    nodes that stand `offset` apart, (node, node or 0 for the origin, offset); `equations` that
    every motion must fulfil; `limbs` as they stand, and the platform's `rotation`; `shown`: all
    nodes whose displacement is asked for, ascending; `coordinates` left free; `spins`: limbs that
    may turn about themselves without energy, None where nothing that moves freely is left out.
    """

    text: str
    platform: tuple[int, int]
    held: Indices
    lines: list[list[Line]]
    joints: list[tuple[int, int, Array]]
    equations: list[list[Term]]
    limbs: list[Standing]
    rotation: Array
    shown: Indices
    coordinates: int
    spins: int | None

    def points(self) -> Array:
        """Return the nodes as written, read back from the text: (N, 3) [m], node n at n - 1."""
        blocks = self.text.split("*NODE\n")[1:]
        rows = [row for block in blocks for row in block.split("*")[0].splitlines()]
        table = np.array([row.split(",") for row in rows], dtype=float)
        return table[np.argsort(table[:, 0]), 1:]

    def gap(self) -> float:
        """Return the largest distance between what joints hold together, as written [m]."""
        points = self.points()
        apart = [
            points[node - 1] - (points[other - 1] if other else 0.0) - offset
            for node, other, offset in self.joints
        ]
        beside = largest_gap(self.limbs, self.rotation, points[self.held - 1])
        return max(beside, float(np.linalg.norm(apart, axis=1).max()))


def write(
    mechanism: Mechanism,
    pose: Pose,
    mesh: Callable[[Rod, float], RodMesh],
    kind: str,
    count: int,
) -> Deck:
    """Return the deck for the `count` lowest modes, of elements of type `kind` on a rod's `mesh`.

    Raises `InputError` for a pose out of reach, a limb that cannot be written or more modes than
    coordinates, and `ModelError` for a body whose inertia no body has.
    """
    o, R, limbs = stand(mechanism, pose)
    deck = Writer()
    held = deck.add_nodes(o + np.array([limb.platform_point for limb in mechanism.limbs]) @ R.T)
    masses = deck.add_masses("MASSES", mechanism.platform, o, R)
    platform = deck.add_rigid("PLATFORM", np.concatenate([held, masses]), o)
    lines = [
        add_limb(deck, limb, R, Frame(node, platform.turn, limb.starts[-1]), mesh, kind)
        for limb, node in zip(limbs, held.tolist(), strict=True)
    ]
    # The platform's six coordinates beside those of the limbs.
    free = deck.coordinates + 6
    spins = None if mechanism.simple else sum(limb.may_spin for limb in limbs)
    wanted = count + (spins or 0)
    check_count(wanted, free)
    asked = {n for equation in deck.equations for n, *_ in equation}
    along = {
        n for limb in lines for line in limb for n in (*line.nodes.ravel().tolist(), line.turn)
    }
    shown = sorted(({platform.place, platform.turn, *held.tolist()} | asked | along) - {0})
    deck.add_set("SHOWN", shown)
    deck.lines += ["*STEP", "*FREQUENCY", str(wanted), "*NODE PRINT,NSET=SHOWN", "U", "*END STEP"]
    return Deck(
        "\n".join([*deck.lines, ""]), (platform.place, platform.turn), held, lines, deck.joints,
        deck.equations, limbs, R, np.array(shown), free, spins,
    )  # fmt: skip
