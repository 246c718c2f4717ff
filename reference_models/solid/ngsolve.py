"""`ngsolve-solid`: limbs as 3-D elastic rods, by NGSolve's tetrahedra.

NGSolve gives the rod's matrices. The joints, the platform and the eigenvalues are solved here, of
the whole mechanism: no limb is reduced to some modes first.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from analytic.errors import InputError
from analytic.errors import count as whole
from analytic.mechanism import Limb, Mechanism
from analytic.model import Info
from analytic.modes import Modes, check_count
from analytic.pose import Pose
from reference_models.placement import Placement, largest_gap, place
from reference_models.protocol import ModelError, UnavailableError, hertz
from reference_models.solid.faces import FACES, Held, check_faces, hold
from reference_models.solid.ngsolve_mesh import LARGEST_ORDER, load, solid_rod
from reference_models.solid.reduction import PARTS, Statics, statics
from reference_models.solid.rod import FAMILIES, SLENDERNESS
from reference_models.spent import SIMULATOR, phase
from reference_models.units import in_robot_units

Array = NDArray[np.float64]

NAME = "ngsolve-solid"
THEORY = "3-D elasticity"
RIM_ORDER = 1.4
"""Twice the exponent with which displacements leave a clamped rim (90 degrees, nu = 0.3)."""
CONVERGED = 1e-12
"""Relative change of the eigenvalues at which the Krylov space is large enough."""
FREE = 1e-12
"""Stiffness of the platform on its limbs, relative to the largest, that is none."""
FINEST = 16
"""Largest `elements` times `order`."""
LONGEST = 60
"""Most blocks of the Krylov space."""
REMARK = (
    "elements: a diameter over the largest tetrahedron; 4 times finer at the rims, where rigid "
    "faces make the stress singular: whatever the order of the elements, convergence is slow "
    "(theory 1.4, observed 1 to 2), so extrapolate. Averaged faces give f1-f3 0.6 % lower"
)


@dataclass(frozen=True)
class NgsolveSolid:
    """Rods of tetrahedra of `order`, at most a diameter / `elements` in size.

    `faces`: "rigid" (RBE2) or "averaged" (RBE3), see `solid_faces`. One rod of 5 diameters is
    meshed and stretched along its axis to each limb's length; see `solid_rod` for its symmetry.
    Joints are closed by construction, so `Modes.residual` is only where the placed rod ends,
    its length rounded to twelve digits, against A_i.
    Raises `InputError` for fewer than one element or more than 16 / order, an order not in 1..6, or
    unknown faces.
    """

    elements: int = 4
    order: int = 2
    faces: str = "rigid"

    def __post_init__(self) -> None:
        order, elements = whole("order", self.order), whole("elements", self.elements)
        if order > LARGEST_ORDER:
            raise InputError("order", order, f"a whole number of at most {LARGEST_ORDER}")
        if elements * order > FINEST:
            expected = f"at most {FINEST // order} with order {order}: finer rods need gigabytes"
            raise InputError("elements", elements, expected)
        check_faces(self.faces)

    @classmethod
    def info(cls) -> Info:
        """Return what the model is; never raises."""
        try:
            version, missing = str(load().__version__), ""
        except UnavailableError as error:
            version, missing = "", str(error)
        theory = f"{THEORY}, {FACES[cls.faces]}"
        rigid = cls.faces == "rigid"
        return Info(
            theory,
            "NGSolve",
            version,
            RIM_ORDER,
            (2, 4),
            (1, 2, 4),
            relaxed="ngsolve-averaged" if rigid else "",
            assumption="rigid end faces" if rigid else "",
            remark=REMARK,
            missing=missing,
            slow=True,
        )

    @property
    def theory(self) -> str:
        """The theory and how the joints hold the end faces."""
        return f"{THEORY}, {FACES[self.faces]}"

    def modes(self, mechanism: Mechanism, pose: Pose, count: int = 6) -> Modes:
        """Return the `count` lowest modes at one pose.

        Raises `InputError` for many poses, a pose out of reach or too many modes, `ModelError`
        where Netgen or NGSolve fails, and `UnavailableError` without NGSolve.
        """
        return in_robot_units(NAME, self._solve, mechanism, pose, count)

    def _solve(self, mechanism: Mechanism, pose: Pose, count: int) -> Modes:
        version = load().__version__
        begin = time.perf_counter()
        placed = place(mechanism, pose)
        R = placed.rotation
        with phase("projection"):
            limbs = [_place(self, limb, placed, i) for i, limb in enumerate(mechanism.limbs)]
        residual = max(*(limb.gap for limb in limbs), largest_gap(mechanism, placed.tips))
        M = np.zeros((6, 6))
        M[:3, :3] = mechanism.platform.mass * np.eye(3)
        M[3:, 3:] = R @ np.array(mechanism.platform.inertia) @ R.T
        system = System(M, [part for limb in limbs for part in limb.parts])
        held = np.linalg.eigvalsh(system.K)
        if held[0] <= FREE * held[-1]:
            raise ModelError(f"{NAME}: the platform moves freely, and only vibrations are found")
        check_count(count, system.size)
        built = time.perf_counter()
        with phase("eigen-solution"):
            eigenvalues, X = lowest(system.flexible, system.inertia, system.size, count)
        solved = time.perf_counter()
        with phase("shapes"):
            local = system.centre_lines(X)
        local = local.reshape(len(limbs), len(FAMILIES), -1, count)
        frames = np.array([limb.frame for limb in limbs])
        return Modes(
            frequencies=hertz(NAME, eigenvalues, 0.0),
            platform=X[:6].T,
            limbs=np.einsum("ncf,nfsk->knsc", frames, local[:, :3]),
            theory=self.theory,
            model=NAME,
            version=f"ngsolve {version}",
            elements=self.elements,
            dofs=system.size,
            residual=residual,
            build_seconds=built - begin,
            solve_seconds=solved - built,
        )


@dataclass(frozen=True)
class NgsolveAveraged(NgsolveSolid):
    """The same rods held by the mean motion of their end faces (RBE3), which may warp."""

    faces: str = "averaged"


@lru_cache(maxsize=4)
def held_rods(poisson: float, elements: int, order: int, faces: str) -> dict[str, Held]:
    """Return all families of a rod in its joints; raises as `NgsolveSolid.modes`."""
    with phase(SIMULATOR):
        rod = solid_rod(poisson, elements, order)
    return {family: hold(rod, family, faces) for family in FAMILIES}


@lru_cache(maxsize=3)
def _statics(
    poisson: float, elements: int, order: int, faces: str, stretch: float
) -> dict[str, Statics]:
    """Return a rod's factored families; the three rods of a symmetric pose share them."""
    held = held_rods(poisson, elements, order, faces)
    return {family: statics(part, stretch) for family, part in held.items()}


