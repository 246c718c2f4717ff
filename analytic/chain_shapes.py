"""How chains move in a mode: the centre lines of their rods, and the links and bodies between."""

import numpy as np
from numpy.typing import NDArray

from analytic.exact_chain import Exact
from analytic.modes import STATIONS
from analytic.motion import Map
from analytic.network import Network, Piece
from analytic.placed import Placed
from analytic.rod_elements import Properties
from analytic.rod_exact import dynamic_stiffness

Floats = NDArray[np.float64]

AT_END = 1e-9
"""A station nearer than this to a node, in pieces, is the node."""


def centre_lines(
    problem: Exact, net: Network, nodes: list[Floats], platform: Floats, omega2: Floats
) -> Floats:
    """Return global displacement at `STATIONS` of all limbs in m motions, (m, n, k, 3).

    `nodes` of every rod of `net`, (n, count + 1, 6, m), and of the `platform` (6, m).

    Stations divide the line from where a limb starts (on its slider) to A_i. Between nodes a rod
    bends as at `omega2` (m,): exactly, or for zeros as an element does. Links and bodies follow the
    rod that is nearer along the chain; a limb without rods is a straight line to its end.
    """
    limbs = sum(len(group.alike.limbs) for group in net.groups)
    modes = platform.shape[1]
    result = np.zeros((modes, limbs, len(STATIONS), 3))
    for g, placed in enumerate(net.groups):
        n, which = len(placed.alike.limbs), placed.alike.limbs
        so_far = np.concatenate([np.zeros((n, 1)), np.cumsum(placed.lengths, axis=1)], axis=1)
        at = STATIONS * so_far[:, -1:]
        done = np.zeros(at.shape, dtype=bool)
        pieces = [(p, own) for p, own in zip(net.rods, nodes, strict=True) if p.group == g]
        if not pieces:
            tip = _tips(placed, platform)
            result[:, which] = np.einsum("k,nim->mnki", STATIONS, tip)
            continue
        moved = np.zeros((n, len(STATIONS), 3, modes))
        for p, motion in pieces:
            begin, end = so_far[:, [p.item]], so_far[:, [p.item + 1]]
            last = p is pieces[-1][0]
            # What lies before the first rod or after the last is carried by that one's end.
            own = ~done & ((at <= end) | last)
            here = _along(problem, net, p, motion, omega2, at - begin)
            moved = np.where(own[..., None, None], here, moved)
            done |= own
        result[:, which] = moved.transpose(3, 0, 1, 2)
    return result


def _tips(placed: Placed, platform: Floats) -> Floats:
    """Return how the ends A_i of limbs move, (n, 3, m): a rigid limb turns about its start."""
    turned = np.cross(platform[None, 3:], placed.arms[:, :, None], axis=1)
    return np.asarray(platform[None, :3] + turned)


def _along(
    problem: Exact, net: Network, piece: Piece, nodes: Floats, omega2: Floats, at: Floats
) -> Floats:
    """Return displacement where a rod is `at` (n, k) [m] from its start, (n, k, 3, m)."""
    placed, s = net.groups[piece.group], piece.count
    length = problem.lengths(piece.group, piece.item)
    h = length / s
    x = at / h[:, None]
    cell = np.clip(np.floor(x).astype(int), 0, s - 1)
    x = np.clip(x - cell, -np.inf, np.inf)
    n, k = at.shape
    R = placed.frames.swapaxes(-1, -2)
    local = np.einsum("nij,nshjm->nshim", R, nodes.reshape(n, s + 1, 2, 3, -1))
    local = local.reshape(n, s + 1, 6, -1)
    row = np.arange(n)[:, None]
    first, second = local[row, cell], local[row, cell + 1]
    u = np.empty((n, k, 6, nodes.shape[-1]))
    inner = (x > AT_END) & (x < 1 - AT_END)
    for i, j in np.argwhere(~inner):
        end, beyond = (
            (first, x[i, j] * h[i]) if x[i, j] <= AT_END else (second, (x[i, j] - 1) * h[i])
        )
        u[i, j] = end[i, j]
        u[i, j, 0] += beyond * end[i, j, 4]
        u[i, j, 1] -= beyond * end[i, j, 3]
    if inner.any():
        i, j = np.nonzero(inner)
        of = problem.of[piece.group, piece.item]
        rods = Properties(*(value[i] for value in vars(of).values()))
        lam = np.maximum(omega2, 1e-12 * problem.first)
        before = dynamic_stiffness(rods, x[i, j] * h[i], lam)
        after = dynamic_stiffness(rods, (1 - x[i, j]) * h[i], lam)
        pull = before[..., 6:, :6] @ first[i, j].transpose(2, 0, 1)[..., None]
        pull = pull + after[..., :6, 6:] @ second[i, j].transpose(2, 0, 1)[..., None]
        found = np.linalg.solve(before[..., 6:, 6:] + after[..., :6, :6], -pull)[..., 0]
        u[i, j] = found.transpose(1, 2, 0)
    return np.asarray(np.einsum("nij,nkjm->nkim", placed.frames, u[:, :, :3]))


def node_motions(net: Network, U: Floats) -> list[Floats]:
    """Return the motions of every rod's nodes in motions `U` (size, m) of `net`."""
    return [_nodes(net, piece, U) for piece in net.rods]


def _nodes(net: Network, piece: Piece, U: Floats) -> Floats:
    """Return the motions of a rod's nodes in global axes, (n, count + 1, 6, m)."""
    starts = net.starts[piece.group]
    n = len(starts)
    nodes = np.empty((n, piece.count + 1, 6, U.shape[1]))
    nodes[:, 0], nodes[:, -1] = (_moved(end, starts, U) for end in (piece.first, piece.last))
    inner = 6 * (piece.count - 1)
    rows = np.array(starts)[:, None] + piece.start + np.arange(inner)
    nodes[:, 1:-1] = U[rows].reshape(n, piece.count - 1, 6, U.shape[1])
    return nodes


def _moved(end: Map, starts: tuple[int, ...], U: Floats) -> Floats:
    columns = np.array(end.columns, dtype=int)
    rows = np.where(columns < 0, len(U) + columns, np.array(starts)[:, None] + columns)
    return np.asarray(end.matrix @ U[rows])
