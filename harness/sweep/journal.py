"""Finished jobs on disk: each is there for good the moment it is reported, and only once."""

import pickle
import sqlite3
import zlib
from collections.abc import Iterable
from pathlib import Path
from typing import Self

from harness.output import OutputError
from harness.sweep.jobs import Answer, Job

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
)


class Journal:
    """The answers of the jobs run into one folder, by the jobs' content hashes.

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
            raise self._cannot_write(error) from None
        try:
            for statement in _OPEN:
                self._run(statement)
            (sound,) = self._run("PRAGMA quick_check(1)").fetchone()
            if sound != "ok":
                raise self._damaged(str(sound))
        except OutputError:
            self._base.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._base.close()

    def __contains__(self, job: Job) -> bool:
        return self.get(job) is not None

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

    def run_of(self, job: Job) -> str | None:
        """Return the run of a history that the answer of `job` went to last, if its file is there.

        It may be missing: the name is taken in before the file is written, so that a process that
        is killed in between neither loses rows nor writes them twice.
        """
        row = self._run("SELECT name FROM run WHERE key = ?", job.key).fetchone()
        return None if row is None else str(row[0])

    def goes_to(self, run: str, jobs: Iterable[Job]) -> None:
        """Take in that the answers of `jobs` are about to be written as this run."""
        self._run("BEGIN")
        for job in jobs:
            self._run("INSERT OR REPLACE INTO run VALUES (?, ?)", job.key, run)
        self._run("COMMIT")

    def _run(self, statement: str, *values: object) -> sqlite3.Cursor:
        try:
            return self._base.execute(statement, values)
        except sqlite3.Error as error:
            if error.sqlite_errorcode == sqlite3.SQLITE_BUSY:
                raise self._refused("another sweep is running into this folder") from None
            if error.sqlite_errorcode in (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB):
                raise self._damaged(str(error)) from None
            raise self._cannot_write(error) from None

    def _damaged(self, why: str) -> OutputError:
        why = " ".join(why.split())
        return self._refused(f"its {NAME} is damaged ({why}); move it away to start anew")

    def _cannot_write(self, error: Exception) -> OutputError:
        return self._refused(f"cannot write there ({getattr(error, 'strerror', None) or error})")

    def _refused(self, why: str) -> OutputError:
        return OutputError(f"output = {str(self._folder)!r}: {why}")
