"""A sweep and its jobs, each one model at a block of poses; the journal keeps their answers."""

import pickle
import sqlite3
import sys
import zlib
from collections.abc import Iterable, Iterator, Sequence
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
from harness.output import OutputError
from harness.poses import columns, used
from harness.sweep.engine import Engine
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
        """Return the answer, or raise what the model raises, and `ModelError` for a bad answer, or
        where the programs here are not those that were planned."""
        _, here = program_of(self.model)
        if here != self.program:
            raise ModelError(f"{here} runs here, not {self.program} as planned")
        uncertainty = None
        if self.isolated:
            modes, seconds = solved(self.model, self.mechanism, self.poses[0], self.count)
            found = modes.frequencies[None]
            if modes.uncertainty is not None:
                uncertainty = modes.uncertainty[None]
        else:
            batch = BatchTask(self.model, self.mechanism, self.poses, self.count).solve()
            found, seconds = batch.table, batch.seconds
            # For their theory, version and size, which are the same at every pose.
            same = (self.model, self.mechanism, self.count)
            if same not in _told:
                _told[same] = self.model.modes(self.mechanism, self.poses[0], self.count)
            modes = _told[same]
        about = modes.residual, modes.theory, modes.version, modes.dofs
        return Answer(found, uncertainty, *about, seconds, tuple(provenance().values()))

    def flaw(self, answer: object) -> str:
        """Return why no number of `answer` must be believed; "" if they may be."""
        if not isinstance(answer, Answer):
            return f"it answered {type(answer).__name__}, where frequencies were expected"
        if answer.closure is not None and not np.isfinite(answer.closure):
            return f"its joints are open by {answer.closure} m"
        return flaw(answer.frequencies, (len(self.poses), self.count), answer.uncertainty)


def program_of(model: Model) -> tuple[str, str]:
    """Return why a model cannot run here at all, "" if it can, and what computes it here: its
    program's version, this bench's, and their sources."""
    if model in _programs:
        return "", _programs[model]
    why, source = "", "none"
    try:
        source = asked(_source, model) if isinstance(model, Named) else _source(model)
    except (UnavailableError, InputError) as error:
        why = str(error)
    info = model.info()
    bench = f"rps-bench {__version__}, numpy {np.__version__}, scipy {scipy.__version__}"
    program = f"{info.program} {info.version} ({bench}, source {source})"
    if not why:
        _programs[model] = program
    return why, program


def _source(model: Any) -> str:
    """Return a hash of the files behind a model: of its own package, or its file, of `analytic`,
    and what makes and checks an answer; raise where it cannot be built."""
    built = model.build() if hasattr(model, "build") else model
    parts = (built, *getattr(built, "__dict__", {}).values())  # an extrapolation holds two models
    names = {"analytic", *(type(part).__module__.partition(".")[0] for part in parts)}
    files = [Path(own) for own in (__file__, answers.__file__, declared.__file__)]
    for name in sorted(names):
        file = Path(getattr(sys.modules.get(name), "__file__", None) or "")
        package = file.name == "__init__.py"
        files += sorted(file.parent.rglob("*.py")) if package else [file]
    content = sha256(b"".join(path.read_bytes() for path in files if path.is_file()))
    return content.hexdigest()[:12]


_programs: dict[Model, str] = {}
_told: dict[tuple[Model, Mechanism, int], Modes] = {}
_said = lru_cache(maxsize=4)(repr)
"""A mechanism in words, every number of it."""

NAME = "journal.sqlite"
_OPEN = (
    # Exclusive: the kernel lets go of the lock when the process ends, even by SIGKILL.
    "PRAGMA locking_mode = EXCLUSIVE",
    "PRAGMA journal_mode = WAL",
    "PRAGMA synchronous = NORMAL",
    "BEGIN EXCLUSIVE",
    "CREATE TABLE IF NOT EXISTS jobs (key BLOB PRIMARY KEY, answer BLOB NOT NULL, "
    "seconds REAL NOT NULL, checksum INTEGER NOT NULL) WITHOUT ROWID",
    "CREATE TABLE IF NOT EXISTS run (key BLOB PRIMARY KEY, name TEXT NOT NULL) WITHOUT ROWID",
    "COMMIT",
    "CREATE TEMP TABLE part (key BLOB)",
)
_RUNS = "SELECT DISTINCT name FROM part LEFT JOIN run USING (key)"


