"""A quarter of a round solid rod as sparse matrices, from whatever mesh made them.

The rod has unit diameter, Young's modulus and density; its section is cut by its two planes of
symmetry, x = 0 and y = 0, and the mesh of the whole is the quarter's, mirrored. Small motions of
such a mesh fall, without approximation, into four families that do not know of each other:
bending in x, bending in y, stretching, twisting. A rod of another length is the same mesh
stretched along its axis, and a stretch enters the matrices in closed form.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

Array = NDArray[np.float64]

SLENDERNESS = 5.0
"""Length of the mesh in diameters, before it is stretched."""
FAMILIES = ("x", "y", "z", "twist")
"""Bending along x (about the revolute axis y), bending along y, stretching along z, twisting."""


@dataclass(frozen=True)
class SolidRod:
    """A quarter rod, 0 <= z <= SLENDERNESS, in m scalar shape functions for each of u_x, u_y, u_z.

    Attributes:
        stiffness: A, B, C of K(s) = s A + B + C / s for a rod s times as long; (3 m, 3 m) each.
        mass: M of M(s) = s M, shape (3 m, 3 m).
        fields: coefficients of the functions 1, x and y, shape (3, m).
        on: which shape functions do not vanish on "base", "tip", "x0", "y0"; (m,) booleans.
        weights: integrals of every shape function times 1, x, y over "base" and "tip"; (3, m).
        axis: the shape functions at `STATIONS` of the axis, shape (11, m).
    """

    stiffness: tuple[sp.csr_array, sp.csr_array, sp.csr_array]
    mass: sp.csr_array
    fields: Array
    on: dict[str, NDArray[np.bool_]]
    weights: dict[str, Array]
    axis: Array
