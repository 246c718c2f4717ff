"""What a frequency costs: every model timed in one run, as ratios to yardsticks of that run."""

import gc
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import NDArray
from scipy.stats import linregress
from threadpoolctl import threadpool_limits

from analytic import (
    Continuum,
    InputError,
    Modes,
    Multipliers,
    Pose,
    Substructure,
    condensed_frequencies,
)
from analytic.kernel import compiled
from harness.cases import PRESETS, Case
from harness.models import PAPER_ELEMENTS, Spec, parse
from harness.precision.solved import Solved
from reference_models import ModelError, UnavailableError, reference

THEORY = "euler-bernoulli"
CASE = "case2"
COUNT = 6
LONG = 0.5
"""A model is not run with more elements once a run took longer than this [s]."""
SLOW, FEW = 1.0, 3
"""A run longer than SLOW [s] is timed FEW times at most."""
ENDLESS = 2.0
"""A run longer than this [s] is timed once, as it warms up."""
SAMPLE = 0.01
"""Shorter runs are repeated within one measurement until they fill this time [s]."""

TIMED = "cost"
"""What the history calls this way of timing."""
YARDSTICK = "scipy.linalg.eigh of the assembled s=3 pair"
FLOOR = "numpy.linalg.eigh of 10,000 6x6 matrices, per matrix"


@dataclass(frozen=True)
class Job:
    """One thing to time: `model` at `size` (elements a limb, or poses a call), by `run`.

    `poses` that one run answers for; `growing`: whether larger sizes may be left out; `solved`:
    what it is in the history, or None.
    """

    model: str
    size: int | None
    run: Callable[[], Any]
    poses: int = 1
    growing: bool = False
    solved: Solved | None = None


@dataclass(frozen=True)
class Timing:
    """Seconds a pose and their ratio to the yardstick of the same round, both (repeats,).

    `dofs` solved for, and `solving`: the seconds of a run that its eigen-solution took, if known;
    `rows` of what it answered, for the history.
    """

    model: str
    size: int | None
    dofs: int | None
    solving: float | None
    seconds: NDArray[np.float64]
    ratios: NDArray[np.float64]
    rows: Sequence[dict[str, Any]] = ()


@dataclass(frozen=True)
class Growth:
    """t ~ size^exponent by least squares on logarithms, with the exponent's standard error."""

    model: str
    sizes: tuple[int, ...]
    exponent: float
    error: float


@dataclass(frozen=True)
class Cost:
    """A whole run: timings against elements and against batch size, and what was left out.

    `stand_in`: what stands for the paper's finite-element model, or None. `left_out`: model to
    the reason it was not run at some sizes. `failures`: (case, label) to the simulator's sentence.
    """

    yardstick: Timing
    floor: Timing
    elements: tuple[Timing, ...]
    batches: tuple[Timing, ...]
    stand_in: Timing | None
    repeats: int
    left_out: dict[str, str]
    failures: dict[tuple[str, str], str]

    @property
    def rows(self) -> list[dict[str, Any]]:
        """All that was solved, for the history: a row a model, way and mode."""
        stand_in = [] if self.stand_in is None else [self.stand_in]
        timings = [self.yardstick, *self.elements, *stand_in, *self.batches]
        return [row for timing in timings for row in timing.rows]


def measure(
    elements: Sequence[int],
    references: Sequence[str],
    batches: Sequence[int],
    repeats: int,
    done: Callable[[str], None] = lambda _: None,
) -> Cost:
    """Time all models in `repeats` rounds; `done` is called after the warm-up and each round.

    Every round times everything once, yardsticks first, so that whatever else the machine does
    falls on all models alike. The paper's s = 3 is always among `elements`.
    """
    case = PRESETS[CASE]
    left_out: dict[str, str] = {}
    failures: dict[tuple[str, str], str] = {}
    steps = sorted({*elements, PAPER_ELEMENTS})
    groups = {
        "yardstick": [_yardstick(case)],
        "floor": [_floor()],
        "elements": _element_jobs(case, steps, references, left_out),
        "stand-in": _stand_in_jobs(case, references),
        "batches": _batch_jobs(case, elements, batches),
    }
    # Programs loaded by the warm-up bring threads of their own: limit them again after it.
    with threadpool_limits(1):
        warm = {name: warm_up(jobs, left_out, failures) for name, jobs in groups.items()}
    done("warm-up")
    sample([job for jobs in warm.values() for job in jobs], repeats, done)
    (yard,), (floor,) = warm["yardstick"], warm["floor"]
    timed = {
        name: tuple(job.timing(floor if name == "batches" else yard) for job in jobs)
        for name, jobs in warm.items()
    }
    return Cost(
        yardstick=timed["yardstick"][0],
        floor=timed["floor"][0],
        elements=timed["elements"],
        batches=timed["batches"],
        stand_in=next(iter(timed["stand-in"]), None),
        repeats=repeats,
        left_out=left_out,
        failures=failures,
    )


