"""What the commands print and write, on real simulators."""

import csv
import io
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from harness import published
from reference_models import ModelError
from reference_models.exudyn_beam import ExudynBeam
from reference_models.exudyn_cable import ExudynCable

Bench = Callable[..., Any]


def cells(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(path.read_text())))


def test_table_one(rps_bench: Bench, tmp_path: Path) -> None:
    answer = rps_bench(
        "table", "--cases", "case1,case2", "--references", "exudyn-beam", "--output", str(tmp_path)
    )
    assert answer.status == 0
    assert "Error (%)" in answer.out
    rows = {(row["Case"], row["Method"]): row for row in cells(tmp_path / "table1.csv")}
    for case in ("case1", "case2"):
        fea, ours, error = (
            np.array([float(rows[case, method][f"f{i} [Hz]"]) for i in range(1, 7)])
            for method in (
                "FEA (exudyn-beam@12+24)",
                "Theoretical (euler-bernoulli@3)",
                "Error (%)",
            )
        )
        np.testing.assert_allclose(error, 100 * (ours - fea) / fea, rtol=1e-9)
        assert (error > 1.3).all()  # shear and rotary inertia at d/L = 0.2
        assert (error[3:] > 4.2).all()
        printed = published.table1()[case, "Theoretical"]
        assert [
            float(rows[case, "printed: Theoretical"][f"f{i} [Hz]"]) for i in range(1, 7)
        ] == list(printed)
    assert "erratum height" in answer.out
    frame = pl.read_csv(tmp_path / "frequencies.csv")
    assert frame.height == 2 * 2 * 6
    assert set(frame["version"]) >= {"exudyn 1.13.6"}
    assert frame["closure_m"].drop_nulls().max() < 1e-9  # type: ignore[operator]


def test_every_erratum_is_shown_by_a_command(rps_bench: Bench) -> None:
    """Long commands have tests of their own; here it is enough that they are there."""
    for erratum in published.errata():
        program, command, *arguments = erratum.command.split()
        if program == "pytest":
            assert (Path(__file__).parents[2] / command).exists()
        else:
            assert (
                rps_bench(command, *(arguments if command == "table" else ["--help"])).status == 0
            )


@pytest.mark.slow
def test_errata_numbers(rps_bench: Bench, tmp_path: Path) -> None:
    """The figures quoted in the errata come from the model, not from memory."""
    rps_bench(
        "reproduce", "--only", "table1", "--references", "exudyn-cable@4", "--output", str(tmp_path)
    )
    rows = {
        r["Case"]: [float(r[f"f{i} [%]"]) for i in range(1, 7)]
        for r in cells(tmp_path / "readings.csv")
    }
    base = rows["case1"] + rows["case2"]
    assert min(base) >= 13.5 and max(base) <= 26.5  # "14 to 26 %"
    assert max(map(abs, rows["case1-z-fitted"])) < 0.8
    assert rows["case2-z-fitted"][0] == pytest.approx(-4.0, abs=0.05)
    assert max(rows["case2-z-fitted"]) == pytest.approx(4.2, abs=0.06)
    assert max(map(abs, rows["case1-z-r1-fitted"])) < 0.02
    assert max(map(abs, rows["case2-z-r1-fitted"])) == pytest.approx(5, abs=0.1)
    outwards = rows["case1-small-base"] + rows["case2-small-base"]
    assert max(map(abs, outwards)) == pytest.approx(1.0, abs=0.05)  # "to 1.0 %"
    inertia = (100 + rows["case1-printed-inertia"][2]) / (100 + rows["case1"][2])
    assert inertia == pytest.approx(0.88, abs=0.005)  # "f3 by 12 %"


def test_several_references_side_by_side(rps_bench: Bench, tmp_path: Path) -> None:
    answer = rps_bench(
        "table", "--cases", "case2", "--references", "exudyn-cable@4,mujoco-cable@4+8",
        "--elements", "1,3", "--modes", "1-3", "--output", str(tmp_path),
    )  # fmt: skip
    assert answer.status == 0
    rows = cells(tmp_path / "references-euler-bernoulli@3.csv")
    assert [row["Mode"] for row in rows] == ["f1", "f2", "f3"]
    assert list(rows[0])[3:] == ["exudyn-cable@4", "mujoco-cable@4+8"]
    assert (tmp_path / "references-euler-bernoulli@1.csv").exists()


