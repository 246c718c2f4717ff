"""The command line: one sentence for bad input, nothing loaded for help, nothing half-written."""

import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from harness.bench import Bench
from harness.cli.main import HELP
from harness.studies import STUDIES

PROGRAM = [sys.executable, "-P", "-c", "from harness.cli.main import main; main()"]
START = Path(__file__).parents[2]

# What is typed, and what the sentence must name: argument, value, expectation.
COMMANDS = [
    (["table", "--cases", "case9"], "--cases", "'case9'", "case1"),
    (["table", "--cases", "case-2"], "--cases", "'case-2'", "did you mean case2?"),
    (["reproduce", "--only", "tabel"], "--only", "'tabel'", "did you mean table?"),
    (["table", "--cases", "case1,,case2"], "--cases", "'case1,,case2'", "separated by commas"),
    (["table", "--cases", ""], "--cases", "''", "names"),
    (["table", "--references", "ansys"], "--references", "'ansys'", "exudyn-beam"),
    (["table", "--references", "exudyn-bean"], "--references", "'exudyn-bean'",
     "did you mean exudyn-beam?"),
    (["table", "--references", "exudyn-beam@0"], "--references", "exudyn-beam@0", "elements as in"),
    (["table", "--references", "exudyn-beam@24+12"], "--references", "24+12", "elements as in"),
    (["table", "--references", "exudyn-beam@exact"], "--references", "@exact", "elements as in"),
    (["table", "--references", "exudyn-cable@1.5"], "--references", "1.5", "elements as in"),
    (["table", "--references", ""], "--references", "''", "names"),
    (["table", "--model", "euler@3"], "--model", "euler", "one of"),
    (["table", "--model", "timoshenko@x"], "--model", "'timoshenko@x'", "elements as in"),
    (["table", "--modes", "0"], "--modes", "'0'", "whole numbers"),
    (["table", "--modes", "six"], "--modes", "'six'", "whole numbers"),
    (["table", "--modes", "3-1"], "--modes", "'3-1'", "whole numbers"),
    (["table", "--modes", "1-"], "--modes", "'1-'", "whole numbers"),
    (["table", "--modes", "101"], "--modes", "'101'", "1 to 100"),
    (["table", "--elements", "-3"], "--elements", "'-3'", "whole numbers"),
    (["table", "--case-file", "missing.toml"], "--case-file", "missing.toml", "readable file"),
    (["table", "--output", ""], "--output", "''", "the name of a folder"),
    (["table", "--history", ""], "--history", "''", "the name of a folder"),
    (["table", "--history", __file__], "--history", "test_cli.py'", "the name of a folder"),
    (["table", "--time-limit", "-1"], "--time-limit", "-1", "x>0"),
    (["table", "--colour", "red"], "--colour", "", "No such option"),
    (["table", "--cases"], "--cases", "", "requires an argument"),
    (["convergence", "--elements", "1,two"], "--elements", "'1,two'", "whole numbers"),
    (["convergence", "--elements", "1000000"], "--elements", "'1000000'", "1 to 512"),
    (["convergence", "--shear", "big"], "--shear", "'big'", "cowper"),
    (["convergence", "--shear", "-1"], "--shear", "'-1'", "positive"),
    (["convergence", "--shear", "nan"], "--shear", "'nan'", "positive"),
    (["refine", "--elements", "2,4"], "--elements", "'2,4'", "three numbers at least"),
    (["budget", "--modes", "x"], "--modes", "'x'", "whole numbers"),
    (["slenderness", "--references", "ansys"], "--references", "'ansys'", "calculix-solid"),
    (["slenderness", "--model", "rayleigh"], "--model", "", "No such option"),
    (["shapes", "--cases", "case9"], "--cases", "'case9'", "case1"),
    (["reproduce", "--only", "table9"], "--only", "'table9'", "one of table"),
    (["tabel"], "tabel", "", "did you mean table?"),
    (["xyzzy"], "xyzzy", "", "rps-bench --help"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("arguments", "argument", "value", "expected"), COMMANDS, ids=[" ".join(c[0]) for c in COMMANDS]
)
def test_bad_input_is_one_sentence(
    rps_bench: Callable[..., Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    arguments: list[str],
    argument: str,
    value: str,
    expected: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(Bench, "run", None)  # nothing is solved before it is refused
    if "--output" not in arguments and len(arguments) > 2:
        arguments = [*arguments, "--output", "out"]
    answer = rps_bench(*arguments)
    assert answer.status == 2
    assert answer.out == "" and answer.err.startswith("rps-bench: ")
    assert answer.err.count("\n") == 1, answer.err
    for part in (argument, value, expected):
        assert part in answer.err
    assert not list(tmp_path.iterdir()), "nothing half-written"


@pytest.mark.parametrize("kind", ["file", "link to a file", "device"])
def test_output_that_is_no_folder_is_refused_before_anything_is_solved(
    rps_bench: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str
) -> None:
    monkeypatch.setattr(Bench, "run", None)
    there = tmp_path / "there"
    there.write_text("mine")
    if kind == "link to a file":
        (tmp_path / "link").symlink_to(there)
    target = {"file": there, "link to a file": tmp_path / "link", "device": Path("/dev/null")}[kind]
    answer = rps_bench("table", "--output", str(target))
    assert answer.status == 2 and "--output" in answer.err and "folder" in answer.err
    assert there.read_text() == "mine" and target.exists()


def call(*arguments: str, **more: Any) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [*PROGRAM, *arguments], capture_output=True, text=True,
        env=os.environ | {"PYTHONPATH": str(START)}, **more,
    )  # fmt: skip


@pytest.mark.parametrize("arguments", [["--help"], ["--version"], [], ["table", "--help"],
                                       ["reproduce", "--help"], ["tabel"]])  # fmt: skip
def test_nothing_heavy_is_loaded_for_help(arguments: list[str]) -> None:
    """A study says what it takes when its module is loaded: that needs numpy, and no more."""
    heavy = ["pandas", "matplotlib", "duckdb", "scipy.optimize", "exudyn", "mujoco", "ngsolve"]
    if "table" not in arguments:
        heavy.append("numpy")
    code = (
        "import sys, atexit\n"
        f"loaded = lambda: [m for m in {heavy} if m in sys.modules]\n"
        "atexit.register(lambda: print(loaded(), file=sys.stderr))\n"
        f"sys.argv = ['rps-bench', *{arguments!r}]\n"
        "from harness.cli.main import main\n"
        "main()\n"
    )
    ended = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True,
                           env=os.environ | {"PYTHONPATH": str(START)})  # fmt: skip
    assert ended.stderr.splitlines()[-1] == "[]", ended.stderr
    if arguments != ["tabel"]:
        assert ended.returncode == 0 and ended.stdout


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("rps-bench tab", ["table"]),
        ("rps-bench table --cases case1,case2-z-f", ["case1,case2-z-fitted"]),
        ("rps-bench table --references usual,exudyn-b", ["usual,exudyn-beam"]),
        ("rps-bench sweep --models mujoco-ca", ["mujoco-cable"]),
        ("rps-bench reproduce --only table,bud", ["table,budget"]),
        ("rps-bench table --case-file mine.toml --cases lo", ["low"]),
    ],
)
def test_the_shell_completes_names(tmp_path: Path, typed: str, meant: list[str]) -> None:
    (tmp_path / "mine.toml").write_text("[cases.low]\nz_mm = 400\n")
    words = {"COMP_WORDS": typed, "COMP_CWORD": str(len(typed.split()) - 1),
             "_RPS_BENCH_COMPLETE": "bash_complete"}  # fmt: skip
    code = "import sys; sys.argv = ['rps-bench']; " + PROGRAM[-1]
    ended = subprocess.run(
        [*PROGRAM[:-1], code], capture_output=True, text=True, cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(START), **words},
    )  # fmt: skip
    assert [line.partition(",")[2] for line in ended.stdout.splitlines()] == meant, ended.stderr


