"""Exudyn's geometrically exact beam as the limbs of the mechanism."""

from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from analytic.errors import InputError, number
from analytic.errors import count as whole
from analytic.mechanism import Mechanism, Rod
from analytic.model import Info
from analytic.modes import Modes
from analytic.pose import Pose
from reference_models.exudyn.chain import chain_modes
from reference_models.exudyn.chain_beams import add_beams
from reference_models.exudyn.system import (
    Axis,
    Line,
    add_rigid_nodes,
    along_elements,
    describe,
    run,
)

NAME = "exudyn-beam"


@dataclass(frozen=True)
class ExudynBeam:
    """Limbs of `elements` ObjectBeamGeometricallyExact: Timoshenko with rotary inertia.

    Linear along the rod between nodes with a position and Euler parameters. `shear` is the shear
    coefficient of a solid round section, "cowper", "0.9", "6/7" or a positive number. Raises
    `InputError` for fewer than one element or a bad `shear`.
    """

    elements: int = 16
    shear: str | float = "cowper"

    def __post_init__(self) -> None:
        whole("elements", self.elements)
        shear_coefficient(self.shear, 0.3)

    @classmethod
    def info(cls) -> Info:
        """Return what the model is; never raises."""
        remark = "second order: extrapolate, or compare with far more elements than elsewhere"
        theory = "Timoshenko, kappa by Cowper"
        return describe(theory, 2, (12, 24), remark, ladder=(6, 12, 24), limit="timoshenko")

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        """Return the `count` lowest modes at one pose; raises as `exudyn_system.run`."""
        if not mechanism.simple:
            theory = self.info().theory
            add = partial(add_beams, self.elements, self._kappas)
            return chain_modes(NAME, theory, self.elements, add, mechanism, pose, count)
        ratios = {limb.rod.material.poisson for limb in mechanism.limbs}
        kappas = sorted({shear_coefficient(self.shear, ratio) for ratio in ratios})
        labels = "; ".join(f"Timoshenko, kappa={kappa:.4g}" for kappa in kappas)
        return run(NAME, labels, self.elements, self._add_rod, mechanism, pose, count)

    def _kappas(self, rod: Rod) -> tuple[float, float]:
        """Return the shear coefficients along x and y; Cowper's of a hollow section too."""
        own, nu = rod.section, rod.material.poisson
        if own.shear_coefficients is not None:
            return own.shear_coefficients
        if own.diameter is None:
            raise InputError("Section.shear_coefficients", None, "two, as the section is not round")
        kappa = shear_coefficient(self.shear, nu)
        if self.shear == "cowper":
            m2 = (own.bore / own.diameter) ** 2
            w = (1 + m2) ** 2
            kappa = 6 * (1 + nu) * w / ((7 + 6 * nu) * w + (20 + 12 * nu) * m2)
        return kappa, kappa

    def _add_rod(self, exu: Any, mbs: Any, axis: Axis) -> Line:
        items, rod = exu.itemInterface, axis.rod
        nodes = add_rigid_nodes(exu, mbs, axis.points(self.elements), axis.frame)
        section = exu.BeamSection()
        material = rod.material
        section.massPerLength = material.density * rod.area
        section.inertia = material.density * np.diag(
            [rod.polar_moment, rod.second_moment, rod.second_moment]
        )
        bending = material.young * rod.second_moment
        shear = shear_coefficient(self.shear, material.poisson)
        shearing = shear * material.shear * rod.area
        twisting = material.shear * rod.polar_moment
        section.stiffnessMatrix = np.diag(
            [material.young * rod.area, shearing, shearing, twisting, bending, bending]
        )
        size = axis.length / self.elements
        elements = [
            mbs.AddObject(
                items.ObjectBeamGeometricallyExact(
                    nodeNumbers=list(ends), physicsLength=size, sectionData=section
                )
            )
            for ends in pairwise(nodes)
        ]
        # Ground and node share the rod's frame, whose second axis is the revolute axis.
        ground = mbs.AddObject(
            items.ObjectGround(referencePosition=axis.base, referenceRotation=axis.frame)
        )
        fixed = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=ground))
        first = mbs.AddMarker(items.MarkerNodeRigid(nodeNumber=nodes[0]))
        mbs.AddObject(
            items.GenericJoint(markerNumbers=[fixed, first], constrainedAxes=[1, 1, 1, 1, 0, 1])
        )
        last = mbs.AddMarker(items.MarkerNodePosition(nodeNumber=nodes[-1]))
        velocities = along_elements(exu, mbs, axis, elements, -size / 2)
        return Line(velocities, (fixed, first), last)


def shear_coefficient(shear: str | float, poisson: float) -> float:
    """Return kappa of a solid round section; "cowper" is 6 (1 + nu) / (7 + 6 nu).

    Raises `InputError` for anything else than the names above and positive numbers.
    """
    named = {"cowper": 6 * (1 + poisson) / (7 + 6 * poisson), "0.9": 0.9, "6/7": 6 / 7}
    if isinstance(shear, str):
        if shear not in named:
            raise InputError("shear", shear, f"one of {', '.join(named)}, or a positive number")
        return named[shear]
    return number("shear", shear, "a positive shear coefficient", positive=True)
