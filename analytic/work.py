"""Counted work of every formulation: what it takes on any machine and in any language.

Floating-point operations are those of the algorithms used here, additions and multiplications
alike, to their leading terms, for a structure of n limbs:

- dense: of N coordinates, N^3 / 3 (Cholesky) + 2 N^3 (reduction to one matrix, by two triangular
  solutions) + 4 N^3 / 3 (tridiagonal form) + 3 N^2 k (k vectors back); Golub and Van Loan (2013),
  Sections 4.2, 8.3, 8.7, and LAPACK Working Note 41. The tridiagonal problem itself is of order
  N^2 and left out.
- sparse: of a column with c entries below its pivot, 2 c^2 + c to eliminate and 2 c + 1 entries to
  store (L and U; Davis 2006, Section 4.1); then `BLOCKS` steps of block Lanczos, each with a
  solution (2 operations an entry, twice), a product with M and two orthogonalisations.

How far columns reach follows from the chains: a node to the next one, the last one to Phi_A and
the platform.
"""

from collections.abc import Iterable
from dataclasses import dataclass

BLOCKS = 5
"""Steps that block Lanczos takes as a rule, with blocks of two more than the modes wanted."""


@dataclass(frozen=True)
class Work:
    """`dofs` solved for, `nonzeros` of K, `bytes` of K, M and factors, `flops` of a solution."""

    dofs: int
    nonzeros: int
    bytes: int
    flops: int


def substructure(s: int, limbs: int = 3, count: int = 6, *, sparse: bool = False) -> Work:
    """Return the work of `Substructure`: 6 s - 2 coordinates a limb and the platform's six."""
    dofs = limbs * (6 * s - 2) + 6
    if s == 1:
        entries, reach = 4 * 4 + 2 * 4 * 6, _falling(4, 6)
    else:
        entries = 49 + 144 * (s - 2) + 81 - 36 * (s - 1) + 2 * 9 * 6
        nodes = _falling(6, 6) * (s - 2) + _falling(6, 9)
        reach = [6, *nodes, *_falling(3, 6)]
    nonzeros = limbs * entries + 36
    if sparse:
        return sparse_work(dofs, nonzeros, reach * limbs + _falling(6, 0), count)
    return Work(dofs, nonzeros, 2 * 8 * dofs**2, dense(dofs, count))


def null_space(s: int, limbs: int = 3, count: int = 6, *, sparse: bool = False) -> Work:
    """Return the work of `Multipliers` by the null space, which is made and applied besides.

    9 n + 6 coordinates are held by 8 n joints' rows. Sparse, what these leave is counted as full.
    """
    held, rows = 9 * limbs + 6, 8 * limbs
    left = held - rows
    own = 36 * (s - 1) + 72 * (s - 2) + 36 + 9 if s > 1 else 9
    beside = 6 * min(s - 1, 2) + 3  # rows of the first and the last node, and of Phi_A
    nonzeros = limbs * (own + 2 * beside * left) + left**2
    reach = None
    if sparse:
        nodes = _falling(6, 6 + left) * (s - 2) + _falling(6, 3 + left) if s > 1 else []
        reach = (nodes + _falling(3, left)) * limbs + _falling(left, 0)
    return null_space_work(limbs * (6 * s - 3), held, rows, nonzeros, count, reach)


def null_space_work(
    others: int, held: int, rows: int, nonzeros: int, count: int, reach: list[int] | None
) -> Work:
    """Return the work where `rows` hold `held` coordinates and no `others`; dense without `reach`.

    Q whole, of held x rows, by Householder's reflections; then N^T A N of two matrices.
    """
    left = held - rows
    dofs = others + left
    making = 4 * (held**2 * rows - held * rows**2) + 4 * rows**3 // 3
    if reach is not None:
        work = sparse_work(dofs, nonzeros, reach, count)
        return Work(dofs, nonzeros, work.bytes, work.flops + making)
    applying = 2 * (2 * (others + held) * held * left + 2 * held * left**2)
    return Work(dofs, nonzeros, 2 * 8 * dofs**2, dense(dofs, count) + making + applying)


def saddle_point(s: int, limbs: int = 3, count: int = 6, *, sparse: bool = False) -> Work:
    """Return the work of `Multipliers` by the saddle point: of a limb 6 (s + 1) and 8 rows."""
    size, rows = limbs * 6 * (s + 1) + 6, 8 * limbs
    nonzeros = limbs * (36 * (s + 1) + 72 * s + 2 * (3 + 2 * 3 + 3 + 3 * 3)) + 36
    reach = None
    if sparse:
        nodes = _falling(6, 6 + 5) * s + _falling(6, 5 + 3)
        reach = nodes * limbs + _falling(6, rows) + _falling(rows, 0)
    return saddle_point_work(size, rows, nonzeros, count, reach)


def saddle_point_work(
    size: int, rows: int, nonzeros: int, count: int, reach: list[int] | None
) -> Work:
    """Return the work of `size` coordinates and `rows`; dense without `reach`.

    Dense, the augmented matrix is eliminated (2 m^3 / 3) and solved for the N columns of M's factor
    (2 m^2 N), and one of N is made of both (2 N^3).
    """
    dofs = size + rows
    if reach is not None:
        return sparse_work(dofs, nonzeros, reach, count)
    flexibility = 2 * dofs**3 // 3 + 2 * dofs**2 * size + 2 * size**3
    standard = size**3 // 3 + 4 * size**3 // 3 + 3 * size**2 * count
    return Work(dofs, nonzeros, 8 * (dofs**2 + 2 * size**2), flexibility + standard)


def condensed(limbs: int = 3, count: int = 6) -> Work:
    """Return the work of `condensed_frequencies` a pose, whatever the number of elements.

    Two bending modes a limb are kept, m = 6 + 2 n coordinates: 9 m^3 for all their vectors (Golub
    and Van Loan, Section 8.3), and three corrections of `count` modes over 3 n directions.
    """
    m, directions = 6 + 2 * limbs, 3 * limbs
    corrections = 3 * count * directions * (4 * m + 2 * 12)
    return Work(m, 36 + 4 * limbs * 7, 8 * m**2, 9 * m**3 + corrections)


def _falling(size: int, beyond: int) -> list[int]:
    """Return entries below the pivots of `size` coordinates that reach `beyond` themselves."""
    return [size - 1 - j + beyond for j in range(size)]


def dense(N: int, count: int) -> int:
    """Return the operations of a dense solution of N coordinates."""
    return 11 * N**3 // 3 + 3 * N**2 * count


def sparse_work(dofs: int, nonzeros: int, reach: Iterable[int], count: int) -> Work:
    """Return the work of a sparse solution whose columns `reach` so many entries below pivots."""
    reach = list(reach)
    stored = sum(2 * c + 1 for c in reach)
    elimination = sum(2 * c * c + c for c in reach)
    block = count + 2
    step = 2 * stored * block + 2 * nonzeros * block
    basis = block * BLOCKS
    orthogonal = 4 * 2 * dofs * basis * block
    work = elimination + BLOCKS * (step + orthogonal)
    return Work(dofs, nonzeros, 12 * (2 * nonzeros + stored), work)
