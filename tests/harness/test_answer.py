"""A wrong model is one sentence and a failure, in every command; the others' results stand."""

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from analytic import Continuum, Mechanism, Modes, Pose, Substructure, limbs_at
from harness.answer import checked
from harness.bench import Bench
from harness.case_file import load_cases
from harness.cases import PRESETS
from harness.declared import alone
from harness.history.duck import connect
from harness.request import Request
from harness.studies import refinement
from harness.studies.slenderness import with_rods
from reference_models import ModelError, Named
from reference_models.exudyn.beam import ExudynBeam

# Every class of tests/plugin/wrong.py, and what the sentence about it must say.
WRONG = {
    "kilohertz": r"is it in hertz\?",
    "radians": r"is it in hertz\?",
    "percent": "not of the theory that it declares",
    "few": "modes, where .* were asked for",
    "many": "modes, where .* were asked for",
    "not-a-number": "its frequencies hold nan",
    "missing": "a mode is missing",
    "raises": "ValueError: a bug",
    "crashes": "its process was ended by SIGSEGV",
    "exits": "its process ended by itself",
    "shape": "its shapes of the limbs are",
    "zero": "moves nothing",
    "unsorted": "do not ascend",
    "array": "it answered ndarray, where Modes were expected",
    "large": "has a modal mass of 1e.06",
    "gap": "its joints are open by 1.0e-03 m",
    "no-elements": "it takes no elements",
    "no-info": r"its info\(\) raises RuntimeError: its licence has run out",
    "unimportable": "it cannot be imported",
}
SOME = ("kilohertz", "percent", "crashes", "few")
MECHANISMS = Path(__file__).parents[2] / "results/published/mechanisms.toml"


def class_of(name: str) -> str:
    return "".join(word.capitalize() for word in name.split("-"))


@pytest.fixture
def site(installed: Callable[[dict[str, str]], None]) -> None:
    """Install the wrong models."""
    points = {f"x-{name}": f"wrong:{class_of(name)}" for name in ("honest", "hangs", *WRONG)}
    installed(points | {"x-unimportable": "unimportable:Model"})


def one_sentence_each(err: str, case: str, models: dict[str, str]) -> None:
    for name, says in models.items():
        lines = [line for line in err.splitlines() if f"x-{name}@" in line]
        assert lines, f"nothing is said of {name}"
        assert all(re.search(says, line) for line in lines), lines
        assert all(f"at {case} failed: " in line for line in lines), lines
    assert "Traceback" not in err


ALL = ",".join(f"x-{name}" for name in ("honest", *WRONG))
COMMANDS = [
    ("table", "--references", ALL),
    ("refine", "--references", ALL),
    ("reproduce", "--only", "table", "--references", ALL, "--output", "out"),
    ("sweep", "--poses", "pose:490,10,-12", "--models", ALL, "--tries", "1", "--output", "out"),
]


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS, ids=lambda c: c[0])
def test_wrong_models(
    rps_bench: Callable[..., Any],
    site: None,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    command: tuple[str, ...],
) -> None:
    monkeypatch.chdir(tmp_path)
    cases = () if command[0] == "sweep" else ("--cases", "case2")
    answer = rps_bench(*command, *cases)
    assert answer.status == 1 and "Traceback" not in answer.err
    if command[0] == "sweep":
        lines = (tmp_path / "out" / "failures.csv").read_text().splitlines()[1:]
        for name, says in WRONG.items():
            found = [line for line in lines if line.startswith(f"x-{name}@")]
            assert len(found) == 1 and re.search(says, found[0]), (name, lines)
        assert not any(line.startswith("x-honest") for line in lines)
        with connect() as base:
            rows = base.execute(f"FROM '{tmp_path / 'out' / 'frequencies.parquet'}'").df()
        assert set(rows["model"]) == {"x-honest@4+8"} and len(rows) == 6
        return
    says = dict(WRONG)
    if command[0] == "refine":
        says["percent"] = "it does not converge to the theory it declares"
    one_sentence_each(answer.err, "case2", says)
    assert "x-honest" not in answer.err
    if command[0] == "reproduce":
        found = (tmp_path / "out" / "table1.csv").read_text()
        assert "FEA (x-honest@4+8)" in found
        assert not any(f"x-{name}@" in found for name in WRONG)
    else:
        assert "149.507" in answer.out and "x-honest" in answer.out


