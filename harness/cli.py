"""The command line: options to objects, results to the terminal and to files."""

import atexit
import gc
import sys
from dataclasses import replace
from pathlib import Path

import click
import numpy as np

from analytic import InputError, __version__
from analytic.theory import BEAMS
from harness.case_file import load_cases
from harness.cases import PRESETS
from harness.claims.command import claims
from harness.dashboard_command import dashboard
from harness.files import OutputError
from harness.gate.command import check
from harness.history.command import history
from harness.identification.command import identify
from harness.models import MADE_FROM, SOLID_LIMB
from harness.options import (
    STAND_IN,
    CostRequest,
    Request,
    takes_cost_request,
    takes_request,
)
from harness.precision.command import precision
from harness.reproduce_command import reproduce
from harness.sweep.command import sweep
from harness.tables import Cell, Number, Table
from harness.terminal import finish, progress, show, status, write
from harness.threads import one_thread
from harness.workspace.command import workspace
from reference_models import UnavailableError, catalogue
from reference_models.protocol import find

# The interpreter would search all that was loaded for garbage: a tenth of a second.
atexit.register(gc.freeze)


def main() -> None:
    """Run the command line; bad input ends with one sentence and exit status 2."""
    try:
        with one_thread():
            ended = cli(standalone_mode=False)
    except click.exceptions.Abort:
        click.echo("rps-bench: interrupted", err=True)
        sys.exit(130)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message())
        sys.exit(2)
    except click.ClickException as error:
        click.echo(f"rps-bench: {error.format_message()}", err=True)
        sys.exit(2)
    except (InputError, UnavailableError, OutputError) as error:
        click.echo(f"rps-bench: {error}", err=True)
        sys.exit(2)
    sys.exit(ended if isinstance(ended, int) else 0)


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="rps-bench")
def cli() -> None:
    """Check the published model of the 3-RPS manipulator against independent simulators."""


@cli.command()
@takes_request
def table(request: Request) -> int:
    """Table I: FEA, Theoretical and Error (%), beside what the paper prints.

    Without --model the theory is the one that the first case is meant for.
    """
    from harness.compare import provenance_table, reference_table, table_one
    from harness.reproduce import tidy
    from harness.run import rows, run

    cases, shown, against = request.chosen, request.shown, request.against(STAND_IN)
    theory, folder = request.theory(cases[0].model), request.folder
    theories = [theory]
    if request.elements is not None:
        theories = [replace(theory, elements=s) for s in request.steps("")]
    with progress(len(cases) * (len(theories) + len(against))) as done:
        study = run(cases, [*theories, *against], max(shown), done)
    tables = {"table1": table_one(study, theories, against, shown)}
    for spec in theories:
        tables[f"references-{spec.label}"] = reference_table(study, spec, against, shown)
    tables["provenance"] = provenance_table(study)
    show(*tables.values())
    files = {"frequencies.csv": tidy(rows(study))}
    for stem, result in tables.items():
        files |= result.files(stem)
    write(folder, files)
    return finish(request.history, study)


@cli.command()
@takes_request
def convergence(request: Request) -> int:
    """Error against the number of elements s, for every case and mode, as in Fig. 3.

    With --references NAME@exact (euler-bernoulli@exact, say) it is the discretisation error alone,
    with its observed order.
    """
    from harness.convergence import converge, convergence_files, convergence_tables

    cases, shown, against = request.chosen, request.shown, request.against(STAND_IN)
    theory, steps, folder = request.theory(cases[0].model), request.steps("1-8"), request.folder
    with progress(len(against) * len(cases) * (1 + len(steps))) as done:
        results = [converge(cases, theory, steps, ref, max(shown), done) for ref in against]
    files: dict[str, bytes] = {}
    for result in results:
        show(*convergence_tables(result, shown))
        if folder is not None:
            stem = f"convergence-{result.reference.label}"
            files |= convergence_files(result, shown, stem)
    write(folder, files)
    return finish(request.history, *(result.study for result in results))


