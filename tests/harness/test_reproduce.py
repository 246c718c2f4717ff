"""The main job's sections stand alone, fail alone, and make one summary together."""

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
import numpy as np
import pytest

from analytic import Mechanism, Pose
from harness.cases import PRESETS
from harness.cli import cli
from harness.files import write_all
from harness.history.store import open_history
from harness.models import Spec
from harness.options import takes_history
from harness.reproduce import Part, Plan, Section, chosen, page, reproduce
from harness.run import Study, rows, run
from harness.sections import SECTIONS, _command
from harness.terminal import finish
from reference_models import ModelError, UnavailableError
from reference_models.exudyn_cable import ExudynCable

PLAN = Plan(
    (PRESETS["case1"],), Spec("euler-bernoulli", 3), (Spec("exudyn-cable", 4),), (1, 2), (1,)
)


def section(name: str, make: Callable[..., Part]) -> Section:
    return Section(name, f"About {name}", f"rps-bench {name}", lambda _: 1, make)


def test_a_section_that_fails_costs_no_other() -> None:
    def broken(*_: object) -> Part:
        raise UnavailableError("no CalculiX; apt-get install calculix-ccx")

    def good(*_: object) -> Part:
        return Part({"b.md": b"table"}, ["It is 3 %."])

    made = list(reproduce([section("a", broken), section("b", good)], PLAN))
    (_, failed), (_, written) = made
    assert failed.failures == {("About a", "a"): "no CalculiX; apt-get install calculix-ccx"}
    assert "Not made: no CalculiX" in failed.sentences[0] and not failed.files
    assert written.files == {"b.md": b"table"} and not written.failures


def test_the_summary_keeps_what_is_not_made_anew() -> None:
    sections = [section(name, lambda *_: Part({}, [])) for name in "abc"]

    def said(text: str, name: str = "x") -> Part:
        return Part({f"{name}.md": b"", f"{name}.svg": b"", f"{name}.csv": b""}, [text])

    text = ""
    for index, words in ((2, "third"), (0, "first"), (1, "second"), (0, "first again")):
        text = page(sections, text, sections[index], said(words))
    lines = [line for line in text.splitlines() if line.startswith("- ")]
    assert lines == ["- first again", "- second", "- third"]
    assert text.count("# Summary") == 1 and text.count("[x](x.md)") == 3
    assert text.count("![x](x.svg)") == 3 and "[x.csv]" not in text
    assert page(sections, text, sections[0], said("first again")) == text


def test_sections_are_chosen_by_name() -> None:
    assert [s.name for s in chosen(SECTIONS, ["budget", "table1"])] == ["table1", "budget"]
    assert chosen(SECTIONS, None) == list(SECTIONS)
    titles = [s.title for s in SECTIONS]
    assert len(set(titles)) == len(titles)


def test_only_names_a_section(rps_bench: Callable[..., Any]) -> None:
    answer = rps_bench("reproduce", "--only", "table9")
    assert answer.status == 2
    assert "--only = 'table9': expected some of table1" in answer.err