def test_what_crashes_exits_or_hangs_costs_its_own_answer(site: None) -> None:
    says = {
        "crashes": "ended by SIGSEGV",
        "exits": "ended by itself with status 0",
        "hangs": "gave no answer within the time limit of 2 s",
    }
    models = [Named(f"x-{name}", 1) for name in ("honest", *says)]
    case = PRESETS["case1"]
    with Bench(limit=2) as bench:
        study = bench.run([case], [*models, Named("euler-bernoulli", 1)])
    assert set(study.failures) == {(case, model) for model in models[1:]}
    for model, why in zip(models[1:], says.values(), strict=True):
        assert why in study.failures[case, model]
    honest = study.answers[case, models[0]].frequencies
    ours = study.answers[case, Named("euler-bernoulli", 1)].frequencies
    np.testing.assert_allclose(honest, ours, rtol=1e-12)


def test_one_mesh_of_another_scale_is_caught_and_one_percent_is_not(site: None) -> None:
    """One mesh may miss its limit by a percent; by a thousand, or a mode, it may not."""
    with Bench() as bench:
        case = PRESETS["case1"]
        for name, told in (("kilohertz", True), ("missing", True), ("percent", False)):
            found = bench.run([case], [Named(f"x-{name}", 1)], 6)
            assert bool(found.failures) == told, (name, found.failures)
        asked = Request((case,), Named("x-percent", 4), (), shown=(1, 2, 3))
        said = refinement.run(asked, bench).failures()
    assert list(said) == ["x-percent@8 at case1"]
    assert "f1 = 139.205 Hz for 137.826 Hz" in said["x-percent@8 at case1"]


def right() -> tuple[Any, ...]:
    case = PRESETS["case2"]
    modes = Substructure(3).modes(case.mechanism, case.pose, 8)
    return modes, Substructure(3).info(), case.mechanism, case.pose


def spoilt(modes: Modes, name: str, i: int, factor: float) -> Modes:
    values = getattr(modes, name).copy()
    values[i] = factor * values[i]
    return replace(modes, **{name: values})


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda m: replace(m, frequencies=-m.frequencies[::-1]), "below zero"),
        (lambda m: spoilt(m, "limbs", 1, 1.1), "mode 2 limbs leave the platform"),
        (lambda m: spoilt(m, "platform", 4, np.inf), "not finite"),
        (lambda m: replace(m, residual=np.nan), "residual is nan"),
        (lambda m: replace(m, limbs=m.limbs + 1e-2), "leave"),
        (lambda m: replace(m, uncertainty=np.full(8, -1.0)), "uncertainties"),
        (lambda m: replace(m, frequencies=m.frequencies.astype(complex)), "type complex"),
    ],
)
def test_what_an_answer_must_satisfy(spoil: Callable[[Modes], Modes], says: str) -> None:
    modes, info, mechanism, pose = right()
    same = checked(modes, info, mechanism, pose, 8)
    assert (same.frequencies == modes.frequencies).all() and (same.limbs == modes.limbs).all()
    with np.errstate(invalid="ignore"), pytest.raises(ModelError, match=says):
        checked(spoil(modes), info, mechanism, pose, 8)


def test_a_carriage_that_turns_alone_is_a_mode_only_where_it_can() -> None:
    """Three of a 3-PRS do about their hinges, on their springs: k / (J + m c^2) of each."""
    case = with_rods(load_cases(MECHANISMS)["prs"], 0.15)
    info = ExudynBeam.info()
    modes = ExudynBeam(4).modes(case.mechanism, case.pose, 9)
    turns = float(np.sqrt(6e5 / (0.05 + 12 * 0.015**2)) / (2 * np.pi))
    assert modes.frequencies[8] == pytest.approx(turns, rel=1e-7)
    assert alone(case.mechanism, case.pose, 1000.0) == pytest.approx(turns, rel=1e-9)
    assert alone(case.mechanism, case.pose, 500.0) == np.inf
    checked(modes, info, case.mechanism, case.pose, 9)
    still = replace(modes, platform=0 * modes.platform, limbs=0 * modes.limbs)
    with pytest.raises(ModelError, match="mode 1 moves nothing, and no rod twists or body turns"):
        checked(still, info, case.mechanism, case.pose, 9)


