"""Models timed against each other: in rounds, on one thread, each where it runs anyway.

Every round times every way once, so that whatever else the machine does falls on all alike. A model
that may crash is timed inside its own process: handing the answer over is no cost of it.
"""

import gc
from collections import Counter, defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from timeit import timeit
from typing import Any

import numpy as np

from analytic import InputError, Mechanism, Modes, Pose
from analytic.kinematics import closes
from analytic.model import Model
from harness.bench import Bench, label
from harness.case import Case
from harness.signatures import Array
from harness.workers import Failure
from reference_models import UnavailableError
from reference_models.spent import recorded

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
SAID = "build_seconds", "solve_seconds"
"""What modes say of their own time."""
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
        asked = {0: "", 1: ", frequencies"}.get(self.poses, f", {self.poses} poses a call")
        return f"{name}{f'[{own}]' if own else ''}{asked}"

    @property
    def size(self) -> str:
        """The elements in words: "3", "8+16" or "exact"."""
        elements = self.model.elements
        if isinstance(elements, tuple):
            return "+".join(map(str, elements))
        return "exact" if elements is None else str(elements)


@dataclass(frozen=True)
class Spent:
    """What a pose took [s] and answered.

    Attributes: `seconds`; `build`, `solve`: what the answers say of their matrices and
    eigen-solutions, NaN where they are frequencies alone; `answers` of the last call, one a place:
    modes, or frequencies of the first pose; `phases`: seconds by `reference_models.spent`.
    """

    seconds: float
    build: float
    solve: float
    answers: tuple[Modes | Array, ...]
    phases: Mapping[str, float] = field(default_factory=dict)

    @property
    def rest(self) -> float:
        """What the answers do not say of the seconds."""
        return self.seconds - self.build - self.solve


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

    def solve(self) -> Spent:
        """Return what they took."""
        model, poses = self.way.model, self.way.poses
        shifted = [
            [(mechanism, replace(pose, z=pose.z + SHIFT * (self.first + k)))
             for mechanism, pose in self.places]
            for k in range(self.number)
        ]  # fmt: skip
        ask = model.frequencies if poses else model.modes
        said, answers = np.zeros(2), list[Any]()

        def run() -> None:
            for at in shifted:
                answers[:] = (ask(mechanism, pose, self.count) for mechanism, pose in at)
                for one in answers:
                    np.add(said, [getattr(one, name, np.nan) for name in SAID], out=said)

        gc.collect()
        with recorded() as record:
            seconds = timeit(run, number=1)
        each = self.number * len(self.places) * max(1, poses)
        firsts = (a if isinstance(a, Modes) else np.atleast_2d(np.asarray(a))[0] for a in answers)
        phases = {name: spent / each for name, spent in record.seconds.items()}
        build, solve = (said / each).tolist()
        return Spent(seconds / each, build, solve, tuple(firsts), phases)


@dataclass(frozen=True)
class Timed:
    """One way, timed: what its `first` call took, and those of the `rounds`."""

    way: Way
    first: Spent
    rounds: tuple[Spent, ...]

    def each(self, what: str) -> Array:
        """Return one of the times in `Spent`, by round [s]."""
        return np.array([getattr(one, what) for one in self.rounds])

    def median(self, what: str = "seconds") -> float:
        """Return the median of one of the times in `Spent` [s]."""
        return float(np.median(self.each(what)))

    @property
    def phases(self) -> dict[str, float]:
        """A simulator's seconds by phase, medians."""
        return {k: float(np.median([one.phases[k] for one in self.rounds]))
                for k in self.first.phases}  # fmt: skip

    @property
    def answers(self) -> tuple[Modes | Array, ...]:
        """What it answered last, one a place."""
        return self.rounds[-1].answers

    @property
    def dofs(self) -> int | None:
        """The coordinates solved for, where the answer says so."""
        return getattr(self.answers[0], "dofs", None)


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


def time_ways(
    bench: Bench,
    ways: Sequence[Way],
    cases: Sequence[Case],
    rounds: int,
    count: int,
    yardsticks: Mapping[str, tuple[Callable[[], Any], int]] | None = None,
) -> Timings:
    """Time every way at every case in `rounds` rounds, beside `yardsticks`: a call, and how many
    solutions it makes.

    A way of many poses a call takes the case's own pose first and others after it. Larger
    sizes of a method are left out once a call takes longer than `LONG`, more poses a call once one
    takes longer than `LONG_BATCH`.
    """
    calls, spent = Counter[Way](), defaultdict[Way, list[Spent]](list)

    @cache
    def places(many: int) -> Places:
        return tuple((c.mechanism, poses_around(c, many) if many else c.pose) for c in cases)

    def call(way: Way, number: int = 1) -> Failure | None:
        """Make `number` calls; return why there is no answer, None if there is one."""
        task = Call(way, places(way.poses), count, number, calls[way])
        calls[way] += number
        found = bench.call(task, way.model.info().isolated)
        if isinstance(found, Failure):
            return found
        assert isinstance(found, Spent)
        spent[way].append(found)
        return None

    def last(way: Way) -> float:
        """Return what the last call took at all places."""
        return spent[way][-1].seconds * len(cases) * max(1, way.poses)

    left_out, failures = dict[str, str](), dict[str, str]()
    yards = {name: np.empty(rounds) for name in yardsticks or {}}
    bench.listener.expect(len(ways) + rounds)
    running, stopped = list[Way](), set[str]()
    for way in ways:
        unfit, batch, name = _unfit(way.model), way.poses > 1, label(way.model)
        # More elements of a method, or more poses of a model, would take longer still.
        key = f"{name}, many poses a call" if batch else way.method
        if unfit:
            left_out[way.method] = f"not with s = {way.size} ({unfit})"
        elif key not in stopped:
            # What the first call loads or compiles is no cost of the method.
            why = call(way) or call(way)
            if why is None:
                running.append(way)
                if last(way) > (LONG_BATCH if batch else LONG):
                    stopped.add(key)
                    most, what = (way.poses, "call") if batch else (way.size, "pose")
                    left_out[key] = f"not beyond {most}: {last(way) / len(cases):.1f} s a {what}"
            elif why.refused:
                left_out[key] = why.reason
            else:
                failures[f"{name} at {', '.join(c.name for c in cases)}"] = why.reason
        bench.listener.done(f"{way.method}, {way.size}")
    for k in range(rounds):
        for name, (run, solutions) in (yardsticks or {}).items():
            number = max(1, int(SAMPLE / timeit(run, number=1)))
            yards[name][k] = timeit(run, number=number) / number / solutions
        for way in running:
            if last(way) <= SLOW or (last(way) <= ENDLESS and k < FEW):
                call(way, max(1, int(SAMPLE / last(way))))
        bench.listener.done(f"round {k + 1}")
    # The first call loads and compiles, the second counts only where there is no other.
    timed = (Timed(way, spent[way][0], tuple(spent[way][2:] or spent[way][1:])) for way in running)
    return Timings(tuple(timed), yards, left_out, failures, rounds)


def _unfit(model: Model) -> str:
    """Return why a model cannot have its number of elements, "" if it can."""
    try:
        getattr(model, "build", lambda: model)()
    except InputError as error:
        return str(error)
    except UnavailableError:  # said when it is asked
        pass
    return ""


def poses_around(case: Case, count: int) -> Pose:
    """Return `count` poses, the case's own first, the same ones every time.

    Heights 0.8 to 1.3 times the case's, any azimuth, tilts to 20 degrees; a pose that the joints
    do not reach has the case's own azimuth and tilt, and then its height. All else is the case's.
    """
    random, pose = np.random.default_rng(0), case.pose
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
