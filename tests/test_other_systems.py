"""What other systems lack, and simulators that are not installed: imports go on without them."""

import os
import subprocess
import sys

import pytest

from analytic import InputError
from harness.workers import Child, sweep_up

ABSENT = ("fcntl", "resource", "pwd", "grp", "termios", "pty", "exudyn", "mujoco", "ngsolve",
          "netgen", "numba", "distributed")  # fmt: skip
NEEDED = {"reference_models.mujoco.geometry", "reference_models.mujoco.linearise"}
"""Modules that nothing imports before MuJoCo runs."""
EVERYTHING = """
import importlib, os, pkgutil, signal, sys
import analytic, reference_models, harness  # with what numpy and others import for themselves
for name in sys.argv[1].split(","):
    sys.modules[name] = None
for place, names in (
    (os, ("fork", "killpg", "getpgid", "setsid", "sched_getaffinity", "getuid", "uname")),
    (signal, ("SIGKILL", "SIGALRM", "alarm", "setitimer", "pthread_sigmask")),
):
    for name in names:
        if hasattr(place, name):
            delattr(place, name)
for package in (analytic, reference_models, harness):
    for found in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
        try:
            importlib.import_module(found.name)
        except ImportError as error:
            print(found.name, error)
"""


def test_every_module_is_imported_without_simulators_and_posix() -> None:
    ended = subprocess.run(
        [sys.executable, "-c", EVERYTHING, ",".join(ABSENT)], capture_output=True, text=True
    )
    assert ended.returncode == 0, ended.stderr
    failed = {line.split()[0]: line for line in ended.stdout.splitlines()}
    assert {*failed} == NEEDED, failed
    assert all("mujoco" in line for line in failed.values())


def test_processes_need_posix_and_say_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """Before anything is started, or any other process looked at (Windows would end it)."""
    monkeypatch.delattr(os, "killpg")
    monkeypatch.delattr(os, "kill")
    with pytest.raises(InputError, match=r"system = .*: expected Linux, macOS or WSL"):
        Child()
    sweep_up()
