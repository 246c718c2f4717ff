"""Models timed against each other: in rounds, on one thread, each where it runs anyway.

Every round times every way once, so that whatever else the machine does falls on all alike. A model
that may crash is timed inside its own process: handing the answer over is no cost of it.
"""

import gc
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from timeit import timeit
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analytic import InputError, Mechanism, Modes, Pose
from analytic.model import Model
from analytic.pose import closes
from harness.bench import Bench, label
from harness.case import Case
from harness.workers import Failure
from reference_models import UnavailableError
from reference_models.spent import recorded

Array = NDArray[np.float64]
Places = tuple[tuple[Mechanism, Pose], ...]

LONG = 0.5
"""A model is not run with more elements once a call took longer than this [s]."""
LONG_BATCH = 5.0
"""No more poses a call are asked of a model once a call took longer than this [s]."""
SLOW, FEW = 1.0, 3
"""A call longer than SLOW [s] is timed FEW times at most."""
ENDLESS = 2.0
"""A call longer than this [s] is timed once, as it warms up."""
SAMPLE = 0.01
"""Shorter calls are repeated within one measurement until they fill this time [s]."""
SHIFT = 1e-12
"""How far apart [m] the heights of two calls are: nothing kept from one serves the next."""


@dataclass(frozen=True)
class Way:
    """One way to solve poses: the modes of one pose a call, or the frequencies of many.

    Attributes: `model`; `poses` a call whose frequencies are asked for, 0 where modes are.
    """

    model: Model
    poses: int = 0

    @property
    def method(self) -> str:
        """What is the same for every number of elements, in words."""
        name = getattr(self.model, "name", type(self.model).__name__)
        own = ",".join(f"{k}={v}" for k, v in getattr(self.model, "settings", ()))
        many = f", {self.poses} poses a call" if self.poses > 1 else ""
        alone = ", frequencies" if self.poses == 1 else ""
        return f"{name}[{own}]{alone}{many}" if own else f"{name}{alone}{many}"

    @property
    def size(self) -> str:
        """The elements in words: "3", "8+16" or "exact"."""
        elements = self.model.elements
        if isinstance(elements, tuple):
            return "+".join(map(str, elements))
        return "exact" if elements is None else str(elements)


@dataclass(frozen=True)
class Call:
    """What is timed: `number` calls of a way at every place, as a worker makes them."""

    way: Way
    places: Places
    count: int
    number: int
    first: int

    @property
    def model(self) -> Model:
        """Whose code runs."""
        return self.way.model

    def solve(self) -> "Spent":
        """Return the seconds of a call and the answers of the last."""
        model, poses = self.way.model, self.way.poses
        shifted = [
            [replace(pose, z=pose.z + SHIFT * (self.first + k)) for _, pose in self.places]
            for k in range(self.number)
        ]
        ask, said = model.frequencies if poses else model.modes, 0.0
        gc.collect()
        gc.disable()
        try:
            with recorded() as record:
                began = time.perf_counter()
                for at in shifted:
                    answers = [
                        ask(mechanism, pose, self.count)
                        for (mechanism, _), pose in zip(self.places, at, strict=True)
                    ]
                    for one in answers:
                        if isinstance(one, Modes):
                            said += one.build_seconds + one.solve_seconds
                seconds = time.perf_counter() - began
        finally:
            gc.enable()
        each = self.number * len(self.places)
        phases = {name: spent / each for name, spent in record.seconds.items()}
        return Spent(seconds / each, tuple(answers), phases, (seconds - said) / each)


@dataclass(frozen=True)
class Spent:
    """What a call took at a place [s] and answered, and seconds by `reference_models.spent`.

    `rest`: what of the seconds its answers do not say of their matrices and eigen-solutions.
    """

    seconds: float
    answers: tuple[Any, ...]
    phases: Mapping[str, float]
    rest: float


