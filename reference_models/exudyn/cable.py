"""Exudyn's absolute nodal coordinate cable as the limbs of the mechanism."""

from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from analytic.errors import count as whole
from analytic.mechanism import Mechanism
from analytic.model import Info
from analytic.modes import Modes
from analytic.pose import Pose
from reference_models.exudyn.chain import chain_modes
from reference_models.exudyn.chain_cables import add_cables
from reference_models.exudyn.system import (
    Axis,
    Line,
    add_spherical,
    along_elements,
    describe,
    run,
)

NAME = "exudyn-cable"
THEORY = "Euler-Bernoulli"


@dataclass(frozen=True)
class ExudynCable:
    """Limbs of `elements` ObjectANCFCable: positions and slope vectors as coordinates.

    Cubic along the rod in all three directions; no shear, no rotary inertia, no torsion.
    Raises `InputError` for fewer than one element.
    """

    elements: int = 8

    def __post_init__(self) -> None:
        whole("elements", self.elements)

    @classmethod
    def info(cls) -> Info:
        """Return what the model is; never raises."""
        remark = "the element has no torsion: the limbs' torsion modes are absent"
        return describe(THEORY, 4, (8, 16), remark, limit="euler-bernoulli", torsion=False)

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        """Return the `count` lowest modes at one pose; raises as `exudyn_system.run`.

        Limbs of any chain that twists no rod are taken, see `chain_cables`.
        """
        if not mechanism.simple:
            add = partial(add_cables, self.elements)
            return chain_modes(NAME, THEORY, self.elements, add, mechanism, pose, count, spin=False)
        return run(NAME, THEORY, self.elements, self._add_rod, mechanism, pose, count)

    def _add_rod(self, exu: Any, mbs: Any, axis: Axis) -> Line:
        items, rod = exu.itemInterface, axis.rod
        young = rod.material.young
        along, about = axis.frame[:, 0], axis.frame[:, 1]
        nodes = [
            mbs.AddNode(items.NodePointSlope1(referenceCoordinates=[*point, *along]))
            for point in axis.points(self.elements)
        ]
        elements = [
            mbs.AddObject(
                items.ObjectANCFCable(
                    nodeNumbers=list(ends),
                    physicsLength=axis.length / self.elements,
                    physicsMassPerLength=rod.material.density * rod.area,
                    physicsBendingStiffness=young * rod.second_moment,
                    physicsAxialStiffness=young * rod.area,
                )
            )
            for ends in pairwise(nodes)
        ]
        first, last = (
            mbs.AddMarker(items.MarkerNodePosition(nodeNumber=node))
            for node in (nodes[0], nodes[-1])
        )
        # A revolute joint holds the point and keeps the slope r' square to its axis, e . r' = 0.
        # The length of r' is strain: held as well, it would clamp the rod's axial motion.
        ground = mbs.AddObject(items.ObjectGround(referencePosition=axis.base))
        joint = add_spherical(exu, mbs, ground, (0.0, 0.0, 0.0), first)
        fixed = mbs.AddMarker(
            items.MarkerNodeCoordinates(nodeNumber=mbs.AddNode(items.NodePointGround()))
        )
        moving = mbs.AddMarker(items.MarkerNodeCoordinates(nodeNumber=nodes[0]))
        mbs.AddObject(
            items.ObjectConnectorCoordinateVector(
                markerNumbers=[moving, fixed],
                scalingMarker0=np.array([[0.0, 0.0, 0.0, *about]]),
                scalingMarker1=np.zeros((0, 0)),
                offset=[0.0],
            )
        )
        return Line(along_elements(exu, mbs, axis, elements, 0.0), joint, last)
