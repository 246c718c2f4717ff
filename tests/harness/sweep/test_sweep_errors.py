"""Error maps of `rps-bench sweep`: worst poses, mode counts, and rods that do not twist."""

import re
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from harness.history.duck import connect


def test_a_worst_pose_is_seen_again_by_the_command_printed(
    rps_bench: Callable[..., Any], tmp_path: Path
) -> None:
    given = ("--poses", "random:30:4", "--models", "euler-bernoulli@3", "--modes", "1-3")
    output = tmp_path / "first"
    first = rps_bench(
        "sweep", *given, "--against", "timoshenko@exact", "--shear", "0.9", "--output", str(output)
    )
    commands = [shlex.split(line) for line in re.findall(r"rps-bench (sweep .*)", first.out)]
    worst = pd.read_csv(output / "worst.csv")
    assert len(commands) == len(set(worst["Pose"]))
    again = tmp_path / "again"
    for command in commands:
        assert rps_bench(*command, "--output", str(again)).status == 0
        rows = pd.read_csv(again / "errors.csv").merge(worst, on=["Model", "Mode"])
        close = np.abs(rows["Mean (%)"].to_numpy() / rows["Error (%)"].to_numpy() - 1) < 1e-9
        assert close.any()
    by_shape = worst["Error (%)"].to_numpy() - worst["By shape (%)"].to_numpy()
    assert np.abs(by_shape).max() < 1e-7


TWISTING = (
    "z_m,azimuth_rad,tilt_rad\n0.2208041504,5.7918971090,0.1928785642\n0.2033,3.106,0.0737\n"
    "0.49,1.2,0.1\n"
)
"""At the first two torsion of limbs is among the six lowest modes."""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("model", "theory", "within", "torsion"),
    [
        ("exudyn-cable@16", "euler-bernoulli@exact", 1e-5, False),
        ("mujoco-cable@8+16", "euler-bernoulli@exact", 4e-4, False),
        ("exudyn-beam@12+24", "timoshenko@exact", 3e-4, True),
    ],
)
def test_rods_that_do_not_twist_are_compared_with_a_theory_that_does_not(
    rps_bench: Callable[..., Any],
    tmp_path: Path,
    model: str,
    theory: str,
    within: float,
    torsion: bool,
) -> None:
    poses = tmp_path / "poses.csv"
    poses.write_text(TWISTING)
    for ours, against in ((model, theory), (theory, model)):
        given = ("--poses", str(poses), "--models", ours, "--against", against)
        answer = rps_bench("sweep", *given, "--output", str(tmp_path))
        assert answer.status == 0, answer.err
        assert (f"is not in {model}; {theory} is taken without it" in answer.out) != torsion
        with connect() as base:
            errors = base.execute(f"FROM '{tmp_path / 'error-map.parquet'}'").df()["error_percent"]
        assert len(errors) == 3 * 6
        assert errors.abs().max() < 100 * within
        worst = pd.read_csv(tmp_path / "worst.csv")
        by_shape = worst["Error (%)"].to_numpy() - worst["By shape (%)"].to_numpy()
        assert np.abs(by_shape).max() < 1e-6
        if against == theory:  # modes are counted against a theory only
            counted = pd.read_csv(tmp_path / "errors.csv")["Miscounted"]
            assert counted.str.startswith("0 of ").all()


def test_a_simulator_that_misses_a_mode_is_found_out(
    rps_bench: Callable[..., Any], tmp_path: Path, plugin: None
) -> None:
    """The third of six is missing at two poses: there the number of modes is wrong from f3 on."""
    poses = tmp_path / "poses.csv"
    poses.write_text("z_mm,azimuth_deg,tilt_deg\n400,10,5\n410,20,-6\n420,30,7\n430,40,-8\n")
    given = ("--poses", str(poses), "--models", "trial@9", "--against", "euler-bernoulli@exact")
    answer = rps_bench("sweep", *given, "--cores", "1", "--output", str(tmp_path))
    assert answer.status == 0, answer.err
    table = pd.read_csv(tmp_path / "errors.csv")
    assert table["Miscounted"].to_list() == ["0 of 4"] * 2 + ["2 of 4"] * 4
    assert "trial@9: poses with a wrong mode count: 2 of 4: 2, 4" in answer.out
