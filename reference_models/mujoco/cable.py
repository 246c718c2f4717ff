"""`mujoco-cable`: MuJoCo's elastic rod, whichever the installed version has."""

from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.errors import count as whole
from analytic.mechanism import Mechanism
from analytic.model import Info
from analytic.modes import Modes
from analytic.pose import Pose
from reference_models.mujoco import composite, flex, system
from reference_models.mujoco.rig import STEP, Rods, document, limbs_of, surplus
from reference_models.mujoco.system import Assembly

Array = NDArray[np.float64]

NAME = "mujoco-cable"
ROUNDING = 1e-10
"""Of an entry of K by differences, relative; 3e-12 is observed."""


@dataclass(frozen=True)
class MujocoCable:
    """Rods of `elements` segments a limb: a flex on MuJoCo 4, the composite cable on MuJoCo 3.

    Base joints are MuJoCo's hinges. At A_i the flex shares a point with the platform; the
    composite is closed by `connect`, by exact projection and not by MuJoCo's softened solver.
    Raises `InputError` for fewer than three elements: MuJoCo's own cable does not compile with two.
    """

    elements: int = 16

    def __post_init__(self) -> None:
        whole("elements", self.elements, at_least=3)

    @classmethod
    def info(cls) -> Info:
        """Return theory, order and version of what the installed MuJoCo offers."""
        rods = _kind()
        return Info(
            rods.THEORY,
            "MuJoCo",
            system.installed(),
            rods.ORDER,
            rods.REFINEMENTS,
            remark=rods.REMARK,
            missing=system.missing(),
            torsion=rods.TORSION,
            limit=rods.LIMIT,
            # Differences of step 1e-7 m are known to 5e-10 of EA / l, the largest entry, which is
            # some hundred times the stiffness against bending.
            precision=1e-7,
        )

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        """Return the `count` lowest modes at one pose; raises as `system.run`."""
        return system.run(
            NAME, _kind().THEORY, self.elements, self._assembly, mechanism, pose, count, ROUNDING
        )

    def _assembly(self, mechanism: Mechanism, pose: Pose) -> Assembly:
        from reference_models.mujoco import geometry
        from reference_models.mujoco import linearise as mj

        limbs = limbs_of(mechanism, pose)
        rods: Rods = _kind().rods(limbs, self.elements)

        def amend(model: Any) -> None:
            model.body("platform").inertia -= surplus(mechanism)
            rods.amend(model)

        def gap(model: Any, data: Any) -> float:
            return geometry.gap(model, data, mechanism, limbs)

        def lines(model: Any, data: Any) -> Array:
            each = zip(limbs, rods.bodies, strict=True)
            return np.stack([geometry.centre_line(model, data, *of) for of in each])

        def stiffness(model: Any, data: Any) -> Array:
            step = STEP * min(limb.length for limb in limbs)
            return mj.stiffness(model, data, len(limbs), step)

        return Assembly(document(mechanism, pose, limbs, rods), amend, gap, lines, stiffness)


def _kind() -> ModuleType:
    is_3 = system.release(system.installed())[:1] == (3,)
    return composite if is_3 else flex
