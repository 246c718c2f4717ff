"""calculix-solid when CalculiX is missing, fails, is killed, hangs, or the disk is full."""

import os
import shutil
import stat
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from analytic import Mechanism, Pose
from harness.cli.main import main
from reference_models import ModelError, UnavailableError, reference
from reference_models.solid import calculix_run
from reference_models.solid.calculix import CalculixSolid, check_answer
from reference_models.solid.calculix_deck import write
from reference_models.solid.calculix_run import Answer, parse

needs_ccx = pytest.mark.skipif(
    shutil.which("ccx") is None, reason="CalculiX is missing: apt-get install calculix-ccx"
)

Fake = Callable[[str], None]


@pytest.fixture
def ccx(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Fake:
    """Put a script in place of ccx, and see that nothing is left in temporary directories."""
    programs, temporary = tmp_path / "bin", tmp_path / "tmp"
    programs.mkdir()
    temporary.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    monkeypatch.setenv("PATH", f"{programs}{os.pathsep}{os.environ['PATH']}")

    def install(body: str) -> None:
        script = programs / "ccx"
        version = 'if [ "$1" = -v ]; then echo This is Version 0.0; exit; fi'
        script.write_text(f"#!/bin/sh\n{version}\n{body}\n")
        script.chmod(script.stat().st_mode | stat.S_IXUSR)

    return install


def no_files(tmp_path: Path) -> bool:
    return not list((tmp_path / "tmp").iterdir())


GARBAGE = r"printf '\377 MODE NO\n 1 nonsense\n displacements (vx,vy,vz)\n\n 1 2' > job.dat"


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("kill -9 $$", "ccx was killed by signal 9 without a word"),
        ("echo half-way; kill -9 $$", "ccx was killed by signal 9: half-way"),
        ("exit 3", "ccx failed with exit status 3 without a word"),
        (
            "echo ' *ERROR in readinput: bad'; echo '   card'; exit 201",
            r"status 201: \*ERROR in readinput: bad card",
        ),
        ("echo ' *ERROR in arpack'", r"exit status 0: \*ERROR in arpack"),
        ("echo Job finished", r"missing, cut off or not finite .*: Job finished"),
        (GARBAGE, "missing, cut off or not finite"),
        ("head -c 3000 /dev/urandom > job.dat", "missing, cut off or not finite"),
    ],
)
def test_ccx_that_fails(
    robot: Mechanism, case2: Pose, ccx: Fake, tmp_path: Path, body: str, message: str
) -> None:
    ccx(body)
    with pytest.raises(ModelError, match=f"^calculix-solid: .*{message}"):
        CalculixSolid(2).modes(robot, case2)
    assert no_files(tmp_path)


def test_ccx_that_hangs(robot: Mechanism, case2: Pose, ccx: Fake, tmp_path: Path) -> None:
    ccx(f"sleep 60 & echo $! > {tmp_path}/child; wait")
    begin = time.perf_counter()
    with pytest.raises(ModelError, match=r"ccx was stopped after 0\.5 s, its time limit"):
        CalculixSolid(2, time_limit=0.5).modes(robot, case2)
    assert time.perf_counter() - begin < 5
    assert no_files(tmp_path)
    # Its children have gone as well; one that awaits its burial counts as gone.
    child = Path("/proc") / (tmp_path / "child").read_text().strip() / "stat"
    deadline = time.perf_counter() + 5
    while child.exists() and child.read_text().split()[2] != "Z":
        assert time.perf_counter() < deadline
        time.sleep(0.01)


@pytest.mark.parametrize("body", ["kill -9 $$", "sleep 60", "exit 1", GARBAGE])
def test_other_models_results_are_kept(
    ccx: Fake,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    body: str,
) -> None:
    ccx(body)
    arguments = ["--cases", "case1", "--references", "calculix-solid,exudyn-cable@4"]
    arguments += ["--time-limit", "5", "--history", "none", "--output", str(tmp_path)]
    monkeypatch.setattr(sys, "argv", ["rps-bench", "table", *arguments])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 1
    said = capsys.readouterr()
    assert "calculix-solid@8+12 at case1 failed" in " ".join((said.out + said.err).split())
    assert "FEA (exudyn-cable@4)" in (tmp_path / "table1.csv").read_text()
    assert no_files(tmp_path)


def test_full_disk(
    robot: Mechanism, case2: Pose, ccx: Fake, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: Any, **__: Any) -> int:
        raise OSError(28, "No space left on device")

    ccx("exit 0")
    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(ModelError, match=r"^calculix-solid: .*: No space left on device$"):
        CalculixSolid(2).modes(robot, case2)
    assert no_files(tmp_path)


@needs_ccx
def test_results_cut_off_anywhere_are_refused(robot: Mechanism, case2: Pose) -> None:
    """A disk that fills up while ccx writes: at any byte, an error and never a wrong number."""
    results: list[str] = []
    original = calculix_run.parse

    def spy(text: str, said: str) -> Answer:
        results.extend([text, said])
        return original(text, said)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(calculix_run, "parse", spy)
        CalculixSolid(2).modes(robot, case2, 2)
    text, said = results
    deck = write(robot, case2, CalculixSolid(2)._mesh, "C3D20R", 2)
    check_answer(parse(text, said), deck, 2)
    for kept in [*range(len(text) - 120, len(text)), *range(0, len(text), 997)]:
        with pytest.raises(ModelError):
            check_answer(parse(text[:kept], said), deck, 2)


def test_numbers_without_room_for_their_exponent_are_read() -> None:
    text = "\n 1 0.1E+02\n P A R T I C I P A T I O N\n displacements (vx,vy,vz) for set A\n\n"
    answer = parse(
        f"{text}  7 -1.484630-108  2.000000E+00  1.000000+100\n", "number of equations\n 9"
    )
    assert answer.displacements.tolist() == [[[-1.484630e-108, 2.0, 1e100]]]
    assert answer.equations == 9


def test_without_ccx(
    robot: Mechanism, case2: Pose, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    info = CalculixSolid.info()
    assert info.version == ""
    assert "apt-get install calculix-ccx" in info.missing
    with pytest.raises(UnavailableError, match="apt-get install calculix-ccx"):
        CalculixSolid(2).modes(robot, case2)
    with pytest.raises(UnavailableError, match="'calculix-solid' cannot run here"):
        reference("calculix-solid", 8)


@needs_ccx
def test_leaves_nothing_behind_and_prints_nothing(
    robot: Mechanism,
    case2: Pose,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / "tmp").mkdir()
    (tmp_path / "here").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "tmp"))
    monkeypatch.chdir(tmp_path / "here")
    CalculixSolid(2).modes(robot, case2)
    assert no_files(tmp_path)
    assert not list((tmp_path / "here").iterdir())
    assert capfd.readouterr() == ("", "")
