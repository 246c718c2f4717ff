"""How natural frequencies change with any parameter: exact derivatives, repeated modes included.

A mode of unit modal mass has d(omega^2)/dp = U^T (dD/dp) U. With the tip motion w_k = a_k . U and
tip force F_k of every limb's direction that is
    sum_k (d_k' w_k^2 + 2 F_k a_k' . U) - omega^2 U^T M_p' U,
primes by complex step: exact to rounding. Next to a pole d_k' w_k^2 is (d_k' / d_k^2) F_k^2.
Modes that repeat share a matrix of such products, whose eigenvalues are their derivatives.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic import chain_sensitivity
from analytic.certified import brackets
from analytic.chain_sensitivity import chain_sensitivities
from analytic.continuum import repeated
from analytic.dynamic_stiffness import limb_stiffness
from analytic.errors import InputError
from analytic.errors import count as whole
from analytic.kinematics import limbs_of
from analytic.mechanism import Mechanism
from analytic.modes import check_count
from analytic.pose import Pose, closure, leaned, one_pose
from analytic.reduced import constants
from analytic.theory import Theory
from analytic.waves import Array, Sections
from analytic.wittrick_williams import Characteristic, characteristic

STEP = 1e-30
FORBIDDEN = 1e-9
"""A larger part of the limbs' change, out of a revolute joint's plane, is refused."""
POSE = ("z", "azimuth", "tilt")
LIMB = ("young", "shear", "density", "diameter", "base_radius", "platform_radius")
MOMENTS = ("xx", "yy", "zz", "xy", "xz", "yz")
PLATFORM = ("mass", *(f"inertia_{pair}" for pair in MOMENTS))


def frequency_sensitivities(
    mechanism: Mechanism,
    pose: Pose,
    parameters: Sequence[str],
    elements: int | None = None,
    *,
    beam: str = "euler-bernoulli",
    shear: str | float = "cowper",
    count: int = 6,
) -> NDArray[np.float64]:
    """Return d f / d p of the `count` lowest modes, shape (count, parameters) [Hz per SI unit].

    Parameters: "z", "azimuth", "tilt"; "young", "shear" (G), "density", "diameter" of the rods and
    "base_radius", "platform_radius", which move B_i and A_i away from the z axis, of all limbs
    together or, as "diameter[0]", of one; "mass" and "inertia_xx" ... "inertia_yz" of the platform
    (an off-diagonal moment means both its entries), which keep their values when all else moves.
    For limbs of any chain also "torsion", "x" and "y" of a pose that says them, and "stiffness" of
    all springs; there "diameter" is the outer one of round rods (see `chain_sensitivity`).
    `elements`, `beam`, `shear` as in `condensed_frequencies`. Derivatives of repeated modes ascend
    in each column: modes that follow one parameter need not follow another. Raises `InputError`
    for an unknown parameter, one that the joints do not let change, a pose out of reach, or a
    mechanism that moves freely.
    """
    theory = Theory(beam, shear)
    n = len(mechanism.limbs)
    available = 10_000 if elements is None else 6 + n * (6 * whole("elements", elements) - 2)
    count = check_count(count, available)
    one_pose(mechanism, pose)
    if isinstance(parameters, str) or not isinstance(parameters, Sequence):
        raise InputError("parameters", parameters, "a list of names of parameters")
    if not mechanism.simple:
        named = [_parsed(name, n, chains=True) for name in parameters]
        return chain_sensitivities(mechanism, pose, named, elements, theory, count)
    moves = [_moved(mechanism, pose, theory, name) for name in parameters]
    problem = characteristic(mechanism, pose, theory, elements)
    # More modes than asked for, so that a group of repeated ones is not cut at the end.
    bounds, twisting = _posesgroups(problem, count, available, 5 * n)
    if bounds[0, 0] == 0:
        raise InputError("mechanism", "one that moves freely", "frequencies above zero")
    eigenvalues = bounds.mean(axis=1)
    result = np.empty((len(eigenvalues), len(moves)))
    unit = constants(mechanism, theory).unit
    for group in repeated(eigenvalues, np.arange(len(eigenvalues))):
        lam = float(eigenvalues[group].mean())
        twisted = [int(limb) for limb in twisting[group] if limb >= 0]
        moving = len(group) - len(twisted)
        slopes = np.empty((len(group), len(moves)))
        for column, move in enumerate(moves):
            slopes[moving:, column] = [move.torsion(lam, limb) for limb in twisted]
        if moving:
            ((_, U, w, F),) = problem.eigenspace(np.array([lam]), np.array([moving]))
            U = U @ unit.T
            for column, move in enumerate(moves):
                projected = move.projected(U, w, F, lam, elements, problem.scale)
                slopes[:moving, column] = np.linalg.eigvalsh(projected)
        result[group] = np.sort(slopes, axis=0)
    # omega^2 = 4 pi^2 f^2.
    return np.asarray((result / (4 * np.pi * np.sqrt(eigenvalues[:, None])))[:count])


def _posesgroups(
    problem: Characteristic, count: int, available: int, spare: int
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    for more in (1, spare):
        bounds, twisting = brackets(problem, min(count + more, available))
        groups = repeated(bounds.mean(axis=1), np.arange(len(bounds)))
        end = next(group[-1] + 1 for group in groups if group[-1] + 1 >= count)
        if end < len(bounds) or len(bounds) == available:
            break
    return bounds[:end], twisting[:end]


@dataclass(frozen=True)
class _Moved:
    """A mechanism a complex step along one parameter, seen from the moving frame.

    Attributes: limbs' `rods` and `lengths`; `vectors` a_k (n, 3, 6); `mass` M_p (6, 6); `size` of
    the step.
    """

    rods: Sections
    lengths: Array
    vectors: Array
    mass: Array
    size: float

    def projected(
        self,
        U: NDArray[np.float64],
        w: NDArray[np.float64],
        F: NDArray[np.float64],
        eigenvalue: float,
        elements: int | None,
        scale: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        """Return U^T (dD/dp) U of modes U (m, 6), w and F (m, n, 3), shape (m, m).

        Where d_k exceeds `scale` (n, 3), by force instead of motion.
        """
        d = limb_stiffness(self.rods, self.lengths, np.array([eigenvalue + 0j]), elements)
        stiff = np.abs(d.real) > scale
        share = np.where(stiff, F, w)
        change = d.imag / self.size / np.where(stiff, d.real**2, 1.0)
        turned = U @ self.vectors.imag.reshape(-1, 6).T / self.size
        cross = F.reshape(len(U), -1) @ turned.T
        result = np.einsum("aik,ik,bik->ab", share, change, share)
        result += cross + cross.T - eigenvalue * U @ (self.mass.imag / self.size) @ U.T
        return np.asarray(result)

    def torsion(self, eigenvalue: float, limb: int) -> float:
        """Return the change of a limb's torsion: omega^2 ~ G / (rho L^2)."""
        speed2, length = self.rods.torsion_speed2[limb], self.lengths[limb]
        relative = (speed2.imag / speed2.real - 2 * length.imag / length.real) / self.size
        return float(eigenvalue * relative)


