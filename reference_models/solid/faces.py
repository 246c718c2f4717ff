"""The end faces of a solid rod, where joints hold it: rigid (RBE2) or by their average (RBE3).

A joint holds the motion of a face as a whole. A rigid face has no other motion. An averaged face
keeps its own: only the rigid motion that fits it best by least squares over its area is held or
driven, and forces spread over the face as that fit weighs it.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from analytic.errors import InputError
from reference_models.solid.rod import FAMILIES, SolidRod

Array = NDArray[np.float64]
Field = tuple[tuple[int, int, float], ...]
"""A motion of a face as (component, function, factor); functions are 1, x, y in turn."""

FACES = {"rigid": "rigid end faces", "averaged": "averaged end faces"}

# Which components vanish on x = 0 and on y = 0: those that the plane's reflection turns round.
STILL = {
    "x": ((1, 2), (1,)),
    "y": ((0,), (0, 2)),
    "z": ((0,), (1,)),
    "twist": ((1, 2), (0, 2)),
}
SHIFT: dict[str, Field] = {family: ((i, 0, 1.0),) for i, family in enumerate(FAMILIES[:3])}
TURN: dict[str, Field] = {
    "x": ((2, 1, -1.0),),  # about y: u_z = -x
    "y": ((2, 2, 1.0),),  # about x: u_z = y
    "twist": ((0, 2, -1.0), (1, 1, 1.0)),  # about z
}


@dataclass(frozen=True)
class Held:
    """A family with its base in the revolute joint and its tip in the spherical one.

    Attributes: `stiffness` A, B, C and `mass` M as in `SolidRod`, over the coordinates left free
    and last, if `driven` (all families but "twist"), the tip's displacement along the family's
    direction; `line` (11, coordinates): the axis' motion along that direction.
    """

    stiffness: tuple[sp.csr_array, sp.csr_array, sp.csr_array]
    mass: sp.csr_array
    line: Array
    driven: bool


def hold(rod: SolidRod, family: str, faces: str) -> Held:
    """Return the `family` of a quarter rod in its joints.

    Base: no displacement and no rotation, but for that of family "x", about the revolute axis.
    Tip: driven along the family's direction, free to turn. Raises `InputError` for unknown `faces`.
    """
    T = _rigid(rod, family) if check_faces(faces) == "rigid" else _averaged(rod, family)
    A, B, C = (sp.csr_array(T.T @ part @ T) for part in rod.stiffness)
    line = np.zeros((len(rod.axis), T.shape[1]))
    if family in SHIFT:
        m, component = rod.fields.shape[1], FAMILIES.index(family)
        line = (sp.csr_array(rod.axis) @ T[component * m : (component + 1) * m]).toarray()
    return Held((A, B, C), sp.csr_array(T.T @ rod.mass @ T), line, family in SHIFT)


def check_faces(faces: str) -> str:
    """Return `faces` if it is a known convention, or raise `InputError`."""
    if faces not in FACES:
        raise InputError("faces", faces, f"one of {', '.join(FACES)}")
    return faces


def _free_of_planes(rod: SolidRod, family: str) -> NDArray[np.bool_]:
    """Return which of the 3 m coefficients the planes of symmetry leave free."""
    free = np.ones((3, rod.fields.shape[1]), dtype=bool)
    for plane, components in zip(("x0", "y0"), STILL[family], strict=True):
        for component in components:
            free[component, rod.on[plane]] = False
    return free.ravel()


def _joints(family: str) -> tuple[list[Field], list[Field], list[Field]]:
    """Return a family's motions: held at the base, free at the base, free at the tip."""
    turn = [TURN[family]] if family in TURN else []
    shift = [SHIFT[family]] if family in SHIFT else []
    return ([shift[0]], turn, turn) if family == "x" else (shift + turn, [], turn)


def _rigid(rod: SolidRod, family: str) -> sp.csr_array:
    """Return T of u = T q: coefficients inside, rotations of the faces, the tip's displacement."""
    _, at_base, at_tip = _joints(family)
    driven = [SHIFT[family]] if family in SHIFT else []
    inside = _free_of_planes(rod, family)
    inside &= ~np.tile(rod.on["base"] | rod.on["tip"], 3)
    columns = [_motion(rod, "base", field) for field in at_base]
    columns += [_motion(rod, "tip", field) for field in at_tip + driven]
    kept = sp.eye_array(len(inside), format="csc")[:, np.flatnonzero(inside)]
    return sp.csr_array(sp.hstack([kept, *(sp.csc_array(c[:, None]) for c in columns)]))


def _motion(rod: SolidRod, face: str, field: Field) -> Array:
    """Return the coefficients on `face` of a rigid motion of it."""
    result = np.zeros_like(np.tile(rod.fields[:1], (3, 1)))
    for component, function, factor in field:
        result[component] = factor * rod.fields[function] * rod.on[face]
    return result.ravel()


def _averaged(rod: SolidRod, family: str) -> sp.csr_array:
    """Return T of u = T q: each averaged motion solved for the coefficient that weighs most."""
    held, _, _ = _joints(family)
    free = _free_of_planes(rod, family)
    rows = [_average(rod, "base", field) for field in held]
    if family in SHIFT:
        rows.append(_average(rod, "tip", SHIFT[family]))
    G = np.array(rows) * free
    # Two motions of one face share no component, so that every row has a pivot of its own.
    pivots = np.abs(G).argmax(axis=1)
    kept = free.copy()
    kept[pivots] = False
    T = sp.lil_array((len(free), int(kept.sum()) + (family in SHIFT)))
    where = np.flatnonzero(kept)
    T[where, np.arange(len(where))] = 1.0
    for row, pivot in zip(G, pivots, strict=True):
        T[pivot, : len(where)] = -row[where] / row[pivot]
    if family in SHIFT:
        T[pivots[-1], len(where)] = 1 / G[-1, pivots[-1]]
    return sp.csr_array(T)


def _average(rod: SolidRod, face: str, field: Field) -> Array:
    """Return the weights that give a face's own motion, least squares over its area, (3 m,)."""
    result = np.zeros((3, rod.fields.shape[1]))
    for component, function, factor in field:
        result[component] = factor * rod.weights[face][function]
    return np.asarray(result.ravel() / (result.ravel() @ _motion(rod, face, field)))
