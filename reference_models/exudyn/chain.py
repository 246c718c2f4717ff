"""Limbs of any chain in Exudyn: the platform, what holds it, and the modes."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.mechanism import Mechanism
from analytic.modes import STATIONS, Modes
from analytic.pose import Pose
from reference_models.chain_placement import Standing, largest_gap, stand
from reference_models.exudyn.system import add_rigid_nodes, load, system
from reference_models.projection import constrained_modes, vibrations
from reference_models.spent import SIMULATOR, phase
from reference_models.units import in_robot_units

Array = NDArray[np.float64]


@dataclass
class Piece:
    """A rod or link: where along the limb it begins, its `length` [m], and the velocity of its
    centre line so far from there.
    """

    begin: float
    length: float
    velocity: Callable[[float], Array]


@dataclass
class Built:
    """What is in the system: the `joints`' pairs of markers, how many there are at every limb's
    end, and the rods and links of every limb's centre line.
    """

    joints: list[tuple[int, int]] = field(default_factory=list)
    tips: list[int] = field(default_factory=list)
    lines: list[list[Piece]] = field(default_factory=list)


AddLimb = Callable[[Any, Any, Standing, int, Array, Built], None]
"""Adds a limb to (exudyn, system), joined to the platform's body, whose rotation is given."""


def chain_modes(
    name: str,
    theory: str,
    elements: int,
    add_limb: AddLimb,
    mechanism: Mechanism,
    pose: Pose,
    count: int,
    *,
    spin: bool = True,
) -> Modes:
    """Return the `count` lowest modes of limbs that `add_limb` makes of `elements` a rod.

    `spin`: whether limbs between two balls can turn about themselves. Raises `InputError` for what
    `add_limb` cannot state, `ModelError` where joints are open or Exudyn fails.
    """

    def solve(mechanism: Mechanism, pose: Pose, count: int) -> Modes:
        return _solve(name, theory, elements, add_limb, mechanism, pose, count, spin=spin)

    return in_robot_units(name, solve, mechanism, pose, count, chains=True)


def _solve(
    name: str, theory: str, elements: int, add_limb: AddLimb, mechanism: Mechanism, pose: Pose,
    count: int, *, spin: bool,
) -> Modes:  # fmt: skip
    exu = load()
    begin = time.perf_counter()
    with phase("building"):
        o, R, limbs = stand(mechanism, pose)
    with system(exu, name) as mbs:
        with phase("building"):
            (node,) = add_rigid_nodes(exu, mbs, o[None], R)
            body = rigid(exu, mbs, node, mechanism.platform, np.eye(3))
            built = Built()
            for limb in limbs:
                add_limb(exu, mbs, limb, body, R, built)
        with phase(SIMULATOR):
            mbs.Assemble()
        with phase("shapes"):
            where = exu.OutputVariableType.Position
            ends = np.array([[mbs.GetMarkerOutput(m, where) for m in j] for j in built.joints])
            tips = ends[[k - 1 for k in built.tips], 1]
            apart = float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).max())
            residual = max(apart, largest_gap(limbs, R, tips))
        with phase(SIMULATOR):
            M, K, _, J = mbs.ComputeLinearizedSystem(returnConstraintJacobian=True)
        made = time.perf_counter()
        # As many modes more as limbs that could spin between two balls.
        spare = sum(limb.may_spin for limb in limbs) if spin else 0
        frequencies, q, free = constrained_modes(name, K, M, J.T, count + spare)
        kept = vibrations(name, frequencies, spare, count)
        frequencies, q = frequencies[kept], q[:, kept]
        solved = time.perf_counter()
        with phase("shapes"):
            of = exu.OutputVariableType
            platform, lines = [], []
            for mode in q.T:
                mbs.systemData.SetODE2Coordinates_t(mode)
                platform.append([
                    mbs.GetNodeOutput(node, which) for which in (of.Velocity, of.AngularVelocity)
                ])  # fmt: skip
                lines.append([
                    [_velocity(limb, line, station) for station in STATIONS]
                    for line, limb in zip(built.lines, limbs, strict=True)
                ])  # fmt: skip
    return Modes(
        frequencies=frequencies,
        platform=np.array(platform).reshape(-1, 6),
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


def _velocity(limb: Standing, line: list[Piece], station: float) -> Array:
    """Return the velocity of the centre line at a fraction of the limb, in the present state."""
    at = station * limb.length
    piece = next((piece for piece in line if at <= piece.begin + piece.length), line[-1])
    return piece.velocity(min(at - piece.begin, piece.length))


def rigid(exu: Any, mbs: Any, node: int, body: Any, axes: Array) -> int:
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


def along(
    exu: Any, mbs: Any, beams: list[int], length: float, start: float
) -> Callable[[float], Array]:
    """Return the velocity of a rod of so many equal elements whose local coordinates begin at
    `start` times their length.
    """
    velocity, h = exu.OutputVariableType.Velocity, length / len(beams)

    def at(x: float) -> Array:
        k = int(np.clip(x / h, 0, len(beams) - 1))
        local = start * h + float(np.clip(x - k * h, 0.0, h))
        return np.asarray(mbs.GetObjectOutputBody(beams[k], velocity, [local, 0.0, 0.0]))

    return at
