"""A job: one model at one block of poses; its content hash, and the work itself."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from hashlib import sha256
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from analytic import Mechanism, Pose, __version__, condensed_frequencies
from analytic.condensed import CHUNK
from analytic.theory import Theory
from harness.models import MADE_FROM, SOLID_LIMB, Model, Spec
from reference_models import ModelError
from reference_models.protocol import Info, find

BATCH = 10 * CHUNK
"""Poses a job of an analytic model: a fraction of a second's work. A simulator's job is one."""


@dataclass(frozen=True)
class Answer:
    """What a job found at its n poses.

    Attributes: `frequencies` (n, count) [Hz]; `uncertainty` of the same shape [Hz], or None;
    `closure`: the largest gap of a joint [m], or None where none can open; `theory` in words;
    `dofs` solved for, 0 without elements; `seconds` the model's call took.
    """

    frequencies: NDArray[np.float64]
    uncertainty: NDArray[np.float64] | None
    closure: float | None
    theory: str
    dofs: int
    seconds: float


@dataclass(frozen=True)
class Job:
    """The `count` lowest modes of one model at the `poses` (arrays) from number `start` on."""

    spec: Spec
    version: str
    mechanism: Mechanism
    count: int
    start: int
    poses: Pose

    @cached_property
    def key(self) -> bytes:
        """A hash of all that the answer depends on: model, version, mechanism, poses, modes."""
        values = np.stack([self.poses.z, self.poses.azimuth, self.poses.tilt])
        return sha256(_settings(self.spec, self.version, self.mechanism, self.count)
                      + values.astype("<f8").tobytes()).digest()[:16]  # fmt: skip

    @property
    def safe(self) -> bool:
        """Whether it can neither crash nor hang."""
        return self.spec.analytic

    def solve(self) -> Answer:
        """Return the answer, or raise what the model raises.

        Raises `ModelError` also where the program here is not of the version that was planned.
        """
        here = version_of(self.spec)
        if here != self.version:
            raise ModelError(f"{here} runs here, not {self.version} as planned")
        if self.spec.analytic:
            return _batch(self)
        model = built(self.spec)
        began = perf_counter()
        modes = model.modes(self.mechanism, self.poses[0], self.count)
        seconds = perf_counter() - began
        uncertainty = None if modes.uncertainty is None else modes.uncertainty[None]
        return Answer(
            modes.frequencies[None],
            uncertainty,
            modes.residual,
            modes.theory,
            modes.dofs,
            seconds,
        )


@lru_cache(maxsize=64)
def _settings(spec: Spec, version: str, mechanism: Mechanism, count: int) -> bytes:
    return repr((spec, version, mechanism, count)).encode()


def jobs(
    spec: Spec, mechanism: Mechanism, poses: Pose, count: int, first: int = 0
) -> Iterator[Job]:
    """Yield the jobs that cover all `poses`, numbered from `first` on, in order.

    Split at fixed numbers: the last bits of an analytic answer depend on a pose's company.
    """
    size = BATCH if spec.analytic else 1
    program = version_of(spec)
    for start in range(0, len(poses), size):
        yield Job(spec, program, mechanism, count, first + start, poses[start : start + size])


@lru_cache(maxsize=64)
def version_of(spec: Spec) -> str:
    """Return the versions of what computes `spec` here."""
    if not spec.analytic:
        info = info_of(spec)
        return f"{info.program} {info.version}"
    return f"rps-bench {__version__}, numpy {np.__version__}"


@lru_cache(maxsize=64)
def info_of(spec: Spec) -> Info:
    """Return what is known of a model that is not analytic."""
    return find(MADE_FROM if spec.name == SOLID_LIMB else spec.name).info()


@lru_cache(maxsize=64)
def built(spec: Spec) -> Model:
    """Return the model, made once a process."""
    return spec.build()


def analytic_frequencies(job: Job, torsion: bool = True) -> NDArray[np.float64]:
    """Return what an analytic job finds, (n, count) [Hz], with or without torsion of limbs."""
    spec = job.spec
    assert not isinstance(spec.elements, tuple), "only simulators are extrapolated"
    # Never compiled: a process would load the loop for longer than a block of poses takes.
    return condensed_frequencies(
        job.mechanism,
        job.poses,
        spec.elements,
        beam=spec.name,
        shear=spec.shear,
        count=job.count,
        torsion=torsion,
        fast=False,
    )


def _batch(job: Job) -> Answer:
    spec = job.spec
    began = perf_counter()
    found = analytic_frequencies(job)
    seconds = perf_counter() - began
    assert not isinstance(spec.elements, tuple)
    theory = Theory(spec.name, spec.shear).labels(job.mechanism)
    limbs = len(job.mechanism.limbs)
    dofs = 0 if spec.elements is None else 6 + limbs * (6 * spec.elements - 2)
    return Answer(found, None, None, theory, dofs, seconds)