def _moved(mechanism: Mechanism, pose: Pose, theory: Theory, name: str) -> _Moved:
    base, one = _parsed(name, len(mechanism.limbs))
    limbs: Any = ... if one is None else one
    size = STEP

    def step(parameter: str, value: Any, chosen: Any = ...) -> Array:
        result = np.asarray(value) + 0j
        if parameter == base:
            result[chosen] += 1j * size
        return result

    rods = [limb.rod for limb in mechanism.limbs]
    E = step("young", [rod.material.young for rod in rods], limbs)
    G = step("shear", [rod.material.shear for rod in rods], limbs)
    rho = step("density", [rod.material.density for rod in rods], limbs)
    d = step("diameter", [rod.diameter for rod in rods], limbs)
    A, second = np.pi * d**2 / 4, np.pi * d**4 / 64
    flexibility = np.zeros_like(A)
    if theory.beam == "timoshenko":
        material: Any = SimpleNamespace(poisson=E / (2 * G) - 1)
        flexibility = 12 * E * second / (theory.shear_coefficient(material) * G * A)
    rotary = rho * second if theory.rotary_inertia else 0 * second
    sections = Sections(E * A, E * second, rho * A, rotary, flexibility, E / rho, G / rho)

    bases = _radially(mechanism.bases, step("base_radius", np.zeros(len(rods)), limbs))
    points = _radially(
        mechanism.platform_points, step("platform_radius", np.zeros(len(rods)), limbs)
    )
    z, azimuth, tilt = (step(key, [getattr(pose, key)])[0] for key in POSE)
    held = closure(mechanism, bases, points, z, leaned(azimuth, tilt))
    limbs = limbs_of(mechanism.axes, held)
    # A change that the joints allow keeps every A_i in its revolute joint's plane.
    aside, moved = np.abs(held.off_plane.imag) / size, np.abs(held.vectors.imag) / size
    if aside.max() > FORBIDDEN * moved.max():
        raise InputError(
            "parameters",
            name,
            f"one that the joints let change here: A_{int(aside.argmax()) + 1} would leave its "
            "revolute joint's plane",
        )
    mass = np.zeros((6, 6), dtype=complex)
    mass[:3, :3] = step("mass", [mechanism.platform.mass])[0] * np.eye(3)
    mass[3:, 3:] = np.array(mechanism.platform.inertia)
    if base.startswith("inertia_"):
        i, j = ("xyz".index(letter) for letter in base[-2:])
        mass[3 + i, 3 + j] += 1j * size
        if i != j:
            mass[3 + j, 3 + i] += 1j * size
    return _Moved(sections, limbs.lengths, limbs.directions, mass, size)


def _parsed(name: str, n: int, *, chains: bool = False) -> tuple[str, int | None]:
    """Return a parameter's name and its limb, None of all; `chains`: with those of any chain."""
    poses = chain_sensitivity.POSE if chains else POSE
    of_limbs = chain_sensitivity.LIMB if chains else LIMB
    match = re.fullmatch(r"([a-z_]+)(?:\[(\d+)\])?", name) if isinstance(name, str) else None
    base = match[1] if match else ""
    if match and match[2] is None and base in (*poses, *of_limbs, *PLATFORM):
        return base, None
    if match and match[2] is not None and base in of_limbs and int(match[2]) < n:
        return base, int(match[2])
    known = ", ".join((*poses, *of_limbs, *PLATFORM))
    raise InputError("parameters", name, f"one of {known}, or of one limb as diameter[0]")


def _radially(points: NDArray[np.float64], shift: Array) -> Array:
    radius = np.hypot(points[:, 0], points[:, 1])[:, None]
    outward = points[:, :2] / np.where(radius > 0, radius, 1.0)
    return np.concatenate([points[:, :2] + shift[:, None] * outward, points[:, 2:] + 0j], axis=1)