def test_a_failure_is_said_once(
    rps_bench: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One section tells of it by its study, the next, which times the same model, by itself."""
    key, why = ("case1", "exudyn-cable@4"), "exudyn-cable: no solution"
    study = Study((PRESETS["case1"],), (), 6, {}, {key: why})
    parts = [
        Part({}, [], studies=(study,)),
        Part({}, [], failures={key: why, ("case1", "b"): "b: none"}),
    ]
    made = [
        section(name, lambda *_, part=part: part) for name, part in zip("ab", parts, strict=True)
    ]
    monkeypatch.setattr("harness.sections.SECTIONS", made)
    answer = rps_bench("reproduce", "--output", str(tmp_path))
    assert answer.status == 1
    assert answer.err.count(why) == answer.err.count("b: none") == 1


@click.command()
@click.option("--output")
@takes_history
def again(output: str, history: Path | None) -> int:
    """A command that solves what another section solves too, and something else."""
    study = run([PRESETS["case1"]], [Spec("rayleigh", 1)], 2)
    write_all(Path(output), {"again.md": b"table"})
    return finish(history, study, more=[row | {"case": "map"} for row in rows(study)])


@pytest.mark.parametrize("place", ["option", "environment", "none"])
def test_rows_of_a_command_are_of_the_run_that_it_is_part_of(
    rps_bench: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, place: str
) -> None:
    """One run, where `reproduce` was told to keep it, or none; nothing twice, nothing elsewhere."""

    def first(*_: object) -> Part:
        return Part({}, [], (run([PRESETS["case1"]], [Spec("rayleigh", 1)], 2),))

    command = _command(__name__, "again", lambda *_: [], under="below/")
    monkeypatch.setattr("harness.sections.SECTIONS", [section("a", first), section("b", command)])
    monkeypatch.chdir(tmp_path)
    typed = ["reproduce", "--only", "a,b"]
    if place == "environment":
        monkeypatch.setenv("RPS_BENCH_HISTORY", "kept")
    elif place == "option":
        monkeypatch.setenv("RPS_BENCH_HISTORY", "other")
        typed += ["--history", "kept"]
    else:
        monkeypatch.setenv("RPS_BENCH_HISTORY", "other")
        typed += ["--history", "none"]
    assert rps_bench(*typed).status == 0
    assert (tmp_path / "results" / "below" / "again.md").read_bytes() == b"table"
    if place == "none":
        assert [path.name for path in tmp_path.iterdir()] == ["results"]
        return
    assert {path.name for path in tmp_path.iterdir()} == {"results", "kept"}
    found = open_history(tmp_path / "kept").query(
        'SELECT run, command, "case", mode, frequency_hz FROM rows ORDER BY "case", mode'
    )
    assert found["run"].n_unique() == 1
    assert set(found["command"]) == {"rps-bench reproduce --only a,b"}
    assert found["case"].to_list() == ["case1", "case1", "map", "map"]
    assert found["mode"].to_list() == [1, 2, 1, 2]
    wanted = Spec("rayleigh", 1).build().modes(Mechanism.paper(), Pose(0.49), 2).frequencies
    np.testing.assert_allclose(found["frequency_hz"], [*wanted, *wanted], rtol=1e-12)


def test_what_a_section_is_alone_keeps_a_history_too() -> None:
    for one in SECTIONS:
        command = cli.get_command(click.Context(cli), one.command.split()[1])
        assert command is not None
        assert "history" in {option.name for option in command.params}, one.name


@pytest.mark.slow
def test_progress_counts_every_step() -> None:
    for one in SECTIONS:
        if one.name in ("table1", "provenance", "convergence", "refinement"):
            done: list[str] = []
            list(reproduce([one], PLAN, done.append))
            assert len(done) == one.steps(PLAN), one.name


@pytest.mark.slow
def test_parts_are_written_one_by_one(
    rps_bench: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    few = ("--references", "exudyn-cable@4", "--cases", "case1,case2", "--elements", "1,2,4")
    answer = rps_bench(
        "reproduce", "--only", "table1,provenance,convergence,refinement", *few,
        "--output", str(tmp_path),
    )  # fmt: skip
    assert answer.status == 0
    assert "0 of the 12 printed theoretical values agree with euler-bernoulli@3" in answer.out
    names = {path.name for path in tmp_path.iterdir()}
    for stem in (
        "table1",
        "references",
        "readings",
        "errata",
        "provenance",
        "fig3",
        "fig3-verification",
        "discretisation",
        "discretisation-verification",
        "discretisation-order",
        "refinement-rayleigh",
        "refinement-exudyn-cable",
    ):
        assert {f"{stem}.csv", f"{stem}.md", f"{stem}.tex"} <= names, stem
    with (tmp_path / "frequencies.csv").open(newline="") as file:
        assert not [name for name in next(csv.reader(file)) if name.endswith("_s")]
    before = (tmp_path / "summary.md").read_text()
    for line in answer.out.splitlines():
        assert not line.startswith("  - ") or line[2:] in before
    for picture in ("fig3.svg", "discretisation.svg"):
        assert f"]({picture})" in before

    def broken(*_: object) -> None:
        raise ModelError("exudyn-cable: no solution")

    monkeypatch.setattr(ExudynCable, "modes", broken)
    again = rps_bench("reproduce", "--only", "refinement", *few, "--output", str(tmp_path))
    assert again.status == 1 and "exudyn-cable: no solution" in again.err
    after = (tmp_path / "summary.md").read_text()
    assert before.split("## ")[1:4] == after.split("## ")[1:4]
    assert before.split("## ")[4] != after.split("## ")[4]


@pytest.mark.slow
def test_verification_beside_fig3_is_that_of_the_last_three(
    rps_bench: Callable[..., Any], tmp_path: Path
) -> None:
    """Order and limit by hand, from the frequencies in the table itself."""
    rps_bench(
        "convergence", "--model", "timoshenko", "--references", "timoshenko@exact", "--cases",
        "case2", "--elements", "1,2,4,8,16", "--output", str(tmp_path),
    )  # fmt: skip
    file = tmp_path / "convergence-timoshenko@exact-verification.csv"
    with file.open(newline="") as text:
        rows = list(csv.DictReader(text))
    assert [row["Mode"] for row in rows] == [f"f{i}" for i in range(1, 7)]
    for row in rows:
        a, b, c = (float(row[n]) for n in ("4", "8", "16"))
        order = np.log2((a - b) / (b - c))
        assert float(row["order"]) == pytest.approx(order, abs=1e-6)
        assert float(row["limit [Hz]"]) == pytest.approx(c + (c - b) / (2**order - 1), rel=1e-9)
        assert row["Remark"] == ""
