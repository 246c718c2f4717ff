"""What a plug-in does while it is imported, or says what it is, costs nobody else anything."""

import re
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from harness import plugins
from harness.cli import flags
from reference_models import catalogue

pytestmark = pytest.mark.slow
ACTS = ("crash", "hang", "quit", "exit", "fill", "shout")
ENDS = {
    "crash": "its process was ended by SIGSEGV",
    "hang": "gave no answer within the time limit of 4 s",
    "quit": "its process ended by itself with status 0",
    "exit": "SystemExit: 0",
    "fill": "MemoryError",
}
SAYS = {f"imported-{act}": f"it cannot be imported.*{why}" for act, why in ENDS.items()} | {
    f"asked-{act}": why for act, why in ENDS.items()
}
RIGHT = ("imported-shout@4+8", "asked-shout@4+8", "exudyn-cable@8")
ALL = ",".join([*SAYS, *RIGHT])
POSE = ("--cases", "case2", "--modes", "1-2")
COMMANDS = {
    "table": (*POSE, "--references", ALL, "--output", "out"),
    "refine": (*POSE, "--references", ALL, "--elements", "2,4,8", "--output", "out"),
    "sweep": ("--poses", "pose:490,10,-12", "--models", ALL, "--cores", "1", "--output", "out"),
    "check": ("--quick", "--baseline", "none", "--models", ",".join([*SAYS, "imported-shout"])),
    "reproduce": ("--only", "table", *POSE, "--references", ALL, "--output", "out"),
}


@pytest.fixture(scope="module")
def patience() -> Iterator[None]:
    """What hangs is waited for once: what is known of a package stays from test to test."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(plugins, "PATIENCE", 4.0)
        yield
    plugins.close()


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory, patience: None) -> Iterator[None]:
    folder = tmp_path_factory.mktemp("rough")
    source = Path(__file__).parents[1] / "plugin"
    for name in ("wrong", "rough"):
        (folder / f"{name}.py").write_text((source / f"{name}.py").read_text())
    lines = []
    for act in ACTS:
        text = f"from rough import ACTS\nACTS[{act!r}]()\nfrom wrong import Honest\n"
        (folder / f"import_{act}.py").write_text(text)
        lines += [f"imported-{act} = import_{act}:Honest", f"asked-{act} = rough:{act.title()}"]
    about = folder / "rough-1.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: rough\nVersion: 1\n")
    text = "\n".join(["[rps_bench.reference_models]", *lines, ""])
    (about / "entry_points.txt").write_text(text)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder)
        patch.setenv("PYTHONPATH", str(folder))
        plugins.close()
        patch.setattr(plugins, "close", lambda: None)
        yield
    known = {"wrong", "rough", *(f"import_{act}" for act in ACTS)}
    assert not known & set(sys.modules), "loaded in the command's own process"


def lines_about(name: str, text: str) -> str:
    return " ".join(line for line in text.splitlines() if re.search(rf"\b{name}\b", line))


@pytest.mark.parametrize("command", COMMANDS)
def test_each_is_a_sentence_and_the_others_answer(
    rps_bench: Callable[..., Any],
    site: None,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    command: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    answer = rps_bench(command, *COMMANDS[command])
    said = answer.err + answer.out
    assert answer.status == 1 and "Traceback" not in said and "noise" not in said, said
    if command == "sweep":
        said = (tmp_path / "out" / "failures.csv").read_text()
    for name, why in SAYS.items():
        assert re.search(why, lines_about(name, said)), (name, said)
    if command == "check":
        assert f"failed: {len(SAYS)} x source; " in answer.out  # and nothing else
        return
    out = answer.out
    if command == "reproduce":
        out = (tmp_path / "out" / "table1.csv").read_text()
    for name in RIGHT:
        assert (name.partition("@")[0] if command == "refine" else name) in out


def test_lists_and_names(rps_bench: Callable[..., Any], site: None) -> None:
    infos = dict(catalogue())
    for name, why in SAYS.items():
        assert re.search(why, infos[name].missing) and "\n" not in infos[name].missing
    for act in ("imported-shout", "asked-shout"):
        assert infos[act].theory == "Euler-Bernoulli" and not infos[act].missing
    answer = rps_bench("models")
    assert answer.status == 0 and "asked-crash" in answer.out and "noise" not in answer.out
    assert {*SAYS} <= {*flags.known_names("models", None)}
    meant = rps_bench("table", "--references", "asked-shut")
    assert meant.status == 2 and "did you mean asked-shout?" in meant.err


@pytest.mark.parametrize("name", SAYS)
def test_verify(rps_bench: Callable[..., Any], site: None, name: str) -> None:
    answer = rps_bench("verify", name)
    assert answer.status == 1 and re.search(SAYS[name], answer.err), answer.err
