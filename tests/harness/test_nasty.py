"""Forty more ways to be a bad plug-in: each is one sentence, or an answer that is right."""

import re
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from harness.bench import Bench
from harness.cases import PRESETS
from reference_models import Named

# Classes of tests/plugin/nasty.py: what the sentence about each must say.
NASTY = {
    "complex": "type complex128",
    "infinite": "its frequencies hold inf",
    "negative": "below zero",
    "negative-zero": "its f1 is 0 Hz, where exact beams have 124.7 Hz(?!:)",
    "subnormal": "is it in hertz",
    "single": "type float32, not float64",
    "single-shapes": "its limbs have type float32",
    "whole": "type int64, not float64",
    "objects": "type object",
    "masked": "are a MaskedArray, not an array",
    "text": "type <U",
    "list": "are a list, not an array",
    "nothing": "it answered NoneType, where Modes were expected",
    "column": r"shape \(\d+, 1\)",
    "doubtful": "its uncertainties are not one finite number",
    "swapped": "shapes are exchanged",
    "shuffled": "limbs leave the platform's points",
    "limbless": "limbs leave the platform's points",
    "backward": "limbs leave the",
    "mirrored": "limbs leave the platform's points",
    "elsewhere": "limbs leave the platform's points",
    "theoryless": "its theory is 3, where a text was expected",
    "sizeless": "its dofs is None, where a number was expected",
    "timeless": "its solve_seconds is nan",
    "spoken": "its residual is 'closed'",
    "unpicklable": "cannot be handed over|its model is <function",
    "unreadable": "it holds builtins.eval|it answered Bomb",
    "lazy": "it holds nasty.LazyModes|it answered LazyModes",
    "deep": "RecursionError: maximum recursion depth",
    "vast": "MemoryError",
    "silent": "ValueError: no reason given",
    "verbose": r"ValueError: .{900,4000} \.\.\.$",
    "interrupted": "its process (was ended by SIGINT|ended by itself with status)",
    "base": "its process ended by itself with status 1",
    "quits": "ended by itself with status 7",
    "killed": "its process was ended by SIGKILL",
    "unplugged": "its process ended by itself",
    "stopped": "no answer within the time limit of 3 s",
    "stubborn": "no answer within the time limit of 3 s",
    "unbuilt": r"cannot run here: it cannot be built \(RuntimeError: no licence\)",
    "out-of-range": "elements = 8",
    "odd-order": r"its info\(\) says order = 'four', where a number was expected",
    "odd-ladder": r"its info\(\) says ladder = None",
    "odd-theory": r"its info\(\) says limit = 'euler', which is no model of the catalogue",
    "no-info-at-all": r"its info\(\) raises TypeError",
}
# What only behaves badly answers; what is asked last spoils its own package and nobody else.
RUDE = ("loud", "closes", "forks", "moves", "strict", "seeds", "warns", "threads", "last-bits",
        "read-only", "shared", "limitless")  # fmt: skip
SAYS = NASTY | {"patches": "patched by somebody else"}
AFTER = ("exudyn-cable@8", "mujoco-cable@8")


@pytest.fixture
def site(installed: Callable[[dict[str, str]], None]) -> None:
    points = {}
    for name in (*RUDE, *SAYS):
        points[f"x-{name}"] = "nasty:" + "".join(word.capitalize() for word in name.split("-"))
    installed(points | {"x-honest": "wrong:Honest"})


NAMES = [*(f"x-{name}" for name in (*NASTY, *RUDE, "patches")), "x-honest", *AFTER]
ALL, TILTED = ",".join(NAMES), ("--case-file", "one.toml")
COMMANDS = {
    "table": (*TILTED, "--references", ALL),
    "refine": (*TILTED, "--references", ALL, "--elements", "3,4,8"),
    "reproduce": (*TILTED, "--references", ALL, "--only", "table"),
    # Without those that answer, whose properties take minutes, and what spoils those after it.
    "check": (*TILTED, "--models", ",".join(f"x-{name}" for name in NASTY), "--baseline", "none"),
    "sweep": ("--poses", "pose:490,10,-12", "--models", ALL, "--tries", "1", "--cores", "1"),
}
_answers: dict[Any, Any] = {}


