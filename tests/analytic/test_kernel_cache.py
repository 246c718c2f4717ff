"""The compiled loop needs no folder of its own."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from analytic import kernel

pytest.importorskip("numba", reason="numba is missing, which compiles the loop")
NO_BYTECODE = shutil.ignore_patterns("__pycache__")


def test_compiles_where_no_folder_can_be_written(tmp_path: Path) -> None:
    """Files stand where folders would be made: what not even root can write."""
    shutil.copytree(Path(kernel.__file__).parent, tmp_path / "analytic", ignore=NO_BYTECODE)
    (tmp_path / "analytic" / "__pycache__").write_text("")
    code = "from analytic import kernel; print(kernel.compiled() is None, kernel.__file__)"
    nowhere = {"HOME": "/dev/null", "XDG_CACHE_HOME": "/dev/null", "PYTHONDONTWRITEBYTECODE": "1"}
    ended = subprocess.run(
        [sys.executable, "-c", code],
        cwd=tmp_path, env=os.environ | nowhere, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.split() == ["False", str(tmp_path / "analytic" / "kernel.py")]
