"""Limbs of any chain in independent coordinates: Eqs. (10)-(22) for joints with any freedoms.

Along a chain the motion u (6) of a point is carried from item to item. A rigid link carries it as
a rigid body does. A joint of freedoms E (6 x f) lets it change by E r; its coordinates are the
absolute motions q along the freedoms, so that
    u_after = (1 - E E+) u_before + E q,
and at the tip, where the platform says what comes after, likewise backwards. With one free
rotation at the base that is Eqs. (17)-(18), with three at the tip Eq. (10). Where a freedom has a
stiffness its coordinate is r itself, of energy r^T k r / 2. Coordinates of a limb run from the base
to the tip; the platform's six are last.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.assembly import Layout, layout
from analytic.errors import InputError
from analytic.mechanism import Joint
from analytic.motion import PLATFORM, Map
from analytic.placed import Alike, Placed
from analytic.strut import DEPENDENT, strut_blocks

Floats = NDArray[np.float64]

PORT = -1.0
"""The stiffness of a freedom that is moved from outside: a coordinate without a spring."""


Block = tuple[int, tuple[int, ...], Floats]
"""Of a group of limbs (-1: the platform), columns and matrices of K and M, (2, n, c, c)."""


@dataclass(frozen=True)
class Piece:
    """A rod of n limbs in `count` pieces, equal but for the last of a `limb_core`.

    Attributes: `group` and `item`, which rod; `first`, `last` the maps of its ends; `start`, the
    coordinate of its first inner node, of six each.
    """

    group: int
    item: int
    count: int
    first: Map
    last: Map
    start: int


@dataclass(frozen=True)
class Network:
    """A mechanism in independent coordinates at one pose.

    Attributes: `groups`; `rods`, in the order of their blocks; `constant` blocks of K and M with
    their columns: springs, bodies, the platform; `joints`, which item the springs of
    a constant block belong to; `own` coordinates a limb of every group; `size`
    of all.
    """

    groups: tuple[Placed, ...]
    rods: tuple[Piece, ...]
    constant: tuple[Block, ...]
    joints: dict[int, int]
    own: tuple[int, ...]
    size: int

    @property
    def starts(self) -> tuple[tuple[int, ...], ...]:
        """The first coordinate of every limb, a tuple a group."""
        return _starts(tuple(tuple(g.alike.limbs.tolist()) for g in self.groups), self.own)

    def layout(self, *, sparse: bool = False) -> Layout:
        """Return where the blocks go: those of `rods` in their turn, then the `constant` ones."""
        starts = self.starts
        where: list[tuple[int, tuple[tuple[int, ...], ...]]] = []
        for piece in self.rods:
            where += [(piece.group, columns) for columns in piece_columns(piece)]
        where += [(group, (columns,)) for group, columns, _ in self.constant]
        return _layout(tuple(where), starts, self.size, sparse)

    def rod_columns(self) -> list[tuple[int, ...]]:
        """Return the columns of the block of every rod, where each is of one piece."""
        return [piece_columns(piece)[0][0] for piece in self.rods]

    def springs(self) -> list[tuple[Block, int]]:
        """Return the blocks of springs, each of one joint, and which item that is."""
        return [
            (block, self.joints[k]) for k, block in enumerate(self.constant) if k in self.joints
        ]

    def rod_blocks(
        self, matrices: Sequence[NDArray[Any]], last: Sequence[NDArray[Any]] | None = None
    ) -> list[NDArray[Any]]:
        """Return blocks of `rods`, from (..., n, 12, 12) in limb axes of every rod's pieces.

        `last`: those of every rod's last piece, where it is another.
        """
        blocks = []
        for piece, *both in zip(self.rods, matrices, last or matrices, strict=True):
            R = self.groups[piece.group].frames.swapaxes(-1, -2)
            *before, end = _ends(piece, R)
            blocks += [H.swapaxes(-1, -2) @ both[0] @ H for H in before]
            blocks.append(end.swapaxes(-1, -2) @ both[1] @ end)
        return blocks


def piece_columns(piece: Piece) -> list[tuple[tuple[int, ...], ...]]:
    """Return the columns of a rod's blocks: each a row of them for every time it is placed."""
    first, last, s, a = piece.first.columns, piece.last.columns, piece.count, piece.start
    if s == 1:
        return [(_union(first, last),)]
    inner = [tuple(range(a + 6 * k, a + 6 * k + 12)) for k in range(s - 2)]
    end = a + 6 * (s - 2)
    both = [((*first, *range(a, a + 6)),), tuple(inner), ((*range(end, end + 6), *last),)]
    return both if inner else [both[0], both[2]]


def _union(first: tuple[int, ...], last: tuple[int, ...]) -> tuple[int, ...]:
    return (*first, *(c for c in last if c not in first))


