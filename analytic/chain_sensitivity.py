"""How frequencies of limbs of any chain change with a parameter.

A mode U of unit modal mass has d(omega^2)/dp = U^T (dD/dp) U at its own omega^2, in whatever
coordinates D is written: those of `network` may move with p. dD/dp is by central differences of
fourth order, so that only rounding is left, about 1e-9.
"""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from analytic.errors import InputError
from analytic.exact_chain import Exact, exact
from analytic.mechanism import Item, Joint, Limb, Mechanism, Rod, Section
from analytic.modes import check_count
from analytic.network import Network, network
from analytic.pose import Pose
from analytic.theory import Theory

Floats = NDArray[np.float64]

STEP = 1e-3
"""Relative to a parameter, or in radians."""
REPEATED = 1e-9
"""Modes whose omega^2 are closer than this, relative, share a matrix of products."""
MOST = 1500
"""Coordinates of elements up to which dense matrices are made."""
POSE = ("z", "azimuth", "tilt", "torsion", "x", "y")
ROD = ("young", "shear", "density", "diameter")
LIMB = (*ROD, "stiffness", "base_radius", "platform_radius")


def chain_sensitivities(
    mechanism: Mechanism,
    pose: Pose,
    parameters: list[tuple[str, int | None]],
    elements: int | None,
    theory: Theory,
    count: int,
) -> Floats:
    """Return d f / d p of the `count` lowest modes, (count, parameters), see `sensitivity`.

    `parameters` by name and limb, None for all of them.
    """
    problem = exact(mechanism, pose, theory)
    omega2, net, groups = _modes(problem, elements, count)
    slopes = np.empty((len(omega2), len(parameters)))
    for column, (name, limb) in enumerate(parameters):
        size = _size(mechanism, pose, name, limb, problem.unit)
        steps = [
            _problem(mechanism, pose, name, limb, k * STEP * size, theory, problem)
            for k in (-2, -1, 1, 2)
        ]
        for rows, U in groups:
            lam = np.array([float(omega2[rows].mean())])
            D = [
                U.T @ _dynamic(one, _alike(one, net, elements), elements, lam) @ U for one in steps
            ]
            change = (8 * (D[2] - D[1]) - (D[3] - D[0])) / (12 * STEP * size)
            slopes[rows, column] = np.linalg.eigvalsh((change + change.T) / 2)
    return np.asarray((slopes / (4 * np.pi * np.sqrt(omega2[:, None])))[:count])


def _modes(
    problem: Exact, elements: int | None, count: int
) -> tuple[Floats, Network, list[tuple[NDArray[np.intp], Floats]]]:
    """Return omega^2 in whole groups of repeated modes, their network, and each group's vectors."""
    still = problem.spins
    if elements is None:
        more = count + 6
        omega2 = problem.brackets(more).mean(axis=1)
        net = problem.cut(float(omega2[-1]))
        vectors = None
    else:
        net = problem.split(elements)
        if net.size > MOST:
            raise InputError("elements", elements, f"fewer: {net.size} coordinates exceed {MOST}")
        more = min(check_count(count, net.size - still) + 6, net.size - still)
        K, M = problem.pair(net)
        values, U = scipy.linalg.eigh(K, M, subset_by_index=(still, still + more - 1))
        omega2, vectors = values, U
    ends = np.flatnonzero(np.diff(omega2) > REPEATED * omega2[1:]) + 1
    groups = []
    for rows in np.split(np.arange(len(omega2)), ends):
        if rows[0] >= count:
            break
        if vectors is None:
            own = problem.eigenspace(net, float(omega2[rows].mean()), len(rows))
        else:
            own = vectors[:, rows]
        groups.append((rows, own))
    kept = int(groups[-1][0][-1]) + 1
    return omega2[:kept], net, groups


def _alike(problem: Exact, net: Network, elements: int | None) -> Network:
    """Return the network of `problem` whose rods are cut as those of `net`."""
    del elements
    counts = {(p.group, p.item): p.count for p in net.rods}
    return network(problem.groups, lambda g, k: counts[g, k], problem.platform_mass, problem.unit)


def _dynamic(problem: Exact, net: Network, elements: int | None, lam: Floats) -> Floats:
    if elements is None:
        return np.asarray(problem.dynamic(net, lam)[0])
    K, M = problem.pair(net)
    return np.asarray(K - lam[0] * M)


