"""Limbs of any chain in Exudyn: beams, bodies, and joints with any freedoms at right angles."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.errors import InputError
from analytic.mechanism import Body, Joint, Link, Mechanism, Rod
from analytic.modes import STATIONS, Modes
from analytic.pose import Pose
from reference_models.chain_placement import Standing, largest_gap, stand, triad
from reference_models.exudyn.system import add_rigid_nodes, load, system
from reference_models.projection import constrained_modes, vibrations
from reference_models.units import in_robot_units

Array = NDArray[np.float64]

LIGHT = 1e-9
"""Mass and inertia of a rigid link between two joints, of about one limb's: it should have none."""


@dataclass
class _Place:
    """A marker where the next item starts, the axes (3, 3) and the rigid body that carry it.

    `at` is where the marker is on the body, in those axes [m].
    """

    marker: int
    axes: Array
    body: int
    at: Array


@dataclass
class _Piece:
    """A rod or link: where along the limb it begins, its `length` [m], and the velocity of its
    centre line so far from there.
    """

    begin: float
    length: float
    velocity: Callable[[float], Array]


@dataclass
class _Built:
    """What is in the system: the `joints`' pairs of markers, how many there are at every limb's
    end, and the rods and links of every limb's centre line.
    """

    joints: list[tuple[int, int]] = field(default_factory=list)
    tips: list[int] = field(default_factory=list)
    lines: list[list[_Piece]] = field(default_factory=list)


def chain_modes(
    name: str, theory: str, elements: int, shear: Any, mechanism: Mechanism, pose: Pose, count: int
) -> Modes:
    """Return the `count` lowest modes of limbs with `elements` geometrically exact beams a rod.

    `shear(rod)` is its two shear coefficients, along x and y of its limb. Raises `InputError` for
    what cannot be stated (see `_joint`), `ModelError` where joints are open or Exudyn fails.
    """

    def solve(mechanism: Mechanism, pose: Pose, count: int) -> Modes:
        return _solve(name, theory, elements, shear, mechanism, pose, count)

    return in_robot_units(name, solve, mechanism, pose, count, chains=True)


