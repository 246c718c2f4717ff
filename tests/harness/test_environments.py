"""One study in two environments: what changes is shown, with what else differs."""

import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from analytic import InputError
from harness.cases import PRESETS
from harness.environments import compare, requirements, study
from reference_models import Named, UnavailableError

CASES = (PRESETS["case1"],)
UV = """#!/bin/sh
# Stands for uv: takes its options and runs the command in this environment.
echo "$*" >> {log}
for word in "$@"; do
    case "$word" in
        --with=broken*) echo "error: No solution found" >&2; echo "  cause: broken is broken" >&2
                        echo "      ^^^" >&2; exit 1 ;;
        --with=silent*) exit 3 ;;
    esac
done
while [ "$1" != python ]; do shift; done
shift
exec {python} "$@"
"""


@pytest.fixture
def uv(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A uv that changes nothing; returns the log of its calls."""
    folder, log = tmp_path / "bin", tmp_path / "log"
    folder.mkdir()
    program = folder / "uv"
    program.write_text(UV.format(log=log, python=sys.executable))
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}:/usr/bin:/bin")
    return log


@pytest.mark.slow
def test_one_model_less_costs_only_itself(uv: Path) -> None:
    """Equal environments give equal numbers; what runs in one only says so."""
    models = [Named("exudyn-cable", 2), Named("exudyn-cable", 2, (("odd", 1),))]
    found = compare("rich==1", "poor==1", CASES, models)
    assert {row[0] for row in found.rows} == {"exudyn-cable@2"}
    assert {str(row[5]) for row in found.rows} == {"+0.000000"}
    rich, poor = (note for note in found.notes if note.startswith("exudyn-cable@2[odd=1] runs"))
    assert rich.startswith("exudyn-cable@2[odd=1] runs with neither: rich==1: settings")
    assert poor.startswith("exudyn-cable@2[odd=1] runs with neither: poor==1: settings")
    first = uv.read_text().splitlines()[0].split()
    assert first[:4] == ["run", "--quiet", "--no-project", "--python"]
    assert "--with=rich==1" in first
    assert any(word.startswith("--with=numpy==") for word in first)  # numpy stays what it is


def test_an_environment_that_cannot_be_made(uv: Path) -> None:
    model = Named("exudyn-cable", 2)
    with pytest.raises(UnavailableError) as refused:
        compare("broken==1", "rich==1", CASES, [model])
    assert str(refused.value) == "broken==1: cause: broken is broken"
    with pytest.raises(UnavailableError, match="silent==2: ended with status 3"):
        compare("silent==2", "rich==1", CASES, [model])


def test_without_uv(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    with pytest.raises(UnavailableError, match="uv, which is not here; pip install uv"):
        compare("mujoco==1", "mujoco==2", CASES, [Named("mujoco-chain", 4)])


def test_the_simulators_of_a_requirement() -> None:
    both = requirements("mujoco==3.17.0, mujoco>=4")
    assert both == ("mujoco==3.17.0", "mujoco>=4")
    assert {model.name for model in study(*both)} >= {"mujoco-cable", "mujoco-chain"}
    labels = [model.label for model in study(*both, ["exudyn-beam", "rayleigh@2"])]
    assert labels == ["exudyn-beam@12+24", "rayleigh@2"]
    with pytest.raises(InputError, match="compare = 'flask==1,flask==2': expected a simulator"):
        study("flask==1", "flask==2")
    for text in ("mujoco==3", "mujoco==3,mujoco==3", "a,b,c", ","):
        with pytest.raises(InputError, match="expected two requirements"):
            requirements(text)


@pytest.mark.slow
def test_the_command(rps_bench: Callable[..., Any], uv: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    answer = rps_bench(
        "check", "--compare", "rich==1,rich==2", "--models", "exudyn-cable@2", "--output", str(out)
    )
    assert answer.status == 0
    assert "rich==1 against rich==2" in answer.out
    assert len((out / "environments.csv").read_text().splitlines()) == 1 + 2 * 6
    broken = rps_bench("check", "--compare", "broken==2,rich==1", "--models", "exudyn-cable@2")
    assert (broken.status, broken.err) == (2, "rps-bench: broken==2: cause: broken is broken\n")


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("uv") is None, reason="uv makes the environments; CI has it")
def test_two_releases_of_mujoco() -> None:
    """The chain is the same in both; the cable is another element, and that is said."""
    models = [Named("mujoco-cable", 16), Named("mujoco-chain", 16)]
    found = compare("mujoco==3.17.0", "mujoco==4.0.0", [PRESETS["case2"]], models)
    off = {(row[0], row[2]): getattr(row[5], "value", row[5]) for row in found.rows}
    assert all(abs(off["mujoco-chain@16", i]) < 1e-7 for i in (1, 2, 3))
    # 3.17's composite is inextensible and first order, 5 % high at 16 elements; 4.0's rod is not.
    assert all(-10 < off["mujoco-cable@16", i] < -3 for i in (1, 2, 3))
    assert "mujoco==3.17.0: mujoco 3.17.0" in found.notes
    assert "mujoco==4.0.0: mujoco 4.0.0" in found.notes
    assert any(
        note.startswith("mujoco-cable@16: its theory is inextensible Rayleigh with mujoco==3.17.0")
        for note in found.notes
    )
