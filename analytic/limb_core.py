"""A limb in its own axes: what depends on its adapting length alone, for tables over it.

Joints whose directions turn relative to the limb from pose to pose are left out: where they are the
core has ports, motions that are given, as its tip's six are.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic.mechanism import Body, Freedom, Item, Joint, Link, Rod, Vector
from analytic.network import PORT, Network, Walk, piece_columns
from analytic.placed import Alike, Freedoms, Placed
from analytic.rod_elements import Properties, element_matrices, properties
from analytic.rod_exact import dynamic_stiffness, pieces
from analytic.theory import Theory

Floats = NDArray[np.float64]
Array = NDArray[Any]

AXES: tuple[Vector, ...] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
TIP = 6


@dataclass(frozen=True)
class Core:
    """A limb in its own axes, hashable.

    Attributes: `chain`, its items, joints with freedoms in limb axes alone; `ports` of every item:
    the limb axes, 0 to 2 displacements and 3 to 5 rotations, along which a joint is moved from
    outside; `elements` a rod, None without; `theory` of the rods.
    """

    chain: tuple[Item, ...]
    ports: tuple[tuple[int, ...], ...]
    elements: int | None
    theory: Theory

    @property
    def given(self) -> list[tuple[int, int]]:
        """Item and axis of every port, in the order of the rows of `Assembled`; the tip's last."""
        own = [(k, axis) for k, axes in enumerate(self.ports) for axis in axes]
        return own + [(-1, axis) for axis in range(TIP)]

    @cached_property
    def adapts(self) -> int | None:
        """Which item takes its length from the pose, None where a slider adapts."""
        for k, item in enumerate(self.chain):
            if isinstance(item, (Rod, Link)) and item.length is None:
                return k
        return None

    @cached_property
    def of(self) -> dict[int, Properties]:
        """Properties of the rods, by item."""
        return {
            k: properties([item], self.theory)
            for k, item in enumerate(self.chain)
            if isinstance(item, Rod)
        }

    def lengths(self, adapting: Floats) -> Floats:
        """Return the lengths of all items (..., items) for `adapting` ones (...)."""
        rows = np.zeros((*adapting.shape, len(self.chain)))
        for k, item in enumerate(self.chain):
            if isinstance(item, (Rod, Link)):
                rows[..., k] = adapting if item.length is None else item.length
        return rows

    def pinned(self, adapting: Floats) -> Floats:
        """Return about omega^2 of bending of all rods in a row between pins, (...): smooth in it.

        (pi / sum_k l_k (m_k / EI_k)^(1/4))^4, exact for equal rods.
        """
        lengths = self.lengths(adapting)
        phase = sum(
            lengths[..., k] * (of.mass[0] / of.EI.min()) ** 0.25 for k, of in self.of.items()
        )
        return np.asarray((np.pi / phase) ** 4)


