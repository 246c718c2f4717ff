"""What there is: `rps-bench models` and `rps-bench cases`."""

from pathlib import Path

import click

from harness.cli.flags import option
from harness.cli.terminal import show_tables
from harness.tables import Cell, Number, Table


@click.command()
def models() -> None:
    """List every model: its theory, version, and whether it can run here, or why not."""
    from reference_models import catalogue

    rows = [
        (name, info.theory, f"{info.program} {info.version}".strip(),
         f"no: {info.missing}" if info.missing else "yes", info.remark)
        for name, info in catalogue()
    ]  # fmt: skip
    columns = ("Model", "Theory", "Version", "Available", "Remarks")
    show_tables(Table("Models", columns, tuple(rows)))


@click.command()
@option("case_file", "FILE", "TOML file with cases of your own.")
def cases(case_file: str | None) -> None:
    """List every case: its pose, and what of it was read or fitted."""
    import numpy as np

    from harness.case_file import load_cases
    from harness.cases import PRESETS

    extra = load_cases(Path(case_file)) if case_file is not None else {}
    rows: list[tuple[Cell, ...]] = []
    for case in (PRESETS | extra).values():
        azimuth, tilt = np.degrees([case.pose.azimuth, case.pose.tilt])
        pose = (Number(1000 * case.pose.z, 2), Number(azimuth, 2), Number(tilt, 2))
        rows.append((case.name, case.theory.label, *pose, case.note))
    columns = ("Case", "Model", "z [mm]", "azimuth [deg]", "tilt [deg]", "What was read or fitted")
    show_tables(Table("Cases", columns, tuple(rows)))
