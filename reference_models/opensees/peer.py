"""What OpenSees takes for the same frames, from an environment of its own.

`python -m reference_models.opensees.peer` makes the environment, once, from the package index, in
the user's cache folder: OpenSees' licence forbids shipping it, and no other command installs it.
"""

import json
import os
import subprocess
import sys
import venv
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from analytic.mechanism import Mechanism
from analytic.pose import Pose
from reference_models.folder import default_folder
from reference_models.placement import place
from reference_models.protocol import ModelError, UnavailableError

Array = NDArray[np.float64]
PACKAGES = ("openseespy==3.7.1.2", "numpy", "scipy")
SOLVERS = {"LAPACK": "-fullGenLapack", "ARPACK": "-genBandArpack"}
"""OpenSees' own solvers, dense and of bands."""
LIMIT = 600.0
"""Seconds that a measurement may take."""
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


@dataclass(frozen=True)
class Peer:
    """What a frame took: seconds by round of its `build`, its `solve` and of `eigh` beside them."""

    name: str
    elements: int
    frequencies: Array
    build: Array
    solve: Array
    eigh: Array


def python() -> Path:
    """Return the environment's Python, or raise `UnavailableError` with what to do."""
    program = _program()
    if not (program.parents[1] / "complete").exists():
        raise UnavailableError(
            "OpenSees needs an environment of its own; python -m reference_models.opensees.peer"
        )
    return program


def make() -> Path:
    """Return the environment's Python, made anew with pip, or raise `UnavailableError`."""
    program = _program()
    try:
        venv.create(program.parents[1], clear=True, with_pip=True)
        install = [str(program), "-m", "pip", "install", "--quiet", *PACKAGES]
        subprocess.run(install, capture_output=True, text=True, check=True)
        (program.parents[1] / "complete").touch()
    except (OSError, subprocess.SubprocessError) as error:
        raise UnavailableError(f"OpenSees cannot be installed: {_reason(error)}") from None
    return program


def timed(
    mechanism: Mechanism,
    pose: Pose,
    elements: int,
    count: int,
    rounds: int,
    pair: tuple[Array, Array],
) -> list[Peer]:
    """Return what the Euler-Bernoulli frame takes, by every solver.

    `pair`: K and M whose `scipy.linalg.eigh` is timed beside it, in the same process. Raises
    `UnavailableError` without the environment, and `ModelError` where OpenSees fails.
    """
    program, found = python(), []
    for name, solver in SOLVERS.items():
        problem = problem_of(mechanism, pose) | {
            "elements": elements, "count": count, "rounds": rounds, "solver": solver,
            "K": pair[0].tolist(), "M": pair[1].tolist(),
        }  # fmt: skip
        try:
            ran = subprocess.run(
                [program, Path(__file__).with_name("frame.py")],
                input=json.dumps(problem),
                capture_output=True,
                text=True,
                timeout=LIMIT,
                env=os.environ | ONE_THREAD,
                check=True,
            )
            answer = json.loads(next(t for t in ran.stdout.splitlines() if t.startswith("{")))
        except (OSError, subprocess.SubprocessError, StopIteration, ValueError) as error:
            raise ModelError(f"OpenSees: {_reason(error)}") from None
        parts = (np.array(answer[key][1:]) for key in ("build", "solve", "eigh"))
        label = f"OpenSees {answer['version']}, {name}"
        found.append(Peer(label, elements, np.array(answer["frequencies"]), *parts))
    return found


def problem_of(mechanism: Mechanism, pose: Pose) -> dict[str, object]:
    """Return the frame of a mechanism at one pose in the platform's own axes about o.

    Raises `ModelError` for a platform whose inertia is not diagonal there.
    """
    placed, inertia = place(mechanism, pose), np.array(mechanism.platform.inertia)
    moments = np.diag(inertia)
    if np.abs(inertia - np.diag(moments)).max() > 1e-9 * moments.max():
        raise ModelError("OpenSees takes a platform whose inertia is diagonal in its own axes")
    R, limbs = placed.rotation, []
    for i, limb in enumerate(mechanism.limbs):
        rod, frame = limb.rod, placed.frames[i]
        base = (np.array(limb.base) - placed.centre) @ R
        tip = (placed.tips[i] - placed.centre) @ R
        limbs.append({
            "base": base.tolist(), "tip": tip.tolist(),
            "x": (frame[:, 0] @ R).tolist(), "y": (frame[:, 1] @ R).tolist(),
            "A": rod.area, "E": rod.material.young, "G": rod.material.shear,
            "polar": rod.polar_moment, "second": rod.second_moment, "rho": rod.material.density,
        })  # fmt: skip
    return {"mass": mechanism.platform.mass, "inertia": moments.tolist(), "limbs": limbs}


def _reason(error: Exception) -> str:
    """Return the last line that a failed program said, or the error itself."""
    said = str(getattr(error, "stderr", None) or "").strip()
    return said.splitlines()[-1] if said else str(error)


def _program() -> Path:
    folder = default_folder() / PACKAGES[0]
    return folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


if __name__ == "__main__":
    try:
        print(make())
    except UnavailableError as error:
        sys.exit(str(error))
