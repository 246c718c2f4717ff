"""What is measured beside the rounds of all models: ratios to plain dense solutions, the frames of
another package, many poses on many cores, and whose seconds a simulator's are."""

import os
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import product
from pathlib import Path
from timeit import repeat, timeit
from typing import Any

import numpy as np
import scipy

from analytic import Continuum, InputError, Mechanism, Multipliers, Pose, Substructure
from analytic.chains import turning
from analytic.condensed import condensed_frequencies
from analytic.kernel import compiled
from analytic.kinematics import limbs_at
from analytic.model import Model
from analytic.rod_elements import element_matrices, properties
from analytic.substructure import platform_mass, rigid_arm
from analytic.theory import Theory
from harness.bench import label
from harness.case import Case
from harness.columns import laid_out
from harness.presets import PAPER_ELEMENTS
from harness.signatures import Array
from harness.studies.precision import COUNT
from harness.tables import Table
from harness.timing import SHIFT, Timed, poses_around
from harness.workers import Children, Failure
from reference_models import ModelError, UnavailableError, peers
from reference_models.peers import Peer
from reference_models.spent import PHASES, SIMULATOR

Call = Callable[..., Any]
CALLS = 4
"""Calls of one pose in a sample."""
SMALL = (1, 2, 3, 4, 8)
"""Elements up to which a hand-written dense assembly is a rival."""
CHAINS = {"s=1": 1, f"s={PAPER_ELEMENTS}": PAPER_ELEMENTS, "s=64": 64, "exact": None}
FRAMES = (PAPER_ELEMENTS, 8)
"""Elements of frames that other programs solve too."""
WARM = 100
MAP, MANY_CORES = 1e9, 64
"""Poses of a large map, and cores of a machine that it is for."""
LARGEST = 1000
"""Coordinates up to which a dense solution is timed."""


def quartiles(values: Array) -> Array:
    """Return the median, and the first and the third quartile."""
    return np.percentile(values, [50, 25, 75])


def dense_pair(case: Case) -> list[Array]:
    """Return K and M of the paper's number of elements at a case, dense."""
    pair = Substructure(PAPER_ELEMENTS).matrices(case.mechanism, case.pose)
    return [matrix.toarray() for matrix in pair]


def eigh_of(number: int) -> Call:
    """Return what solves `number` symmetric 6x6 matrices by `numpy.linalg.eigh`."""
    A = np.random.default_rng(0).standard_normal((number, 6, 6))
    return partial(np.linalg.eigh, A + A.swapaxes(1, 2))


@dataclass(frozen=True)
class Ratio:
    """What was timed, in times of what; `own` and `yard` seconds by round, a call or a pose."""

    what: str
    against: str
    own: Array
    yard: Array


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


def ratios(case: Case, rounds: int, poses: int) -> list[Ratio]:
    """Return our models in times of plain dense solutions of the same problem, call by call.

    In `rounds` rounds; `poses` a call of those that take many, 0: none. Each is timed between two
    runs of its yardstick, on one thread, by the processor's clock: what else the machine does falls
    on both alike.
    """
    mechanism, simple, s = case.mechanism, case.mechanism.simple, PAPER_ELEMENTS
    paper, floor = Substructure(s), f"eigh of the s={s} pair"
    condensed: Call = condensed_frequencies
    whole: Call = partial(scipy.linalg.eigh, *dense_pair(case))
    single: list[tuple[str, str, Call, Call]] = [
        (f"modes of s={s}", floor, paper.modes, whole),
        (f"frequencies of s={s}", floor, paper.frequencies, whole),
        *((f"modes of s={n}, assembly and all", "a plain dense assembly and eigh",
           Substructure(n).modes, partial(_plain, case, n)) for n in SMALL if simple),
    ]  # fmt: skip
    for solver, alone in (("null-space", _null_space), ("saddle-point", _saddle_point)):
        rival, against, yard = Multipliers(s, solver=solver), floor, whole
        if simple:
            against = "its own dense solution by numpy and eigh"
            parts = (A.toarray() for A in rival.matrices(mechanism, case.pose))
            yard = partial(alone, *parts)
        single.append((f"multipliers, {solver}, s={s}", against, rival.modes, yard))
    for name, size in CHAINS.items():
        one = partial(condensed, elements=size, fast=False)
        single.append((f"condensed, {name}, one pose", floor, one, whole))
    single.append(("exact modes, certified", floor, Continuum().modes, whole))
    every, small = poses_around(case, max(1, poses)), eigh_of(max(1, poses))
    loops = {"": False, ", compiled": True} if simple and compiled() else {"": False}
    batches: list[tuple[str, str, Call, Call]] = [
        (f"condensed{word}, {name}, {poses} poses", "6x6 eigh, batched, a pose",
         partial(condensed, elements=size, fast=fast), small)
        for word, fast in loops.items() if poses for name, size in CHAINS.items()
    ]  # fmt: skip
    at = [replace(case.pose, z=case.pose.z + SHIFT * k) for k in range(CALLS)]
    found = []
    for places, solutions, asked in ((at, CALLS, single), ([every], poses, batches)):
        for what, against, own, yard in asked:
            ratio = Ratio(what, against, np.empty(rounds), np.empty(rounds))
            ours = partial(_run, own, [(mechanism, place) for place in places])
            found.append((ratio, ours, partial(_run, yard, [()] * len(places)), solutions))
    for _, ours, plain, _ in found:
        for call in (ours, plain, ours):  # loads, compiles and tabulates
            call()
    for k in range(rounds):
        for ratio, ours, plain, solutions in found:
            # By the processor's clock, and without collecting what is left over.
            before, spent, after = (
                timeit(call, timer=time.thread_time, number=1) for call in (plain, ours, plain)
            )
            ratio.own[k], ratio.yard[k] = spent / solutions, (before + after) / 2 / solutions
    return [ratio for ratio, *_ in found]