class Journal:
    """The answers of the jobs run into one folder, by the jobs' content hashes; to be closed.

    SQLite with a write-ahead log: a finished job survives the end of this process, however it
    ends. One process at a time: a second is refused. Raises `OutputError` where the folder cannot
    be written, is in use, or the file is damaged.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._base = sqlite3.connect(folder / NAME, timeout=0, isolation_level=None)
        except (OSError, sqlite3.Error) as error:
            raise self._refused(error) from None
        try:
            for statement in _OPEN:
                self._run(statement)
            (sound,) = self._run("PRAGMA quick_check(1)").fetchone()
            if sound != "ok":
                raise self._refused(sound)
        except OutputError:
            self.close()
            raise

    def close(self) -> None:
        """Let go of the folder."""
        self._base.close()

    def get(self, job: Job) -> Answer | None:
        """Return the answer of `job`, or None if it is not there, or not one to be believed."""
        row = self._run("SELECT answer, checksum FROM jobs WHERE key = ?", job.key).fetchone()
        if row is None or zlib.crc32(row[0]) != row[1]:
            return None
        try:
            answer: Answer = pickle.loads(row[0])
        except Exception:  # whatever it is, it is no answer
            return None
        return None if job.flaw(answer) else answer

    def put(self, job: Job, answer: Answer) -> None:
        """Keep the answer of `job`; once this returns it is there for good."""
        content = pickle.dumps(answer, protocol=5)
        values = (job.key, content, answer.seconds, zlib.crc32(content))
        self._run("INSERT OR REPLACE INTO jobs VALUES (?, ?, ?, ?)", *values)

    def takes(self, jobs: Iterable[Job]) -> None:
        """Take in that the answers of `jobs` are part of this sweep."""
        for job in jobs:
            self._run("INSERT INTO part VALUES (?)", job.key)

    def runs(self) -> set[str | None]:
        """Return the runs of a history that this sweep's answers went to last, None among them
        where one went nowhere yet.

        The file of one may be missing: its name is taken in before it is written, so that a process
        that is killed in between neither loses rows nor writes them twice.
        """
        return {name for (name,) in self._run(_RUNS)}

    def goes_to(self, run: str) -> None:
        """Take in that this sweep's answers are about to be written as this run."""
        self._run("INSERT OR REPLACE INTO run SELECT key, ? FROM part", run)

    def _run(self, statement: str, *values: object) -> sqlite3.Cursor:
        try:
            return self._base.execute(statement, values)
        except sqlite3.Error as error:
            raise self._refused(error) from None

    def _refused(self, error: Any) -> OutputError:
        """Return why the folder cannot be used; what is no error is the damage that was found."""
        code = getattr(error, "sqlite_errorcode", None)
        why = f"cannot write there ({getattr(error, 'strerror', None) or error})"
        if code == sqlite3.SQLITE_BUSY:
            why = "another sweep is running into this folder"
        elif isinstance(error, str) or code in (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB):
            damage = " ".join(str(error).split())
            why = f"its {NAME} is damaged ({damage}); move it away to start anew"
        return OutputError(f"output = {str(self._folder)!r}: {why}")


@dataclass(frozen=True)
class Sweep:
    """The lowest modes of `mechanism` at `poses` (arrays) by the models `chosen`.

    `modes`: the numbers that are shown; `against`: what the others are compared with, one of them
    or one more, or None. Jobs run where the `engine` says; what they find is in the `journal`.
    """

    mechanism: Mechanism
    poses: Pose
    chosen: Iterable[Model]
    modes: Sequence[int]
    against: Model | None
    journal: Journal
    engine: Engine

    @cached_property
    def models(self) -> tuple[Model, ...]:
        """All of them, each once."""
        return tuple(dict.fromkeys([*self.chosen, *([self.against] if self.against else [])]))

    @property
    def count(self) -> int:
        """How many modes are solved for."""
        return max(self.modes)

    @cached_property
    def where(self) -> tuple[str, ...]:
        """The columns that say where the poses are."""
        return used([self.poses])

    def jobs(self, model: Model, start: int = 0, stop: int | None = None) -> Iterator[Job]:
        """Yield the jobs of one model for the poses from `start`, a multiple of `BATCH`, on.

        Split at fixed numbers: the last bits of a batch's answer depend on a pose's company.
        """
        size = 1 if model.info().isolated else BATCH
        _, program = program_of(model)
        poses = self.poses[start:stop]
        for at in range(0, len(poses), size):
            some = poses[at : at + size]
            yield Job(model, program, self.mechanism, self.count, start + at, some)

    @property
    def blocks(self) -> range:
        """Where the blocks of `BATCH` poses start in which these are read back."""
        return range(0, len(self.poses), BATCH)

    def answers(self, model: Model, start: int) -> Iterator[tuple[Job, Answer]]:
        """Yield the finished jobs of a block of poses, in order."""
        for job in self.jobs(model, start, start + BATCH):
            answer = self.journal.get(job)
            if answer is not None:
                yield job, answer
