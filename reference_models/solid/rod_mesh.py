"""A structured mesh of a round rod: 20-node hexahedra, finer towards rims and end faces."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from analytic.errors import InputError, count, number

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

_FACE = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
CORNERS = np.array([(*corner, z) for z in (-1, 1) for corner in _FACE])
_RING = [(0, 1), (1, 2), (2, 3), (3, 0)]
EDGES = [*_RING, *((a + 4, b + 4) for a, b in _RING), *((a, a + 4) for a in range(4))]
LOCAL = np.concatenate([CORNERS, [(CORNERS[a] + CORNERS[b]) // 2 for a, b in EDGES]])
"""Local coordinates of an element's nodes, (20, 3): corners, then edges, in Abaqus's order."""

CORE = 0.6
"""Half the diagonal of the square block at the centre, relative to the rod's radius."""
BULGE = 0.4
"""How round that square is: 0 straight, 1 a circle."""


@dataclass(frozen=True)
class RodMesh:
    """A rod of `length` and `diameter` [m] along local z, from its base at z = 0.

    `along` elements lie between the end faces. Across, a square of `across` x `across` elements
    is surrounded by `across` rings of 4 `across` elements. Their outer edges are parabolas, not
    arcs: the section is scaled (by 4e-4 for two rings) to the rod's own area, which leaves its
    second moment right to 1e-6 (6e-5 for one ring). Twice both numbers halves every element.

    A rod with a `bore` [m] has `across` rings of 8 `across` elements instead, whose inner and outer
    edges are such parabolas too.

    `grading` g >= 1 crowds elements towards the end faces and the rims: the distance to them goes
    as the g-th power of the element's number. Stress at a rigid face's rim is singular, and equal
    elements (g = 1) converge slowly to it.
    Raises `InputError` for anything that makes no rod.
    """

    length: float
    diameter: float
    along: int
    across: int
    grading: float = 1.0
    bore: float = 0.0

    def __post_init__(self) -> None:
        for name in ("length", "diameter"):
            number(name, getattr(self, name), "a positive number of metres", positive=True)
        count("along", self.along)
        count("across", self.across)
        if not 0 <= number("bore", self.bore, "a number of metres") < self.diameter:
            raise InputError("bore", self.bore, f"from 0 to less than {self.diameter:g} m")
        if number("grading", self.grading, "an exponent of at least 1") < 1:
            raise InputError("grading", self.grading, "an exponent of at least 1")

    @cached_property
    def levels(self) -> Array:
        """Where the elements' end planes are, z of shape (along + 1,) [m]."""
        return self.length * self._crowded(self.along)

    def _crowded(self, elements: int) -> Array:
        """Return where elements end that crowd to both ends of 0..1, (elements + 1,)."""
        t = np.linspace(0.0, 1.0, elements + 1)
        near = 0.5 * (2 * np.minimum(t, 1 - t)) ** self.grading
        return np.where(t < 0.5, near, 1 - near)

    @cached_property
    def section(self) -> tuple[Array, Indices]:
        """Points (p, 2) [m] of the cross-section, and its quadrilaterals (q, 9) of them.

        Each lists corners, middles of edges, and its own middle, which no element uses.
        """
        if self.bore:
            return self._tube()
        n = 2 * self.across
        u, v = np.meshgrid(*[np.linspace(-1.0, 1.0, n + 1)] * 2, indexing="ij")
        square = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
        core = _core(u, v).reshape(-1, 2)
        # The square's boundary, anticlockwise from its corner at -135 degrees.
        loop = np.r_[square[:-1, 0], square[-1, :-1], square[:0:-1, -1], square[0, :0:-1]]
        angle = np.pi * (-0.75 + 0.5 * np.arange(4 * n) / n)
        circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        # Rings' edges run straight from the core to the circle; middles are half-way.
        ends = 1 - (1 - np.linspace(0.0, 1.0, self.across + 1)) ** self.grading
        out = np.interp(np.arange(n + 1) / 2, np.arange(self.across + 1), ends)[1:, None, None]
        rings = core[loop] + out * (circle - core[loop])
        points = np.concatenate([core, rings.reshape(-1, 2)])
        points *= self.diameter / 2 * _area_kept(4 * self.across)

        fan = np.concatenate([loop[None], len(core) + np.arange(4 * n * n).reshape(n, 4 * n)])
        fan = np.concatenate([fan, fan[:, :1]], axis=1).T
        # A fan's first direction runs round and its second outwards: reversed, it is right-handed.
        return points, np.concatenate([_quads(square), _quads(fan[::-1])])

    def _tube(self) -> tuple[Array, Indices]:
        around = 8 * self.across
        angle = np.pi * np.arange(2 * around) / around
        ends = self._crowded(self.across)
        out = np.interp(np.arange(2 * self.across + 1) / 2, np.arange(self.across + 1), ends)
        radius = (self.bore + (self.diameter - self.bore) * out) / 2 * _area_kept(around)
        circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        points = (radius[:, None, None] * circle).reshape(-1, 2)
        fan = np.arange(len(points)).reshape(len(radius), 2 * around)
        fan = np.concatenate([fan, fan[:, :1]], axis=1).T
        return points, _quads(fan[::-1])

    @cached_property
    def _lattice(self) -> tuple[Array, Indices]:
        points, quads = self.section
        z = np.interp(np.arange(2 * self.along + 1) / 2, np.arange(self.along + 1), self.levels)
        nodes = np.concatenate(
            [np.tile(points, (len(z), 1)), np.repeat(z, len(points))[:, None]], axis=1
        )
        base, middle = quads[:, [0, 1, 2, 3]], quads[:, [4, 5, 6, 7]]
        step = len(points)
        one = np.concatenate(
            [base, base + 2 * step, middle, middle + 2 * step, base + step], axis=1
        )
        shift = 2 * step * np.arange(self.along)[:, None, None]
        elements = (one + shift).reshape(-1, 20)
        used, inverse = np.unique(elements, return_inverse=True)
        return nodes[used], inverse.reshape(elements.shape).astype(np.int64)

    @property
    def nodes(self) -> Array:
        """Where the nodes are, local frame, shape (N, 3) [m]."""
        return self._lattice[0]

    @property
    def elements(self) -> Indices:
        """The nodes of every element, shape (E, 20), in Abaqus's order, layer after layer."""
        return self._lattice[1]

    @property
    def base(self) -> Indices:
        """The nodes of the end face at z = 0."""
        return np.flatnonzero(self.nodes[:, 2] == self.nodes[:, 2].min())

    @property
    def tip(self) -> Indices:
        """The nodes of the end face at z = length."""
        return np.flatnonzero(self.nodes[:, 2] == self.nodes[:, 2].max())

    def centre_line(self, fractions: Array) -> tuple[Indices, Array]:
        """Return the nodes (k, c) and weights (k, c) that give the motion of the centre line.

        `fractions` (k,) of the length, 0..1; weights are the element's own shape functions, c = 20,
        or with a bore the mean of the corners around it.
        """
        quads = len(self.section[1])
        # The centre is the middle of the core's middle element, or a corner of one beside it.
        half = self.across // 2
        corner = 0 if self.across % 2 else -1
        z = self.levels / self.length
        layer = np.clip(np.searchsorted(z, fractions, side="right") - 1, 0, self.along - 1)
        along = 2 * (fractions - z[layer]) / (z[layer + 1] - z[layer]) - 1
        if self.bore:
            return self._around_bore(layer, along)
        at = np.stack([np.full_like(along, corner), np.full_like(along, corner), along], axis=1)
        return self.elements[layer * quads + half * self.across + half], shape_functions(at)

    def _around_bore(self, layer: Indices, along: Array) -> tuple[Indices, Array]:
        # Of the innermost elements, the edge along the rod at their first corner.
        quads = self.elements.reshape(self.along, -1, 20)
        points = self.nodes[quads[0, :, :4], :2]
        radius = np.linalg.norm(points, axis=-1)
        quad, corner = np.nonzero(radius < radius.min() * (1 + 1e-9))
        edge = np.stack([corner, corner + 16, corner + 4], axis=1)
        nodes = quads[layer[:, None, None], quad[:, None], edge]
        of = np.stack([along * (along - 1) / 2, 1 - along**2, along * (along + 1) / 2], axis=1)
        weights = np.tile(of[:, None, :] / len(quad), (1, len(quad), 1))
        return nodes.reshape(len(along), -1), weights.reshape(len(along), -1)