def _run(call: Call, arguments: Sequence[tuple[Any, ...]]) -> None:
    for some in arguments:
        call(*some)


def _plain(case: Case, s: int) -> Any:
    return scipy.linalg.eigh(*plain_pair(case.mechanism, case.pose, s))


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
    rows = []
    for one in found:
        medians = 1e6 * np.median([one.own, one.yard], axis=1)
        rows.append((one.what, one.against, *quartiles(one.own / one.yard), *medians))
    columns = dict.fromkeys(("Ours", "in times of")) | dict.fromkeys(("median", "q1", "q3"), 2)
    columns |= {"ours [us]": 1, "yardstick [us]": 1}
    note = (
        "shapes included where it says modes; the processor's own time of one thread, each sample "
        "between two of its yardstick"
    )
    return laid_out("Our time in times of plain dense solutions", columns, rows, [note])


@dataclass(frozen=True)
class Peers:
    """What `found` others and ours took, one of `ours` a size; `reason` why others are missing."""

    found: list[Peer]
    ours: list[Peer]
    reason: str


def frames(case: Case, rounds: int) -> Peers:
    """Return what `FRAMES` take at a case, with `scipy.linalg.eigh` in every round."""
    found, ours, reason, (K, M) = list[Peer](), list[Peer](), "", dense_pair(case)
    for s in FRAMES:
        times = []
        for k in range(rounds + 1):
            pose = replace(case.pose, z=case.pose.z + SHIFT * k)
            modes = Substructure(s).modes(case.mechanism, pose, COUNT)
            spent = timeit(partial(scipy.linalg.eigh, K, M), number=1)
            times.append((modes.build_seconds, modes.solve_seconds, spent))
        ours.append(Peer("ours", s, modes.frequencies, *np.array(times[1:]).T))
        try:
            found += peers.timed(case.mechanism, case.pose, s, COUNT, rounds, (K, M))
        except (InputError, UnavailableError, ModelError) as error:
            reason = str(error)
    return Peers(found, ours, reason)


def peers_table(result: Peers) -> Table:
    """Return seconds and frequencies of all, those of ours beside."""
    rows = list[Any]()
    for own in result.ours:
        for one in (own, *(p for p in result.found if p.elements == own.elements)):
            whole = one.build + one.solve
            apart = np.abs(one.frequencies / own.frequencies - 1).max()
            ms = 1e3 * np.median([one.build, one.solve, whole], axis=1)
            rows.append((one.name, one.elements, *ms, np.median(whole / one.eigh), f"{apart:.0e}"))
        floor = 1e3 * np.median(own.eigh)
        rows.append(("the floor: scipy.linalg.eigh", PAPER_ELEMENTS, None, floor, floor, 1.0, "-"))
    columns = dict.fromkeys(("Frame", "s"))
    columns |= dict.fromkeys(("build [ms]", "solve [ms]", "both [ms]"), 3)
    columns |= {"eigh = 1": 2, "apart": None}
    notes = [
        f"eigh: of the s = {PAPER_ELEMENTS} pair, in the same process and round; shapes are not "
        "read; apart: largest relative difference of f1-f6 from ours",
        *([f"not measured: {result.reason}"] if result.reason else []),
    ]
    return laid_out("The same frames by other programs", columns, rows, notes)


@dataclass(frozen=True)
class Share:
    """A share of the poses, as a process solves it: seconds, and its largest memory [MB]."""

    model: Model
    mechanism: Mechanism
    poses: Pose

    def solve(self) -> tuple[float, float]:
        """Return seconds and memory; the first poses are solved twice, to load what is needed."""
        self.model.frequencies(self.mechanism, self.poses[:WARM], COUNT)
        began = time.perf_counter()
        self.model.frequencies(self.mechanism, self.poses, COUNT)
        return time.perf_counter() - began, _megabytes()


def _megabytes() -> float:
    """Return the most memory that this process had [MB]; NaN where the system does not say.

    Not `ru_maxrss`: a new program inherits that of the process that started it.
    """
    try:
        status = Path("/proc/self/status").read_text()
    except OSError:
        return float("nan")
    return 1024 * int(status.split("VmHWM:")[1].split()[0]) / 1e6