@dataclass(frozen=True)
class Timed:
    """One way, timed.

    Attributes: `seconds` a pose, by round; `builds`, `solves`: what its answers say of their
    matrices and eigen-solutions, by call, empty for frequencies alone; `answers`, one a place:
    modes, or frequencies of the first pose of a call; `phases`: a simulator's seconds by phase,
    medians of all calls; `once`: those of its first call; `rests`, by round: seconds less what the
    same calls' answers say.
    """

    way: Way
    seconds: Array
    builds: Array
    solves: Array
    answers: tuple[Modes | Array, ...]
    phases: Mapping[str, float] = field(default_factory=dict)
    once: Mapping[str, float] = field(default_factory=dict)
    rests: Array = field(default_factory=lambda: np.empty(0))

    @property
    def rest(self) -> float | None:
        """The median time beside matrices and eigen-solution [s]; None for frequencies alone."""
        return float(np.median(self.rests)) if self.builds.size else None

    @property
    def build(self) -> float | None:
        """The median time of the matrices [s]; None for frequencies alone."""
        return float(np.median(self.builds)) if self.builds.size else None

    @property
    def solve(self) -> float | None:
        """The median time of the eigen-solution [s]; None for frequencies alone."""
        return float(np.median(self.solves)) if self.solves.size else None

    @property
    def median(self) -> float:
        """The median time of a pose [s]."""
        return float(np.median(self.seconds))

    @property
    def dofs(self) -> int | None:
        """The coordinates solved for, where the answer says so."""
        first = self.answers[0]
        return first.dofs if isinstance(first, Modes) else None

    def frequencies(self, place: int) -> Array:
        """Return the frequencies at a place [Hz]."""
        found = self.answers[place]
        return found.frequencies if isinstance(found, Modes) else found


@dataclass(frozen=True)
class Timings:
    """All that was timed in one run.

    Attributes: `timed`, in the order asked; `yardsticks`: seconds of each, by round; `left_out`:
    why a method was not run at some sizes; `failures` by "MODEL at CASE".
    """

    timed: tuple[Timed, ...]
    yardsticks: dict[str, Array]
    left_out: dict[str, str]
    failures: dict[str, str]
    rounds: int


@dataclass
class _Running:
    """A way under way: the seconds a call takes, its samples, and its last answers."""

    way: Way
    places: Places
    seconds: float = 0.0
    samples: dict[int, float] = field(default_factory=dict)
    builds: list[float] = field(default_factory=list)
    solves: list[float] = field(default_factory=list)
    answers: tuple[Any, ...] = ()
    phases: list[Mapping[str, float]] = field(default_factory=list)
    rest: float = 0.0
    rests: dict[int, float] = field(default_factory=dict)
    calls: int = 0

    def call(self, bench: Bench, count: int, number: int = 1) -> Failure | None:
        """Make `number` calls; return why there is no answer, None if there is one."""
        task = Call(self.way, self.places, count, number, self.calls)
        self.calls += number
        found = bench.call(task, self.way.model.info().isolated)
        if isinstance(found, Failure):
            return found
        assert isinstance(found, Spent)
        self.seconds, self.rest, self.answers = found.seconds, found.rest, found.answers
        self.phases.append(found.phases)
        for answer in found.answers:
            if isinstance(answer, Modes):
                self.builds.append(answer.build_seconds)
                self.solves.append(answer.solve_seconds)
        return None

    def sample(self, bench: Bench, count: int, k: int) -> None:
        """Time the way in round `k`, unless it has been timed often enough."""
        one = self.seconds * len(self.places)
        if one > ENDLESS or (one > SLOW and k >= FEW):
            k = min(self.samples, default=k)
            self.samples.setdefault(k, self.seconds)
            self.rests.setdefault(k, self.rest)
            return
        if not self.call(bench, count, max(1, int(SAMPLE / max(one, 1e-9)))):
            self.samples[k], self.rests[k] = self.seconds, self.rest

    def timed(self) -> Timed:
        many = max(1, self.way.poses)
        answers = tuple(
            a if isinstance(a, Modes) else np.atleast_2d(np.asarray(a))[0] for a in self.answers
        )
        return Timed(
            self.way,
            np.array(list(self.samples.values())) / many,
            np.array(self.builds),
            np.array(self.solves),
            answers,
            {k: float(np.median([p[k] for p in self.phases[1:]])) for k in self.phases[0]},
            self.phases[0],
            np.array(list(self.rests.values())),
        )


