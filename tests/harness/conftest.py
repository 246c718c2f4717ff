"""The command line as a person runs it, in this process."""

import io
import os
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
from harness.studies import find
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
def unheard(monkeypatch: pytest.MonkeyPatch) -> Callable[..., tuple[int, str]]:
    """Runs a command whose standard output is a "pipe" that nobody reads, or a "full" device.

    Returns its status and what it said; checks that it says nothing of a pipe, but of the other.
    """

    def run(how: str, *arguments: str) -> tuple[int, str]:
        if how == "pipe":
            reader, writer = os.pipe()
            os.close(reader)
        else:
            writer = os.open("/dev/full", os.O_WRONLY)
        err = io.StringIO()
        with monkeypatch.context() as patched, os.fdopen(writer, "w") as out:
            patched.setattr(sys, "argv", ["rps-bench", *arguments])
            patched.setattr(sys, "stdout", out)
            patched.setattr(sys, "stderr", err)
            with pytest.raises(SystemExit) as ended:
                main()
        assert isinstance(ended.value.code, int)
        said = err.getvalue()
        assert "Traceback" not in said and ("cannot show more" in said) == (how == "full"), said
        return ended.value.code, said

    return run


@pytest.fixture
def writes_first(
    unheard: Callable[..., tuple[int, str]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Callable[[str, object], None]:
    """Checks that a study whose output nobody reads writes all files and the history.

    Its result is taken as given: that of the module's other tests.
    """

    def check(name: str, result: object) -> None:
        monkeypatch.setattr(find(name).load(), "run", lambda *_: result)
        monkeypatch.setenv("RPS_BENCH_HISTORY", str(tmp_path / "past"))
        status, said = unheard("pipe", name, "--output", str(tmp_path / "out"))
        assert status == 0, said
        names = {path.name for path in (tmp_path / "out").iterdir()}
        assert {f"{name}-data.csv", f"{name}.svg"} <= names
        assert len(list((tmp_path / "past").glob("*.parquet"))) == 1

    return check


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