def _ends(piece: Piece, R: Floats) -> list[Floats]:
    """Return what turns a piece's coordinates into its own in limb axes, each (n, 12, c)."""
    n = len(R)
    first, last = (_turned(R, end.matrix) for end in (piece.first, piece.last))
    a, b = piece.first.size, piece.last.size
    if piece.count == 1:
        both = _union(piece.first.columns, piece.last.columns)
        alone = np.zeros((n, 12, len(both)))
        alone[:, :6, :a] = first
        alone[:, 6:, [both.index(c) for c in piece.last.columns]] = last
        return [alone]
    begin, end = np.zeros((n, 12, a + 6)), np.zeros((n, 12, 6 + b))
    begin[:, :6, :a], end[:, 6:, 6:] = first, last
    begin[:, 6:9, a : a + 3] = begin[:, 9:, a + 3 :] = R
    end[:, :3, :3] = end[:, 3:6, 3:6] = R
    if piece.count == 2:
        return [begin, end]
    inner = np.zeros((n, 12, 12))
    for k in range(0, 12, 3):
        inner[:, k : k + 3, k : k + 3] = R
    return [begin, inner, end]


def _turned(R: Floats, matrix: Floats) -> Floats:
    halves = matrix.reshape(len(R), 2, 3, -1)
    return np.asarray(R[:, None] @ halves).reshape(matrix.shape)


@lru_cache(maxsize=64)
def _starts(limbs: tuple[tuple[int, ...], ...], own: tuple[int, ...]) -> tuple[Any, ...]:
    """Return where the coordinates of every limb start, a tuple a group: limb after limb."""
    sizes = {i: size for some, size in zip(limbs, own, strict=True) for i in some}
    before = np.concatenate([[0], np.cumsum([sizes[i] for i in sorted(sizes)])])
    return tuple(tuple(int(before[i]) for i in some) for some in limbs)


@lru_cache(maxsize=64)
def _layout(where: Any, starts: Any, size: int, sparse: bool) -> Layout:
    kinds = []
    for group, times in where:
        start = np.array(starts[group] if group >= 0 else [0])[:, None]
        columns = np.array(times)[:, None, :]
        kinds.append(np.where(columns < 0, size + columns, start + columns))
    return layout(kinds, size, sparse=sparse)


def network(groups: Sequence[Placed], count: Any, platform_mass: Floats, unit: float) -> Network:
    """Return the mechanism whose limbs are `groups`, at one pose, in independent coordinates.

    `count(group, item)` says into how many pieces a rod is cut; `platform_mass` M_p (6, 6) in
    global axes; `unit` a length [m]. Raises `InputError` where freedoms depend on each other with
    nothing between them, and for limbs that do not give way.
    """
    rods: list[Piece] = []
    constant: list[Block] = []
    joints: dict[int, int] = {}
    own = []
    for g, placed in enumerate(groups):
        walk = Walk(g, placed, unit, count)
        own.append(walk.own)
        rods += walk.rods
        joints |= {len(constant) + k: item for k, item in walk.joints.items()}
        constant += walk.constant
    still = np.zeros((2, 1, 6, 6))
    still[1, 0] = platform_mass
    constant.append((-1, PLATFORM, still))
    size = sum(c * len(p.alike.limbs) for c, p in zip(own, groups, strict=True)) + 6
    return Network(tuple(groups), tuple(rods), tuple(constant), joints, tuple(own), size)


