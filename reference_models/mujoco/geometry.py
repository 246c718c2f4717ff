"""Where a compiled MuJoCo model has its joints and centre lines, and how they move."""

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, make_interp_spline

from analytic.mechanism import Mechanism
from analytic.modes import STATIONS
from reference_models.mujoco.rig import Limb
from reference_models.mujoco.segments import End, Segmented
from reference_models.placement import largest_gap

Array = NDArray[np.float64]


def gap(model: Any, data: Any, mechanism: Mechanism, limbs: list[Limb]) -> float:
    """Return the largest gap of a joint: hinge from B_i, along its axis as given, rod from A_i.

    A `connect` knows its gap; a flex's last vertex, on the platform, is where the platform is.
    """
    hinges = [model.body(f"B{i}").jntadr[0] for i in range(len(limbs))]
    gaps = [
        data.xanchor[hinges] - [limb.base for limb in limbs],
        np.reshape(data.efc_pos, (-1, 3)),
    ]
    if model.nflex:
        ends = data.flexvert_xpos[model.flex_vertadr + model.flex_vertnum - 1]
        gaps.append(ends - [limb.tip for limb in limbs])
    tips = np.array([data.site(f"A{i}").xpos for i in range(len(limbs))])
    apart = float(np.linalg.norm(np.concatenate(gaps), axis=1).max())
    return max(apart, largest_gap(mechanism, tips))


def jacobian(model: Any, data: Any, body: str, point: Array) -> Array:
    """Return the map from coordinates to the motion of `body` at a global `point`.

    Shape (6, nv): displacement and rotation, global axes.
    """
    J = np.zeros((6, model.nv))
    mujoco.mj_jac(model, data, J[:3], J[3:], point, model.body(body).id)
    return J


def centre_line(model: Any, data: Any, limb: Limb, bodies: list[str]) -> Array:
    """Return the map from coordinates to a limb's displacement at `STATIONS`, (11, 3, nv).

    A cubic spline through the vertices, which are the origins of `bodies` and, last, A_i.
    """
    points = np.array([*(data.body(name).xpos for name in bodies[:-1]), limb.tip])
    maps = [jacobian(model, data, *at)[:3] for at in zip(bodies, points, strict=True)]
    along = (points - limb.base) @ limb.along / limb.length
    return np.asarray(CubicSpline(along, maps)(STATIONS))


def chain_line(model: Any, data: Any, limb: Segmented) -> Array:
    """Return the map from coordinates to the displacement of a chain at `STATIONS`, (11, 3, nv).

    Along a rod a cubic spline through its ends and segments' middles; along a link a line.
    """
    stations = STATIONS * limb.limb.length
    found = np.zeros((len(stations), 3, model.nv))
    done = np.zeros(len(stations), dtype=bool)
    for piece in limb.pieces:
        own = ~done & ((stations <= piece.end) | (piece is limb.pieces[-1]))
        done |= own
        if not own.any():
            continue
        n = len(piece.bodies)
        inner = (np.arange(n) + 0.5) / n if n else np.zeros(0)
        along = piece.begin + np.r_[0.0, inner, 1.0] * (piece.end - piece.begin)
        middles = [jacobian(model, data, b, data.body(b).xpos)[:3] for b in piece.bodies]
        first, last = (_end(model, data, end) for end in piece.ends)
        maps = np.array([first, *middles, last])
        at = np.clip(stations[own], piece.begin, piece.end)
        curve = CubicSpline(along, maps) if n else make_interp_spline(along, maps, k=1)
        found[own] = curve(at)
    return found


def _end(model: Any, data: Any, end: End) -> Array:
    """Return the motion (3, nv) of an end of a rod."""
    own, beside = (jacobian(model, data, b, end.point)[:3] for b in (end.body, end.beside))
    return np.asarray(own - end.share @ (own - beside))