@dataclass(frozen=True)
class Assembled:
    """A core at n adapting lengths, cut into pieces: D over `inside` and `given` coordinates."""

    core: Core
    net: Network
    lengths: Floats
    given: NDArray[np.intp]

    @cached_property
    def inside(self) -> NDArray[np.intp]:
        """The coordinates that are not given."""
        return np.setdiff1d(np.arange(self.net.size), self.given)

    @cached_property
    def pair(self) -> Floats:
        """K and M with one element a piece, (2, n, size, size)."""
        blocks = self._rods(lambda of, lengths, _: element_matrices(of, lengths))
        return self._placed(blocks, [b for _, _, b in self.net.constant])

    def dynamic(self, lam: Array) -> Array:
        """Return D at `lam` (q, n), shape (q, n, size, size); complex of complex."""
        blocks = self._rods(lambda of, lengths, s: dynamic_stiffness(of, lengths, lam, s))
        still = [b[0] - lam[..., None, None] * b[1] for _, _, b in self.net.constant]
        return self._placed(blocks, still)

    def _rods(self, matrices: Callable[[Properties, Floats, int | None], Array]) -> list[Array]:
        """Return the blocks of rods, `matrices` being a piece's of its length and elements."""
        most, last = [], []
        for p in self.net.rods:
            of, length = repeated(self.core.of[p.item], len(self.lengths)), self.lengths[:, p.item]
            s = self.core.elements or p.count
            m = -(-s // p.count)
            end = s - (p.count - 1) * m
            both = {k: matrices(of, length * (k / s), self.core.elements and k) for k in (m, end)}
            most.append(both[m])
            last.append(both[end])
        return self.net.rod_blocks(most, last)

    def _placed(self, blocks: list[Array], still: list[Array]) -> Array:
        size = self.net.size
        where = [times for p in self.net.rods for times in piece_columns(p)]
        where += [(columns,) for _, columns, _ in self.net.constant]
        both = blocks + still
        D = np.zeros((*both[0].shape[:-2], size, size), dtype=np.result_type(*both))
        for times, block in zip(where, both, strict=True):
            for columns in times:
                at = np.array(columns, dtype=int)
                at = np.where(at < 0, size + at, at)
                D[..., at[:, None], at] += block
        return D


def repeated(of: Properties, n: int) -> Properties:
    """Return the properties of n equal rods."""
    return Properties(*(np.repeat(value, n, axis=0) for value in vars(of).values()))


def assembled(core: Core, adapting: Floats, omega2: Floats) -> Assembled:
    """Return `core` at `adapting` lengths (n,), without modes of pieces below `omega2` (n,)."""
    placed = _placed(core, adapting)
    lengths = placed.lengths

    def count(_: int, item: int) -> int:
        of = repeated(core.of[item], len(adapting))
        return pieces(of, lengths[:, item], omega2, core.elements)

    walk = Walk(0, placed, float(lengths.sum(axis=1).mean()), count)
    size = walk.own + TIP
    net = Network((placed,), tuple(walk.rods), tuple(walk.constant), walk.joints, (walk.own,), size)
    ports = [walk.ports[k, f] for k, axes in enumerate(core.ports) for f in range(len(axes))]
    return Assembled(core, net, lengths, np.array([*ports, *range(walk.own, size)]))


def _placed(core: Core, adapting: Floats) -> Placed:
    n = len(adapting)
    kinds: list[tuple[Any, ...]] = []
    freedoms = {}
    for k, (item, ports) in enumerate(zip(core.chain, core.ports, strict=True)):
        if isinstance(item, Joint):
            kinds.append(("joint", ""))
            own = [(f.kind, f.axis, f.stiffness) for f in item.freedoms]
            # Ports first.
            moved = [(("translation", "rotation")[a // 3], AXES[a % 3], PORT) for a in ports]
            each = moved + own
            freedoms[k] = Freedoms(
                np.broadcast_to(np.array([f[1] for f in each]).reshape(-1, 3), (n, len(each), 3)),
                np.broadcast_to(np.array([f[2] for f in each], dtype=float), (n, len(each))),
                tuple(f[0] for f in each),
                ("limb",) * len(each),
                (False,) * len(each),
            )
        else:
            name = "body" if isinstance(item, Body) else "rod" if isinstance(item, Rod) else "link"
            kinds.append((name,))
    lengths = core.lengths(adapting)
    zeros = np.zeros((n, 3))
    group = Alike(
        np.arange(n), (core.chain,) * n, tuple(kinds), zeros, zeros, zeros, lengths, freedoms, "",
        zeros,
    )  # fmt: skip
    starts = np.zeros((n, len(core.chain) + 1, 3))
    starts[:, 1:, 2] = np.cumsum(lengths, axis=1)
    frames = np.broadcast_to(np.eye(3), (n, 3, 3))
    return Placed(group, frames, zeros, lengths, starts, np.eye(3))


def in_limb_axes(joint: Joint, freedoms: list[tuple[str, Vector, float]]) -> Joint:
    """Return `joint` with these freedoms (kind, axis, stiffness) in limb axes."""
    return Joint(
        tuple(Freedom(kind, axis, "limb", stiffness) for kind, axis, stiffness in freedoms),
        name=joint.name,
    )