class Walk:
    """The coordinates, rods, springs and bodies of one group of limbs, from base to tip."""

    def __init__(self, group: int, placed: Placed, unit: float, count: Any) -> None:
        self.group, self.placed, self.unit = group, placed, unit
        self.alike: Alike = placed.alike
        self.n = len(self.alike.limbs)
        self.own = 0
        self.rods: list[Piece] = []
        self.constant: list[Block] = []
        self.joints: dict[int, int] = {}
        self.ports: dict[tuple[int, int], int] = {}
        kinds = [kind[0] for kind in self.alike.kind]
        if "rod" not in kinds:
            for item, block in strut_blocks(placed, unit):
                if kinds[item] == "joint":
                    self.joints[len(self.constant)] = item
                self.constant.append((group, PLATFORM, block))
            return
        last = max(self.alike.rods)
        held: Map | None = None
        at, pending = 0, []
        for k, kind in enumerate(kinds[: last + 1]):
            if kind == "joint":
                pending.append(k)
            elif kind == "link" and not pending:
                pass
            elif kind in ("rod", "body"):
                held = self._joined(held, at, k, pending)
                at, pending = k, []
                if kind == "body":
                    self._weigh(k, held)
                    continue
                s = count(group, k)
                start, self.own = self.own, self.own + 6 * (s - 1)
                end = self._free() if k < last else self._tail(last, kinds)
                self.rods.append(Piece(group, k, s, held, end, start))
                held, at = end, k + 1

    def _free(self) -> Map:
        columns = self._new(6)
        return Map(columns, np.broadcast_to(np.eye(6), (self.n, 6, 6)))

    def _new(self, count: int) -> tuple[int, ...]:
        self.own += count
        return tuple(range(self.own - count, self.own))

    def _tail(self, last: int, kinds: list[str]) -> Map:
        """Return the motion of the last rod's end: backwards from the platform."""
        J = Map(PLATFORM, np.broadcast_to(np.eye(6), (self.n, 6, 6))).carried(self.placed.arms)
        held, at, pending = J, len(kinds), []
        for k in range(len(kinds) - 1, last, -1):
            if kinds[k] == "joint":
                pending.append(k)
            elif kinds[k] == "body":
                held = self._joined(held, at, k, pending)
                at, pending = k, []
                self._weigh(k, held)
        return self._joined(held, at, last + 1, pending)

    def _joined(self, held: Map | None, before: int, after: int, joints: list[int]) -> Map:
        """Return the motion where item `after` starts, joined to `held` where `before` does."""
        starts = self.placed.starts
        there = starts[:, after]
        if held is not None:
            held = held.carried(there - starts[:, before])
        if not joints:
            return held or Map((), np.zeros((self.n, 6, 0)))
        twists = [
            Map((), self.placed.twists(k)).carried(there - starts[:, k]).matrix for k in joints
        ]
        E = np.concatenate(twists, axis=-1)
        f = E.shape[-1]
        if not f:
            return held or Map((), np.zeros((self.n, 6, 0)))
        scale = np.array([1.0] * 3 + [self.unit] * 3)[:, None]
        stiffness = np.concatenate([self.alike.freedoms[k].stiffness for k in joints], axis=1)
        self._check_independent((E * scale)[..., (stiffness >= 0).all(axis=0)], joints)
        sprung = (stiffness != 0).any(axis=0)
        u = held or Map((), np.zeros((self.n, 6, 0)))
        if sprung.any():
            # Relative coordinates: the stretch of a stiff spring is no difference of large motions.
            r = self._new(int(sprung.sum()))
            u = Map((*u.columns, *r), np.concatenate([u.matrix, E[..., sprung]], axis=-1))
            which = np.concatenate(
                [[k] * self.alike.freedoms[k].stiffness.shape[1] for k in joints]
            )
            for k in joints:
                moved = (stiffness == PORT).any(axis=0) & (which == k)
                for number, j in enumerate(np.flatnonzero(moved[sprung])):
                    self.ports[k, number] = r[j]
                mine = np.flatnonzero((which == k)[sprung] & ~moved[sprung])
                if mine.size:
                    f = np.arange(mine.size)
                    block = np.zeros((2, self.n, mine.size, mine.size))
                    block[0][:, f, f] = stiffness[:, sprung][:, mine]
                    self.joints[len(self.constant)] = k
                    self.constant.append((self.group, tuple(r[i] for i in mine), block))
        if not sprung.all():
            free = E[..., ~sprung]
            q = self._new(free.shape[-1])
            left = u.matrix
            if u.size:
                left = left - free @ ((np.linalg.pinv(free * scale) * scale.T) @ left)
            u = Map((*u.columns, *q), np.concatenate([left, free], axis=-1))
        return u

    def _check_independent(self, E: Floats, joints: list[int]) -> None:
        """Refuse freedoms (n, 6, f) that depend on each other with nothing between them."""
        if not E.shape[-1]:
            return
        size = np.linalg.norm(E, axis=1, keepdims=True)
        least = np.zeros(self.n)
        if E.shape[-1] <= 6:
            least = np.linalg.svd(E / size, compute_uv=False)[:, -1]
        poor = least < DEPENDENT
        if poor.any():
            limb = int(self.alike.limbs[int(poor.argmax())]) + 1
            items = [self.alike.chains[0][k] for k in sorted(joints)]
            names = " and ".join(item.name for item in items if isinstance(item, Joint))
            raise InputError(
                "mechanism",
                f"limb {limb}: the freedoms of {names} depend on each other "
                f"({float(least.min()):.1e} of independent)",
                "something between joints that share a freedom",
            )

    def _weigh(self, k: int, held: Map) -> None:
        """Add the mass of the bodies that are item `k`."""
        block = np.zeros((2, self.n, held.size, held.size))
        block[1] = held.matrix.swapaxes(-1, -2) @ self.placed.masses(k) @ held.matrix
        self.constant.append((self.group, held.columns, block))
