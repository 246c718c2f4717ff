"""A compiled MuJoCo model at rest: its K, M and joint Jacobian, from the forces it computes.

`mjd_transitionFD` is no way to K: it corrupts its state with flexible rods (4.0.0) and linearises
softened joints.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from reference_models.protocol import ModelError
from reference_models.spent import SIMULATOR, phase

Array = NDArray[np.float64]

REACH = 2
"""Vertices to either side that feel a vertex move: bending joins three."""


@contextmanager
def strict() -> Iterator[None]:
    """Turn MuJoCo's warnings and errors into `ModelError`, and keep its log file from being.

    Warnings raise when the block ends, as no exception may cross MuJoCo's own C code.
    """
    heard: list[str] = []
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(heard.append)
    try:
        yield
    except (mujoco.FatalError, mujoco.UnexpectedError) as error:
        raise ModelError(f"MuJoCo: {error}") from None
    finally:
        mujoco.set_mju_user_warning(before)
    if heard:
        raise ModelError(f"MuJoCo warns: {'; '.join(heard)}")


def compiled(document: str) -> Any:
    """Return the model of an MJCF text."""
    try:
        return mujoco.MjModel.from_xml_string(document)
    except ValueError as error:
        raise ModelError(f"MuJoCo cannot compile this mechanism: {error}") from None


def at_rest(model: Any) -> Any:
    """Return the data of `model` in its reference position, joints and inertia evaluated."""
    data = mujoco.MjData(model)
    mujoco.mj_setConst(model, data)  # a changed model; M of a lone body is such a constant
    mujoco.mj_resetData(model, data)
    mujoco.mj_fwdPosition(model, data)
    return data


def inertia(model: Any, data: Any) -> Array:
    """Return M, shape (nv, nv)."""
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    return M


def joint_jacobian(model: Any, data: Any) -> Array:
    """Return J of the joints closed by constraints, shape (rows, nv); the option must be dense."""
    return np.array(data.efc_J).reshape(-1, model.nv) if data.nefc else np.zeros((0, model.nv))


def stiffness(model: Any, data: Any, limbs: int, step: float) -> Array:
    """Return K = -d(qfrc_passive)/dq at rest, shape (nv, nv), by finite differences.

    The coordinates are 6 of the platform, then for each of `limbs` the hinge's and 3 a vertex.
    Coordinates too far apart to feel each other move at once: about 20 groups, however fine.
    """
    nv = model.nv
    own = (nv - 6) // limbs
    place = np.r_[0, 1 + np.arange(own - 1) // 3]
    component = np.r_[0, np.arange(own - 1) % 3]
    colour = 3 * (place % (2 * REACH + 1)) + component
    near = np.abs(place[:, None] - place) <= REACH

    K = np.zeros((nv, nv))
    for i in range(6):
        K[:, i] = -_slope(model, data, np.eye(nv)[i], step)
    K[:6, 6:] = K[6:, :6].T
    for group in np.unique(colour):
        moved = np.flatnonzero(colour == group)
        force = -_slope(model, data, np.r_[np.zeros(6), np.tile(colour == group, limbs)], step)
        for i, start in enumerate(range(6, nv, own)):
            block = K[start : start + own, start : start + own]
            block[:, moved] = force[6 + i * own : 6 + (i + 1) * own, None] * near[:, moved]
    return K


def _slope(model: Any, data: Any, direction: Array, step: float) -> Array:
    """Return d(qfrc_passive) along `direction`, by differences of fourth order.

    Second order would leave the edges' stretch under a sideways step, EA step^2 / (2 l^3), in K:
    nothing to one vertex, but much to a smooth mode of a fine mesh.
    """
    near, far = (
        _force(model, data, direction * h) - _force(model, data, direction * -h)
        for h in (step, 2 * step)
    )
    return np.asarray((8 * near - far) / (12 * step))


def _force(model: Any, data: Any, displacement: Array) -> Array:
    data.qpos[:] = model.qpos0
    with phase(SIMULATOR):
        mujoco.mj_integratePos(model, data.qpos, displacement, 1.0)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_flex(model, data)
        mujoco.mj_passive(model, data)
    return np.array(data.qfrc_passive)
