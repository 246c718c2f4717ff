"""Eqs. (12)-(22) in one step: every element is placed where its coordinates are.

All elements of a limb are alike. Each is turned into its independent coordinates by one small
product, for all limbs at once; where its entries go depends on nothing but the numbers of limbs
and elements, and is worked out once.
"""

from __future__ import annotations  # scipy loads its parts when they are first used

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True)
class Layout:
    """Where blocks of entries go, for `size` coordinates.

    Attributes: `taken` (t,) entries of the blocks, some more than once, and `slots` (t,) of the
    matrices that they are added to: all entries, row by row, or the stored ones of the sparse
    matrices with `indices` and `pointers`.
    """

    size: int
    taken: Integers
    slots: Integers
    indices: Integers | None
    pointers: Integers | None

    def pair(self, blocks: list[Floats]) -> tuple[Any, ...]:
        """Return K and M from blocks (2, ...) of both: dense, or sparse."""
        every = np.concatenate([block.reshape(2, -1) for block in blocks], axis=1)
        entries = every.take(self.taken, axis=1)
        stored = self.size**2 if self.indices is None else len(self.indices)
        K, M = (np.bincount(self.slots, of, stored) for of in entries)
        if self.indices is None:
            return K.reshape(self.size, -1), M.reshape(self.size, -1)
        where: Any = (self.indices, self.pointers)
        shape = (self.size, self.size)
        return tuple(scipy.sparse.csr_array((of, *where), shape=shape) for of in (K, M))


@lru_cache(maxsize=16)
def joined(n: int, s: int, *, sparse: bool) -> Layout:
    """Return the layout of U, Eq. (19): 6 s - 2 coordinates a limb, then the platform's six.

    Blocks, for all limbs: the first elements (7 x 7), over phi_B and the node after; the inner ones
    (12 x 12); the last (15 x 15), over the node before, Phi_A and the platform; the platform.
    One element alone (10 x 10) has phi_B, Phi_A and the platform.
    """
    own = 6 * s - 2
    start = own * np.arange(n)[:, None]
    platform = np.broadcast_to(n * own + np.arange(6), (n, 6))
    if s == 1:
        chain = [np.hstack([start + np.arange(4), platform])]
        inner = np.empty((0, n, 0), dtype=int)
    else:
        before = start + np.arange(own - 9, own)
        chain = [start + np.arange(7), np.hstack([before, platform])]
        inner = 6 * np.arange(s - 2)[:, None, None] + (start + np.arange(1, 13))
    kinds = [chain[0][None], *([inner] if s > 2 else []), *(d[None] for d in chain[1:])]
    return layout([*kinds, platform[None, :1]], n * own + 6, sparse=sparse)


@lru_cache(maxsize=16)
def free(n: int, s: int, *, sparse: bool) -> Layout:
    """Return the layout of n limbs that nothing joins, 6 (s + 1) coordinates each, and a platform.

    Blocks: every limb's element (12 x 12), then the platform.
    """
    own = 6 * (s + 1)
    element = np.arange(12) + own * np.arange(n)[:, None] + 6 * np.arange(s)[:, None, None]
    platform = n * own + np.arange(6)[None, None]
    return layout([element, platform], n * own + 6, sparse=sparse)


def layout(kinds: list[Integers], size: int, *, sparse: bool) -> Layout:
    """Return the layout of blocks with coordinates (times, limbs, d): one a limb, so often."""
    taken, slots, offset = [], [], 0
    for dofs in kinds:
        times, limbs, d = dofs.shape
        taken.append(np.tile(offset + np.arange(limbs * d * d), times))
        slots.append((dofs[..., :, None] * size + dofs[..., None, :]).ravel())
        offset += limbs * d * d
    slot, entry = np.concatenate(slots), np.concatenate(taken)
    if not sparse:
        return Layout(size, entry, slot, None, None)
    stored, slot = np.unique(slot, return_inverse=True)
    rows, columns = np.divmod(stored, size)
    pointers = np.searchsorted(rows, np.arange(size + 1))
    return Layout(size, entry, slot, columns.astype(np.int32), pointers.astype(np.int32))