def _area_kept(around: int) -> float:
    """Return by how much a circle of parabolas is larger that encloses the circle's area.

    A parabola over the angle 2a of a circle encloses sin(a) (4 - cos(a)) / 3, an arc a.
    """
    a = np.pi / around
    return float(np.sqrt(3 * a / (np.sin(a) * (4 - np.cos(a)))))


def shape_functions(at: Array) -> Array:
    """Return the 20 serendipity functions at local coordinates (k, 3) in -1..1, shape (k, 20)."""
    product = at[:, None, :] * LOCAL
    linear = (1 + product).prod(axis=2)
    corner = linear * (product.sum(axis=2) - 2) / 8
    # At the middle of an edge one local coordinate is zero: a parabola along, linear across.
    parabola = (1 - np.where(LOCAL == 0, at[:, None, :], 0.0) ** 2).prod(axis=2)
    return np.asarray(np.where((LOCAL != 0).all(axis=1), corner, linear * parabola / 4))


def _core(u: Array, v: Array) -> Array:
    """Map the square -1..1 to one with corners at `CORE` and sides rounded by `BULGE`."""
    flat = np.stack([u, v], axis=-1) / np.sqrt(2)
    # Lines of constant u become arcs: the square of Shirley and Chiu's concentric disc.
    size = np.maximum(np.abs(u), np.abs(v))
    steep = np.abs(v) > np.abs(u)
    ratio = np.where(steep, u, v) / np.where(size == 0, 1.0, np.where(steep, v, u))
    radial = np.where(steep, v, u)
    c, s = radial * np.cos(ratio * np.pi / 4), radial * np.sin(ratio * np.pi / 4)
    round_ = np.where(steep[..., None], np.stack([s, c], axis=-1), np.stack([c, s], axis=-1))
    return np.asarray(CORE * ((1 - BULGE) * flat + BULGE * round_))


def _quads(lattice: Indices) -> Indices:
    """Return the 9 points of every quadrilateral of a lattice with odd numbers of points."""
    a, b = (slice(0, -2, 2), slice(2, None, 2))
    m = slice(1, None, 2)
    corners = [lattice[a, a], lattice[b, a], lattice[b, b], lattice[a, b]]
    middles = [lattice[m, a], lattice[b, m], lattice[m, b], lattice[a, m], lattice[m, m]]
    return np.stack([part.ravel() for part in corners + middles], axis=1)
