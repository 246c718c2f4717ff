"""`mujoco-cable`: MuJoCo's elastic rod, whichever the installed version has."""

import time
from dataclasses import dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from types import ModuleType

import numpy as np

from analytic.errors import InputError
from analytic.errors import count as whole
from analytic.mechanism import Mechanism
from analytic.modes import Modes
from analytic.pose import Pose
from reference_models import mujoco_composite, mujoco_flex
from reference_models.mujoco_rig import document, limbs_of, surplus
from reference_models.projection import constrained_modes
from reference_models.protocol import Info, UnavailableError, check_closure

OLDEST, TOO_NEW = (3, 17), (5,)
INSTALL = "pip install 'mujoco>=3.17,<5'"


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
        installed = _installed()
        rods = _rods(installed)
        return Info(
            rods.THEORY,
            "MuJoCo",
            installed,
            rods.ORDER,
            rods.REFINEMENTS,
            remark=rods.REMARK,
            missing=_missing(installed),
        )

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        """Return the `count` lowest modes at one pose.

        Raises `InputError` for a pose out of reach or more modes than coordinates, `ModelError`
        where MuJoCo warns or fails or a joint is open, `UnavailableError` without a fit MuJoCo.
        """
        installed = _installed()
        if missing := _missing(installed):
            raise UnavailableError(f"mujoco-cable cannot run here: {missing}")
        # These need MuJoCo; info() must not.
        from reference_models import mujoco_geometry as geometry
        from reference_models import mujoco_linearise as mj

        if pose.shape:
            raise InputError("pose", f"{pose.shape} poses", "one pose at a time for this model")
        begin = time.perf_counter()
        limbs = limbs_of(mechanism, pose)
        rods = _rods(installed).rods(limbs, self.elements)
        with mj.strict():
            model = mj.compiled(document(mechanism, pose, limbs, rods))
            model.body("platform").inertia -= surplus(mechanism)
            rods.amend(model)
            data = mj.at_rest(model)
            residual = check_closure("mujoco-cable", geometry.gap(model, data, limbs))
            platform = geometry.jacobian(model, data, "platform", data.body("platform").xpos)
            motion = np.stack(
                [
                    geometry.centre_line(model, data, limb, names)
                    for limb, names in zip(limbs, rods.bodies, strict=True)
                ]
            )
            M, J = mj.inertia(model, data), mj.joint_jacobian(model, data)
            step = mj.STEP * min(limb.length for limb in limbs)
            K = mj.stiffness(model, data, len(limbs), step)
        built = time.perf_counter()
        frequencies, shapes, dofs = constrained_modes(K, M, J, count)
        return Modes(
            frequencies=frequencies,
            platform=(platform @ shapes).T,
            limbs=np.einsum("iskq,qm->misk", motion, shapes),
            theory=_rods(installed).THEORY,
            model="mujoco-cable",
            version=f"mujoco {installed}",
            elements=self.elements,
            dofs=dofs,
            residual=residual,
            build_seconds=built - begin,
            solve_seconds=time.perf_counter() - built,
        )


@cache
def _installed() -> str:
    try:
        return version("mujoco")
    except PackageNotFoundError:
        return ""


def _release(installed: str) -> tuple[int, ...]:
    return tuple(int(part) for part in installed.split(".")[:2] if part.isdigit())


def _missing(installed: str) -> str:
    if not installed:
        return f"MuJoCo is not installed; {INSTALL}"
    if not OLDEST <= _release(installed) < TOO_NEW:
        return f"MuJoCo {installed} is installed, 3.17 or later and before 5 is needed; {INSTALL}"
    return ""


def _rods(installed: str) -> ModuleType:
    return mujoco_composite if _release(installed)[:1] == (3,) else mujoco_flex