def test_a_limb_that_twists_alone_is_a_mode_only_where_it_can() -> None:
    """Three limbs of case 1 twist at sqrt(G / rho) / 4 L; zero shapes lower down are none."""
    case = PRESETS["case1"]
    modes = Continuum().modes(case.mechanism, case.pose, 14)
    info = Continuum().info()
    checked(modes, info, case.mechanism, case.pose, 14)
    with pytest.raises(ModelError, match="moves nothing"):
        checked(modes, replace(info, torsion=False), case.mechanism, case.pose, 14)
    low = spoilt(spoilt(modes, "limbs", 0, 0.0), "platform", 0, 0.0)
    with pytest.raises(ModelError, match="mode 1 moves nothing"):
        checked(low, info, case.mechanism, case.pose, 14)


@pytest.mark.slow
@pytest.mark.parametrize(("command", "names"), [("check", WRONG), ("accept", SOME)])
def test_wrong_models_do_not_pass_the_gate(
    rps_bench: Callable[..., Any],
    site: None,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    command: str,
    names: Iterable[str],
) -> None:
    """One sentence each; nothing of them is accepted, and nothing compared is no pass."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "one.toml").write_text(
        "[cases.one]\nz_mm = 490\nazimuth_deg = 10\ntilt_deg = -12\n"
    )
    models = ",".join(f"x-{name}" for name in ("honest", *names))
    base = ("--baseline", "none") if command == "check" else ("--baseline", "b", "--reason", "so")
    answer = rps_bench(command, "--case-file", "one.toml", "--models", models, *base)
    assert answer.status == 1 and "Traceback" not in answer.err
    assert "passed" not in answer.out and not (tmp_path / "b").exists()
    if command == "accept":
        assert re.search(
            r"nothing accepted: \d+ x (failure|failure and property), which", answer.err
        )
    said = " ".join(answer.out.split())
    for name in names:
        assert f"x-{name}" in said, name


@pytest.mark.parametrize("name", ["prs", "rps-real", "tricept"])
def test_limbs_of_any_chain_keep_to_what_their_joints_let_them(name: str) -> None:
    """A drive's give along its axis is no fault; the same give across it is an open joint."""
    case = load_cases(MECHANISMS)[name]
    of = case.mechanism, case.pose
    info, modes = Substructure(1).info(), Substructure(1).modes(*of, 6)
    checked(modes, info, *of, 6)
    largest = np.abs(modes.limbs[0]).max()
    along = limbs_at(*of).frames[-1]
    for k, end in ((0, 0), (1, 0), (0, -1), (1, -1)):
        moved = modes.limbs.copy()
        moved[0, -1, end] += 0.05 * largest * along[:, k]
        with pytest.raises(ModelError, match="mode 1 limbs leave"):
            checked(replace(modes, limbs=moved), info, *of, 6)


def test_a_chain_whose_springs_give_may_move_along_them_alone() -> None:
    """The carriage of a P joint slides on its drive by the force over its stiffness, or any way."""
    case = load_cases(MECHANISMS)["prs"]
    of = case.mechanism, case.pose
    info, modes = Substructure(1).info(), Substructure(1).modes(*of, 6)
    moved = modes.limbs.copy()
    moved[0, :, 0, 2] += 0.05 * np.abs(modes.limbs[0]).max()  # its axis is vertical
    checked(replace(modes, limbs=moved), info, *of, 6)


def test_a_model_without_a_limit_is_of_the_size_of_exact_beams() -> None:
    """Whatever a simulator of any chain assumes, hertz are told from radians a second."""
    case = load_cases(MECHANISMS)["prs"]
    with Bench() as bench:
        honest = bench.run([case], [NoLimit(1.0)], 3)
        wrong = bench.run([case], [NoLimit(2 * np.pi)], 3)
    assert not honest.failures
    assert [why for why in wrong.failures.values() if "is it in hertz?" in why]


@dataclass(frozen=True)
class NoLimit:
    """Elements that say nothing of their theory, in units of their own."""

    factor: float
    elements: int | None = 2

    def info(self) -> Any:
        return replace(Substructure(2).info(), limit=None)

    def limit(self) -> None:
        return None

    def modes(self, mechanism: Mechanism, pose: Pose, count: int) -> Modes:
        found = Substructure(2).modes(mechanism, pose, count)
        return replace(found, frequencies=self.factor * found.frequencies)


def test_repeated_modes_of_a_hexapod_at_home_ascend() -> None:
    case = load_cases(MECHANISMS)["hexapod-home"]
    modes = Continuum("timoshenko").modes(case.mechanism, case.pose, 12)
    assert (np.diff(modes.frequencies) >= 0).all()
