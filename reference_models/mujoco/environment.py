"""An environment of its own for MuJoCo 3.17.0, the last release with the composite cable.

`python -m reference_models.mujoco.environment` makes it, once, from the package index, in the
user's cache folder; no other command installs anything.
"""

import atexit
import os
import pickle
import subprocess
import sys
import venv
from functools import cache
from pathlib import Path
from typing import Any

import numpy
import scipy

from reference_models.folder import default_folder
from reference_models.mujoco.system import installed
from reference_models.protocol import ModelError, UnavailableError

VERSION = "3.17.0"
ROOT = Path(__file__).parents[2]
"""Where this project's packages are imported from."""


def python() -> Path | None:
    """Return a Python that has MuJoCo 3.17.0, this one or that of the environment, or None."""
    if installed() == VERSION:
        return Path(sys.executable)
    made = _folder()
    return _program(made) if (made / "complete").exists() else None


def make() -> Path:
    """Return the Python of the environment, made anew with pip.

    Raises `UnavailableError` where it cannot be made.
    """
    folder = _folder()
    numbers = {"mujoco": VERSION, "numpy": numpy.__version__, "scipy": scipy.__version__}
    packages = [f"{name}=={number}" for name, number in numbers.items()]
    try:
        venv.create(folder, clear=True, with_pip=True)
        command = [str(_program(folder)), "-m", "pip", "install", "--quiet", *packages]
        subprocess.run(command, check=True)
        (folder / "complete").touch()
    except (OSError, subprocess.CalledProcessError) as error:
        raise UnavailableError(f"MuJoCo {VERSION} cannot be installed: {error}") from None
    return _program(folder)


def ask(question: Any) -> Any:
    """Return what `answer(question)` returns in the environment; raises what it raises.

    One process answers all questions, and ends when this one does. Raises `ModelError` if it dies,
    and `UnavailableError` without the environment.
    """
    program = python()
    if program is None:
        raise UnavailableError(f"the environment of MuJoCo {VERSION} is not made")
    child = _child(program, os.getpid())
    try:
        pickle.dump(question, child.stdin)
        child.stdin.flush()
        found = pickle.load(child.stdout)
    except (EOFError, OSError, pickle.UnpicklingError):
        _child.cache_clear()
        child.kill()
        status = child.wait()
        raise ModelError(f"the process of MuJoCo {VERSION} ended, exit status {status}") from None
    if isinstance(found, BaseException):
        raise found
    return found


@cache
def _child(program: Path, _parent: int) -> Any:
    """Start the process; a forked parent starts its own."""
    child = subprocess.Popen(
        [program, "-m", "reference_models.mujoco.answering"],
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )
    atexit.register(child.communicate)  # without more questions it ends
    return child


def _folder() -> Path:
    return default_folder() / f"mujoco-{VERSION}"


def _program(folder: Path) -> Path:
    return folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


if __name__ == "__main__":
    print(make())
