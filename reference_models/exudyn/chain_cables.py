"""A limb of Exudyn's cables: rods that nothing twists, between joints that leave torsion alone."""

from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.errors import RefusedError
from analytic.mechanism import Joint, Rod
from reference_models.chain_placement import Standing
from reference_models.exudyn.chain import Built, Piece, along
from reference_models.exudyn.system import add_spherical
from reference_models.series import Series

Array = NDArray[np.float64]

SQUARE = 1e-9
"""Axes this near to square to a limb, or along it [rad], couple nothing with torsion."""
ROUND = 1e-9
"""A relative difference of second moments of area that is rounding."""


def add_cables(
    elements: int, exu: Any, mbs: Any, limb: Standing, platform: int, R: Array, built: Built
) -> None:
    """Add a limb with `elements` cables a rod.

    Raises `InputError` naming the limb for what has torsion to carry: whatever does not end in a
    ball, a body, a link, a joint whose turns about the limb and across it are coupled; and for a
    rod that does not bend alike in every direction.
    """
    *chain, last = limb.limb.chain
    ball = Series().joined(last, "rotation", limb, R) if isinstance(last, Joint) else Series()
    slides = isinstance(last, Joint) and any(f.kind == "translation" for f in last.freedoms)
    if not ball.all_free or slides or not chain or not isinstance(chain[-1], Rod):
        raise _refused(limb, "a rod and a ball that turns freely at its end")
    items = exu.itemInterface
    node: int | None = None
    shift, turn = Series(), Series()
    line: list[Piece] = []
    for k, item in enumerate(chain):
        if isinstance(item, Joint):
            shift = shift.joined(item, "translation", limb, R)
            turn = turn.joined(item, "rotation", limb, R)
            continue
        if not isinstance(item, Rod):
            raise _refused(limb, "only rods and joints")
        start, stop = limb.starts[k : k + 2]
        nodes, cables = _cables(exu, mbs, limb, item, start, stop, elements)
        _tie(exu, mbs, node, nodes[0], limb, shift, turn)
        begin, length = (float(np.linalg.norm(x)) for x in (start - limb.starts[0], stop - start))
        line.append(Piece(begin, length, along(exu, mbs, cables, length, 0.0)))
        if node is None:
            ground = mbs.AddObject(items.ObjectGround(referencePosition=start))
            held = mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=ground))
            first = mbs.AddMarker(items.MarkerNodePosition(nodeNumber=nodes[0]))
            built.joints.append((held, first))
        node, shift, turn = nodes[-1], Series(), Series()
    tip = mbs.AddMarker(items.MarkerNodePosition(nodeNumber=node))
    held, _ = add_spherical(exu, mbs, platform, limb.limb.platform_point, tip)
    built.joints.append((tip, held))
    built.tips.append(len(built.joints))
    built.lines.append(line)


def _refused(limb: Standing, expected: str) -> RefusedError:
    found = f"limb {limb.number}, {limb.limb.described}"
    return RefusedError(
        "mechanism", found, f"limbs of {expected}: exudyn-cable has no torsion to carry"
    )


def _cables(
    exu: Any, mbs: Any, limb: Standing, rod: Rod, start: Array, stop: Array, elements: int
) -> tuple[list[int], list[int]]:
    """Add a rod; return its nodes and elements."""
    items, own, of = exu.itemInterface, rod.section, rod.material
    Ix, Iy = own.second_moments
    if abs(Ix - Iy) > ROUND * Ix:
        raise _refused(limb, "rods that bend alike in every direction")
    z = limb.frame[:, 2]
    points = start + np.linspace(0.0, 1.0, elements + 1)[:, None] * (stop - start)
    nodes = [mbs.AddNode(items.NodePointSlope1(referenceCoordinates=[*p, *z])) for p in points]
    cables = [
        mbs.AddObject(
            items.ObjectANCFCable(
                nodeNumbers=list(ends),
                physicsLength=float(np.linalg.norm(stop - start)) / elements,
                physicsMassPerLength=of.density * own.area,
                physicsBendingStiffness=of.young * Ix,
                physicsAxialStiffness=of.young * own.area,
            )
        )
        for ends in pairwise(nodes)
    ]
    return nodes, cables


def _tie(
    exu: Any, mbs: Any, before: int | None, after: int, limb: Standing, shift: Series, turn: Series
) -> None:
    """Hold a rod's first node to the node `before`, or to the ground, but for a joint's freedoms.

    Its motions in the limb's axes: displacement, and turns about x and y, which are the slope's
    -dr'_y and dr'_x. The slope's length is strain: no joint holds it. Torsion is left alone where
    the turn about z is free, or coupled with no other.
    """
    x, y, _ = limb.frame.T
    moved = np.zeros((5, 6))
    moved[:3, :3] = limb.frame.T
    moved[3, 3:], moved[4, 3:] = -y, x
    free, axes, c = shift.apart()
    give = [(axis, 0.0) for axis in free.T]
    give += [(axis, 1 / s) for axis, s in zip(axes.T, c, strict=True)]
    ways = [(np.r_[axis, 0.0, 0.0], k) for axis, k in give]
    free, axes, c = _across(limb, turn).apart()
    give = [(axis, 0.0) for axis in free.T]
    give += [(axis, 1 / s) for axis, s in zip(axes.T, c, strict=True)]
    ways += [(np.r_[np.zeros(3), axis[:2]], k) for axis, k in give]
    stiffness = np.zeros((5, 5))
    for way, k in ways:
        stiffness += k * np.outer(way, way)
    _, size, rows = np.linalg.svd(np.array([way for way, _ in ways]).reshape(-1, 5))
    locked = rows[int((size > SQUARE).sum()) :] @ moved
    items = exu.itemInterface
    other = mbs.AddNode(items.NodePointGround()) if before is None else before
    markers = [
        mbs.AddMarker(items.MarkerNodeCoordinates(nodeNumber=node)) for node in (after, other)
    ]
    if len(locked):
        # Exudyn's constraint is the difference of both products.
        mbs.AddObject(
            items.ObjectConnectorCoordinateVector(
                markerNumbers=markers,
                scalingMarker0=locked,
                scalingMarker1=np.zeros((0, 0)) if before is None else locked,
                offset=[0.0] * len(locked),
            )
        )
    if stiffness.any():
        D = moved if before is None else np.hstack([-moved, moved])
        zero = np.zeros((D.shape[1], D.shape[1]))
        mbs.AddObject(
            items.ObjectGenericODE2(
                nodeNumbers=[after] if before is None else [before, after],
                massMatrix=zero,
                stiffnessMatrix=D.T @ stiffness @ D,
                dampingMatrix=zero,
                forceVector=np.zeros(len(zero)),
            )
        )


def _across(limb: Standing, turn: Series) -> Series:
    """Return the turns across a limb; raises `InputError` where they are coupled with torsion."""
    z = np.array([0.0, 0.0, 1.0])
    free, _, _ = turn.apart()
    along = float(np.linalg.norm(free.T @ z))
    own = turn.own
    if along > 1 - SQUARE:
        held = np.eye(3) - free @ free.T
        own = held @ own @ held
    elif along > SQUARE or np.abs(own[:2, 2]).max() > SQUARE * np.abs(own).max():
        raise _refused(limb, "joints that turn about it or square to it")
    flat = np.diag([1.0, 1.0, 0.0])
    across = free.T @ flat
    return Series(across[np.linalg.norm(across, axis=1) > SQUARE], own=flat @ own @ flat)
