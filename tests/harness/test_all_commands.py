"""Every command: no digit of its tables is cut, and an output that takes nothing loses no file."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from harness.cli.main import HELP
from harness.tables import Table

pytestmark = pytest.mark.slow
ONE = ("--cases", "case1", "--modes", "1-2", "--references")
EXACT = (*ONE, "timoshenko@exact")
WRITES = "--output"
# What each is asked, and whether it writes files into --output.
COMMANDS: dict[str, tuple[tuple[str, ...], bool]] = {
    "table": (EXACT, True),
    "convergence": ((*EXACT, "--elements", "1,2"), True),
    "refine": ((*EXACT, "--elements", "1,2,4"), True),
    "budget": (EXACT, True),
    "shapes": (EXACT, True),
    "slenderness": (EXACT, True),
    "workspace": (("--modes", "1", "--layers", "490", "--grid", "12x2"), True),
    "claims": (("--only", "name-3-prs"), True),
    "identify": (("--free", "1", "--starts", "1", "--candidates", "z_mm"), True),
    "stiffness": (("--cases", "case1"), True),
    "reproduce": ((*EXACT, "--only", "table"), True),
    "accept": (("--case-file", "one.toml", "--models", "rayleigh", "--reason", "so"),
               True),
    "sweep": (("--poses", "pose:490,0,0", "--models", "rayleigh@1"), True),
    "check": (("--quick", "--models", "rayleigh", "--baseline", "none"), True),
    "history": ((), False),
    "dashboard": ((), True),
    "new": (("case", "mine"), True),
    "export": (("case1", "--to", "exudyn"), True),
    "verify": (("rayleigh",), False),
    "models": ((), False),
    "cases": ((), False),
}  # fmt: skip


def test_all_of_them_are_here() -> None:
    elsewhere = {"cost", "work-precision"}  # in tests of their own: what they time takes long
    assert set(COMMANDS) | elsewhere == set(HELP)


@pytest.fixture
def shown(monkeypatch: pytest.MonkeyPatch) -> list[Table]:
    """The tables that a command shows."""
    tables: list[Table] = []
    right = Table.terminal

    def terminal(table: Table, *width: Any) -> Any:
        tables.append(table)
        return right(table, *width)

    monkeypatch.setattr(Table, "terminal", terminal)
    return tables


@pytest.mark.parametrize("name", COMMANDS)
def test_whole_digits_and_outputs_that_take_nothing(
    rps_bench: Callable[..., Any],
    unheard: Callable[..., tuple[int, str]],
    shown: list[Table],
    whole: Callable[[Table], None],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    name: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RPS_BENCH_HISTORY", "past")
    Path("one.toml").write_text("[cases.one]\nz_mm = 490\nazimuth_deg = 10\ntilt_deg = -12\n")
    if name in ("dashboard", "history"):
        assert rps_bench("reproduce", *COMMANDS["reproduce"][0], WRITES, "run").status == 0
    asked, writes = COMMANDS[name]
    answer = rps_bench(name, *asked, *_folder(name, "seen", writes))
    assert "Traceback" not in answer.err and answer.status in (0, 1), answer.err
    for table in tuple(shown):
        whole(table)
    for how in ("pipe", "full"):
        Path("one.toml").touch()
        status, err = unheard(how, name, *asked, *_folder(name, how, writes))
        assert status in {"pipe": (0, answer.status), "full": (1,)}[how], err
        assert not writes or _names(how) == _names("seen")
    if name in ("table", "check", "sweep", "reproduce"):  # each of the three is a run
        assert len(list(Path("past").glob("*.parquet"))) == 3


def _folder(name: str, folder: str, writes: bool) -> tuple[str, ...]:
    if name == "dashboard":
        return (WRITES, f"{folder}/page.html", "--results", "run")
    if name == "accept":
        return ("--baseline", folder)
    return (WRITES, folder) if writes else ()


def _names(folder: str) -> set[str]:
    """The files that a command has written, at least one."""
    found = {path.name for path in Path(folder).iterdir()}
    assert found
    return found
