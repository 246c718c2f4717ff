"""A slower solver is found amid noise; noise alone is not."""

from collections.abc import Callable, Sequence
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from harness.gate.plan import YARDSTICK, yardstick, yardstick_row
from harness.gate.timing_watch import LEAST, WINDOWS, changes, timings
from harness.history.store import append, open_history

SERIES, RUNS = 40, 200
"""As many series as a whole check has."""
Draw = Callable[[np.random.Generator, tuple[int, ...]], NDArray[np.float64]]


def normal(random: np.random.Generator, shape: tuple[int, ...]) -> NDArray[np.float64]:
    return 0.2 * random.standard_normal(shape)


def skew(random: np.random.Generator, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """20 % of the seconds, not of their logarithm."""
    return np.log(np.maximum(1 + 0.2 * random.standard_normal(shape), 0.1))


def heavy(random: np.random.Generator, shape: tuple[int, ...]) -> NDArray[np.float64]:
    return 0.2 * random.standard_t(3, shape) / np.sqrt(3)


def outliers(random: np.random.Generator, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """One run in 20 is 1.5 to 5 times as slow."""
    hit = random.random(shape) < 0.05
    return np.asarray(normal(random, shape) + hit * np.log(random.uniform(1.5, 5, shape)))


def fired(series: Sequence[float]) -> NDArray[np.bool_]:
    """Return at which of its runs the check fails for this one series."""
    return np.array([one is not None and one.happened for one in changes(series)])


@pytest.mark.slow
@pytest.mark.parametrize("draw", [normal, skew, heavy, outliers])
def test_two_hundred_clean_runs_raise_at_most_two_alarms(draw: Draw) -> None:
    """Over all models together."""
    noise = draw(np.random.default_rng(7), (SERIES, RUNS))
    failing = np.array([fired(series) for series in noise.tolist()])
    begins = failing[:, 1:] & ~failing[:, :-1]
    assert begins.sum() <= 2


@pytest.mark.parametrize(
    ("draw", "caught"), [(normal, 0.96), (skew, 0.9), (heavy, 0.96), (outliers, 0.85)]
)
def test_a_solver_twice_as_slow_is_caught_within_five_runs(draw: Draw, caught: float) -> None:
    """From 60 planted slowdowns after 30 runs; a run that is slow by chance comes on top."""
    noise = draw(np.random.default_rng(3), (60, 35))
    noise[:, 30:] += np.log(2)
    found = np.array([fired(series) for series in noise.tolist()])
    assert not found[:, :30].any()
    assert found[:, 30:].any(axis=1).mean() >= caught


def test_it_goes_on_until_it_is_fast_again() -> None:
    """Also when most of the runs so far were slow."""
    noise = normal(np.random.default_rng(5), (190,))
    noise[30:170] += np.log(2)
    found = fired(noise.tolist())
    assert not found[:30].any()
    assert found[35:170].all()
    assert not found[175:].any()


def test_no_single_run_fires() -> None:
    """However slow it is, and however quiet the others are."""
    random = np.random.default_rng(1)
    for quiet in (0.2, 1e-6):
        series = quiet * random.standard_normal(60)
        series[45] += np.log(1000)
        assert not fired(series.tolist()).any()


def test_a_smaller_change_takes_longer() -> None:
    """1.5 times the time: seldom within 5 runs, nearly always within 20."""
    noise = normal(np.random.default_rng(2), (60, 80))
    noise[:, 60:] += np.log(1.5)
    found = np.array([fired(series) for series in noise.tolist()])[:, 60:]
    assert found[:, :5].any(axis=1).mean() < 0.6
    assert found.any(axis=1).mean() > 0.85


def test_too_few_runs_say_nothing() -> None:
    least = LEAST + min(WINDOWS)
    assert changes([0.0] * (least - 1))[-1] is None
    assert changes([0.0] * least)[-1] is not None


def history(folder: Path, seconds: NDArray[np.float64], machine: str = "one") -> None:
    """Write runs of models m0, m1, ...: `seconds` (runs, models); each machine at its own pace."""
    pace = np.random.default_rng(0).uniform(1, 3, len(seconds))
    start = datetime(2026, 1, 1, tzinfo=UTC)
    for day, (run, slow) in enumerate(zip(seconds, pace.tolist(), strict=True)):
        rows = [row(YARDSTICK, YARDSTICK, 0.01 * slow, machine)]
        for model, second in enumerate(run.tolist()):
            rows += [row(f"m{model}", case, second * slow, machine) for case in ("case1", "case2")]
        append(folder, rows, "rps-bench check", start + timedelta(days=day))


def row(model: str, case: str, seconds: float, machine: str) -> dict[str, Any]:
    return {"case": case, "model": model, "mode": 1, "frequency_hz": 1.0, "build_s": 0.0,
            "solve_s": seconds, "machine": machine}  # fmt: skip


def test_the_history_is_asked_by_model_and_machine(tmp_path: Path) -> None:
    """A machine three times as slow on some days is no change: its yardstick is as slow."""
    seconds = 0.05 * np.exp(0.05 * normal(np.random.default_rng(4), (30, 2)))
    seconds[25:, 1] *= 2
    history(tmp_path, seconds)
    history(tmp_path, 10 * seconds[:5], "another")
    steady, slow = timings(open_history(tmp_path), "one")
    assert (steady.model, slow.model) == ("m0", "m1")
    assert not steady.slower.happened and not steady.faster.happened
    assert slow.slower.happened and slow.slower.runs == 30
    assert slow.slower.factor == pytest.approx(2, rel=0.05)
    assert slow.since == datetime(2026, 1, 26)
    assert timings(open_history(tmp_path), "another") == []
    # Accepted from the day it began, it is the new measure: too few runs, for now.
    again = timings(open_history(tmp_path), "one", {"m1": slow.since})
    assert [one.model for one in again] == ["m0"]


def test_other_commands_are_no_part_of_the_series(tmp_path: Path) -> None:
    """Seconds of the same model timed by another command have no yardstick of the gate beside."""
    seconds = 0.05 * np.exp(0.05 * normal(np.random.default_rng(4), (30, 1)))
    history(tmp_path, seconds)
    before = timings(open_history(tmp_path), "one")
    assert [one.model for one in before] == ["m0"]
    for day in range(20):
        at = datetime(2026, 3, 1, tzinfo=UTC) + timedelta(days=day)
        append(tmp_path, [row("m0", "case1", 7.0, "one")], "rps-bench cost", at)
    assert timings(open_history(tmp_path), "one") == before


def test_the_yardstick_is_a_known_chain() -> None:
    """150 unit masses between walls: omega_1 = 2 sin(pi / 302)."""
    frequency, seconds = yardstick()
    assert frequency == pytest.approx(2 * np.sin(np.pi / 302) / (2 * np.pi), rel=1e-10)
    assert seconds > 0
    middle = yardstick_row([(1.0, 3.0), (1.0, 1.0), (1.0, 2.0)])
    assert (middle["model"], middle["solve_s"]) == (YARDSTICK, 2.0)


@pytest.mark.slow
def test_a_hundred_thousand_rows(tmp_path: Path) -> None:
    """200 runs of 500 rows: the question is asked at once, and the answer is right."""
    noise = np.exp(normal(np.random.default_rng(6), (200, 50)))
    noise[195:, 17] *= 2
    start = datetime(2026, 1, 1, tzinfo=UTC)
    for day, run in enumerate(noise):
        rows = [row(YARDSTICK, YARDSTICK, 0.01, "one")]
        for model, second in enumerate(run.tolist()):
            rows += [row(f"m{model}", f"case{k}", 0.1 * second, "one") for k in range(10)]
        append(tmp_path, rows, "rps-bench check", start + timedelta(days=day))
    past = open_history(tmp_path)
    found = timings(past, "one")
    assert past.query("SELECT count(*) AS n FROM rows").rows() == [{"n": 200 * 501}]
    assert [one.model for one in found if one.slower.happened] == ["m17"]