def time_ways(
    bench: Bench,
    ways: Sequence[Way],
    cases: Sequence[Case],
    rounds: int,
    count: int,
    yardsticks: dict[str, Any] | None = None,
) -> Timings:
    """Time every way at every case in `rounds` rounds; `yardsticks` are calls without arguments.

    A way of many poses a call takes the case's own pose first and others after it. Larger
    sizes of a method are left out once a call takes longer than `LONG`, more poses a call once one
    takes longer than `LONG_BATCH`.
    """
    left_out: dict[str, str] = {}
    failures: dict[str, str] = {}
    known = yardsticks or {}
    bench.listener.expect(len(ways) + rounds)
    running: list[_Running] = []
    stopped: set[str] = set()
    for way in ways:
        unfit, batch = _unfit(way.model), way.poses > 1
        # More elements of a method, or more poses of a model, would take longer still.
        key = f"{label(way.model)}, many poses a call" if batch else way.method
        if unfit:
            left_out[way.method] = f"not with {way.size} elements ({unfit})"
        elif key not in stopped:
            one = _Running(way, _places(way, cases))
            # What the first call loads or compiles is no cost of the method.
            why = one.call(bench, count) or one.call(bench, count)
            if why is not None and why.refused:
                left_out[key] = why.reason
            elif why is not None:
                failures[f"{label(way.model)} at {', '.join(c.name for c in cases)}"] = why.reason
            else:
                one.builds, one.solves = one.builds[-1:], one.solves[-1:]
                running.append(one)
                if one.seconds * len(cases) > (LONG_BATCH if batch else LONG):
                    stopped.add(key)
                    most, what = (way.poses, "call") if batch else (way.size, "pose")
                    left_out[key] = f"not beyond {most}: {one.seconds:.1f} s a {what}"
        bench.listener.done(f"{way.method}, {way.size}")
    spent: dict[str, list[float]] = {name: [] for name in known}
    for k in range(rounds):
        for name, run in known.items():
            spent[name].append(_seconds(run))
        for one in running:
            one.sample(bench, count, k)
        bench.listener.done(f"round {k + 1}")
    return Timings(
        tuple(one.timed() for one in running),
        {name: np.array(values) for name, values in spent.items()},
        left_out,
        failures,
        rounds,
    )


def _unfit(model: Model) -> str:
    """Return why a model cannot have its number of elements, "" if it can."""
    try:
        getattr(model, "build", lambda: model)()
    except InputError as error:
        return str(error)
    except UnavailableError:  # said when it is asked
        pass
    return ""


def _places(way: Way, cases: Sequence[Case]) -> Places:
    many = way.poses
    return tuple((c.mechanism, poses_around(c, many) if many else c.pose) for c in cases)


def poses_around(case: Case, count: int) -> Pose:
    """Return `count` poses, the case's own first, the same ones every time.

    Heights 0.8 to 1.3 times the case's, any azimuth, tilts to 20 degrees; a pose that the joints
    do not reach has the case's own azimuth and tilt, and then its height. All else is the case's.
    """
    random = np.random.default_rng(0)
    pose = case.pose
    z = pose.z * random.uniform(0.8, 1.3, count)
    azimuth = random.uniform(-np.pi, np.pi, count)
    tilt = np.radians(random.uniform(-20, 20, count))
    z[0], azimuth[0], tilt[0] = pose.z, pose.azimuth, pose.tilt
    rest = (pose.torsion, pose.x, pose.y)
    far = ~closes(case.mechanism, Pose(z, azimuth, tilt, *rest))
    azimuth[far], tilt[far] = pose.azimuth, pose.tilt
    far = ~closes(case.mechanism, Pose(z, azimuth, tilt, *rest))
    z[far] = pose.z
    return Pose(z, azimuth, tilt, *rest)


def _seconds(run: Any) -> float:
    """Return the seconds of a call, repeated until they fill `SAMPLE`."""
    number = max(1, int(SAMPLE / timeit(run, number=1)))
    return timeit(run, number=number) / number