@dataclass(frozen=True)
class Part:
    """One family of one limb.

    Attributes: `vector` (6,): the tip moves vector . U along the family's direction; `statics`,
    with units `stiff` [N/m] and `mass` [kg]; `line` (11, q + 1) as in `Held`.
    """

    vector: Array
    statics: Statics
    stiff: float
    mass: float
    line: Array


@dataclass(frozen=True)
class Placed:
    """One limb at a pose: its `parts`, `frame` (columns x, y, z) and joint `gap` [m]."""

    parts: list[Part]
    frame: Array
    gap: float


def _place(model: NgsolveSolid, limb: Limb, placed: Placement, i: int) -> Placed:
    """Return limb `i` between its joints."""
    base, rod = np.array(limb.base), limb.rod
    frame, arm, length = placed.frames[i], placed.arms[i], float(placed.lengths[i])
    d, E, rho = rod.diameter, rod.material.young, rod.material.density
    # Rounded, so that lengths equal but for rounding share what follows; the gap shows by how much.
    stretch = float(f"{length / (d * SLENDERNESS):.12g}")
    gap = float(np.linalg.norm(base + stretch * SLENDERNESS * d * frame[:, 2] - placed.tips[i]))
    settings = (rod.material.poisson, model.elements, model.order, model.faces)
    held, known = held_rods(*settings), _statics(*settings, stretch)
    parts = []
    for i, family in enumerate(FAMILIES):
        vector = np.zeros(6)
        if held[family].driven:
            vector = np.concatenate([frame[:, i], np.cross(arm, frame[:, i])])
        line = held[family].line
        parts.append(Part(vector, known[family], PARTS * E * d, PARTS * rho * d**3, line))
    return Placed(parts, frame, gap)