def _solve(
    name: str, theory: str, elements: int, shear: Any, mechanism: Mechanism, pose: Pose, count: int
) -> Modes:
    exu = load()
    begin = time.perf_counter()
    o, R, limbs = stand(mechanism, pose)
    with system(exu, name) as mbs:
        (node,) = add_rigid_nodes(exu, mbs, o[None], R)
        body = _rigid(exu, mbs, node, mechanism.platform, np.eye(3))
        built = _Built()
        for limb in limbs:
            _add_limb(exu, mbs, limb, body, R, elements, shear, built)
        mbs.Assemble()
        where = exu.OutputVariableType.Position
        ends = np.array([[mbs.GetMarkerOutput(m, where) for m in j] for j in built.joints])
        tips = ends[[k - 1 for k in built.tips], 1]
        apart = float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).max())
        residual = max(apart, largest_gap(limbs, R, tips))
        M, K, _, J = mbs.ComputeLinearizedSystem(returnConstraintJacobian=True)
        made = time.perf_counter()
        # As many modes more as limbs that could spin between two balls.
        spare = sum(limb.may_spin for limb in limbs)
        frequencies, q, free = constrained_modes(name, K, M, J.T, count + spare)
        kept = vibrations(name, frequencies, spare, count)
        frequencies, q = frequencies[kept], q[:, kept]
        solved = time.perf_counter()
        velocity, spin = exu.OutputVariableType.Velocity, exu.OutputVariableType.AngularVelocity
        platform, lines = [], []
        for mode in q.T:
            mbs.systemData.SetODE2Coordinates_t(mode)
            platform.append(np.r_[mbs.GetNodeOutput(node, velocity), mbs.GetNodeOutput(node, spin)])
            lines.append([
                [_velocity(limb, line, station) for station in STATIONS]
                for line, limb in zip(built.lines, limbs, strict=True)
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


def _velocity(limb: Standing, line: list[_Piece], station: float) -> Array:
    """Return the velocity of the centre line at a fraction of the limb, in the present state."""
    at = station * limb.length
    piece = next((piece for piece in line if at <= piece.begin + piece.length), line[-1])
    return piece.velocity(min(at - piece.begin, piece.length))


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
    exu: Any, mbs: Any, limb: Standing, platform: int, R: Array, elements: int, shear: Any,
    built: _Built,
) -> None:  # fmt: skip
    ground = mbs.AddObject(exu.itemInterface.ObjectGround(referencePosition=limb.starts[0]))
    before = _place(exu, mbs, ground, np.eye(3), np.zeros(3))
    waiting: Joint | None = None
    line: list[_Piece] = []
    rigid = Joint(())
    for k, item in enumerate(limb.limb.chain):
        start, end = limb.starts[k : k + 2]
        if isinstance(item, Joint):
            if waiting:
                found = f"limb {limb.number}, {limb.limb.described}"
                raise InputError("mechanism", found, "one joint at a place for exudyn")
            waiting = item
            continue
        begin = float(np.linalg.norm(start - limb.starts[0]))
        length = float(np.linalg.norm(end - start))
        if isinstance(item, Rod):
            x, y, z = limb.frame.T
            axes = np.stack([z, y, -x], axis=1)
            points = start + np.linspace(0.0, 1.0, elements + 1)[:, None] * (end - start)
            nodes = add_rigid_nodes(exu, mbs, points, axes)
            beams = _beams(exu, mbs, nodes, length, _section(exu, item, shear(item)))
            line.append(_Piece(begin, length, _along_beams(exu, mbs, beams, length)))
            # Bodies without mass, by which joints hold the rod's ends.
            first, last = (_massless(exu, mbs, node, axes) for node in (nodes[0], nodes[-1]))
        else:
            if isinstance(item, Link) and not waiting:
                first = before  # the body that is there reaches to the end of the link
            else:
                first = _body(exu, mbs, limb, item, start)
            last = _place(exu, mbs, first.body, first.axes, first.at + first.axes.T @ (end - start))
            if isinstance(item, Link):
                line.append(_Piece(begin, length, _along_link(exu, mbs, first, limb.frame[:, 2])))
        if first is not before:
            _joint(exu, mbs, limb, waiting or rigid, R, before, first, built)
        before, waiting = last, None
    tip = _place(exu, mbs, platform, R, np.array(limb.limb.platform_point))
    _joint(exu, mbs, limb, waiting or rigid, R, before, tip, built)
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
    light = ((LIGHT, 0.0, 0.0), (0.0, LIGHT, 0.0), (0.0, 0.0, LIGHT))
    body = item if isinstance(item, Body) else Body(LIGHT, light)
    (node,) = add_rigid_nodes(exu, mbs, start[None], np.eye(3))
    axes = limb.frame if body.frame == "limb" else np.eye(3)
    return _place(exu, mbs, _rigid(exu, mbs, node, body, axes), np.eye(3), np.zeros(3))


def _along_link(exu: Any, mbs: Any, start: _Place, z: Array) -> Callable[[float], Array]:
    velocity, along = exu.OutputVariableType.Velocity, start.axes.T @ z
    return lambda at: np.array(
        mbs.GetObjectOutputBody(start.body, velocity, list(start.at + at * along))
    )


def _along_beams(exu: Any, mbs: Any, beams: list[int], length: float) -> Callable[[float], Array]:
    velocity, h = exu.OutputVariableType.Velocity, length / len(beams)

    def at(x: float) -> Array:
        k = int(np.clip(x / h, 0, len(beams) - 1))
        local = float(np.clip(x - (k + 0.5) * h, -h / 2, h / 2))
        return np.asarray(mbs.GetObjectOutputBody(beams[k], velocity, [local, 0.0, 0.0]))

    return at


def _beams(exu: Any, mbs: Any, nodes: list[int], length: float, section: Any) -> list[int]:
    make, size = exu.itemInterface.ObjectBeamGeometricallyExact, length / (len(nodes) - 1)
    return [
        mbs.AddObject(make(nodeNumbers=list(ends), physicsLength=size, sectionData=section))
        for ends in pairwise(nodes)
    ]


def _joint(
    exu: Any, mbs: Any, limb: Standing, joint: Joint, R: Array, before: _Place, after: _Place,
    built: _Built,
) -> None:  # fmt: skip
    """Join two markers by what a joint leaves, and springs for what it resists.

    Raises `InputError` where the freedoms are not along the axes of one frame.
    """
    loose = [f for f in joint.freedoms if f.stiffness < np.inf]
    axes = [limb.axis(f, R) for f in loose]
    frame = triad(axes)
    if frame is None:
        found = f"limb {limb.number}, {limb.limb.described}"
        raise InputError("mechanism", found, "freedoms of a joint at right angles for exudyn")
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
