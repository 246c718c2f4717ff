"""Limbs of any chain in Exudyn: beams, bodies, and joints with any freedoms at right angles."""

import time
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.errors import InputError
from analytic.mechanism import Body, Joint, Limb, Mechanism, Rod
from analytic.modes import STATIONS, Modes
from analytic.pose import Pose
from reference_models.chain_placement import Standing, stand, triad
from reference_models.exudyn.system import add_rigid_nodes, load, system
from reference_models.projection import constrained_modes
from reference_models.protocol import ModelError

Array = NDArray[np.float64]

STILL = 1e-4
"""A frequency below this part of the highest found is that of a limb that spins."""
CLOSED = 1e-9
"""Markers of a joint further apart than this part of the mechanism are an open joint."""


@dataclass
class _Place:
    """A marker at the end of what is built so far, and its own axes (3, 3)."""

    marker: int
    axes: Array


@dataclass
class _Built:
    """What is in the system: the `joints`' pairs of markers, every limb's beam `elements`."""

    joints: list[tuple[int, int]] = field(default_factory=list)
    rods: list[list[tuple[float, float, list[int]]]] = field(default_factory=list)


def chain_modes(
    name: str, theory: str, elements: int, shear: Any, mechanism: Mechanism, pose: Pose, count: int
) -> Modes:
    """Return the `count` lowest modes of limbs with `elements` geometrically exact beams a rod.

    `shear(rod)` is its two shear coefficients, along x and y of its limb. Raises `InputError` for
    what cannot be stated (see `_joint`), `ModelError` where joints are open or Exudyn fails.
    """
    exu = load()
    begin = time.perf_counter()
    o, R, limbs = stand(mechanism, pose)
    with system(exu, name) as mbs:
        (node,) = add_rigid_nodes(exu, mbs, o[None], R)
        body = _rigid(exu, mbs, node, mechanism.platform, np.eye(3))
        built = _Built()
        for number, limb in enumerate(limbs):
            _add_limb(exu, mbs, number, limb, body, R, elements, shear, built)
        mbs.Assemble()
        where = exu.OutputVariableType.Position
        ends = np.array([[mbs.GetMarkerOutput(m, where) for m in j] for j in built.joints])
        residual = float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).max())
        size = max(float(np.ptp(limb.starts, axis=0).max()) for limb in limbs)
        if residual > CLOSED * size:
            raise ModelError(f"{name}: joints are open by {residual:.1e} m")
        M, K, _, J = mbs.ComputeLinearizedSystem(returnConstraintJacobian=True)
        made = time.perf_counter()
        # As many modes more as limbs that could spin between two balls.
        spare = sum(_may_spin(limb.limb) for limb in limbs)
        frequencies, q, free = constrained_modes(name, K, M, J.T, count + spare)
        still = frequencies < STILL * frequencies[-1]
        if still.sum() > spare:
            raise ModelError(f"{name}: {int(still.sum())} motions need no energy, of {spare} limbs")
        kept = np.flatnonzero(~still)[:count]
        frequencies, q = frequencies[kept], q[:, kept]
        solved = time.perf_counter()
        velocity, spin = exu.OutputVariableType.Velocity, exu.OutputVariableType.AngularVelocity
        platform, lines = [], []
        for mode in q.T:
            mbs.systemData.SetODE2Coordinates_t(mode)
            platform.append(np.r_[mbs.GetNodeOutput(node, velocity), mbs.GetNodeOutput(node, spin)])
            lines.append([
                [_velocity(exu, mbs, rods, limb, station) for station in STATIONS]
                for rods, limb in zip(built.rods, limbs, strict=True)
            ])  # fmt: skip
    return Modes(
        frequencies=frequencies,
        platform=np.array(platform),
        limbs=np.array(lines),
        theory=theory,
        model=name,
        version=f"exudyn {exu.__version__}",
        elements=elements,
        dofs=free,
        residual=residual,
        build_seconds=made - begin,
        solve_seconds=solved - made,
    )


def _may_spin(limb: Limb) -> bool:
    """Return whether a limb has a freely turning ball near either end."""
    balls = [
        item
        for item in limb.chain
        if isinstance(item, Joint)
        and sum(f.kind == "rotation" and not f.stiffness for f in item.freedoms) == 3
    ]
    return len(balls) == 2


def _velocity(
    exu: Any, mbs: Any, rods: list[tuple[float, float, list[int]]], limb: Standing, station: float
) -> Array:
    """Return the velocity of the centre line at a fraction of the limb, by the nearest rod."""
    total = float(np.linalg.norm(limb.starts[-1] - limb.starts[0]))
    at = station * total
    begin, length, beams = next((r for r in rods if at <= r[0] + r[1]), rods[-1])
    h = length / len(beams)
    k = int(np.clip((at - begin) / h, 0, len(beams) - 1))
    x = float(np.clip(at - begin - (k + 0.5) * h, -h / 2, h / 2))
    return np.asarray(
        mbs.GetObjectOutputBody(beams[k], exu.OutputVariableType.Velocity, [x, 0.0, 0.0])
    )