class System:
    """K and M of the whole mechanism over U, the platform, and q of every part, as operators.

    K = diag(K_U, K_qq, ...), since statics couple no q to U, and
    M = [[M_p + sum m a a^T, a p^T, ...], [p a^T, M_qq], ...].
    """

    def __init__(self, platform: Array, parts: list[Part]) -> None:
        self.parts = parts
        self.K, self.M = np.zeros((6, 6)), platform.copy()
        self.slices = []
        start = 6
        for part in parts:
            square = np.outer(part.vector, part.vector)
            k, m = part.statics.tip
            self.K += part.stiff * k * square
            self.M += part.mass * m * square
            self.slices.append(slice(start, start + len(part.statics.shape)))
            start += len(part.statics.shape)
        self.size = start

    def inertia(self, X: Array) -> Array:
        """Return M X for X (size, k)."""
        result = np.empty_like(X)
        result[:6] = self.M @ X[:6]
        for part, own in zip(self.parts, self.slices, strict=True):
            known = part.statics
            result[:6] += part.mass * np.outer(part.vector, known.coupling @ X[own])
            along = np.outer(known.coupling, part.vector @ X[:6])
            result[own] = part.mass * (known.mass @ X[own] + along)
        return result

    def flexible(self, F: Array) -> Array:
        """Return K^-1 F for F (size, k)."""
        result = np.empty_like(F)
        result[:6] = np.linalg.solve(self.K, F[:6])
        for part, own in zip(self.parts, self.slices, strict=True):
            result[own] = part.statics.factor.solve(np.ascontiguousarray(F[own])) / part.stiff
        return result

    def centre_lines(self, X: Array) -> Array:
        """Return every part's motion of its axis, shape (parts, 11, k)."""
        lines = []
        for part, own in zip(self.parts, self.slices, strict=True):
            t = part.vector @ X[:6]
            inner = X[own] + np.outer(part.statics.shape, t)
            n = len(inner)
            tip = part.line[:, n:] * t if part.line.shape[1] > n else 0.0
            lines.append(part.line[:, :n] @ inner + tip)
        return np.array(lines)


Operator = Callable[[Array], Array]


def lowest(flexible: Operator, inertia: Operator, size: int, count: int) -> tuple[Array, Array]:
    """Return the lowest eigenvalues (count,) of (K, M) and mass-normalised vectors (size, count).

    Rayleigh-Ritz in the block Krylov space of K^-1 M from a random start, whose width lets modes
    repeat. Raises `ModelError` where it does not converge. `analytic` has a block
    Lanczos too: they are two so that a slip in either shows.
    """
    width = min(count + 2, size)
    V = _orthonormal(np.random.default_rng(1).normal(size=(size, width)), inertia)
    basis, image, rows = V, inertia(V), []
    before = np.zeros(count)
    for _ in range(min(LONGEST, size // width)):
        W = flexible(image[:, -width:])
        rows.append(image.T @ W)
        H = _assembled(rows)
        values, S = scipy.linalg.eigh(H)
        largest = values[::-1][:count]
        # What rounding of the largest leaves in the others is no lack of convergence.
        rounding = 8 * np.finfo(float).eps * largest[0]
        if (np.abs(largest - before) < CONVERGED * largest + rounding).all():
            return 1 / largest, basis @ S[:, ::-1][:, :count]
        before = largest
        for _ in range(2):  # once is not enough for orthogonality to the last digit
            W -= basis @ (image.T @ W)
        W = _orthonormal(W, inertia)
        basis, image = np.hstack([basis, W]), np.hstack([image, inertia(W)])
    raise ModelError(f"{NAME}: the lowest {count} modes have not converged")


def _orthonormal(V: Array, inertia: Operator) -> Array:
    for _ in range(2):
        root = np.linalg.cholesky(V.T @ inertia(V))
        V = scipy.linalg.solve_triangular(root, V.T, lower=True).T
    return V


def _assembled(columns: list[Array]) -> Array:
    """Return the symmetric matrix whose upper triangle's block columns are given."""
    size = len(columns[-1])
    H = np.zeros((size, size))
    start = 0
    for column in columns:
        H[: len(column), start : start + column.shape[1]] = column
        start += column.shape[1]
    return np.triu(H) + np.triu(H, 1).T