def test_convergence(rps_bench: Bench, tmp_path: Path) -> None:
    answer = rps_bench(
        "convergence", "--cases", "case1", "--references", "euler-bernoulli@exact,exudyn-cable@8",
        "--elements", "1,2,4,8", "--output", str(tmp_path),
    )  # fmt: skip
    assert answer.status == 0
    assert "Observed order" in answer.out
    orders = cells(tmp_path / "convergence-euler-bernoulli@exact-order.csv")
    assert [row["s"] for row in orders] == ["1 to 2", "2 to 4", "4 to 8"]
    last = [float(orders[-1][f"f{i}"]) for i in range(1, 7)]
    np.testing.assert_allclose(last, 4, atol=0.1)
    for stem in ("convergence-euler-bernoulli@exact", "convergence-exudyn-cable@8"):
        assert (tmp_path / f"{stem}.svg").read_bytes().startswith(b"<?xml")
        assert (tmp_path / f"{stem}.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_pictures_are_the_same_bytes_every_time(rps_bench: Bench, tmp_path: Path) -> None:
    for name in ("a", "b"):
        rps_bench(
            "convergence", "--references", "timoshenko@exact", "--elements", "1,2",
            "--output", str(tmp_path / name),
        )  # fmt: skip
    for file in (tmp_path / "a").iterdir():
        assert file.read_bytes() == (tmp_path / "b" / file.name).read_bytes()


def test_models_says_what_is_missing(rps_bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    answer = rps_bench("models")
    for name in ("euler-bernoulli", "timoshenko", "exudyn-beam", "exudyn-cable", "mujoco-cable"):
        assert name in answer.out
    info = ExudynCable.info()
    gone = staticmethod(lambda: replace(info, missing="no Exudyn; pip install exudyn"))
    monkeypatch.setattr(ExudynCable, "info", gone)
    answer = rps_bench("models")
    assert answer.status == 0
    assert "no: no Exudyn; pip install exudyn" in answer.out
    answer = rps_bench("table", "--references", "exudyn-cable")
    assert answer.status == 2
    assert "'exudyn-cable' cannot run here: no Exudyn; pip install exudyn" in answer.err


@pytest.mark.slow
def test_a_failing_model_costs_only_its_own_results(
    rps_bench: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object) -> None:
        raise ModelError("exudyn-beam: joints are open by 1.0e-03 m")

    monkeypatch.setattr(ExudynBeam, "modes", broken)
    answer = rps_bench(
        "reproduce", "--only", "table1", "--references", "exudyn-cable@4,exudyn-beam@4",
        "--output", str(tmp_path),
    )  # fmt: skip
    assert answer.status == 1
    assert "exudyn-beam@4 failed at case1: exudyn-beam: joints are open" in answer.err
    assert "exudyn-cable@4" in (tmp_path / "table1.md").read_text()
    assert "failed" in (tmp_path / "references.md").read_text()


def test_user_cases(rps_bench: Bench, tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(
        """
        [mechanisms.square]
        platform_mass_kg = 20
        platform_inertia_kg_m2 = [[0.2, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.4]]
        rod_diameter_mm = 80
        young_GPa = 200
        shear_GPa = 77
        density_kg_m3 = 7820
        [[mechanisms.square.limb]]
        base_mm = [300, 0, 0]
        axis = [0, 1, 0]
        platform_point_mm = [200, 0, 0]
        [[mechanisms.square.limb]]
        base_mm = [0, 300, 0]
        axis = [-1, 0, 0]
        platform_point_mm = [0, 200, 0]
        rod_diameter_mm = 60
        [[mechanisms.square.limb]]
        base_mm = [-300, 0, 0]
        axis = [0, -1, 0]
        platform_point_mm = [-200, 0, 0]
        [cases.home]
        mechanism = "square"
        z_mm = 490
        [cases.paper-low]
        z_mm = 400
        tilt_deg = 5
        model = "timoshenko@4"
        """
    )
    answer = rps_bench("table", "--case-file", str(file), "--references", "exudyn-cable@4")
    assert answer.status == 0
    assert "home" in answer.out and "paper-low" in answer.out
    listed = rps_bench("cases", "--case-file", str(file)).out
    assert "400.00" in listed and "timoshenko@4" in listed
    only = rps_bench(
        "table",
        "--case-file",
        str(file),
        "--cases",
        "paper-low,case1",
        "--references",
        "exudyn-cable@4",
    )
    assert "home" not in only.out and "case1" in only.out
