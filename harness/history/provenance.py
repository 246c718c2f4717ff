"""What a run ran on: code, machine and libraries; no names of hosts or people."""

import os
import platform
import re
import subprocess
from contextlib import suppress
from functools import cache
from pathlib import Path

import numpy as np
import scipy

from analytic import __version__

ROOT = Path(__file__).parents[2]
"""The checkout this package runs from, if it is one."""


@cache
def provenance() -> dict[str, str]:
    """Return the columns of the history that are the same for every row of a run."""
    return {
        "commit": _commit(),
        "release": __version__,
        "machine": f"{_processor()}, {os.cpu_count()} cores, {_system()}",
        "python": platform.python_version(),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "blas": _blas(),
    }


def _commit() -> str:
    """Return the checkout's commit, `-dirty` where files differ from it; "" without a checkout."""
    if not (ROOT / ".git").exists():
        return ""
    describe = ["describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    own = {k: v for k, v in os.environ.items() if not k.startswith("GIT_")}  # a hook's are not ours
    command = ["git", "--no-optional-locks", "-C", str(ROOT), *describe]
    try:
        ended = subprocess.run(command, capture_output=True, text=True, timeout=10, env=own)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return ended.stdout.strip() if ended.returncode == 0 else ""


def _processor() -> str:
    with suppress(OSError):
        about = Path("/proc/cpuinfo").read_text()
        if named := re.search(r"^model name\s*: *(.+?) *$", about, re.MULTILINE):
            return named[1]
    return platform.processor() or platform.machine()


def _system() -> str:
    try:
        return platform.freedesktop_os_release()["PRETTY_NAME"]
    except (OSError, KeyError):
        return f"{platform.system()} {platform.release()}"


def _blas() -> str:
    """Return what numpy and scipy were built with; wheels carry one each."""
    asked = (library.show_config(mode="dicts") for library in (np, scipy))
    found = [config["Build Dependencies"]["blas"] for config in asked]
    first, second = (f"{blas['name']} {blas['version']}" for blas in found)
    return first if first == second else f"numpy: {first}, scipy: {second}"
