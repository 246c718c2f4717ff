"""The whole solid rod of `ngsolve-solid` in the displacements of its nodes.

NGSolve's second order has vertices and, on every edge, a bubble beside the straight line between
its ends. Here the middle of an edge is a node like any other, as flexible multibody codes want
it, and the quarter rod is mirrored to the whole: another basis of the same space, without any
approximation.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from reference_models.solid.ngsolve_mesh import coefficients, load, quarter
from reference_models.solid.rod import SolidRod

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

ORDER = 2


@dataclass(frozen=True)
class NodalRod:
    """A rod of unit diameter, Young's modulus and density along z, from its base at z = 0.

    Attributes: `positions` (N, 3); `stiffness` A, B, C and `mass` M as in `SolidRod`, but (3 N,
    3 N) with the three displacements of a node side by side; nodes of the `base` and `tip` faces;
    `axis` (11, N), which gives the displacement of the axis at `STATIONS` from the nodes'.
    """

    positions: Array
    stiffness: tuple[sp.csr_array, sp.csr_array, sp.csr_array]
    mass: sp.csr_array
    base: Indices
    tip: Indices
    axis: Array

    def stretched(self, s: float) -> tuple[Array, sp.csr_array, sp.csr_array]:
        """Return positions, K and M of a rod s times as long."""
        A, B, C = self.stiffness
        K = sp.csr_array(s * A + B + C / s)
        return self.positions * [1.0, 1.0, s], K, sp.csr_array(s * self.mass)


@lru_cache(maxsize=4)
def nodal_rod(poisson: float, elements: int) -> NodalRod:
    """Return the rod of `ngsolve_mesh.solid_rod` of order 2; raises as that does."""
    mesh, rod = quarter(poisson, elements, ORDER)
    values = _nodal_values(mesh, rod)
    z = coefficients(load(), load().H1(mesh, order=ORDER), load().z)
    places = (values @ np.stack([rod.fields[1], rod.fields[2], z], axis=1)).round(15)
    return _mirrored(rod, places, sp.linalg.inv(sp.csc_array(values)))


def _nodal_values(mesh: Any, rod: SolidRod) -> sp.csr_array:
    """Return the map from a function's coefficients to its values at the nodes, (m, m)."""
    ends = np.array([[vertex.nr for vertex in edge.vertices] for edge in mesh.edges])
    m, vertices = rod.fields.shape[1], int(mesh.nv)
    middle = np.arange(vertices, m)
    rows = np.r_[np.arange(vertices), middle, middle, middle]
    columns = np.r_[np.arange(vertices), ends[:, 0], ends[:, 1], middle]
    entries = np.r_[np.ones(vertices), np.full(2 * len(middle), 0.5), np.full(m - vertices, 1.0)]
    entries[-len(middle) :] = _bubble(mesh)
    return sp.csr_array(sp.coo_array((entries, (rows, columns)), shape=(m, m)))


def _bubble(mesh: Any) -> float:
    """Return the height of an edge's bubble at its middle; the first four functions are others."""
    ng = load()
    element = ng.H1(mesh, order=ORDER).GetFE(ng.ElementId(ng.VOL, 0))
    heights = np.array(element.CalcShape(0.5, 0.5, 0.0))[4:]
    return float(heights[np.abs(heights).argmax()])


def _mirrored(rod: SolidRod, places: Array, coefficients_of: sp.csc_array) -> NodalRod:
    """Return the whole of a quarter rod, whose nodes on a plane of symmetry are common."""
    m = len(places)
    quadrants = [(x, y) for x in (1.0, -1.0) for y in (1.0, -1.0)]
    # A node's own copy in every quadrant, but for those on the planes.
    code = [
        2 * ((x < 0) & ~rod.on["x0"]) + ((y < 0) & ~rod.on["y0"]).astype(int) for x, y in quadrants
    ]
    number = np.array([np.arange(m) + m * c for c in code])
    kept, index = np.unique(number, return_inverse=True)
    index = index.reshape(number.shape)
    N = len(kept)
    positions = np.zeros((N, 3))
    whole = [sp.csr_array((3 * N, 3 * N)) for _ in range(4)]
    basis = sp.block_diag([coefficients_of] * 3, format="csr")
    parts = [sp.csr_array(basis.T @ part @ basis) for part in (*rod.stiffness, rod.mass)]
    for own, (x, y) in zip(index, quadrants, strict=True):
        signs = np.array([x, y, 1.0])
        positions[own] = places * signs
        columns = (3 * own + np.arange(3)[:, None]).ravel()
        entries = (np.repeat(signs, m), (np.arange(3 * m), columns))
        G = sp.csr_array(sp.coo_array(entries, shape=(3 * m, 3 * N)))
        whole = [K + sp.csr_array(G.T @ part @ G) for K, part in zip(whole, parts, strict=True)]
    axis = np.zeros((len(rod.axis), N))
    axis[:, index[0]] = rod.axis @ coefficients_of
    base, tip = (np.unique(index[:, rod.on[face]]) for face in ("base", "tip"))
    A, B, C, M = whole
    return NodalRod(positions, (A, B, C), M, base, tip, axis)
