"""A job: one model at one block of poses; its content hash, and the work itself."""

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from analytic import InputError, Mechanism, Modes, Pose, __version__
from analytic.condensed import CHUNK
from analytic.model import Model
from harness import answer as answers
from harness import declared
from harness.answer import BatchTask, flaw, solved
from harness.history.provenance import provenance
from harness.poses import columns
from reference_models import ModelError, Named, UnavailableError
from reference_models.catalogue import asked

BATCH = 10 * CHUNK
"""Poses a job of a model that can neither crash nor hang: a fraction of a second's work."""


@dataclass(frozen=True)
class Answer:
    """What a job found at its n poses.

    Attributes: `frequencies` (n, count) [Hz]; `uncertainty` of the same shape [Hz], or None;
    `closure`: the largest gap of a joint [m], or None where none can open; `theory` and `version`
    in words; `dofs` solved for; `seconds` the model's call took; `made`: code, machine and
    libraries of the process that found it, as `provenance` says them.
    """

    frequencies: NDArray[np.float64]
    uncertainty: NDArray[np.float64] | None
    closure: float | None
    theory: str
    version: str
    dofs: int
    seconds: float
    made: tuple[str, ...]


@dataclass(frozen=True)
class Job:
    """The `count` lowest modes of one model at the `poses` (arrays) from number `start` on."""

    model: Model
    program: str
    mechanism: Mechanism
    count: int
    start: int
    poses: Pose

    @cached_property
    def key(self) -> bytes:
        """A hash of all that the answer depends on: model, programs, mechanism, poses, modes."""
        said = f"{self.model!r} {self.program} {_said(self.mechanism)} {self.count}"
        given = {name: v for name, v in columns(self.poses).items() if v is not None}
        values = np.stack([*given.values()]).astype("<f8")
        return sha256(f"{said} {[*given]}".encode() + values.tobytes()).digest()[:16]

    @property
    def isolated(self) -> bool:
        """Whether it must run in a process of its own."""
        return self.model.info().isolated

    def solve(self) -> Answer:
        """Return the answer, or raise what the model raises, and `ModelError` for a bad answer.

        Raises `ModelError` also where the programs here are not those that were planned.
        """
        here = program_of(self.model)
        if here != self.program:
            raise ModelError(f"{here} runs here, not {self.program} as planned")
        count = self.count
        if self.isolated:
            modes, seconds = solved(self.model, self.mechanism, self.poses[0], count)
            found, uncertainty = modes.frequencies[None], modes.uncertainty
            uncertainty = None if uncertainty is None else np.asarray(uncertainty)[None]
        else:
            batch = BatchTask(self.model, self.mechanism, self.poses, count).solve()
            found, seconds, uncertainty = batch.table, batch.seconds, None
            # For their theory, version and size, which are the same at every pose.
            asked = (self.model, self.mechanism, count)
            if asked not in _told:
                _told[asked] = self.model.modes(self.mechanism, self.poses[0], count)
            modes = _told[asked]
        about = modes.residual, modes.theory, modes.version, modes.dofs
        answer = Answer(found, uncertainty, *about, seconds, tuple(provenance().values()))
        if why := self.flaw(answer):
            raise ModelError(why)
        return answer

    def flaw(self, answer: object) -> str:
        """Return why no number of `answer` must be believed; "" if they may be."""
        if not isinstance(answer, Answer):
            return f"it answered {type(answer).__name__}, where frequencies were expected"
        if answer.closure is not None and not np.isfinite(answer.closure):
            return f"its joints are open by {answer.closure} m"
        return flaw(answer.frequencies, (len(self.poses), self.count), answer.uncertainty)


def jobs(
    model: Model, mechanism: Mechanism, poses: Pose, count: int, first: int = 0
) -> Iterator[Job]:
    """Yield the jobs that cover all `poses`, numbered from `first` on, in order.

    Split at fixed numbers: the last bits of a batch's answer depend on a pose's company.
    """
    size = 1 if model.info().isolated else BATCH
    program = program_of(model)
    for start in range(0, len(poses), size):
        yield Job(model, program, mechanism, count, first + start, poses[start : start + size])


def unusable(model: Model) -> str:
    """Return why a model cannot run here at all, "" if it can."""
    return _here(model)[0]


def program_of(model: Model) -> str:
    """Return what computes a model here: its program's version, this bench's, and their sources."""
    if model not in _programs:
        info, (_, source) = model.info(), _here(model)
        bench = f"rps-bench {__version__}, numpy {np.__version__}, scipy {scipy.__version__}"
        _programs[model] = f"{info.program} {info.version} ({bench}, source {source})"
    return _programs[model]


def _here(model: Model) -> tuple[str, str]:
    """Return why a model cannot be built here, "" if it can, and a hash of the files behind it."""
    try:
        found: tuple[str, str] = asked(_built, model) if isinstance(model, Named) else _built(model)
    except UnavailableError as error:
        return str(error), "none"
    return found


def _built(model: Any) -> tuple[str, str]:
    """Return the same where the model may be built. The files: of its own package, or its file, of
    `analytic`, and what makes and checks an answer."""
    try:
        built = model.build() if hasattr(model, "build") else model
    except (UnavailableError, InputError) as error:
        return str(error), "none"
    parts = (built, *getattr(built, "__dict__", {}).values())  # an extrapolation holds two models
    names = {"analytic", *(type(part).__module__.partition(".")[0] for part in parts)}
    files = [Path(own) for own in (__file__, answers.__file__, declared.__file__)]
    for name in sorted(names):
        file = Path(getattr(sys.modules.get(name), "__file__", None) or "")
        if file.is_file():
            package = file.name == "__init__.py"
            files += sorted(file.parent.rglob("*.py")) if package else [file]
    content = sha256(b"".join(path.read_bytes() for path in files))
    return "", content.hexdigest()[:12]


_programs: dict[Model, str] = {}
_told: dict[tuple[Model, Mechanism, int], Modes] = {}
_said = lru_cache(maxsize=4)(repr)
"""A mechanism in words, every number of it."""
