"""One run of CalculiX: private directory, one thread, limited time; what it answers."""

import os
import re
import shutil
import signal
import subprocess
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from reference_models.protocol import ModelError, UnavailableError
from reference_models.spent import SIMULATOR, phase

Array = NDArray[np.float64]

NAME = "calculix-solid"
MISSING = (
    "CalculiX's program ccx is not on the path; install it (Debian: apt-get install calculix-ccx)"
)
THREADS = ("OMP_NUM_THREADS", "NUMBER_OF_CPUS", "CCX_NPROC_STIFFNESS", "CCX_NPROC_RESULTS",
           "CCX_NPROC_EQUATION_SOLVER")  # fmt: skip
JOB = "job"
_EXPONENT = re.compile(r"(\d)([-+]\d{3})$")  # Fortran leaves the E out for lack of room
CUT_OFF = "results of ccx are missing, cut off or not finite (is the disk full?)"
TAIL = 3
"""Lines of CalculiX's own message that are passed on."""


@dataclass(frozen=True)
class Answer:
    """What CalculiX computed; m modes, N nodes asked for.

    Attributes: `eigenvalues` omega^2 (m,) [1/s^2]; `nodes`, their ascending numbers (N,);
    `displacements` (m, N, 3), scaled to unit modal mass; `equations`: unknowns it solved for.
    """

    eigenvalues: Array
    nodes: NDArray[np.int64]
    displacements: Array
    equations: int

    def at(self, nodes: NDArray[np.int64]) -> Array:
        """Return the displacements of `nodes` (...), shape (m, ..., 3)."""
        return self.displacements[:, np.searchsorted(self.nodes, nodes)]


def program() -> str:
    """Return the path of ccx, or raise `UnavailableError` with what to do."""
    path = shutil.which("ccx")
    if path is None:
        raise UnavailableError(MISSING)
    return path


@cache
def version(path: str) -> str:
    """Return the version that the program at `path` states, or "unknown"."""
    try:
        said = subprocess.run(
            [path, "-v"], capture_output=True, text=True, errors="replace", timeout=10, check=False
        ).stdout
    except (OSError, subprocess.SubprocessError):
        return "unknown"
    found = re.search(r"[Vv]ersion\s+(\S+)", said)
    return found[1] if found else "unknown"


def run(deck: str, time_limit: float) -> Answer:
    """Return what CalculiX answers to an input deck within `time_limit` [s].

    Its files live in a temporary directory that is gone afterwards, whatever happens. Raises
    `UnavailableError` without the program, and `ModelError` where it fails, is killed or takes too
    long, where its answer cannot be read, or where the disk is full.
    """
    path = program()
    try:
        with tempfile.TemporaryDirectory(prefix="rps-bench-ccx-") as folder:
            directory = Path(folder)
            (directory / f"{JOB}.inp").write_text(deck)
            with phase(SIMULATOR):
                said = _execute(path, directory, time_limit)
            results = directory / f"{JOB}.dat"
            text = results.read_text(errors="replace") if results.exists() else ""
    except OSError as error:
        reason = error.strerror or error
        raise ModelError(f"{NAME}: cannot set up a run of ccx: {reason}") from None
    with phase("shapes"):
        return parse(text, said)


def _execute(path: str, directory: Path, time_limit: float) -> str:
    """Run ccx in `directory` and return what it printed."""
    log = directory / "log"
    with log.open("w") as out:
        process = subprocess.Popen(
            [path, JOB],
            cwd=directory,
            env=os.environ | dict.fromkeys(THREADS, "1"),
            stdin=subprocess.DEVNULL,
            stdout=out,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            status = process.wait(time_limit)
        except subprocess.TimeoutExpired:
            raise ModelError(
                f"{NAME}: ccx was stopped after {time_limit:g} s, its time limit"
            ) from None
        finally:
            # With its children, and also where this program is interrupted.
            if process.poll() is None:
                end_group(process)
                process.wait()
    said = log.read_text(errors="replace")
    if status < 0:
        raise ModelError(f"{NAME}: ccx was killed by signal {-status}{_tail(said)}")
    if status > 0 or "*ERROR" in said:
        raise ModelError(f"{NAME}: ccx failed with exit status {status}{_tail(said)}")
    return said


def end_group(process: subprocess.Popen[bytes]) -> None:
    """End a process and, where the system has groups, the group that it leads (not on Windows)."""
    if hasattr(os, "killpg"):
        os.killpg(process.pid, signal.SIGKILL)
    else:
        process.kill()


def _tail(said: str) -> str:
    """Return the last lines of CalculiX's message, from its last error on if it names one."""
    lines = [line.strip() for line in said.splitlines()]
    errors = [i for i, line in enumerate(lines) if "*ERROR" in line]
    lines = [line for line in lines[errors[-1] if errors else 0 :] if line.strip("_* ")]
    chosen = lines[:TAIL] if errors else lines[-TAIL:]
    return f": {' '.join(chosen)}" if chosen else " without a word"


def parse(text: str, said: str) -> Answer:
    """Return what CalculiX's results file says; raise `ModelError` if it is not what was asked."""
    try:
        head, *shapes = text.split(" displacements (vx,vy,vz)")
        table = head.split("P A R T I C I P A T I O N")[0].splitlines()
        values = [line.split()[1] for line in table if re.match(r"\s+\d+\s", line)]
        # The first line of a block is the rest of its heading; a block ends where no node follows.
        blocks = np.array([_rows(shape.splitlines()[1:]) for shape in shapes])
        modes, _, columns = blocks.shape
        found = re.search(r"number of equations\s+(\d+)", said)
        if columns != 4 or modes != len(values) or not (blocks[:, :, 0] == blocks[0, :, 0]).all():
            raise ValueError("modes and shapes do not match")
        answer = Answer(
            eigenvalues=np.array(values, dtype=float),
            nodes=blocks[0, :, 0].astype(np.int64),
            displacements=blocks[:, :, 1:],
            equations=int(found[1]) if found else 0,
        )
    except (ValueError, IndexError):
        raise ModelError(f"{NAME}: {CUT_OFF}{_tail(said)}") from None
    finite = np.isfinite(answer.eigenvalues).all() and np.isfinite(answer.displacements).all()
    if not finite or not answer.equations or not text.endswith("\n"):
        raise ModelError(f"{NAME}: {CUT_OFF}{_tail(said)}")
    return answer


def _rows(lines: list[str]) -> list[list[float]]:
    """Return the lines of numbers after a heading."""
    rows: list[list[float]] = []
    for line in lines:
        if line.strip():
            if not re.match(r"\s+\d+\s", line):
                break
            rows.append([float(_EXPONENT.sub(r"\1E\2", word)) for word in line.split()])
        elif rows:
            break
    return rows
