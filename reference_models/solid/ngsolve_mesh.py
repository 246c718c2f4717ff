"""NGSolve's part: the tetrahedral mesh of a quarter rod, and its matrices as scipy's."""

from functools import lru_cache
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from analytic.modes import STATIONS
from reference_models.protocol import ModelError, UnavailableError, unlinked
from reference_models.solid.rod import SLENDERNESS, SolidRod

Array = NDArray[np.float64]
INSTALL = "pip install 'ngsolve>=6.2.2608'"
LARGEST_ORDER = 6
RIM = 4
"""How much finer than elsewhere the mesh is at the rims, where clamped stresses are singular."""
GRADING = 0.4
FLAT = 1e-9
"""Within this of a plane, in diameters, is on it."""


def load() -> Any:
    """Return the module ngsolve, or raise `UnavailableError` with what to do."""
    try:
        import ngsolve
    except ModuleNotFoundError:
        raise UnavailableError(f"ngsolve is not installed; {INSTALL}") from None
    except ImportError as error:
        # Its BLAS is linked to a library of the compiler's that bare machines lack.
        remedy = "install libquadmath, which its BLAS needs (Debian: apt-get install libquadmath0)"
        raise unlinked("ngsolve", error, remedy) from None
    return ngsolve


@lru_cache(maxsize=4)
def solid_rod(poisson: float, elements: int, order: int) -> SolidRod:
    """Return a quarter rod of tetrahedra of `order`, at most 1 / `elements` diameters in size.

    The rims, where a clamped face makes the stress singular, are meshed `RIM` times finer.
    """
    return quarter(poisson, elements, order)[1]


def quarter(poisson: float, elements: int, order: int) -> tuple[Any, SolidRod]:
    """Return NGSolve's mesh of `solid_rod` with it."""
    ng = load()
    ng.SetNumThreads(1)
    try:
        mesh = _mesh(ng, elements, order)
        return mesh, _matrices(ng, mesh, poisson, order)
    except Exception as error:  # netgen raises whatever its C++ throws
        raise ModelError(f"ngsolve-solid: {error}") from error


def _mesh(ng: Any, elements: int, order: int) -> Any:
    from netgen import occ

    size, L = 1 / elements, SLENDERNESS
    rod = occ.Cylinder(occ.Pnt(0, 0, 0), occ.Z, r=0.5, h=L)
    quarter = rod * occ.Box(occ.Pnt(0, 0, -1), occ.Pnt(1, 1, L + 1))
    for face in quarter.faces:
        c = face.center
        planes = {"base": c.z, "tip": c.z - L, "x0": c.x, "y0": c.y}
        (face.name,) = [name for name, at in planes.items() if abs(at) < FLAT] or ["side"]
    for edge in quarter.edges:
        c = edge.center
        if min(abs(c.z), abs(c.z - L)) < FLAT and min(c.x, c.y) > FLAT:
            edge.maxh = size / RIM
    made = occ.OCCGeometry(quarter).GenerateMesh(
        maxh=size, grading=GRADING, parallel_meshing=False, nthreads=1
    )
    mesh = ng.Mesh(made)
    mesh.Curve(order)
    return mesh


def _matrices(ng: Any, mesh: Any, poisson: float, order: int) -> SolidRod:
    vector = ng.VectorH1(mesh, order=order)
    scalar = ng.H1(mesh, order=order)
    u, v = vector.TnT()
    mu, lam = 1 / (2 * (1 + poisson)), poisson / ((1 + poisson) * (1 - 2 * poisson))
    along = ng.CoefficientFunction((0, 0, 0, 0, 0, 0, 0, 0, 1), dims=(3, 3))
    across = ng.Id(3) - along

    def energy(a: Any, b: Any) -> Any:
        strain, other = (a + a.trans) / 2, (b + b.trans) / 2
        return 2 * mu * ng.InnerProduct(strain, other) + lam * ng.Trace(a) * ng.Trace(b)

    plane_u, plane_v = ng.Grad(u) * across, ng.Grad(v) * across
    length_u, length_v = ng.Grad(u) * along, ng.Grad(v) * along
    forms = (
        energy(plane_u, plane_v),
        energy(plane_u, length_v) + energy(length_u, plane_v),
        energy(length_u, length_v),
        ng.InnerProduct(u, v),
    )
    A, B, C, M = (_sparse(ng.BilinearForm(form * ng.dx).Assemble().mat) for form in forms)
    functions = (ng.CoefficientFunction(1.0), ng.x, ng.y)
    return SolidRod(
        stiffness=(A, B, C),
        mass=M,
        fields=np.array([coefficients(ng, scalar, f) for f in functions]),
        on={
            name: np.array(scalar.GetDofs(mesh.Boundaries(name)), dtype=bool)
            for name in ("base", "tip", "x0", "y0")
        },
        weights={
            name: np.array([_integrals(ng, mesh, scalar, f, name) for f in functions])
            for name in ("base", "tip")
        },
        axis=np.array([_values(mesh, scalar, z * SLENDERNESS) for z in STATIONS]),
    )


def _sparse(matrix: Any) -> sp.csr_array:
    rows, columns, values = (np.array(part) for part in matrix.COO())
    found = sp.csr_array(sp.coo_array((values, (rows, columns)), shape=matrix.shape))
    return sp.csr_array((found + found.T) / 2)


def coefficients(ng: Any, space: Any, function: Any) -> Array:
    """Return the coefficients of a function that the curved elements hold exactly."""
    part = ng.GridFunction(space)
    part.Set(function)
    return np.array(part.vec.FV().NumPy())


def _integrals(ng: Any, mesh: Any, space: Any, function: Any, face: str) -> Array:
    test = space.TestFunction()
    form = ng.LinearForm(function * test * ng.ds(mesh.Boundaries(face))).Assemble()
    return np.array(form.vec.FV().NumPy())


def _values(mesh: Any, space: Any, z: float) -> Array:
    """Return the value of every shape function on the axis at `z`."""
    point = mesh(0.0, 0.0, z)
    ng = load()
    element = ng.ElementId(ng.VOL, point.nr)
    values = np.zeros(space.ndof)
    values[list(space.GetDofNrs(element))] = np.array(space.GetFE(element).CalcShape(*point.pnt))
    return values