def sample(jobs: Sequence["Warm"], repeats: int, done: Callable[[str], None]) -> None:
    """Time every job once a round, one after the other, on one thread."""
    with threadpool_limits(1):
        for k in range(repeats):
            gc.collect()
            for job in jobs:
                job.sample(k)
            done(f"round {k + 1}")


def growth(timings: Sequence[Timing], least: int = 1) -> list[Growth]:
    """Return the growth of every model with three or more sizes of at least `least`."""
    result = []
    for model in dict.fromkeys(timing.model for timing in timings):
        points = [
            (timing.size, float(np.median(timing.seconds)))
            for timing in timings
            if timing.model == model and timing.size is not None and timing.size >= least
        ]
        if len(points) >= 3:
            sizes, seconds = zip(*points, strict=True)
            fit = linregress(np.log(sizes), np.log(seconds))
            result.append(Growth(model, sizes, float(fit.slope), float(fit.stderr)))
    return result


def _yardstick(case: Case) -> Job:
    pair = Substructure(PAPER_ELEMENTS).matrices(case.mechanism, case.pose)
    K, M = (matrix.toarray() for matrix in pair)
    spec, version = Spec(THEORY, PAPER_ELEMENTS), f"scipy {scipy.__version__}"
    solved = Solved(spec, case, YARDSTICK, TIMED, read=_hertz, version=version)
    return Job(YARDSTICK, None, partial(scipy.linalg.eigh, K, M), solved=solved)


def _hertz(pair: tuple[NDArray[np.float64], NDArray[np.float64]]) -> NDArray[np.float64]:
    """Return the lowest frequencies [Hz] of squares [rad^2/s^2] and vectors."""
    return np.asarray(np.sqrt(pair[0][:COUNT]) / (2 * np.pi))


def _floor() -> Job:
    A = np.random.default_rng(0).standard_normal((10_000, 6, 6))
    return Job(FLOOR, None, partial(np.linalg.eigh, A + A.swapaxes(1, 2)), poses=len(A))


def _element_jobs(
    case: Case, steps: Sequence[int], references: Sequence[str], left_out: dict[str, str]
) -> list[Job]:
    robot, pose = case.mechanism, case.pose
    kinds: dict[str, Callable[[int], Callable[[], Any]]] = {
        "substructure, dense": lambda s: partial(Substructure(s).modes, robot, pose, COUNT),
        "substructure, sparse": lambda s: partial(
            Substructure(s, solver="sparse").modes, robot, pose, COUNT
        ),
        "multipliers, null-space": lambda s: partial(Multipliers(s).modes, robot, pose, COUNT),
        "multipliers, saddle-point": lambda s: partial(
            Multipliers(s, solver="saddle-point").modes, robot, pose, COUNT
        ),
    }
    for label, fast in _loops():
        kinds[label] = lambda s, fast=fast: partial(  # type: ignore[misc]
            condensed_frequencies, robot, pose, s, count=COUNT, fast=fast
        )
    for name in references:
        kinds[name] = lambda s, name=name: partial(reference(name, s).modes, robot, pose, COUNT)  # type: ignore[misc]
    jobs = []
    for model, build in kinds.items():
        for s in steps:
            solved = Solved(Spec(model if model in references else THEORY, s), case, model, TIMED)
            try:
                jobs.append(Job(model, s, build(s), growing=True, solved=solved))
            except InputError as error:
                left_out[model] = f"not at s={s} ({error}); "
    exact: dict[str, Callable[[], Any]] = {
        label: partial(condensed_frequencies, robot, pose, count=COUNT, fast=fast)
        for label, fast in _loops()
    }
    exact["continuum"] = partial(Continuum().modes, robot, pose, COUNT)
    for label, run in exact.items():
        jobs.append(Job(label, None, run, solved=Solved(Spec(THEORY, None), case, label, TIMED)))
    return jobs


def _stand_in_jobs(case: Case, references: Sequence[str]) -> list[Job]:
    """Return sheared beams, extrapolated: what this bench has for the paper's ANSYS."""
    name = "exudyn-beam"
    if name not in references:
        return []
    spec = parse(name, "reference")
    run = partial(spec.build().modes, case.mechanism, case.pose, COUNT)
    return [Job(spec.label, None, run, solved=Solved(spec, case, name, TIMED))]


