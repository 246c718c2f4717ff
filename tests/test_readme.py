"""What the README shows is what the commands print."""

import csv
import re
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from analytic import Mechanism, Pose
from harness.options import STAND_IN
from reference_models import reference

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()


def test_the_table_is_the_accepted_one() -> None:
    accepted = (ROOT / "results" / "table1.md").read_text()
    table = "\n".join(line for line in accepted.splitlines() if line.startswith("|"))
    assert table in README


def sentences(heading: str) -> list[str]:
    """Return the bullets of README under the line that starts with `heading`, each on one line."""
    _, _, below = README.partition(f"\n{heading}")
    block = below.partition("\n\n")[2].partition("\n\n")[0]
    return [" ".join(bullet.split()) for bullet in re.split(r"^- ", block, flags=re.MULTILINE)[1:]]


def parted(sentence: str) -> tuple[str, list[float]]:
    """Return the words of `sentence`, each number a sign, and the numbers."""
    number = r"(?<![\w@.])[+-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w@])"
    return re.sub(number, "#", sentence), [float(n) for n in re.findall(number, sentence)]


def test_the_summary_is_what_reproduce_says() -> None:
    """Word for word, and number for number but for seconds: every one of them is computed.

    Two percent for another machine's last digit, as results/ may have been made anew there.
    """
    lines = (ROOT / "results" / "summary.md").read_text().splitlines()
    said = dict(parted(line.removeprefix("- ")) for line in lines)
    for heading, fewest, timed in (("In plain words", 6, False), ("What a pose costs", 2, True)):
        quoted = sentences(heading)
        assert len(quoted) >= fewest
        for words, numbers in map(parted, quoted):
            assert words in said
            if not timed:
                np.testing.assert_allclose(numbers, said[words], rtol=0.02, atol=1e-9)


def test_links_lead_somewhere() -> None:
    for target in re.findall(r"\]\((?!https?:)([^)#]+)\)", README):
        assert (ROOT / target).exists(), target


def test_the_python_example_runs() -> None:
    (example,) = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)
    exec(compile(example, "README.md", "exec"), {})


def test_the_sweep_from_python_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """With fewer poses than the page has, which take a simulator some seconds."""
    page = (ROOT / "docs" / "sweeps.md").read_text()
    (example,) = re.findall(r"```python\n(.*?)```", page, flags=re.DOTALL)
    assert "random:1000:7" in example
    monkeypatch.chdir(tmp_path)
    exec(compile(example.replace("1000", "3"), "sweeps.md", "exec"), {})
    assert capsys.readouterr().out == "4 {}\n"  # one block of the theory, three poses
    assert pl.read_parquet(tmp_path / "out/python/frequencies.parquet").height == 2 * 3 * 6


def test_the_accepted_results_are_still_what_comes_out(case1: Pose, case2: Pose) -> None:
    with (ROOT / "results" / "frequencies.csv").open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["model"].startswith(f"{STAND_IN}@12+24")]
    model = reference(STAND_IN, elements=(12, 24))
    for name, pose in (("case1", case1), ("case2", case2)):
        accepted = [float(row["frequency_hz"]) for row in rows if row["case"] == name]
        found = model.modes(Mechanism.paper(), pose).frequencies
        np.testing.assert_allclose(found, accepted, rtol=1e-8)
