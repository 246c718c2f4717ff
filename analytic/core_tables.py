"""Tables of a limb's core over its adapting length: poles, residues and a short polynomial.

Its dynamic stiffness at what moves it from outside (its tip and its ports) is
    S(lambda) = P(lambda) - sum_j c_j c_j^T / (lambda_j - lambda),
with the poles lambda_j below a threshold, the limb's modes with all of that held still, and a P
that is smooth up to a cap. Coordinates fall into blocks that nothing couples (the bar, the shaft,
either plane of bending); modes of a block that nothing moves from outside are modes of the
mechanism. The whole is checked against S itself between the nodes of the tables.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import scipy.sparse.csgraph
from numpy.typing import NDArray

from analytic.limb_core import Array, Assembled, Core, Floats, assembled
from analytic.limb_modes import DEGREE, MARGIN, chebyshev_series, to_powers

EXACT = 5e-11
"""Largest error of a table against S itself, relative to S and its slope."""
MOST_NODES = 64
"""Most Chebyshev nodes over the adapting length."""
MOST_INSIDE = 260
"""Most coordinates of a core whose modes are found by dense matrices."""
ROUNDING = 1e-15
"""A power of P whose Chebyshev coefficient is below this part of the largest is left out."""
COUPLED = 1e-12
"""An entry below this part of its diagonal's is none."""
STILL = 1e-9
"""Of stiffness scaled by its diagonal: an eigenvalue below is a motion without energy."""
SPARE, GAP = 3, 1.3
"""Poles that nearly meet over the lengths are kept both, up to so many more than needed."""
CIRCLE, ORDERS = 64, 48
STEP = 1e-30
STEPS, CLOSE = 12, 1e-13
"""Most of Newton's steps to a pole, and one that is the last, relative."""


