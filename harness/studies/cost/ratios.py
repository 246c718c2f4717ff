"""Our models in times of plain dense solutions of the same problem, call by call.

Each is timed between two runs of its yardstick, on one thread, by the processor's clock: what else
the machine does falls on both alike.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from timeit import timeit
from typing import Any

import numpy as np
import scipy

from analytic import Continuum, Mechanism, Multipliers, Pose, Substructure, limbs_at
from analytic.chains import turning
from analytic.condensed import condensed_frequencies
from analytic.kernel import compiled
from analytic.rod_elements import element_matrices, properties
from analytic.substructure import platform_mass, rigid_arm
from analytic.theory import Theory
from harness.case import Case
from harness.compare import cells
from harness.presets import PAPER_ELEMENTS
from harness.signatures import Array
from harness.tables import Table
from harness.timing import SHIFT, poses_around

Call = Callable[[], Any]
CALLS = 4
"""Calls of one pose in a sample."""
SMALL = (1, 2, 3, 4, 8)
"""Elements up to which a hand-written dense assembly is a rival."""
LONG_CHAIN = 64


@dataclass(frozen=True)
class Ratio:
    """What was timed, in times of what; `own` and `yard` seconds by round, a call or a pose."""

    what: str
    against: str
    own: Array
    yard: Array

    @property
    def quartiles(self) -> Array:
        """Median, first and third quartile of the ratio over rounds."""
        return np.percentile(self.own / self.yard, [50, 25, 75])

    @property
    def medians(self) -> Array:
        """Medians of both [us]."""
        return 1e6 * np.median([self.own, self.yard], axis=1)


def plain_pair(mechanism: Mechanism, pose: Pose, s: int) -> tuple[Array, Array]:
    """Return K and M of Eq. (22) as one would write them: limb by limb, B^T K B with B = T H Q."""
    theory, limbs, n = Theory("euler-bernoulli", "cowper"), limbs_at(mechanism, pose), 6 * (s + 1)
    rods = properties([limb.rod for limb in mechanism.limbs], theory)
    turns = turning(mechanism.axes)
    kept, size = 6 * s - 2, len(limbs.lengths) * (6 * s - 2) + 6
    K, M = np.zeros((size, size)), np.zeros((size, size))
    elements = element_matrices(rods, limbs.lengths / s)
    for i, (frame, arm) in enumerate(zip(limbs.frames, limbs.arms, strict=True)):
        chain, B, R = np.zeros((2, n, n)), np.zeros((n, size)), frame.T
        for e in range(s):
            chain[:, 6 * e : 6 * e + 12, 6 * e : 6 * e + 12] += elements[:, i]
        B[3:6, i * kept] = R @ turns[i]
        for k in range(2, 2 * s):
            column = i * kept + 1 + 3 * (k - 2)
            B[3 * k : 3 * k + 3, column : column + 3] = R
        B[n - 6 : n - 3, -6:] = R @ rigid_arm(arm)
        B[n - 3 :, (i + 1) * kept - 3 : (i + 1) * kept] = R
        K += B.T @ chain[0] @ B
        M += B.T @ chain[1] @ B
    M[-6:, -6:] += platform_mass(mechanism, pose)
    return K, M


def ratios(case: Case, rounds: int, poses: int) -> tuple[Ratio, ...]:
    """Return every ratio, in `rounds` rounds; `poses` a call of those that take many, 0: none."""
    mechanism, pose = case.mechanism, case.pose
    at = [replace(pose, z=pose.z + SHIFT * k) for k in range(CALLS)]
    asked: list[tuple[str, str, Call, Call, int]] = []

    def one(what: str, against: str, own: Callable[[Pose], Any], yard: Call) -> None:
        asked.append((what, against, lambda: [own(p) for p in at], lambda: [yard() for _ in at],
                      CALLS))  # fmt: skip

    paper, simple = Substructure(PAPER_ELEMENTS), mechanism.simple
    pair = (A.toarray() for A in paper.matrices(mechanism, pose))
    whole = partial(scipy.linalg.eigh, *pair)
    floor = f"eigh of the s={PAPER_ELEMENTS} pair"
    one(f"modes of s={PAPER_ELEMENTS}", floor, partial(paper.modes, mechanism), whole)
    one(f"frequencies of s={PAPER_ELEMENTS}", floor, partial(paper.frequencies, mechanism), whole)
    for s in SMALL if simple else ():
        plain = partial(_plain, mechanism, pose, s)
        what, against = f"modes of s={s}, assembly and all", "a plain dense assembly and eigh"
        one(what, against, partial(Substructure(s).modes, mechanism), plain)
    for solver, alone in (("null-space", _null_space), ("saddle-point", _saddle_point)):
        rival, against, yard = Multipliers(PAPER_ELEMENTS, solver=solver), floor, whole
        if simple:
            against = "its own dense solution by numpy and eigh"
            yard = partial(alone, *(A.toarray() for A in rival.matrices(mechanism, pose)))
        what = f"multipliers, {solver}, s={PAPER_ELEMENTS}"
        one(what, against, partial(rival.modes, mechanism), yard)
    chains: list[tuple[str, int | None]] = [
        *((f"s={s}", s) for s in (1, PAPER_ELEMENTS, LONG_CHAIN)), ("exact", None),
    ]  # fmt: skip
    for name, size in chains:
        single = partial(_condensed, mechanism, size, fast=False)
        one(f"condensed, {name}, one pose", floor, single, whole)
    one("exact modes, certified", floor, partial(Continuum().modes, mechanism), whole)
    many = poses_around(case, max(1, poses))
    A = np.random.default_rng(0).standard_normal((len(many), 6, 6))
    small = partial(np.linalg.eigh, A + A.swapaxes(1, 2))
    loops = (False, True) if simple and compiled() else (False,)
    for fast in loops if poses else ():
        for name, size in chains:
            what = f"condensed{', compiled' if fast else ''}, {name}, {poses} poses"
            batch = partial(_condensed, mechanism, size, many, fast=fast)
            asked.append((what, "6x6 eigh, batched, a pose", batch, small, poses))
    return _timed(asked, rounds)


def _timed(asked: Sequence[tuple[str, str, Call, Call, int]], rounds: int) -> tuple[Ratio, ...]:
    empty = partial(np.empty, rounds)
    found = [Ratio(what, against, empty(), empty()) for what, against, *_ in asked]
    for _, _, own, yard, _ in asked:
        for call in (own, yard, own):  # loads, compiles and tabulates
            call()
    for k in range(rounds):
        for ratio, (_, _, own, yard, number) in zip(found, asked, strict=True):
            # By the processor's clock, and without collecting what is left over.
            before, spent, after = (
                timeit(call, timer=time.thread_time, number=1) for call in (yard, own, yard)
            )
            ratio.own[k], ratio.yard[k] = spent / number, (before + after) / 2 / number
    return tuple(found)


def _condensed(mechanism: Mechanism, s: int | None, poses: Pose, *, fast: bool) -> Any:
    return condensed_frequencies(mechanism, poses, s, fast=fast)


def _plain(mechanism: Mechanism, pose: Pose, s: int) -> Any:
    return scipy.linalg.eigh(*plain_pair(mechanism, pose, s))


def _null_space(K: Array, M: Array, C: Array) -> Any:
    N = scipy.linalg.qr(C.T)[0][:, len(C) :]
    return scipy.linalg.eigh(N.T @ K @ N, N.T @ M @ N)


def _saddle_point(K: Array, M: Array, C: Array) -> Any:
    size, held = len(K), len(C)
    whole = np.block([[K, C.T], [C, np.zeros((held, held))]])
    L = np.linalg.cholesky(M)
    return scipy.linalg.eigh(L.T @ np.linalg.inv(whole)[:size, :size] @ L)


def ratios_table(found: Sequence[Ratio]) -> Table:
    """Return every ratio with its quartiles."""
    rows = tuple(
        (one.what, one.against, *cells(one.quartiles), *cells(one.medians, 1)) for one in found
    )
    columns = ("Ours", "in times of", "median", "q1", "q3", "ours [us]", "yardstick [us]")
    notes = (
        "shapes included where it says modes; the processor's own time of one thread, each sample "
        "between two of its yardstick",
    )
    return Table("Our time in times of plain dense solutions", columns, rows, notes)