def test_a_bar_says_what_runs_and_of_what_it_is_a_part() -> None:
    from harness.cli.terminal import Bar

    with Bar() as bar:
        bar.parts(40)
        bar.part("2 of 11, Error budget")
        bar.expect(4)
        bar.begin("exudyn-beam at case1")
        steps, parts = bar._bar.tasks
        assert parts.description == "2 of 11, Error budget"
        assert steps.description == "exudyn-beam at case1"
        bar.done("exudyn-beam at case1")
        assert (steps.completed, steps.total) == (1, 4)
        bar.finished(3)
        assert (parts.completed, parts.total) == (3, 40)


def test_first_lines_of_help_are_whole_sentences() -> None:
    for name, said in HELP.items():
        assert re.fullmatch(r"[A-Z][^\n]*[.]", said), name


def test_help_lists_every_study() -> None:
    said = call("--help").stdout
    for entry in STUDIES:
        assert re.search(rf"^  {entry.name} ", said, re.MULTILINE), entry.name


@pytest.mark.parametrize("arguments", ["cases", "table --references rayleigh@exact"])
def test_a_pipe_that_closes_early_is_no_error(arguments: str) -> None:
    ended = subprocess.run(
        f"{{ {sys.executable} -P -c '{PROGRAM[-1]}' {arguments}; echo $? >&2; }} | head -n 1",
        shell=True, capture_output=True, text=True, env=os.environ | {"PYTHONPATH": str(START)},
    )  # fmt: skip
    assert ended.stderr.strip() == "0"
    assert ended.stdout.count("\n") == 1