def _rigid(exu: Any, mbs: Any, node: int, body: Any, axes: Array) -> int:
    """Add a rigid body with its mass, inertia about and centre in `axes` of its node's frame."""
    J = axes @ np.array(body.inertia) @ axes.T
    c = axes @ np.array(body.centre)
    J = J + body.mass * (c @ c * np.eye(3) - np.outer(c, c))
    return int(
        mbs.AddObject(
            exu.itemInterface.ObjectRigidBody(
                nodeNumber=node,
                physicsMass=body.mass,
                physicsInertia=[J[0, 0], J[1, 1], J[2, 2], J[1, 2], J[0, 2], J[0, 1]],
                physicsCenterOfMass=list(c),
            )
        )
    )


def _add_limb(
    exu: Any, mbs: Any, number: int, limb: Standing, platform: int, R: Array, elements: int,
    shear: Any, built: _Built,
) -> None:  # fmt: skip
    items = exu.itemInterface
    ground = mbs.AddObject(items.ObjectGround(referencePosition=limb.starts[0]))
    before = _Place(mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=ground)), np.eye(3))
    joint = Joint(())
    rods: list[tuple[float, float, list[int]]] = []
    chain = limb.limb.chain
    for k, item in enumerate(chain):
        if isinstance(item, Joint):
            if k and isinstance(chain[k - 1], Joint):
                raise InputError("limb", limb.limb.described, "one joint at a place for exudyn")
            joint = item
        elif isinstance(item, Body):
            (node,) = add_rigid_nodes(exu, mbs, limb.starts[k][None], np.eye(3))
            axes = limb.frame if item.frame == "limb" else np.eye(3)
            own = _rigid(exu, mbs, node, item, axes)
            after = _Place(mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=own)), np.eye(3))
            _joint(exu, mbs, number, limb, joint, R, before, after, built)
            before, joint = after, Joint(())
        elif isinstance(item, Rod):
            x, y, z = limb.frame.T
            axes = np.stack([z, y, -x], axis=1)
            length = float(np.linalg.norm(limb.starts[k + 1] - limb.starts[k]))
            part = np.linspace(0.0, 1.0, elements + 1)[:, None]
            points = limb.starts[k] + part * (limb.starts[k + 1] - limb.starts[k])
            nodes = add_rigid_nodes(exu, mbs, points, axes)
            section = _section(exu, item, shear(item))
            beams = [
                mbs.AddObject(
                    items.ObjectBeamGeometricallyExact(
                        nodeNumbers=list(ends), physicsLength=length / elements, sectionData=section
                    )
                )
                for ends in pairwise(nodes)
            ]
            begin = float(np.linalg.norm(limb.starts[k] - limb.starts[0]))
            rods.append((begin, length, beams))
            first, last = (
                _Place(mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=node)), axes)
                for node in (nodes[0], nodes[-1])
            )
            _joint(exu, mbs, number, limb, joint, R, before, first, built)
            before, joint = last, Joint(())
        else:
            raise InputError("limb", limb.limb.described, "no rigid links for exudyn")
    point = list(limb.limb.platform_point)
    tip = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=platform, localPosition=point))
    _joint(exu, mbs, number, limb, joint, R, before, _Place(tip, R), built)
    built.rods.append(rods)


def _joint(
    exu: Any, mbs: Any, number: int, limb: Standing, joint: Joint, R: Array, before: _Place,
    after: _Place, built: _Built,
) -> None:  # fmt: skip
    """Join two markers by what a joint leaves, and springs for what it resists.

    Raises `InputError` where the freedoms are not along the axes of one frame.
    """
    loose = [f for f in joint.freedoms if f.stiffness < np.inf]
    axes = [limb.axis(f, R) for f in loose]
    frame = triad(axes)
    if frame is None:
        raise InputError("limb", number + 1, "freedoms of a joint at right angles for exudyn")
    held, stiffness = np.ones(6, dtype=int), np.zeros(6)
    for freedom, axis in zip(loose, axes, strict=True):
        at = int(np.abs(frame.T @ axis).argmax()) + 3 * (freedom.kind == "rotation")
        held[at] = 0
        stiffness[at] += freedom.stiffness
    items, pair = exu.itemInterface, [before.marker, after.marker]
    turn = {
        "rotationMarker0": before.axes.T @ frame,
        "rotationMarker1": after.axes.T @ frame,
    }
    mbs.AddObject(items.GenericJoint(markerNumbers=pair, constrainedAxes=held.tolist(), **turn))
    if stiffness.any():
        mbs.AddObject(
            items.RigidBodySpringDamper(markerNumbers=pair, stiffness=np.diag(stiffness), **turn)
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
