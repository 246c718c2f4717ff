"""The command line as a person runs it, in this process."""

import io
import shutil
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from rich.console import Console

from harness import plugins
from harness.cli.main import main
from harness.tables import Number, Table


@dataclass(frozen=True)
class Answer:
    """What a command ended with and printed."""

    status: int
    out: str
    err: str


@pytest.fixture
def rps_bench(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., Answer]:
    def run(*arguments: str) -> Answer:
        monkeypatch.setattr(sys, "argv", ["rps-bench", *arguments])
        capsys.readouterr()
        plugins.close()  # a command is a process of its own: it knows nothing yet
        with pytest.raises(SystemExit) as ended:
            main()
        captured = capsys.readouterr()
        code = ended.value.code
        assert isinstance(code, int)
        return Answer(code, captured.out, captured.err)

    return run


@pytest.fixture
def installed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Callable[[dict[str, str]], None]]:
    """Returns what installs models of tests/plugin for this process and those it starts."""
    site = tmp_path / "site"

    def install(points: dict[str, str]) -> None:
        shutil.copytree(Path(__file__).parents[1] / "plugin", site)
        about = site / "wrong-1.dist-info"
        about.mkdir()
        (about / "METADATA").write_text("Metadata-Version: 2.1\nName: wrong\nVersion: 1\n")
        lines = "".join(f"{name} = {where}\n" for name, where in points.items())
        (about / "entry_points.txt").write_text(f"[rps_bench.reference_models]\n{lines}")
        monkeypatch.setenv("PYTHONPATH", str(site))
        monkeypatch.syspath_prepend(site)

    yield install
    for module in ("wrong", "nasty"):
        sys.modules.pop(module, None)


@pytest.fixture
def plugin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Install the reference model `trial` for this process and those it starts."""
    site = tmp_path / "site"
    about = site / "trial-1.dist-info"
    about.mkdir(parents=True)
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: trial\nVersion: 1\n")
    (about / "entry_points.txt").write_text("[rps_bench.reference_models]\ntrial = trial:Trial\n")
    shutil.copy(Path(__file__).with_name("plugin") / "trial.py", site)
    monkeypatch.setenv("PYTHONPATH", str(site))
    monkeypatch.syspath_prepend(site)


WIDTHS = (60, 80, 120)


@pytest.fixture(scope="session")
def whole() -> Callable[[Table], None]:
    """Check that a terminal of any usual width shows every number of a table."""

    def check(table: Table) -> None:
        for width in WIDTHS:
            _whole(table, width)

    return check


def _whole(table: Table, width: int) -> None:
    """Every number of a table stands in what a terminal of so many characters shows."""
    out = io.StringIO()
    Console(file=out, width=width, highlight=False, markup=False).print(table.terminal(width))
    assert max(map(len, out.getvalue().splitlines())) <= width, table.title
    seen = Counter(out.getvalue().split())
    numbers = Counter(
        str(cell) for row in table.rows for cell in row if isinstance(cell, (int, Number))
    )
    cut = {n: (times, seen[n]) for n, times in numbers.items() if seen[n] < times}
    assert not cut, (table.title, cut)
