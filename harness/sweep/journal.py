"""Finished jobs on disk: each is there for good the moment it is reported, and only once."""

import pickle
import sqlite3
import zlib
from pathlib import Path
from types import TracebackType
from typing import Self

from harness.output import OutputError
from harness.sweep.jobs import Answer, Job

NAME = "journal.sqlite"


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
            self._base = sqlite3.connect(
                folder / NAME, timeout=0, isolation_level=None, check_same_thread=False
            )
        except (OSError, sqlite3.Error) as error:
            raise self._cannot_write(error) from None
        try:
            # Exclusive: the kernel lets go of the lock when the process ends, even by SIGKILL.
            self._run("PRAGMA locking_mode = EXCLUSIVE")
            self._run("PRAGMA journal_mode = WAL")
            self._run("PRAGMA synchronous = NORMAL")
            self._run("BEGIN EXCLUSIVE")
            self._run(
                "CREATE TABLE IF NOT EXISTS jobs (key BLOB PRIMARY KEY, answer BLOB NOT NULL, "
                "seconds REAL NOT NULL, checksum INTEGER NOT NULL) WITHOUT ROWID"
            )
            self._run("COMMIT")
            (sound,) = self._run("PRAGMA quick_check(1)").fetchone()
            if sound != "ok":
                raise self._damaged(str(sound))
        except OutputError:
            self._base.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
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
        self._run(
            "INSERT OR REPLACE INTO jobs VALUES (?, ?, ?, ?)",
            job.key,
            content,
            answer.seconds,
            zlib.crc32(content),
        )

    def _run(self, statement: str, *values: object) -> sqlite3.Cursor:
        try:
            return self._base.execute(statement, values)
        except sqlite3.Error as error:
            if error.sqlite_errorcode == sqlite3.SQLITE_BUSY:
                raise OutputError(
                    f"output = {str(self._folder)!r}: another sweep is running into this folder"
                ) from None
            if error.sqlite_errorcode in (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB):
                raise self._damaged(str(error)) from None
            raise self._cannot_write(error) from None

    def _damaged(self, why: str) -> OutputError:
        return OutputError(
            f"output = {str(self._folder)!r}: its {NAME} is damaged "
            f"({' '.join(why.split())}); "
            "move it away to start anew"
        )

    def _cannot_write(self, error: Exception) -> OutputError:
        reason = getattr(error, "strerror", None) or str(error)
        return OutputError(f"output = {str(self._folder)!r}: cannot write there ({reason})")