@pytest.fixture
def remembered(monkeypatch: pytest.MonkeyPatch) -> None:
    """A bench asks what no bench before it has asked: crashes and time limits are waited for."""
    right = Bench._solve

    def solve(bench: Bench, *asked: Any) -> Any:
        if asked not in _answers:
            _answers[asked] = right(bench, *asked)
        return _answers[asked]

    monkeypatch.setattr(Bench, "_solve", solve)


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_each_is_a_sentence_or_a_right_answer(
    rps_bench: Callable[..., Any],
    site: None,
    remembered: None,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    command: str,
) -> None:
    monkeypatch.setenv("NASTY_LOG", str(tmp_path / "log"))
    monkeypatch.chdir(tmp_path)
    Path("one.toml").write_text("[cases.one]\nz_mm = 490\nazimuth_deg = 10\ntilt_deg = -12\n")
    answer = rps_bench(command, *COMMANDS[command], "--time-limit", "3", "--output", "out")
    assert answer.status == 1 and "Traceback" not in answer.err + answer.out
    assert "\x1b" not in answer.out + answer.err
    assert not {"nasty", "wrong"} & set(sys.modules), "loaded in the command's own process"
    if command == "sweep":
        lines = (tmp_path / "out" / "failures.csv").read_text().splitlines()[1:]
    elif command == "check":
        lines = [
            line for line in answer.out.splitlines() if re.match(r" *(failure|source) +x-", line)
        ]
    else:
        lines = [line for line in answer.err.splitlines() if " failed: " in line]
    said: dict[str, list[str]] = {}
    for line in lines:
        name = re.search(r"\bx-([a-z-]+)", line)
        assert name, line
        said.setdefault(name[1], []).append(line.rstrip('" '))
    assert set(said) == set(NASTY if command == "check" else SAYS)
    silent = [name for name in said if not any(re.search(SAYS[name], one) for one in said[name])]
    assert not silent, [said[name] for name in silent]
    rows = answer.out
    if command in ("table", "reproduce"):
        rows = (tmp_path / "out" / "table1.csv").read_text()
    if command in ("table", "reproduce", "sweep"):
        assert all(one in rows for one in (*(f"x-{name}@4+8" for name in RUDE), *AFTER))
    if (tmp_path / "log").exists():  # not where all answers are known from another command
        _gone(tmp_path / "log")


def _gone(log: Path) -> None:
    """What a model started in a session of its own has ended with its process."""
    left = [int(line) for line in log.read_text().split()]
    assert left
    deadline = time.monotonic() + 300
    while any(_runs(process) for process in left):
        assert time.monotonic() < deadline
        time.sleep(0.02)


def _runs(process: int) -> bool:
    try:
        stat = Path(f"/proc/{process}/stat").read_text()
    except OSError:
        return False
    return stat.rpartition(")")[2].split()[0] != "Z"


@pytest.mark.slow
def test_what_one_package_does_to_numpy_is_its_own_affair(site: None) -> None:
    case = PRESETS["case2"]
    cable = Named("exudyn-cable", 8)
    with Bench() as bench:
        right = bench.run([case], [cable]).answers[case, cable].frequencies
    with Bench() as bench:
        # After it, in the order in which processes become free.
        study = bench.run([case], [Named("x-patches", 4), Named("x-honest", 4), cable])
        assert not study.failures
        assert (study.answers[case, cable].frequencies == right).all()
        again = bench.run([case], [Named("x-patches", 8)])
    assert "patched by somebody else" in again.failures[case, Named("x-patches", 8)]