@dataclass(frozen=True)
class Throughput:
    """What so many `cores` made of `poses` by a `model`.

    Attributes: `seconds`, the longest that a process took; `megabytes`, the largest of one; `load`,
    processes that wanted a core at the time, those of others included.
    """

    model: Model
    cores: int
    poses: int
    seconds: float
    megabytes: float
    load: float

    @property
    def rate(self) -> float:
        """Frequencies a second."""
        return COUNT * self.poses / self.seconds


def throughput(
    case: Case, models: Sequence[Model], poses: int, limit: float
) -> tuple[list[Throughput], dict[str, str]]:
    """Return what 1, 2, 4 ... and all cores make of as many `poses` a core, and what failed."""
    here = os.cpu_count() or 1
    steps = sorted({*(2**k for k in range(here.bit_length())), here})
    found, failures = list[Throughput](), dict[str, str]()
    with closing(Children()) as children:
        children.start(here)
        for model, cores in product(models, steps):
            every = poses_around(case, poses * cores)
            shares = [
                Share(model, case.mechanism, every[poses * k : poses * (k + 1)])
                for k in range(cores)
            ]
            with ThreadPoolExecutor(cores) as threads:
                answers = list(threads.map(lambda share: children.attempt(share, limit), shares))
            bad = next((a for a in answers if isinstance(a, Failure)), None)
            if bad is not None:
                failures[f"{label(model)} on {cores} cores"] = bad.reason
                continue
            seconds, memory = np.max(np.array(answers), axis=0).tolist()
            load = os.getloadavg()[0] if hasattr(os, "getloadavg") else float("nan")
            found.append(Throughput(model, cores, poses * cores, seconds, memory, load))
    return found, failures


def cores_table(found: Sequence[Throughput]) -> Table:
    """Return frequencies a second against the count of cores, and what a large map would take."""
    single = {one.model: one.rate for one in reversed(found)}  # the first of each: one core
    rows = []
    for one in found:
        hours = MAP / (one.poses / one.seconds) / 3600
        rows.append((
            label(one.model), one.cores, one.load, one.poses, one.seconds, round(one.rate),
            one.rate / single[one.model], one.megabytes, hours, hours * one.cores / MANY_CORES,
        ))  # fmt: skip
    columns = {
        "Model": None, "cores": None, "load": 1, "poses": None, "seconds": 2,
        "frequencies a second": None, "one core = 1": 2, "MB a process": 0, "1e9 poses here [h]": 2,
        f"on {MANY_CORES} such cores [h]": 2,
    }  # fmt: skip
    size = f"8 bytes a frequency are {8 * COUNT * MAP / 1e9:.0f} GB, written by parts in a sweep"
    notes = (
        "a process a core, one BLAS thread each; no process keeps more than its own frequencies",
        "load: processes that wanted a core, those of others included",
        f"1e9 poses: {size}" if found else "not measured",
    )
    return laid_out("Many poses on many cores", columns, rows, notes)


@cache
def dense_seconds(dofs: int) -> float:
    """Return the shortest of five times of `scipy.linalg.eigh` of a pair of this size [s]."""
    random = np.random.default_rng(0).standard_normal((dofs, dofs))
    M = random @ random.T / dofs + np.eye(dofs)
    K = (random + random.T) / 2 + 2 * dofs * np.eye(dofs)
    return min(repeat(partial(scipy.linalg.eigh, K, M), number=1, repeat=5))


def simulators_table(timed: Sequence[Timed]) -> Table:
    """Return where the seconds of every simulator's answer go."""
    rows = []
    for t in timed:
        phases, whole = t.phases, t.median()
        own, *ours = (phases[name] for name in PHASES)
        if not own + sum(ours):
            continue
        projection, ratio = phases["projection"], None
        if t.dofs and t.dofs <= LARGEST and projection:
            ratio = projection / dense_seconds(t.dofs)
        milliseconds = (1e3 * x for x in (whole, own, *ours, phases[""]))
        rows.append((
            label(t.way.model), t.way.model.info().program, t.dofs, *milliseconds,
            100 * (1 - own / whole), ratio, 1e3 * t.first.phases[SIMULATOR],
        ))  # fmt: skip
    parts = ("whole", *PHASES, "rest")
    columns = dict.fromkeys(("Model", "Simulator", "dofs"))
    columns |= {f"{name} [ms]": 2 for name in parts}
    columns |= {"ours [%]": 1, "projection / eigh": 2, "first call [ms]": 1}
    notes = (
        "simulator: seconds in its own code, of every call and of the first, whose meshes and "
        "reductions may be kept; all else is ours, and rest what no column is named for; medians",
        "projection / eigh: to one scipy.linalg.eigh of a pair of as many coordinates",
    )
    return laid_out("The simulators' own time, and ours", columns, rows, notes)
