"""Short commands that are no study: models, cases, new, export, dashboard and verify."""

from pathlib import Path

import click

from harness.cli import flags
from harness.cli.terminal import Bar, show, show_tables, wrote


@click.command()
def models() -> None:
    """List every model: its theory, version, and whether it can run here, or why not."""
    from harness import plugins  # noqa: F401  models of other packages stay out of this process
    from harness.tables import Table
    from reference_models import catalogue

    rows = [
        (name, info.theory, f"{info.program} {info.version}".strip(),
         f"no: {info.missing}" if info.missing else "yes", info.remark)
        for name, info in catalogue()
    ]  # fmt: skip
    columns = ("Model", "Theory", "Version", "Available", "Remarks")
    show_tables(Table("Models", columns, tuple(rows)))


@click.command()
@flags.option("case_file", "FILE", "TOML file with cases of your own.")
def cases(case_file: str | None) -> None:
    """List every case: its pose, and what of it was read or fitted."""
    from harness.case_file import load_cases
    from harness.cases import PRESETS
    from harness.poses import cells, columns, headings, used
    from harness.tables import Table

    every = (PRESETS | (load_cases(Path(case_file)) if case_file is not None else {})).values()
    shown = used(case.pose for case in every)
    rows = tuple(
        (case.name, case.theory.label, *cells(columns(case.pose), shown), case.note)
        for case in every
    )
    names = ("Case", "Model", *headings(shown), "What was read or fitted")
    show_tables(Table("Cases", names, rows))


@click.command()
@click.argument("kind", metavar="case|mechanism|model|study|paper")
@click.argument("name")
@flags.output(".")
def new(kind: str, name: str, output: Path) -> None:
    """Write a commented template that runs as it is, and say what to run then.

    NAME is lower-case letters, digits and hyphens. Nothing that is there is written over.
    """
    from analytic import InputError
    from harness.output import write_all
    from harness.templates import written

    files, then = written(kind, name)
    for file in files:
        if (output / file).exists():
            raise InputError("name", name, f"one whose files are not there yet ({output / file})")
    wrote(write_all(output, {file: text.encode() for file, text in files.items()}))
    click.echo(f"run it: {then}" if output == Path() else f"run it: cd {output} && {then}")


@click.command()
@click.argument("case")
@flags.option("to", "PROGRAM", "What is to run it: calculix, mujoco, exudyn, exudyn-beam or one "
              "that is installed beside them.", required=True)  # fmt: skip
@flags.option("elements", "S", "Elements a limb; default the model's own.")
@flags.standard("case_file")
@flags.output("export")
def export(case: str, to: str, elements: str | None, case_file: str | None, output: Path) -> None:
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
    for argument, typed, some in (("case", case, found), ("elements", elements, steps)):
        if len(some) != 1:
            raise InputError(argument, typed, "one of them")
    made = write(found[0].mechanism, found[0].pose, steps[0], 6)
    wrote(write_all(output, {name: text.encode() for name, text in made.files.items()}))
    click.echo(f"run it: cd {output} && {made.run}")
    study = run(found, made.model)
    modes = study.first(found[0], made.model)
    if modes is None:
        click.echo(f"{made.model.label} did not run here: {study.failures[found[0], made.model]}")
    else:
        figures = " ".join(f"{f:.4f}" for f in modes.frequencies)
        click.echo(f"this bench gets by {made.model.label}: {figures} Hz")


@click.command()
@flags.option("output", "FILE", "The page to write, such as dashboard.html.", required=True)
@flags.option("results", "DIR", f"Folder of the run that is shown; default {flags.LATEST}.",
              default=flags.LATEST)  # fmt: skip
@flags.history()
def dashboard(output: str, results: str, history: Path | None) -> None:
    """Make the page anew from the last run, the newest history and the gate's last answer.

    Nothing is solved: the run has left what the page needs in page.json.
    """
    from harness.output import check_file, write_all
    from harness.report.page import load, load_check, render

    file, folder = check_file(output), Path(results)
    page = render(load(folder), history, load_check(folder))
    write_all(file.parent, {file.name: page})
    click.echo(f"wrote {file} ({len(page) / 1e6:.1f} MB)")


@click.command()
@click.argument("model")
@flags.time_limit()
def verify(model: str, time_limit: float) -> int:
    """Tell a model's author what of it fails, and how; exit status 1 if anything does.

    MODEL is a name of `rps-bench models`. Asked at the paper's two cases: units, joints, mode
    counts, modal mass, symmetry, convergence, repeated modes, limits, and how it refuses.
    """
    from harness.bench import Bench
    from harness.verify import verify as verified

    with Bar() as bar, Bench(time_limit, bar) as bench:
        found = verified(model, bench)
    show({"": found})
    for what, why in found.failures().items():
        click.echo(f"rps-bench: {what}: {why}", err=True)
    return 0 if found.passed else 1