@dataclass(frozen=True)
class Table:
    """The tables of one core for adapting lengths within `span` [m].

    Attributes: `rows`, which of `Core.given` it takes; `poles` and `alone`, how many poles there
    are and how many modes that nothing moves from outside; `pole` and `row` of every residue;
    `first` and `second` row of every entry of P, first <= second; `reach`, up to which part of
    `Core.pinned` P holds, and `degree` its degree there; `columns` Chebyshev coefficients over the
    logarithm of the length (q, columns): poles, modes alone, residues, powers of every entry;
    `error` of every row's entries of S found between the nodes, relative to S and its slope.
    """

    core: Core
    span: tuple[float, float]
    rows: NDArray[np.intp]
    poles: int
    alone: int
    pole: NDArray[np.intp]
    row: NDArray[np.intp]
    first: NDArray[np.intp]
    second: NDArray[np.intp]
    reach: float
    degree: int
    columns: Floats
    error: Floats

    def caps(self, lengths: Floats) -> Floats:
        """Return lambda up to which P holds, shape of `lengths`."""
        return self.reach * self.core.pinned(lengths)

    def at(self, lengths: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Return poles (N, p), modes alone (N, a), residues (N, r), powers (degree+1, N, e)."""
        q = len(self.columns)
        if q == 1:
            values = np.broadcast_to(self.columns, (len(lengths), self.columns.shape[1]))
        else:
            low, high = np.log(self.span)
            u = (2 * np.log(lengths) - (low + high)) / (high - low)
            T = np.ones((q, len(u)))
            T[1] = u
            for k in range(2, q):
                np.multiply(2 * u, T[k - 1], out=T[k])
                T[k] -= T[k - 2]
            values = T.T @ self.columns
        a = self.poles + self.alone
        b = a + len(self.pole)
        powers = values[:, b:].reshape(len(lengths), self.degree + 1, -1).swapaxes(0, 1)
        return values[:, : self.poles], values[:, self.poles : a], values[:, a:b], powers


def table(core: Core, low: float, high: float, reach: float) -> Table | None:
    """Return tables for adapting lengths `low` to `high` up to `reach` times `Core.pinned`.

    None where no table is exact.
    """
    if core.adapts is None:
        return _table(core, (1.0, 1.0), reach)
    # Outward to eighths of an octave, so that neighbouring calls share a table.
    low, high = low * (1 - 1e-9), high * (1 + 1e-9)
    span = 2 ** (np.floor(8 * np.log2(low)) / 8), 2 ** (np.ceil(8 * np.log2(high)) / 8)
    return _table(core, (float(span[0]), float(span[1])), reach)


@lru_cache(maxsize=256)
def _table(core: Core, span: tuple[float, float], reach: float) -> Table | None:
    sizes = (1,) if core.adapts is None else (18, 28, 42, MOST_NODES)
    for size in sizes:
        made = _made(core, span, reach, size)
        if made is None:
            return None
        error = _error(core, made)
        worst = float(error.max())
        if worst < EXACT:
            return replace(made, error=error)
        # Errors fall by a factor a node: from here they would not fall far enough.
        if not worst <= EXACT ** (size / (1.2 * MOST_NODES)):
            return None
    return None


def _nodes(span: tuple[float, float], size: int) -> Floats:
    low, high = np.log(span)
    u = np.cos(np.pi * (np.arange(size) + 0.5) / size)
    return np.asarray(np.exp((low + high) / 2 + (high - low) / 2 * u))


def _made(core: Core, span: tuple[float, float], reach: float, size: int) -> Table | None:
    lengths = _nodes(span, size)
    caps = reach * core.pinned(lengths)
    cut = assembled(core, lengths, 1.3 * caps / MARGIN)
    if len(cut.inside) > MOST_INSIDE:
        return None
    blocks = _blocks(cut)
    K, M = cut.pair
    inner = [(inside, given, _guesses(K, M, inside)) for inside, given in blocks]
    kept = [_kept(g[1], caps / MARGIN) for _, _, g in inner]
    highest = [g[1][:, k - 1] for k, (_, _, g) in zip(kept, inner, strict=True) if k]
    cover = np.max([1.3 * caps, *(1.1 * top for top in highest)], axis=0)
    cut = assembled(core, lengths, cover)
    if len(cut.inside) > MOST_INSIDE:
        return None
    return _filled(core, span, cut, reach, caps, kept)


def _kept(omega2: Floats, least: Floats) -> int:
    """Return how many poles (n, i) to keep: all below `least` (n,), and then up to a wide gap."""
    below = int((omega2 < least[:, None]).sum(axis=1).max(initial=0))
    ends = [k for k in range(below, below + SPARE) if 0 < k < omega2.shape[1]]
    if not below or not ends:
        return below
    gaps = [float((omega2[:, k] / omega2[:, k - 1]).min()) for k in ends]
    good = [k for k, gap in zip(ends, gaps, strict=True) if gap > GAP]
    return good[0] if good else ends[int(np.argmax(gaps))]


def _blocks(cut: Assembled) -> list[tuple[NDArray[np.intp], NDArray[np.intp]]]:
    """Return the inside and the given coordinates of every block that nothing couples."""
    joined = np.zeros((cut.net.size,) * 2, dtype=bool)
    for matrix in cut.pair:
        size = np.sqrt(np.abs(np.einsum("nii->ni", matrix)))
        joined |= (np.abs(matrix) > COUPLED * size[:, :, None] * size[:, None, :]).any(axis=0)
    count, label = scipy.sparse.csgraph.connected_components(joined, directed=False)
    found = []
    for k in range(count):
        own = np.flatnonzero(label == k)
        given = np.intersect1d(own, cut.given)
        # What is given and joined to nothing, not to itself either, moves nothing.
        if joined[np.ix_(own, own)].any():
            found.append((np.setdiff1d(own, given), given))
    return sorted(found, key=lambda pair: _order(cut, pair))


def _order(cut: Assembled, block: tuple[NDArray[np.intp], NDArray[np.intp]]) -> tuple[int, ...]:
    """Return a key by which blocks keep their order however rods are cut."""
    inside, given = block
    where = {int(c): k for k, c in enumerate(cut.given)}
    if given.size:
        return (0, *sorted(where[int(c)] for c in given))
    return (1, *(int(c) for c in inside))


def _guesses(K: Floats, M: Floats, inside: NDArray[np.intp]) -> tuple[int, Floats]:
    """Return how many motions need no energy, and omega^2 of the others, ascending, (n, i)."""
    if not inside.size:
        return 0, np.empty((len(K), 0))
    k, m = (X[:, inside[:, None], inside] for X in (K, M))
    scale = 1 / np.sqrt(np.maximum(np.einsum("nii->ni", k), 1e-300))
    stiff = k * scale[:, :, None] * scale[:, None, :]
    free = np.einsum("nii->ni", k) <= 0
    values = np.linalg.eigvalsh(np.where(free[:, :, None], 0, stiff))
    still = int((values < STILL).sum(axis=1).max())
    own: Array = np.linalg.eigvalsh(_standard(k, m))
    return still, own[:, still:]


def _standard(k: Array, m: Floats) -> Floats:
    scale = 1 / np.sqrt(np.einsum("...ii->...i", m))
    both = scale[..., :, None] * scale[..., None, :]
    left = np.linalg.inv(np.linalg.cholesky(m * both))
    return np.asarray(left @ (k * both) @ left.swapaxes(-1, -2))


def _filled(
    core: Core,
    span: tuple[float, float],
    cut: Assembled,
    reach: float,
    caps: Floats,
    kept: list[int],
) -> Table | None:
    """Return the table of the poles `kept` in every block."""
    n = len(caps)
    place = {int(c): k for k, c in enumerate(cut.given)}
    blocks = _blocks(cut)
    K, M = cut.pair
    # The lower half of the circle mirrors the upper one.
    angles = np.exp(2j * np.pi * (np.arange(CIRCLE // 2) + 0.5) / CIRCLE)
    circle = caps / 2 * (1 + 1.5 * angles[:, None])
    at_circle = cut.dynamic(circle)
    t = np.cos(np.pi * (np.arange(DEGREE + 1) + 0.5) / (DEGREE + 1))
    order = np.arange(ORDERS)
    to_nodes = (t[:, None] / 1.5) ** order @ (angles[:, None] ** -order).T * 2 / CIRCLE
    poles: list[Floats] = []
    alone: list[Floats] = []
    residues: list[tuple[int, int, Floats]] = []
    entries: list[tuple[int, int, Floats]] = []
    degree = 1
    for (inside, given), p in zip(blocks, kept, strict=True):
        still, guesses = _guesses(K, M, inside)
        lam, x = _modes(cut, inside, still, guesses[:, :p])
        if not given.size:
            alone += list(lam.T)
            continue
        c = np.empty((n, p, len(given)))
        for j in range(p):
            coupling = cut.dynamic(lam[None, :, j])[0][:, given[:, None], inside]
            c[:, j] = (coupling @ x[:, :, j, None])[..., 0]
        D = at_circle[..., given[:, None], given]
        size = np.sqrt(np.abs(np.einsum("tnii->tni", D)).max(axis=(0, 1)))
        if inside.size:
            across = at_circle[..., inside[:, None], given]
            solved = np.linalg.solve(at_circle[..., inside[:, None], inside], across)
            D = D - across.swapaxes(-1, -2) @ solved
        for j in range(p):
            outer = c[:, j, :, None] * c[:, j, None, :]
            D = D + outer / (lam[:, j] - circle)[..., None, None]
        values = (to_nodes @ D.reshape(len(angles), -1)).real.reshape(
            len(t), n, len(given), len(given)
        )
        for i, one in enumerate(given):
            for k in range(i, len(given)):
                if np.abs(values[:, :, i, k]).max() > COUPLED * size[i] * size[k]:
                    series = chebyshev_series(values[:, :, i, k])
                    large = np.abs(series) > ROUNDING * np.abs(series).max(axis=0)
                    degree = max(degree, int(np.flatnonzero(large.any(axis=1))[-1]))
                    entries.append((place[int(one)], place[int(given[k])], series))
        for j in range(p):
            residues += [
                (len(poles) + j, place[int(one)], c[:, j, i]) for i, one in enumerate(given)
            ]
        poles += list(lam.T)
    used = sorted({k for first, second, _ in entries for k in (first, second)})
    at = {k: position for position, k in enumerate(used)}
    residues = [row for row in residues if row[1] in at]
    columns = np.concatenate([
        np.reshape([*poles, *alone, *(r[2] for r in residues)], (-1, n)),
        # Powers outside, entries inside.
        np.stack([to_powers(e[2][: degree + 1]) for e in entries], axis=1).reshape(-1, n),
    ])  # fmt: skip
    return Table(
        core,
        span,
        np.array(used),
        len(poles),
        len(alone),
        np.array([r[0] for r in residues], dtype=int),
        np.array([at[r[1]] for r in residues], dtype=int),
        np.array([at[e[0]] for e in entries]),
        np.array([at[e[1]] for e in entries]),
        reach,
        degree,
        chebyshev_series(columns.T),
        np.full(len(used), np.inf),
    )


def _modes(
    cut: Assembled, inside: NDArray[np.intp], still: int, guesses: Floats
) -> tuple[Floats, Floats]:
    """Return omega^2 (n, p) and vectors (n, i, p) of unit modal mass of a block held outside.

    Newton's iteration on D x = delta (-D') x by rank, from above.
    """
    n, p = guesses.shape
    lam, x = guesses.T.copy(), np.zeros((p, n, len(inside)))
    if not p:
        return lam.T, x.transpose(1, 2, 0)
    rank = np.arange(p)[:, None]
    for step in range(STEPS):
        D = cut.dynamic(lam * (1 + 1j * STEP))[..., inside[:, None], inside]
        mass = -D.imag / (STEP * lam[..., None, None])
        scale = 1 / np.sqrt(np.einsum("pnii->pni", mass))
        both = scale[..., :, None] * scale[..., None, :]
        left = np.linalg.inv(np.linalg.cholesky(mass * both))
        values, y = np.linalg.eigh(left @ (D.real * both) @ left.swapaxes(-1, -2))
        # Motions without energy have sunk below zero.
        delta = values[rank, np.arange(n), still + rank]
        y = y.swapaxes(-1, -2)[rank, np.arange(n), still + rank]
        x = scale * np.einsum("pnji,pnj->pni", left, y)
        if (np.abs(delta) < CLOSE * lam).all() or step == STEPS - 1:
            break
        lam = lam + delta
    # Neighbours over the length agree in sign.
    weight = np.sqrt(np.einsum("pnii->pni", mass))
    agree = ((x * weight)[:, 1:] * (x * weight)[:, :-1]).sum(axis=-1)
    x[:, 1:] *= np.cumprod(np.where(agree < 0, -1.0, 1.0), axis=1)[..., None]
    return lam.T, x.transpose(1, 2, 0)


def _error(core: Core, made: Table) -> Floats:
    """Return each row's largest relative error of S between the nodes, over lengths and lambda."""
    several = 1 if core.adapts is None else 13
    fraction = np.linspace(0.03, 0.97, 7)
    lengths = _nodes(made.span, several)
    caps = made.caps(lengths)
    cut = assembled(core, lengths, 1.01 * caps)
    lam = fraction[:, None] * caps
    D = cut.dynamic(lam * (1 + 1j * STEP))
    b, i = cut.given[made.rows], cut.inside
    S = D[..., b[:, None], b]
    if i.size:
        across = D[..., i[:, None], b]
        # By blocks: a motion without energy is regular off zero.
        S = S - across.swapaxes(-1, -2) @ np.linalg.solve(D[..., i[:, None], i], across)
    slope = np.abs(S.imag) / STEP
    own = np.einsum("qnii->qni", np.abs(S.real) + slope)
    size = np.sqrt(own[..., :, None] * own[..., None, :])
    found = np.stack([evaluate(made, lengths, row) for row in lam])
    return np.asarray((np.abs(found - S.real) / size).max(axis=(0, 1, 2)))


def evaluate(made: Table, lengths: Floats, lam: Floats) -> Floats:
    """Return S over the table's rows at `lam` (N,), shape (N, c, c)."""
    poles, _, residues, powers = made.at(lengths)
    t = 2 * lam / made.caps(lengths) - 1
    entry = (powers * (t ** np.arange(made.degree + 1)[:, None])[..., None]).sum(axis=0)
    S = np.zeros((len(lengths), len(made.rows), len(made.rows)))
    S[:, made.first, made.second] = entry
    S[:, made.second, made.first] = entry
    C = np.zeros((len(lengths), made.poles, len(made.rows)))
    C[:, made.pole, made.row] = residues
    return np.asarray(S - C.swapaxes(1, 2) @ (C / (poles - lam[:, None])[..., None]))