def _problem(
    mechanism: Mechanism,
    pose: Pose,
    name: str,
    limb: int | None,
    step: float,
    theory: Theory,
    before: Exact,
) -> Exact:
    moved, there = _moved(mechanism, pose, name, limb, step)
    try:
        found = exact(moved, there, theory)
    except InputError as error:
        expected = f"one that the joints let change here ({error})"
        raise InputError("parameters", name, expected) from None
    # Of the same lengths' unit, so that coordinates stay comparable.
    return replace(found, unit=before.unit)


def _size(mechanism: Mechanism, pose: Pose, name: str, limb: int | None, unit: float) -> float:
    """Return what a step is relative to."""
    if name in ("azimuth", "tilt", "torsion"):
        return 1.0
    if name in ("x", "y", "z", "base_radius", "platform_radius"):
        return unit
    if name == "mass":
        return mechanism.platform.mass
    if name.startswith("inertia_"):
        return float(np.linalg.eigvalsh(np.array(mechanism.platform.inertia))[0])
    limbs = mechanism.limbs if limb is None else (mechanism.limbs[limb],)
    found = [value for one in limbs for item in one.chain for value in _values(item, name)]
    if not found:
        raise InputError("parameters", name, "one that some limb has")
    return min(found)


def _values(item: Item, name: str) -> list[float]:
    if isinstance(item, Joint) and name == "stiffness":
        return [f.stiffness for f in item.freedoms if 0 < f.stiffness < math.inf]
    if isinstance(item, Rod) and name == "diameter":
        d = item.section.diameter
        return [] if d is None else [d - item.section.bore]
    if isinstance(item, Rod) and name in ROD:
        return [float(getattr(item.material, name))]
    return []


def _moved(
    mechanism: Mechanism, pose: Pose, name: str, limb: int | None, step: float
) -> tuple[Mechanism, Pose]:
    """Return the mechanism and the pose with one parameter changed by `step`."""
    if name in POSE:
        if getattr(pose, name) is None:
            raise InputError("parameters", name, "a coordinate that the pose says")
        return mechanism, replace(pose, **{name: getattr(pose, name) + step})
    if name == "mass":
        platform = replace(mechanism.platform, mass=mechanism.platform.mass + step)
        return Mechanism(mechanism.limbs, platform), pose
    if name.startswith("inertia_"):
        i, j = ("xyz".index(letter) for letter in name[-2:])
        inertia = np.array(mechanism.platform.inertia)
        inertia[i, j] += step
        inertia[j, i] = inertia[i, j]
        rows: Any = tuple(map(tuple, inertia.tolist()))
        return Mechanism(mechanism.limbs, replace(mechanism.platform, inertia=rows)), pose
    limbs = tuple(
        _changed(one, name, step) if limb in (None, i) else one
        for i, one in enumerate(mechanism.limbs)
    )
    return Mechanism(limbs, mechanism.platform), pose


def _changed(limb: Limb, name: str, step: float) -> Limb:
    if name in ("base_radius", "platform_radius"):
        field = "base" if name == "base_radius" else "platform_point"
        x, y, z = getattr(limb, field)
        radius = math.hypot(x, y) or 1.0
        # Its axes stay where they are.
        moved: dict[str, Any] = {field: (x + step * x / radius, y + step * y / radius, z)}
        return replace(limb, reference=limb.towards, **moved)
    return replace(limb, chain=tuple(_item(item, name, step) for item in limb.chain))


def _item(item: Item, name: str, step: float) -> Item:
    if isinstance(item, Joint) and name == "stiffness":
        freedoms = tuple(
            replace(f, stiffness=f.stiffness + step) if 0 < f.stiffness < math.inf else f
            for f in item.freedoms
        )
        return replace(item, freedoms=freedoms)
    if isinstance(item, Rod) and name == "diameter" and item.section.diameter is not None:
        section = Section.round(item.section.diameter + step, item.section.bore)
        return replace(item, section=section)
    if isinstance(item, Rod) and name in ("young", "shear", "density"):
        value: dict[str, Any] = {name: getattr(item.material, name) + step}
        return replace(item, material=replace(item.material, **value))
    return item
