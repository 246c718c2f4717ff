"""What both MuJoCo models share: the installed version, and the modes of a compiled mechanism."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.mechanism import Mechanism
from analytic.modes import Modes
from analytic.pose import Pose
from reference_models.projection import ROUNDING, constrained_modes, vibrations
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


@dataclass(frozen=True)
class Assembly:
    """A mechanism at a pose, for MuJoCo.

    Attributes: the `document` in MJCF; `amend` puts right, in the compiled model, what the compiler
    cannot say exactly. Of a model and its data at rest: `gap`, how far joints are open [m];
    `lines`, the map from coordinates to the limbs' motion at `STATIONS` (n, 11, 3, nv);
    `stiffness`, K (nv, nv). `spins`: how many limbs may turn about themselves without energy; None
    where nothing that moves freely is left out.
    """

    document: str
    amend: Callable[[Any], None]
    gap: Callable[[Any, Any], float]
    lines: Callable[[Any, Any], Array]
    stiffness: Callable[[Any, Any], Array]
    spins: int | None = None


def run(
    name: str,
    theory: str,
    elements: int,
    assembly: Callable[[Mechanism, Pose], Assembly],
    mechanism: Mechanism,
    pose: Pose,
    count: int,
    rounding: float = ROUNDING,
    *,
    chains: bool = False,
) -> Modes:
    """Return the `count` lowest modes of what `assembly` makes of a mechanism.

    K's entries are known to `rounding`, relative; `chains`: whether limbs of any chain are taken.
    Raises `InputError` for many poses, a pose out of reach or more modes than coordinates,
    `ModelError` where MuJoCo warns or fails or a joint is open, `UnavailableError` without a fit
    MuJoCo.
    """
    if reason := missing():
        raise UnavailableError(f"{name} cannot run here: {reason}")

    def solve(mechanism: Mechanism, pose: Pose, count: int) -> Modes:
        return _solve(name, theory, elements, assembly, mechanism, pose, count, rounding)

    return in_robot_units(name, solve, mechanism, pose, count, chains=chains)


def _solve(
    name: str,
    theory: str,
    elements: int,
    assembly: Callable[[Mechanism, Pose], Assembly],
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
        made = assembly(mechanism, pose)
    with mj.strict():
        with phase(SIMULATOR):
            model = mj.compiled(made.document)
        made.amend(model)
        with phase(SIMULATOR):
            data = mj.at_rest(model)
        with phase("shapes"):
            residual = made.gap(model, data)
            platform = geometry.jacobian(model, data, "platform", data.body("platform").xpos)
            motion = made.lines(model, data)
        with phase(SIMULATOR):
            M, J = mj.inertia(model, data), mj.joint_jacobian(model, data)
        with phase("linearising"):
            K = made.stiffness(model, data)
    built = time.perf_counter()
    spins = made.spins or 0
    frequencies, shapes, dofs = constrained_modes(name, K, M, J, count + spins, rounding)
    if made.spins is not None:
        kept = vibrations(name, frequencies, spins, count)
        frequencies, shapes = frequencies[kept], shapes[:, kept]
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
