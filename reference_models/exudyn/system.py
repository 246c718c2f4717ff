"""What all Exudyn models share: one silent system, its rigid platform and joints, its modes.

The modes come from Exudyn's own assembled M, K and constraint Jacobian, and their shapes from
Exudyn's own kinematics: a mode loaded as a velocity moves the platform and the centre lines.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from analytic.mechanism import Mechanism, Platform, Rod
from analytic.model import Info
from analytic.modes import STATIONS, Modes
from analytic.pose import Pose
from reference_models import placement
from reference_models.placement import Placement, place
from reference_models.projection import constrained_modes
from reference_models.protocol import ModelError, UnavailableError, unlinked
from reference_models.spent import SIMULATOR, phase
from reference_models.units import in_robot_units

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Axis:
    """One rod in space: from `base` B_i to `tip` A_i [m], about the revolute axis.

    `frame` holds unit vectors along the rod, along the revolute axis and across both, as columns.
    """

    rod: Rod
    base: Array
    tip: Array
    frame: Array
    length: float

    def points(self, elements: int) -> Array:
        """Return the nodes' positions, shape (elements + 1, 3) [m]."""
        fraction = np.linspace(0.0, 1.0, elements + 1)[:, None]
        return self.base + (self.tip - self.base) * fraction


@dataclass(frozen=True)
class Line:
    """One rod in Exudyn.

    `velocities` returns those of its centre line at `STATIONS`, (11, 3), in the system's present
    state; `joint` is the revolute joint's pair of markers, `tip` the marker at A_i.
    """

    velocities: Callable[[], Array]
    joint: tuple[int, int]
    tip: int


AddRod = Callable[[Any, Any, Axis], Line]
"""Adds one rod and its revolute joint to (exudyn, system), and says what it added."""


def describe(
    theory: str, order: float, refinements: tuple[int, int], remark: str, **more: Any
) -> Info:
    """Return what is known of a model on Exudyn; `more`: other fields of `Info`.

    It is there only if Exudyn can be imported.
    """
    try:
        version, missing = str(load().__version__), ""
    except UnavailableError as error:
        version, missing = "", str(error)
    return Info(
        theory, "Exudyn", version, order, refinements, remark=remark, missing=missing, **more
    )


def load() -> Any:
    """Return the module exudyn, or raise `UnavailableError` with what to do."""
    try:
        import exudyn
    except ModuleNotFoundError:
        raise UnavailableError("exudyn is not installed; pip install exudyn") from None
    except ImportError as error:
        # Its renderer is linked to OpenGL even where nothing is drawn.
        remedy = "install the system's OpenGL library (Debian: apt-get install libgl1)"
        raise unlinked("exudyn", error, remedy) from None
    return exudyn


@contextmanager
def system(exu: Any, name: str) -> Iterator[Any]:
    """Open an empty system that prints nothing, and free its memory afterwards."""
    said = exu.config.printToConsole, exu.config.suppressWarnings
    exu.config.printToConsole, exu.config.suppressWarnings = False, True
    container = exu.SystemContainer()
    try:
        yield container.AddSystem()
    except (exu.ExudynError, np.linalg.LinAlgError) as error:
        # Exudyn ends its messages with the line of this file that asked: no use to a reader.
        raise ModelError(f"{name}: {str(error).split(' [Python file')[0]}") from error
    finally:
        container.Reset()
        exu.config.printToConsole, exu.config.suppressWarnings = said


def run(
    name: str,
    theory: str,
    elements: int,
    add_rod: AddRod,
    mechanism: Mechanism,
    pose: Pose,
    count: int,
) -> Modes:
    """Return the `count` lowest modes of the platform on rods made by `add_rod`.

    Raises `InputError` for many poses, a pose out of reach or too many modes, and `ModelError`
    where joints are open or Exudyn fails.
    """

    def solve(mechanism: Mechanism, pose: Pose, count: int) -> Modes:
        return _solve(name, theory, elements, add_rod, mechanism, pose, count)

    return in_robot_units(name, solve, mechanism, pose, count)