def test_what_is_shown_is_what_is_written(rps_bench: Callable[..., Any], tmp_path: Path) -> None:
    answer = rps_bench("table", "--cases", "case2", "--references", "timoshenko@exact",
                       "--output", str(tmp_path))  # fmt: skip
    assert answer.status == 0
    names = {path.name for path in tmp_path.iterdir()}
    assert {"table1.csv", "table1.md", "table1.tex", "table1-data.csv"} <= names
    for name in names:
        assert f"wrote {tmp_path / name}" in answer.out
    assert "123.007" in answer.out and "123.007" in (tmp_path / "table1.csv").read_text()
    assert "erratum height" in answer.out


def test_a_cases_name_reaches_the_terminal_escaped(
    rps_bench: Callable[..., Any], tmp_path: Path
) -> None:
    file = tmp_path / "mine.toml"
    file.write_text('[cases."\\u001b[31mred"]\nz_mm = 490\n')
    answer = rps_bench("table", "--case-file", str(file), "--references", "rayleigh@exact")
    assert "\x1b" not in answer.out + answer.err


def test_what_is_shown_nowhere_is_written_all_the_same(tmp_path: Path) -> None:
    """A closed or full standard output, and letters that the terminal does not have."""
    (tmp_path / "mine.toml").write_text(
        '[cases."=größe"]\nz_mm = 490\n', encoding="utf-8"
    )  # fmt: skip
    asked = "table --case-file mine.toml --references rayleigh@exact --output"
    plain = os.environ | {"PYTHONPATH": str(START), "LC_ALL": "C", "PYTHONUTF8": "0"}
    for name, how, status in (("closed", ">&-", 0), ("full", ">/dev/full", 1), ("c", "| cat", 0)):
        ended = subprocess.run(
            ["bash", "-o", "pipefail", "-c",
             f"{sys.executable} -P -c '{PROGRAM[-1]}' {asked} {name} {how}"],
            capture_output=True, text=True, cwd=tmp_path,
            env=plain | {"PYTHONCOERCECLOCALE": "0"},
        )  # fmt: skip
        said = "rps-bench: cannot show more: the standard output takes nothing (No space left on"
        assert ended.returncode == status, ended.stderr
        assert ended.stderr.startswith(said) if name == "full" else ended.stderr == ""
        for file in ("table1.csv", "table1-data.csv"):
            text = (tmp_path / name / file).read_text(encoding="utf-8")
            assert "'=größe" in text and not re.search("^=|,=", text, re.MULTILINE)
