"""What there is: `rps-bench models` and `rps-bench cases`."""

from pathlib import Path

import click
import numpy as np

from analytic import __version__
from analytic.theory import BEAMS
from harness.case_file import load_cases
from harness.cases import PRESETS
from harness.models import MADE_FROM, SOLID_LIMB
from harness.tables import Cell, Number, Table
from harness.terminal import show
from reference_models import catalogue
from reference_models.protocol import find


@click.command()
def models() -> None:
    """Every model: its theory, version, and whether it can run here, or why not."""
    rows: list[tuple[str, ...]] = [
        (name, theory, f"rps-bench {__version__}", "yes", "@S elements, or @exact without any")
        for name, theory in BEAMS.items()
    ]
    described = {SOLID_LIMB: find(MADE_FROM).info(), **dict(catalogue())}
    for name, info in described.items():
        here = f"no: {info.missing}" if info.missing else "yes"
        rows.append((name, info.theory, f"{info.program} {info.version}", here, info.remark))
    columns = ("Model", "Theory", "Version", "Available", "Remarks")
    show(Table("Models", columns, tuple(rows)))


@click.command(name="cases")
@click.option("--case-file", metavar="FILE", help="TOML file with cases of your own.")
def list_cases(case_file: str | None) -> None:
    """Every case: its pose, and what of it was read or fitted."""
    extra = load_cases(Path(case_file)) if case_file is not None else {}
    rows: list[tuple[Cell, ...]] = []
    for case in (PRESETS | extra).values():
        azimuth, tilt = np.degrees([case.pose.azimuth, case.pose.tilt])
        pose = (Number(1000 * case.pose.z, 2), Number(azimuth, 2), Number(tilt, 2))
        rows.append((case.name, case.model, *pose, case.note))
    columns = ("Case", "Model", "z [mm]", "azimuth [deg]", "tilt [deg]", "What was read or fitted")
    show(Table("Cases", columns, tuple(rows)))
