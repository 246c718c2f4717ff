"""What both MuJoCo models share: the installed version, and the modes of a compiled mechanism."""

import time
from collections.abc import Callable
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.mechanism import Mechanism
from analytic.modes import Modes
from analytic.pose import Pose
from reference_models.mujoco.rig import Limb, Rods, document, limbs_of, surplus
from reference_models.projection import ROUNDING, constrained_modes
from reference_models.protocol import UnavailableError
from reference_models.spent import SIMULATOR, phase
from reference_models.units import in_robot_units

Array = NDArray[np.float64]

OLDEST, TOO_NEW = (3, 17), (5,)
INSTALL = "pip install 'mujoco>=3.17,<5'"


@cache
def installed() -> str:
    """Return MuJoCo's version without loading it, empty where there is none."""
    try:
        return version("mujoco")
    except PackageNotFoundError:
        return ""


def release(number: str) -> tuple[int, ...]:
    """Return the first two parts of a version."""
    return tuple(int(part) for part in number.split(".")[:2] if part.isdigit())


def missing() -> str:
    """Return why the models cannot run here and what to do about it, empty if they can."""
    number = installed()
    if not number:
        return f"MuJoCo is not installed; {INSTALL}"
    if not OLDEST <= release(number) < TOO_NEW:
        return f"MuJoCo {number} is installed, 3.17 or later and before 5 is needed; {INSTALL}"
    return ""


def run(
    name: str,
    theory: str,
    elements: int,
    make_rods: Callable[[list[Limb]], Rods],
    stiffness: Callable[[Any, Any, list[Limb]], Array],
    mechanism: Mechanism,
    pose: Pose,
    count: int,
    rounding: float = ROUNDING,
) -> Modes:
    """Return the `count` lowest modes of the platform on rods made by `make_rods`.

    `stiffness` returns K (nv, nv) of a compiled model with its data at rest, whose entries are
    known to `rounding`, relative.
    Raises `InputError` for many poses, a pose out of reach or more modes than coordinates,
    `ModelError` where MuJoCo warns or fails or a joint is open, `UnavailableError` without a fit
    MuJoCo.
    """
    if reason := missing():
        raise UnavailableError(f"{name} cannot run here: {reason}")

    def solve(mechanism: Mechanism, pose: Pose, count: int) -> Modes:
        return _solve(
            name, theory, elements, make_rods, stiffness, mechanism, pose, count, rounding
        )

    return in_robot_units(name, solve, mechanism, pose, count)


def _solve(
    name: str,
    theory: str,
    elements: int,
    make_rods: Callable[[list[Limb]], Rods],
    stiffness: Callable[[Any, Any, list[Limb]], Array],
    mechanism: Mechanism,
    pose: Pose,
    count: int,
    rounding: float,
) -> Modes:
    # These need MuJoCo; info() must not.
    from reference_models.mujoco import geometry
    from reference_models.mujoco import linearise as mj

    begin = time.perf_counter()
    with phase("building"):
        limbs = limbs_of(mechanism, pose)
        rods = make_rods(limbs)
        text = document(mechanism, pose, limbs, rods)
    with mj.strict():
        with phase(SIMULATOR):
            model = mj.compiled(text)
        model.body("platform").inertia -= surplus(mechanism)
        rods.amend(model)
        with phase(SIMULATOR):
            data = mj.at_rest(model)
        with phase("shapes"):
            residual = geometry.gap(model, data, mechanism, limbs)
            platform = geometry.jacobian(model, data, "platform", data.body("platform").xpos)
            motion = np.stack(
                [
                    geometry.centre_line(model, data, limb, names)
                    for limb, names in zip(limbs, rods.bodies, strict=True)
                ]
            )
        with phase(SIMULATOR):
            M, J = mj.inertia(model, data), mj.joint_jacobian(model, data)
        with phase("linearising"):
            K = stiffness(model, data, limbs)
    built = time.perf_counter()
    frequencies, shapes, dofs = constrained_modes(name, K, M, J, count, rounding)
    return Modes(
        frequencies=frequencies,
        platform=(platform @ shapes).T,
        limbs=np.einsum("iskq,qm->misk", motion, shapes),
        theory=theory,
        model=name,
        version=f"mujoco {installed()}",
        elements=elements,
        dofs=dofs,
        residual=residual,
        build_seconds=built - begin,
        solve_seconds=time.perf_counter() - built,
    )
