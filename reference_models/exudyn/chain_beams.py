"""A limb of any chain of geometrically exact beams, bodies, links and joints in Exudyn."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.errors import RefusedError
from analytic.mechanism import Body, Joint, Link, Rod
from reference_models.chain_placement import Standing
from reference_models.exudyn.chain import Built, Piece, along, rigid
from reference_models.exudyn.system import add_rigid_nodes

Array = NDArray[np.float64]

INDEPENDENT = 1e-9
"""Directions of freedoms that depend on each other have a smaller singular value."""
LIGHT = 1e-12
"""Mass and inertia of a rigid link between two joints, of its limb's: it should have none."""


@dataclass
class _Place:
    """A marker where the next item starts, the axes (3, 3) and the rigid body that carry it.

    `at` is where the marker is on the body, in those axes [m].
    """

    marker: int
    axes: Array
    body: int
    at: Array


def add_beams(
    elements: int, shear: Any, exu: Any, mbs: Any, limb: Standing, platform: int, R: Array,
    built: Built,
) -> None:  # fmt: skip
    """Add a limb with `elements` beams a rod, of shear coefficients `shear(rod)` along x and y.

    Joints with nothing between them are one, of the freedoms of all. Raises `InputError` naming the
    limb as `_joint`.
    """
    ground = mbs.AddObject(exu.itemInterface.ObjectGround(referencePosition=limb.starts[0]))
    before = _place(exu, mbs, ground, np.eye(3), np.zeros(3))
    waiting: list[Joint] = []
    line: list[Piece] = []
    for k, item in enumerate(limb.limb.chain):
        start, end = limb.starts[k : k + 2]
        if isinstance(item, Joint):
            waiting.append(item)
            continue
        begin = float(np.linalg.norm(start - limb.starts[0]))
        length = float(np.linalg.norm(end - start))
        if isinstance(item, Rod):
            x, y, z = limb.frame.T
            axes = np.stack([z, y, -x], axis=1)
            points = start + np.linspace(0.0, 1.0, elements + 1)[:, None] * (end - start)
            nodes = add_rigid_nodes(exu, mbs, points, axes)
            beams = _beams(exu, mbs, nodes, length, _section(exu, item, shear(item)))
            line.append(Piece(begin, length, along(exu, mbs, beams, length, -0.5)))
            # Bodies without mass, by which joints hold the rod's ends.
            first, last = (_massless(exu, mbs, node, axes) for node in (nodes[0], nodes[-1]))
        else:
            if isinstance(item, Link) and not waiting:
                first = before  # the body that is there reaches to the end of the link
            else:
                first = _body(exu, mbs, limb, item, start)
            last = _place(exu, mbs, first.body, first.axes, first.at + first.axes.T @ (end - start))
            if isinstance(item, Link):
                line.append(Piece(begin, length, _along_link(exu, mbs, first, limb.frame[:, 2])))
        if first is not before:
            _joint(exu, mbs, limb, waiting, R, before, first, built)
        before, waiting = last, []
    tip = _place(exu, mbs, platform, R, np.array(limb.limb.platform_point))
    _joint(exu, mbs, limb, waiting, R, before, tip, built)
    built.tips.append(len(built.joints))
    built.lines.append(line)


def _place(exu: Any, mbs: Any, body: int, axes: Array, at: Array) -> _Place:
    """Return a place on a rigid body, marked."""
    make = exu.itemInterface.MarkerBodyRigid
    return _Place(int(mbs.AddMarker(make(bodyNumber=body, localPosition=list(at)))), axes, body, at)


def _massless(exu: Any, mbs: Any, node: int, axes: Array) -> _Place:
    """Return a place on a rigid body without mass that moves with a node of a beam."""
    make = exu.itemInterface.ObjectRigidBody
    body = mbs.AddObject(make(nodeNumber=node, physicsMass=0.0, physicsInertia=[0.0] * 6))
    return _place(exu, mbs, body, axes, np.zeros(3))