def _solve(
    name: str,
    theory: str,
    elements: int,
    add_rod: AddRod,
    mechanism: Mechanism,
    pose: Pose,
    count: int,
) -> Modes:
    exu = load()
    begin = time.perf_counter()
    with phase("building"):
        placed = place(mechanism, pose)
        o, R, axes = placed.centre, placed.rotation, rod_axes(mechanism, placed)
    with system(exu, name) as mbs:
        with phase("building"):
            node, body = add_platform(exu, mbs, mechanism.platform, o, R)
            lines = [add_rod(exu, mbs, axis) for axis in axes]
            spherical = [
                add_spherical(exu, mbs, body, limb.platform_point, line.tip)
                for line, limb in zip(lines, mechanism.limbs, strict=True)
            ]
        with phase(SIMULATOR):
            mbs.Assemble()
        with phase("shapes"):
            residual = largest_gap(exu, mbs, mechanism, [line.joint for line in lines], spherical)
        with phase(SIMULATOR):
            M, K, _, J = mbs.ComputeLinearizedSystem(returnConstraintJacobian=True)
        if not np.isfinite(K).all() or not np.isfinite(M).all():
            raise ModelError(f"{name}: Exudyn's matrices hold values that are not finite")
        built = time.perf_counter()
        frequencies, q, free = constrained_modes(name, K, M, J.T, count)
        solved = time.perf_counter()
        with phase("shapes"):
            platform, limbs = read_shapes(exu, mbs, q, node, lines)
    return Modes(
        frequencies=frequencies,
        platform=platform,
        limbs=limbs,
        theory=theory,
        model=name,
        version=f"exudyn {exu.__version__}",
        elements=elements,
        dofs=free,
        residual=residual,
        build_seconds=built - begin,
        solve_seconds=solved - built,
    )


def rod_axes(mechanism: Mechanism, placed: Placement) -> list[Axis]:
    """Return where every rod is, in the simulators' own placement."""
    result = []
    for i, limb in enumerate(mechanism.limbs):
        along, about = placed.along[i], placed.about[i]
        frame = np.stack([along, about, np.cross(along, about)], axis=1)
        base, length = np.array(limb.base), float(placed.lengths[i])
        result.append(Axis(limb.rod, base, placed.tips[i], frame, length))
    return result


def add_rigid_nodes(exu: Any, mbs: Any, points: Array, rotation: Array) -> list[int]:
    """Add nodes with a position and Euler parameters, which know no singular direction."""
    parameters = scipy.spatial.transform.Rotation.from_matrix(rotation).as_quat(scalar_first=True)
    make = exu.itemInterface.NodeRigidBodyEP
    return [mbs.AddNode(make(referenceCoordinates=[*point, *parameters])) for point in points]


def add_platform(exu: Any, mbs: Any, platform: Platform, o: Array, R: Array) -> tuple[int, int]:
    """Add the rigid platform with its centre of mass at o; return its node and body."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = platform.inertia
    (node,) = add_rigid_nodes(exu, mbs, o[None], R)
    body = exu.itemInterface.ObjectRigidBody(
        nodeNumber=node, physicsMass=platform.mass, physicsInertia=[xx, yy, zz, yz, xz, xy]
    )
    return node, int(mbs.AddObject(body))


def add_spherical(exu: Any, mbs: Any, body: int, point: Any, marker: int) -> tuple[int, int]:
    """Join `marker` to a `point` of a body by an ideal spherical joint; return both markers."""
    items = exu.itemInterface
    held = int(mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=body, localPosition=list(point))))
    mbs.AddObject(items.SphericalJoint(markerNumbers=[held, marker]))
    return held, marker


def largest_gap(
    exu: Any,
    mbs: Any,
    mechanism: Mechanism,
    revolute: list[tuple[int, int]],
    spherical: list[tuple[int, int]],
) -> float:
    """Return the largest gap of a joint [m]: between markers, and along a revolute axis as given.

    `revolute` and `spherical` hold the pair of markers of every limb; those at A_i are the
    platform's first.
    """
    where = exu.OutputVariableType.Position
    joints = revolute + spherical
    ends = np.array([[mbs.GetMarkerOutput(m, where) for m in joint] for joint in joints])
    beside = placement.largest_gap(mechanism, ends[len(revolute) :, 0])
    return max(beside, float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).max()))


def along_elements(
    exu: Any, mbs: Any, axis: Axis, elements: list[int], start: float
) -> Callable[[], Array]:
    """Return `Line.velocities` of equal elements whose local coordinate begins at `start` [m]."""
    velocity, s = exu.OutputVariableType.Velocity, len(elements)
    which = np.minimum((STATIONS * s).astype(int), s - 1)
    local = start + (STATIONS * s - which) * axis.length / s
    places = [(elements[e], [x, 0.0, 0.0]) for e, x in zip(which, local, strict=True)]
    return lambda: np.array([mbs.GetObjectOutputBody(e, velocity, at) for e, at in places])


def read_shapes(exu: Any, mbs: Any, q: Array, node: int, lines: list[Line]) -> tuple[Array, Array]:
    """Return the platform's (m, 6) and the centre lines' (m, n, 11, 3) motion in modes q (N, m)."""
    velocity, spin = exu.OutputVariableType.Velocity, exu.OutputVariableType.AngularVelocity
    platform, limbs = [], []
    for mode in q.T:
        mbs.systemData.SetODE2Coordinates_t(mode)
        platform.append(np.r_[mbs.GetNodeOutput(node, velocity), mbs.GetNodeOutput(node, spin)])
        limbs.append([line.velocities() for line in lines])
    return np.array(platform), np.array(limbs)