def _batch_jobs(case: Case, elements: Sequence[int], batches: Sequence[int]) -> list[Job]:
    """Return `condensed_frequencies` at random poses: fewest and most elements, and none."""
    jobs = []
    for name, fast in _loops():
        for s in dict.fromkeys((elements[0], elements[-1], None)):
            label = f"{name}, exact" if s is None else f"{name}, s={s}"
            for size in batches:
                poses = random_poses(size)
                run = partial(
                    condensed_frequencies, case.mechanism, poses, s, count=COUNT, fast=fast
                )
                first = Pose(*(float(getattr(poses, x)[0]) for x in Pose.__match_args__))
                one = Case("random", case.mechanism, first, "the first of many")
                solved = Solved(Spec(THEORY, s), one, name, TIMED, poses=size)
                jobs.append(Job(label, size, run, poses=size, solved=solved))
    return jobs


def _loops() -> list[tuple[str, bool]]:
    """Return the names of the condensed model's loops that can run here, and how to ask."""
    return [("condensed", False)] + ([("condensed, compiled", True)] if compiled() else [])


def random_poses(count: int) -> Pose:
    """Return the same `count` poses every time: z 0.35-0.7 m, any azimuth, tilt to 20 degrees."""
    random = np.random.default_rng(0)
    return Pose(
        z=random.uniform(0.35, 0.7, count),
        azimuth=random.uniform(-np.pi, np.pi, count),
        tilt=random.uniform(-np.radians(20), np.radians(20), count),
    )


@dataclass(frozen=True)
class Warm:
    """A job that has run once: its `answer`, and its samples so far, round to seconds a pose.

    `solving`: seconds of each run that went into its eigen-solution, where it says so.
    """

    job: Job
    seconds: float
    answer: Any
    samples: dict[int, float]
    solving: list[float]

    def sample(self, k: int) -> None:
        """Time the job in round `k`, unless it has been timed often enough."""
        if self.seconds > ENDLESS or (self.seconds > SLOW and k >= FEW):
            return
        if self.seconds <= LONG:
            self.job.run()  # what other models have displaced from caches is not this one's cost
        number = max(1, int(SAMPLE / self.seconds))
        gc.disable()
        begin = time.perf_counter()
        for _ in range(number):
            answer = self.job.run()
        self.samples[k] = (time.perf_counter() - begin) / number / self.job.poses
        gc.enable()
        if isinstance(answer, Modes):
            self.solving.append(answer.solve_seconds)

    def timing(self, yardstick: "Warm") -> Timing:
        """Return the samples, and their ratios to those of `yardstick`."""
        seconds = np.array(list(self.samples.values()))
        solved = self.job.solved
        return Timing(
            self.job.model,
            self.job.size,
            self.answer.dofs if isinstance(self.answer, Modes) else None,
            float(np.median(self.solving)) if self.solving else None,
            seconds,
            np.array([t / yardstick.samples[k] for k, t in self.samples.items()]),
            () if solved is None else solved.rows(self.answer, float(np.median(seconds))),
        )


def warm_up(
    jobs: Sequence[Job], left_out: dict[str, str], failures: dict[tuple[str, str], str]
) -> list[Warm]:
    """Run every job once, the first of each model twice; drop what fails or takes too long."""
    warm: list[Warm] = []
    started: set[str] = set()
    stopped: set[str] = set()
    for job in jobs:
        if job.growing and job.model in stopped:
            continue
        try:
            # What the first call of a model loads or compiles is not its cost, nor what another
            # size is the first to need: a long run must be long twice.
            if job.model not in started:
                job.run()
            seconds, answer = _timed(job)
            if job.growing and seconds > LONG:
                seconds = min(seconds, _timed(job)[0])
        except (ModelError, UnavailableError) as error:
            label = job.model if job.size is None else f"{job.model}@{job.size}"
            failures[CASE, label] = str(error)
            continue
        started.add(job.model)
        samples = {0: seconds / job.poses} if seconds > ENDLESS else {}
        solving = [answer.solve_seconds] if samples and isinstance(answer, Modes) else []
        warm.append(Warm(job, seconds, answer, samples, solving))
        if job.growing and seconds > LONG:
            stopped.add(job.model)
            why = f"not beyond s={job.size}, which took {seconds:.1f} s"
            left_out[job.model] = left_out.get(job.model, "") + why
    return warm


def _timed(job: Job) -> tuple[float, Any]:
    begin = time.perf_counter()
    answer = job.run()
    return time.perf_counter() - begin, answer