@cli.command()
@takes_request
def refine(request: Request) -> int:
    """Observed order, Richardson limit and GCI of the theory and of every reference.

    Without --elements each reference doubles from half its own coarser mesh, the theory from 4.
    """
    from harness import refinement

    cases, shown, against = request.chosen, request.shown, request.against(STAND_IN)
    theory, folder = request.theory(cases[0].model), request.folder
    ladders = [refinement.ladder(spec, request.steps_or_none) for spec in (theory, *against)]
    with progress(len(cases) * sum(map(len, ladders))) as done:
        result = refinement.refine(cases, ladders, max(shown), done)
    tables = refinement.refinement_tables(result, shown)
    show(*tables)
    files: dict[str, bytes] = {}
    for steps, table in zip(ladders, tables, strict=True):
        files |= table.files(f"refinement-{steps[0].name}")
    write(folder, files)
    return finish(request.history, result.study)


@cli.command()
@takes_request
def budget(request: Request) -> int:
    """The error split into its causes: elements, rotary inertia, shear, and what remains.

    Against the first of --references; the parts add up to the error.
    """
    from harness import budget as parts
    from harness.figures import figure_files

    cases, shown, reference = request.chosen, request.shown, request.against(STAND_IN)[0]
    theory, steps, folder = request.theory(cases[0].model), request.steps("1-4"), request.folder
    with progress(len(cases) * len(parts.models(theory, steps, reference))) as done:
        result = parts.budget(cases, theory, steps, reference, max(shown), done)
    table = parts.budget_table(result, shown)
    show(table)
    files = table.files("budget")
    if folder is not None and result.shares:
        files |= figure_files(parts.budget_figure(result, shown), "budget")
        files |= figure_files(parts.floor_figure(result, shown), "floor")
    write(folder, files)
    return finish(request.history, result.study)


@cli.command()
@takes_request
def slenderness(request: Request) -> int:
    """Beam theory against 3-D solids at d/L = 0.05, 0.1, 0.15 and 0.2.

    Against the first of --references, by default calculix-solid.
    """
    from harness import slenderness as study
    from harness.figures import figure_files

    cases, shown, folder = request.chosen, request.shown, request.folder
    reference = request.against("calculix-solid")[0]
    with progress(3 * len(cases) * len(study.RATIOS)) as done:
        result = study.slenderness(cases, study.RATIOS, reference, max(shown), done)
    table = study.slenderness_table(result, shown)
    show(table)
    files = table.files("slenderness")
    if folder is not None:
        files |= figure_files(study.slenderness_figure(result, shown), "slenderness")
    write(folder, files)
    return finish(request.history, *result.studies)


@cli.command()
@takes_request
def shapes(request: Request) -> int:
    """Mode shapes, as in Figs. 4-5, beside those of --references, with the assurance matrix.

    Pictures go to --output, by default the folder shapes/.
    """
    from harness.figures import figure_files
    from harness.run import run
    from harness.shapes import assurance_figure, shapes_figure

    cases, shown, against = request.chosen, request.shown, request.against(STAND_IN)
    theory, folder = request.theory(cases[0].model), request.folder or Path("shapes")
    with progress(len(cases) * (1 + len(against))) as done:
        study = run(cases, [theory, *against], max(shown), done)
    files: dict[str, bytes] = {}
    for case in cases:
        figure = shapes_figure(study, case, [theory, *against], shown)
        files |= figure_files(figure, f"shapes-{case.name}", forms=("png",))
        for reference in against:
            matrix = assurance_figure(study, case, theory, reference, shown)
            if matrix is not None:
                files |= figure_files(matrix, f"assurance-{case.name}-{reference.label}")
    write(folder, files)
    return finish(request.history, study)


@cli.command()
@takes_cost_request
def cost(request: CostRequest) -> int:
    """Seconds and dofs of every model against s and batch size, beside the paper's claims.

    All in one run on one BLAS thread, interleaved, as ratios to one dense eigen-solution.
    """
    from harness.precision.cost import measure
    from harness.precision.cost_report import cost_files, cost_tables

    steps, programs, poses = request.steps, request.programs, request.poses
    rounds, folder = request.rounds, request.folder
    with progress(1 + rounds) as done:
        result = measure(steps, programs, poses, rounds, done)
    show(*cost_tables(result).values())
    write(folder, cost_files(result) if folder is not None else {})
    return status(result.failures)


@cli.command()
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


@cli.command(name="cases")
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


cli.add_command(reproduce)


cli.add_command(sweep)


cli.add_command(workspace)


cli.add_command(history)


cli.add_command(precision)


cli.add_command(claims)


cli.add_command(dashboard)


cli.add_command(identify)


cli.add_command(check)
