"""What there is: `rps-bench models` and `rps-bench cases`."""

from pathlib import Path

import click

from harness.cli.flags import option
from harness.cli.terminal import show_tables
from harness.tables import Table


@click.command()
def models() -> None:
    """List every model: its theory, version, and whether it can run here, or why not."""
    from harness import plugins  # noqa: F401  models of other packages stay out of this process
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
    from harness.case_file import load_cases
    from harness.cases import PRESETS
    from harness.poses import cells, columns, headings, used

    extra = load_cases(Path(case_file)) if case_file is not None else {}
    shown = used(case.pose for case in (PRESETS | extra).values())
    rows = tuple(
        (case.name, case.theory.label, *cells(columns(case.pose), shown), case.note)
        for case in (PRESETS | extra).values()
    )
    names = ("Case", "Model", *headings(shown), "What was read or fitted")
    show_tables(Table("Cases", names, rows))
