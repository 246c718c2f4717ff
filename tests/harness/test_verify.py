"""`rps-bench verify` and the fixture: a right model passes, every wrong one hears what is wrong."""

import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from analytic import InputError
from harness.bench import Bench
from harness.verify import verify

pytestmark = pytest.mark.slow
ROOT = Path(__file__).parents[2]
SITE = ROOT / "tests" / "plugin"
WRONG = {
    "wrong:Kilohertz": r"believed: .*is it in hertz\?",
    "wrong:Radians": r"is it in hertz\?",
    "wrong:Percent": "not of the theory that it declares",
    "wrong:Missing": "a mode is missing",
    "wrong:Large": "has a modal mass of 1e.06, where 1 was expected",
    "wrong:Gap": "its joints are open by 1.0e-03 m",
    "wrong:Raises": "ValueError: a bug",
    "wrong:NoElements": "runs here: it takes no elements",
    "unimportable:Model": "it cannot be imported",
    "subtle:Slipped": "limbs leave the platform's points",
    "subtle:Lopsided": r"axes turned by 57.3 deg: .*off by \S+e-07",
    "subtle:Metres": r"lengths in mm: .*off by \S+e-05",
    "subtle:Split": r"f1 = f2 of the level platform .*: f2/f1 - 1 is 1.0e-07",
    "subtle:Twice": r"no two modes are one: modes 1 and 2 of x-twice@\S+ at case1 are one shape",
    "subtle:Rude": "no modes .count=0.: ZeroDivisionError: .*raise analytic.InputError",
    "subtle:SecondOrder": "order of convergence .*observed [34].*, declared 2",
    "subtle:Backwards": "version is empty; its ladder .8, 4. does not ascend",
}


def name_of(where: str) -> str:
    words = re.sub(r"(?<!^)([A-Z])", r"-\1", where.partition(":")[2])
    return f"x-{'unimportable' if words == 'Model' else words.lower()}"


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    """The wrong models, installed for this process and those it starts."""
    site = tmp_path_factory.mktemp("verify") / "site"
    shutil.copytree(SITE, site)
    about = site / "wrong-2.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: wrong\nVersion: 2\n")
    lines = "".join(f"{name_of(one)} = {one}\n" for one in ("wrong:Honest", *WRONG))
    (about / "entry_points.txt").write_text(f"[rps_bench.reference_models]\n{lines}")
    with pytest.MonkeyPatch.context() as patch, Bench() as own:
        patch.syspath_prepend(site)
        yield own
    for module in ("wrong", "subtle"):
        sys.modules.pop(module, None)


def test_a_right_model_passes(bench: Bench) -> None:
    found = verify("x-honest", bench)
    assert found.passed and not found.failures(), found.failures()
    assert found.sentences() == [f"x-honest: all {len(found.answers)} hold."]
    asked = " ".join(one.question for one in found.answers)
    for what in ("mm", "mass unit", "symmetry", "exact", "order", "f1 = f2", "count", "refused"):
        assert what in asked
    assert len(found.to_frame()) == len(found.table().rows) == len(found.answers)


@pytest.mark.parametrize("where", list(WRONG))
def test_a_wrong_model_is_told(bench: Bench, where: str) -> None:
    found = verify(name_of(where), bench)
    assert not found.passed
    said = [f"{question}: {why}" for question, why in found.failures().items()]
    assert any(re.search(WRONG[where], line) for line in said), said


def test_an_unknown_name() -> None:
    with pytest.raises(InputError, match=r"model = 'exudyn-cabel': .*did you mean exudyn-cable"):
        verify("exudyn-cabel")


def text_of(page: str, language: str) -> list[str]:
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    return re.findall(rf"```{language}[^\n]*\n(.*?)```", text, re.DOTALL)


def test_the_example_of_the_docs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rps_bench: Callable[..., Any]
) -> None:
    """As it stands: packed, installed, verified by the command and by its own test."""
    model, test = text_of("how-to/own-simulator.md", "python")
    (project,) = text_of("how-to/own-simulator.md", "toml")
    source, site = tmp_path / "lumped", tmp_path / "site"
    source.mkdir()
    for name, text in (("lumped.py", model), ("pyproject.toml", project), ("test_lumped.py", test)):
        (source / name).write_text(text)
    build = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path)]
    subprocess.run(build, cwd=source, check=True, capture_output=True)
    with zipfile.ZipFile(next(tmp_path.glob("*.whl"))) as wheel:
        wheel.extractall(site)
    monkeypatch.setenv("PYTHONPATH", str(site))
    monkeypatch.syspath_prepend(site)
    said = rps_bench("verify", "lumped")
    assert said.status == 0, said.err
    assert "lumped: all 20 hold." in said.out
    ran = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "test_lumped.py"],
        cwd=source, capture_output=True, text=True,
    )  # fmt: skip
    assert ran.returncode == 0 and "1 passed" in ran.stdout, ran.stdout + ran.stderr


def test_the_fixture_fails_with_the_sentences(bench: Bench, tmp_path: Path) -> None:
    file = tmp_path / "test_mine.py"
    file.write_text("def test(verify_model):\n    verify_model('x-kilohertz')\n")
    site = next(path for path in sys.path if path.endswith("/site"))
    ran = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(file)],
        cwd=tmp_path, capture_output=True, text=True, env={"PYTHONPATH": site, "PATH": ""},
    )  # fmt: skip
    assert ran.returncode == 1 and "is it in hertz?" in ran.stdout, ran.stdout + ran.stderr