def _body(exu: Any, mbs: Any, limb: Standing, item: Any, start: Array) -> _Place:
    """Add a body of the chain, or a link as one, at `start` in global axes."""
    mass = LIGHT * limb.mass
    J = mass * limb.length**2
    light = ((J, 0.0, 0.0), (0.0, J, 0.0), (0.0, 0.0, J))
    body = item if isinstance(item, Body) else Body(mass, light)
    (node,) = add_rigid_nodes(exu, mbs, start[None], np.eye(3))
    axes = limb.frame if body.frame == "limb" else np.eye(3)
    return _place(exu, mbs, rigid(exu, mbs, node, body, axes), np.eye(3), np.zeros(3))


def _along_link(exu: Any, mbs: Any, start: _Place, z: Array) -> Callable[[float], Array]:
    velocity, along = exu.OutputVariableType.Velocity, start.axes.T @ z
    return lambda at: np.array(
        mbs.GetObjectOutputBody(start.body, velocity, list(start.at + at * along))
    )


def _beams(exu: Any, mbs: Any, nodes: list[int], length: float, section: Any) -> list[int]:
    make, size = exu.itemInterface.ObjectBeamGeometricallyExact, length / (len(nodes) - 1)
    return [
        mbs.AddObject(make(nodeNumbers=list(ends), physicsLength=size, sectionData=section))
        for ends in pairwise(nodes)
    ]


def _joint(
    exu: Any, mbs: Any, limb: Standing, joints: list[Joint], R: Array, before: _Place,
    after: _Place, built: Built,
) -> None:  # fmt: skip
    """Join two markers by what joints leave, and springs for what they resist.

    Shifts and turns each in a frame of their own, whose first axes the freedoms span: what they do
    not span is held, and springs along skew axes a_j are W^T diag(k) W there, W a_j = e_j.
    Raises `InputError` where freedoms depend on each other.
    """
    loose = [f for joint in joints for f in joint.freedoms if f.stiffness < np.inf]
    items, pair = exu.itemInterface, [before.marker, after.marker]
    for kind, of in (("translation", slice(0, 3)), ("rotation", slice(3, 6))):
        own = [f for f in loose if f.kind == kind]
        axes = np.array([limb.axis(f, R) for f in own]).reshape(-1, 3).T
        frame, size, _ = np.linalg.svd(axes)
        if len(own) > 3 or size.min(initial=1.0) < INDEPENDENT:
            found = f"limb {limb.number}, {limb.limb.described}"
            raise RefusedError("mechanism", found, "independent freedoms at a place for exudyn")
        frame[:, 2] *= np.linalg.det(frame)
        held, stiffness = np.zeros(6, dtype=int), np.zeros((6, 6))
        held[of] = np.arange(3) >= len(own)
        apart = np.linalg.pinv(frame.T @ axes)
        stiffness[of, of] = apart.T @ np.diag([f.stiffness for f in own]) @ apart
        turn = {
            "rotationMarker0": before.axes.T @ frame,
            "rotationMarker1": after.axes.T @ frame,
        }
        if held.any():
            mbs.AddObject(
                items.GenericJoint(markerNumbers=pair, constrainedAxes=held.tolist(), **turn)
            )
        if stiffness.any():
            mbs.AddObject(
                items.RigidBodySpringDamper(markerNumbers=pair, stiffness=stiffness, **turn)
            )
    built.joints.append((before.marker, after.marker))


def _section(exu: Any, rod: Rod, kappa: tuple[float, float]) -> Any:
    """Return the section of a rod: along it, then y and minus x of its limb."""
    section, of, own = exu.BeamSection(), rod.material, rod.section
    Ix, Iy = own.second_moments
    section.massPerLength = of.density * own.area
    section.inertia = of.density * np.diag([Ix + Iy, Iy, Ix])
    shearing = of.shear * own.area
    section.stiffnessMatrix = np.diag([
        of.young * own.area, kappa[1] * shearing, kappa[0] * shearing,
        of.shear * own.torsion_constant, of.young * Iy, of.young * Ix,
    ])  # fmt: skip
    return section
