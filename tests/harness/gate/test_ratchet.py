"""Tolerances tighten by themselves and widen for a reason that is kept; files survive a round."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from analytic import InputError
from harness.gate.figures import (
    FACTOR,
    Count,
    Figures,
    Finding,
    Order,
    Reason,
    Shaped,
    Source,
    load,
    save,
)
from harness.gate.gate import FLOOR, accept

ABOUT = {"time": "2026-01-02T03:04:05+00:00", "commit": "abc"}
KEY = ("case1", "m@4", 1)
LEFT = Finding("missing", "m@4", "case1", None, "accepted figures", "accepted", "not measured")


def figures(frequency: float = 100.0) -> Figures:
    labels = ("m@1", "m@2", "m@4")
    values = (frequency * 1.16, frequency * 1.01, frequency)
    return Figures(
        {("case1", label, 1): Shaped(f, 2, 0.987654)
         for label, f in zip(labels, values, strict=True)},
        {("case1", "m@4", 1): 0.25},
        {("case1", "m@4"): Count(123.4, 1)},
        {("case1", "m", 1): Order(3.9, 4.0, (1, 2, 4))},
        {label: Source("a theory, kappa=1", "program 1.2") for label in labels},
        {"case1": "0123456789ab"},
    )  # fmt: skip


def baseline(noise: float = 1e-9) -> Figures:
    return accept(None, figures(), everywhere(noise), ABOUT, "")


def everywhere(noise: float) -> dict[tuple[str, str, int], float]:
    return dict.fromkeys(figures().modes, noise)


def test_a_tolerance_is_ten_times_the_noise_or_the_floor() -> None:
    assert baseline(1e-9).tolerance(KEY) == FACTOR * 1e-9
    assert baseline(0.0).tolerance(KEY) == FACTOR * FLOOR


def test_accepting_takes_values_and_only_tightens() -> None:
    quieter = accept(baseline(), figures(101.0), everywhere(1e-10), ABOUT, "")
    assert quieter.modes[KEY].frequency == 101.0
    assert quieter.tolerance(KEY) == FACTOR * 1e-10
    noisier = accept(quieter, figures(102.0), everywhere(1e-6), ABOUT, "")
    assert noisier.modes[KEY].frequency == 102.0
    assert noisier.tolerance(KEY) == FACTOR * 1e-10
    assert noisier.reasons == ()


def test_small_steps_do_not_add_up() -> None:
    """A value within its tolerance stays what it was when it was accepted."""
    crept = accept(baseline(), figures(100.0 * (1 + 5e-9)), everywhere(1e-9), ABOUT, "")
    assert crept.modes[KEY].frequency == 100.0
    moved = accept(baseline(), figures(100.0 * (1 + 5e-8)), everywhere(1e-9), ABOUT, "")
    assert moved.modes[KEY].frequency == 100.0 * (1 + 5e-8)


@pytest.mark.parametrize("drift", [1e-10, 8e-10, 5e-9])
def test_what_is_accepted_is_met_by_what_was_measured(drift: float) -> None:
    """A value is kept, and its tolerance not tightened below the distance to the new one."""
    now = figures(100.0 * (1 + drift))
    quieter = accept(baseline(), now, everywhere(1e-11), ABOUT, "")
    assert quieter.modes[KEY].frequency == 100.0
    assert drift < quieter.tolerance(KEY) <= baseline().tolerance(KEY)


def test_widening_takes_a_reason_which_stays() -> None:
    wide = accept(baseline(), figures(), everywhere(1e-7), ABOUT, "prints fewer digits")
    assert wide.tolerance(KEY) == FACTOR * 1e-7
    kept = [one for one in wide.reasons if (one.case, one.model, one.mode) == KEY]
    assert kept == [
        Reason("2026-01-02T03:04:05+00:00", "abc", "tolerance", "m@4", "case1", 1,
               repr(FACTOR * 1e-9), repr(FACTOR * 1e-7), "prints fewer digits")
    ]  # fmt: skip
    later = accept(wide, figures(), everywhere(1e-9), ABOUT, "")
    assert later.tolerance(KEY) == FACTOR * 1e-9
    assert later.reasons == wide.reasons


def test_a_reason_widens_only_what_noise_has_come_near() -> None:
    """Twice the noise is chance among four evaluations; the tolerance is ten times it."""
    same = accept(baseline(), figures(), everywhere(2e-9), ABOUT, "another matter")
    assert same.tolerance(KEY) == FACTOR * 1e-9 and same.reasons == ()


def test_models_that_were_not_measured_stay() -> None:
    part = figures(200.0)
    only = Figures({KEY: part.modes[KEY]}, sources={"m@4": part.sources["m@4"]})
    after = accept(baseline(), only, {KEY: 1e-9}, ABOUT, "")
    assert after.modes[KEY].frequency == 200.0
    assert after.modes["case1", "m@2", 1].frequency == 101.0
    assert after.counts == {}, "an old count of a model measured anew"
    assert after.orders == {}, "an old order, one of whose meshes was measured anew"


def test_what_is_gone_goes_with_all_its_figures() -> None:
    after = accept(baseline(), Figures(), {}, ABOUT, "it left", [LEFT])
    left = after
    assert {*left.sources} == {"m@1", "m@2"} == {key[1] for key in (*left.modes, *after.limits)}
    assert (left.counts, left.orders, left.uncertainties) == ({}, {}, {})


def test_files_hold_every_digit(tmp_path: Path) -> None:
    first = replace(baseline(1.234e-9), timed_since={"m@4": "2026-01-02T00:00:00"})
    first = replace(
        first, reasons=(Reason("t", "c", 'a "quantity"', "m", "", 0, "1", "2", "x, y"),)
    )
    save(tmp_path, first)
    again = load(tmp_path)
    assert again is not None
    assert {k: one.frequency for k, one in again.modes.items()} == {
        k: one.frequency for k, one in first.modes.items()
    }
    for one in first.limits:
        assert again.tolerance(one) == pytest.approx(first.tolerance(one), rel=1e-2)
    assert again.reasons == first.reasons and again.timed_since == first.timed_since
    assert again.sources == first.sources
    assert again.mechanisms == first.mechanisms
    assert again.uncertainties == first.uncertainties == {KEY: 0.25}
    assert again.orders["case1", "m", 1].p == pytest.approx(3.9)
    values = again.followed("case1", ("m@1", "m@2", "m@4"), 1)
    assert values.tolist() == [100.0 * 1.16, 101.0, 100.0]
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    save(tmp_path, again)
    assert before == {path.name: path.read_bytes() for path in tmp_path.iterdir()}


def test_the_order_follows_its_frequencies() -> None:
    """Noise of the frequencies, carried through the logarithm; and a floor."""
    key = ("case1", "m", 1)
    assert baseline(1e-12).order_tolerance(key) == 0.02
    # d = 100 x 1e-4 Hz; steps of 15 and 1 Hz; ln 2.
    expected = (2 * 0.01 / 15 + 2 * 0.01 / 1) / np.log(2)
    assert baseline(1e-5).order_tolerance(key) == pytest.approx(expected, rel=1e-9)


def test_no_baseline_is_none_and_a_broken_one_is_said(tmp_path: Path) -> None:
    assert load(tmp_path / "none") is None
    save(tmp_path, baseline())
    (tmp_path / "tolerances.csv").write_text("case,model\n")
    with pytest.raises(InputError, match=r"tolerances\.csv: other columns"):
        load(tmp_path)
    save(tmp_path, baseline())
    text = (tmp_path / "frequencies.csv").read_text()
    (tmp_path / "frequencies.csv").write_text(text.replace("100.0", "a hundred"))
    with pytest.raises(InputError, match="a hundred"):
        load(tmp_path)
    save(tmp_path, baseline())
    (tmp_path / "orders.csv").unlink()
    with pytest.raises(InputError, match=r"orders\.csv: No such file"):
        load(tmp_path)


@pytest.mark.parametrize(
    ("name", "digits", "expected"),
    [
        ("frequencies.csv", "100.0", "frequency_hz of m@4 at case1"),
        ("frequencies.csv", "0.987654", "assurance of m@1 at case1"),
        ("tolerances.csv", "1e-08", "tolerance of m@1 at case1"),
        ("counts.csv", "123.4", "cut_hz of m@4 at case1"),
        ("orders.csv", "3.900000", "order of m at case1"),
        ("uncertainties.csv", "0.25", "uncertainty_hz of m@4 at case1"),
    ],
)
@pytest.mark.parametrize("wrong", ["nan", "inf", "-1.0"])
def test_a_baseline_of_no_numbers_is_refused(
    tmp_path: Path, name: str, digits: str, expected: str, wrong: str
) -> None:
    """With NaN for a value or a tolerance nothing would ever be too far off."""
    save(tmp_path, baseline())
    text = (tmp_path / name).read_text()
    assert digits in text
    (tmp_path / name).write_text(text.replace(digits, wrong, 1))
    with pytest.raises(InputError, match=f"{expected} is {wrong}"):
        load(tmp_path)
