"""`rps-bench export`: a case as input files that need nothing of this bench."""

from pathlib import Path

import click

from harness.cli import flags


@click.command()
@click.argument("case")
@flags.option("to", "PROGRAM", "What is to run it: calculix, mujoco, exudyn, exudyn-beam or one "
              "that is installed beside them.", required=True)  # fmt: skip
@flags.option("elements", "S", "Elements a limb; default the model's own.")
@flags.option("case_file", *flags.FLAGS["case_file"])
@flags.output("export")
def export(case: str, to: str, elements: str | None, case_file: str | None, output: Path) -> int:
    """Write a case as input files for a simulator of your own.

    They are what this bench runs, in SI units, with comments. The command says how to run them,
    and what this bench gets from the same where it can run it.
    """
    from analytic import InputError
    from harness.bench import run
    from harness.output import write_all
    from harness.text import MOST_ELEMENTS, chosen, numbers
    from reference_models.export import exporter

    write = exporter(to)
    found = chosen(case, case_file, case)
    steps = [None] if elements is None else numbers("elements", elements, MOST_ELEMENTS)
    if len(found) != 1 or len(steps) != 1:
        where, value = ("cases", case) if len(found) != 1 else ("elements", elements)
        raise InputError(where, value, "one of them")
    made = write(found[0].mechanism, found[0].pose, steps[0], 6)
    for path in write_all(output, {name: text.encode() for name, text in made.files.items()}):
        click.echo(f"wrote {path}")
    click.echo(f"run it: cd {output} && {made.run}")
    study = run(found, made.model)
    modes = study.first(found[0], made.model)
    if modes is None:
        click.echo(f"{made.model.label} did not run here: {study.failures[found[0], made.model]}")
    else:
        figures = " ".join(f"{f:.4f}" for f in modes.frequencies)
        click.echo(f"this bench gets by {made.model.label}: {figures} Hz")
    return 0
